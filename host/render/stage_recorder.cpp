#include "render/stage_recorder.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "render/film.hpp"
#include "render/iteration.hpp"
#include "render/rays_choice.hpp"
#include "render/wave_scheduler.hpp"
#include "render/wavefront.hpp"

namespace regulus::render {

using namespace interface;

namespace {

/// A film's fixed-point sums as numbers.
std::vector<glm::dvec3> film_values(const std::vector<uint32_t>& words, int exponent) {
  std::vector<glm::dvec3> values(words.size() / FILM_WORDS_PER_PIXEL, glm::dvec3(0));
  for (size_t i = 0; i < values.size(); ++i)
    for (int channel = 0; channel < 3; ++channel)
      values[i][channel] =
          film_sum(&words[i * FILM_WORDS_PER_PIXEL + 3 * static_cast<size_t>(channel)], exponent);
  return values;
}

}  // namespace

Plan plan_recording(const PreparedScene& prepared, RenderSettings settings, uint32_t techniques) {
  settings.techniques = settings.techniques.value_or(ALL_TECHNIQUES) & techniques;
  settings.light_paths.reset();
  Plan plan = make_plan(prepared, settings);
  // The same kernels connect to the cache and to a path's own light path, which may have as many vertices as
  // edges.
  if (plan.connections_per_vertex != 0)
    plan.connections_per_vertex = std::max(plan.connections_per_vertex, plan.max_depth);
  return plan;
}

namespace {

// Observers watch the wave core and the iteration of a real render, and copy what lies in the arrays.

/// What a watched render leaves in device memory.
class Memory {
 public:
  Memory(Wavefront& wavefront, uint32_t paths) : wavefront_(wavefront), paths_(paths) {}

  const WavefrontBuffers& buffers() const { return wavefront_.buffers; }

  template <typename T>
  std::vector<T> download(const gpu::Buffer& buffer, size_t count, size_t first = 0) const {
    return gpu::download_all<T>(wavefront_.device, buffer, count, first * sizeof(T));
  }
  /// By path slot.
  template <typename T>
  std::vector<T> by_slot(const gpu::Buffer& buffer) const {
    return download<T>(buffer, paths_);
  }
  /// Empty without FEATURE_CONTACTS.
  std::vector<PathMedia> media(const gpu::Buffer& buffer, size_t count) const {
    return buffer.size() == 0 ? std::vector<PathMedia>() : download<PathMedia>(buffer, count);
  }
  std::vector<PathMedia> path_media() const { return media(buffers().path_media, paths_); }

  uint32_t queue_count(uint32_t bounce, Queue queue) const {
    const gpu::Buffer& heads = buffers().queue_heads;
    return download<QueueHead>(heads, 1, QueueHeads::offset_of(bounce, queue) / sizeof(QueueHead))
        .front()
        .count;
  }
  std::vector<uint32_t> ray_queue(uint32_t bounce) const {
    return download<uint32_t>(buffers().ray_queues, queue_count(bounce, Queue::Rays),
                              size_t{bounce & 1u} * buffers().frame().wave_capacity);
  }
  std::vector<ConnectionPair> pairs(uint32_t bounce) const {
    std::vector<ConnectionPair> all;
    for (uint32_t c = 0; c < MATERIAL_CLASS_COUNT; ++c) {
      const auto own = download<ConnectionPair>(buffers().pairs, queue_count(bounce, pair_queue(c)),
                                                size_t{c} * buffers().frame().pair_capacity);
      all.insert(all.end(), own.begin(), own.end());
    }
    return all;
  }
  /// By pixel of a film.
  std::vector<glm::dvec3> film(const gpu::Buffer& film) const {
    return film_values(download<uint32_t>(film, film.size() / sizeof(uint32_t)),
                       wavefront_.plan.features.film_exponents.radiance);
  }

  void fill(const gpu::Buffer& buffer, uint32_t word) const {
    wavefront_.work.room_for(1).fill(buffer, 0, buffer.size(), word);
    wavefront_.work.finish();
  }
  template <typename Values>
  void upload(const gpu::Buffer& buffer, const Values& values, uint64_t offset = 0) const {
    wavefront_.device.upload(buffer, offset, gpu::bytes_of(values));
  }

  /// Runs a stage of the camera pass over its queue once more.
  void run_again(Stage stage, const StageArguments& arguments) const {
    for (const PipelineStep& entry : wavefront_.pipeline)
      if (entry.step.pass == Pass::Camera && entry.step.stage == stage)
        record_over_queue(wavefront_.work.room_for(1), entry, arguments, buffers().queue_heads);
    wavefront_.work.finish();
  }

 private:
  Wavefront& wavefront_;
  uint32_t paths_;
};

/// Records a wave of camera or light paths.
class WaveObserver : public StageObserver {
 public:
  WaveObserver(const Memory& memory, Recording& recording) : memory_(memory), recording_(recording) {}

  void before(Pass, Stage stage, const StageArguments& arguments) override {
    if (stage != Stage::TraceClosest) return;
    RecordedBounce& bounce = recording_.bounces.emplace_back();
    bounce.slots = memory_.ray_queue(arguments.bounce);
    bounce.before = memory_.by_slot<Path>(memory_.buffers().paths);
    bounce.media_before = memory_.path_media();
    memory_.fill(memory_.buffers().hits, INVALID_INDEX);  // a ray that misses leaves no hit
  }

  void after(Pass pass, Stage stage, const StageArguments& arguments) override {
    const WavefrontBuffers& buffers = memory_.buffers();
    if (stage == Stage::CameraGenerate || stage == Stage::LightGenerate || stage == Stage::StartMedia)
      recording_.generated = memory_.by_slot<Path>(buffers.paths);
    if (recording_.bounces.empty()) return;
    RecordedBounce& bounce = recording_.bounces.back();
    if (stage == Stage::TraceClosest) {
      bounce.hits = memory_.by_slot<Hit>(buffers.hits);
      bounce.media_on_arrival = memory_.path_media();
    } else if (stage == Stage::CameraBounce || stage == Stage::LightBounce) {
      bounce.after = memory_.by_slot<Path>(buffers.paths);
      bounce.continuing = memory_.ray_queue(arguments.bounce + 1);
      if (pass == Pass::Camera) record_candidates(arguments, bounce);
    } else if (stage == Stage::TraceVisibility) {
      bounce.radiance = memory_.by_slot<glm::vec3>(buffers.radiance);
      for (const float share : {1 - PROBE_MARGIN, 1 + PROBE_MARGIN}) probe(arguments, share, bounce);
      memory_.upload(buffers.radiance, bounce.radiance);
    }
  }

 private:
  void record_candidates(const StageArguments& arguments, RecordedBounce& bounce) const {
    const WavefrontBuffers& buffers = memory_.buffers();
    bounce.candidates = memory_.download<VisibilityCandidate>(
        buffers.candidates, memory_.queue_count(arguments.bounce, Queue::Visibility));
    bounce.candidate_media = memory_.media(buffers.candidate_media, bounce.candidates.size());
    bounce.radiance_before_visibility = memory_.by_slot<glm::vec3>(buffers.radiance);
    bounce.radiance = bounce.radiance_before_visibility;  // the same, unless light samples add to it
  }

  // Probes segments along the bounce's rays, of `share` times the distance to what they hit. Each path has
  // one, and its radiance tells whether the segment is open.
  void probe(const StageArguments& arguments, float share, RecordedBounce& bounce) {
    const WavefrontBuffers& buffers = memory_.buffers();
    std::vector<VisibilityCandidate> segments;
    std::vector<PathMedia> segment_media;
    for (const uint32_t slot : bounce.slots) {
      const Path& path = bounce.before[slot];
      const Hit& hit = bounce.hits[slot];
      if (hit.triangle == INVALID_INDEX) continue;
      segments.push_back({path.origin, share * hit.t, path.direction, slot, glm::vec3(1)});
      if (!bounce.media_before.empty()) segment_media.push_back(bounce.media_before[slot]);
    }
    if (segments.empty()) return;
    const auto count = static_cast<uint32_t>(segments.size());
    const QueueHead head{(count + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE, 1, 1, count};
    memory_.upload(buffers.candidates, segments);
    if (!segment_media.empty()) memory_.upload(buffers.candidate_media, segment_media);
    memory_.upload(buffers.queue_heads, head, QueueHeads::offset_of(arguments.bounce, Queue::Visibility));
    memory_.fill(buffers.radiance, 0);
    memory_.run_again(Stage::TraceVisibility, arguments);
    const auto radiance = memory_.by_slot<glm::vec3>(buffers.radiance);
    for (const VisibilityCandidate& segment : segments)
      bounce.probes.push_back({segment, radiance[segment.receiver].r > 0});
  }

  const Memory& memory_;
  Recording& recording_;
};

/// Records the light pass of an iteration; if its light paths are walked more than once, the last time.
class LightPassObserver : public StageObserver {
 public:
  LightPassObserver(const Memory& memory, ConnectionRecording& recording)
      : memory_(memory), recording_(recording) {}

  void before(Pass, Stage stage, const StageArguments& arguments) override {
    if (stage == Stage::TraceClosest) memory_.fill(memory_.buffers().hits, INVALID_INDEX);
    if (stage != Stage::LightGenerate) return;
    recording_.light_hits.clear();
    if (arguments.is_repeated != 0) return;  // the walk is repeated: its splats are those that were recorded
    recording_.splats.clear();
    recording_.splat_media.clear();
  }

  void after(Pass pass, Stage stage, const StageArguments& arguments) override {
    const WavefrontBuffers& buffers = memory_.buffers();
    const size_t paths = buffers.frame().light_path_count, cells = buffers.grid_cell_count() + size_t{1};
    if (stage == Stage::TraceClosest) recording_.light_hits.push_back(memory_.by_slot<Hit>(buffers.hits));
    if (stage == Stage::LightBounce && arguments.is_repeated == 0) record_splats(arguments.bounce);
    if (stage == Stage::LightPathCounts)
      recording_.path_counts = memory_.download<uint32_t>(buffers.light_path_ends, paths);
    if (stage == Stage::GridCount) {
      recording_.cell_counts = memory_.download<uint32_t>(buffers.grid_cells, cells);
      recording_.ranks = memory_.download<uint32_t>(buffers.grid_ranks, light_vertices());
    }
    if (stage == Stage::ScanSums && pass == Pass::Cache)
      recording_.path_ends = memory_.download<uint32_t>(buffers.light_path_ends, paths);
    if (stage == Stage::ScanSums && pass == Pass::Grid)
      recording_.cell_ends = memory_.download<uint32_t>(buffers.grid_cells, cells);
    if (stage == Stage::GridScatter)
      recording_.entries = memory_.download<GridEntry>(buffers.grid_entries, light_vertices());
  }

 private:
  uint32_t light_vertices() const {
    const WavefrontBuffers& buffers = memory_.buffers();
    return std::min(memory_.download<uint32_t>(buffers.light_vertex_count, 1).front(),
                    buffers.frame().light_vertex_capacity);
  }

  void record_splats(uint32_t bounce) {
    const WavefrontBuffers& buffers = memory_.buffers();
    const auto splats =
        memory_.download<SplatCandidate>(buffers.splats, memory_.queue_count(bounce, Queue::Splats));
    const std::vector<PathMedia> media = memory_.media(buffers.splat_media, splats.size());
    recording_.splats.insert(recording_.splats.end(), splats.begin(), splats.end());
    recording_.splat_media.insert(recording_.splat_media.end(), media.begin(), media.end());
  }

  const Memory& memory_;
  ConnectionRecording& recording_;
};

/// Records connections and merges of a wave of camera paths.
class ConnectionObserver : public StageObserver {
 public:
  ConnectionObserver(const Memory& memory, ConnectionRecording& recording)
      : memory_(memory), recording_(recording) {}

  void before(Pass, Stage stage, const StageArguments& arguments) override {
    const WavefrontBuffers& buffers = memory_.buffers();
    if (stage == Stage::TraceClosest) {
      recording_.bounces.emplace_back().slots = memory_.ray_queue(arguments.bounce);
      memory_.fill(buffers.hits, INVALID_INDEX);
    } else if (stage == Stage::Merge &&
               recording_.bounces.back().merged.empty()) {  // the first of its rounds
      film_before_ = memory_.film(buffers.film);
    }
  }

  void after(Pass, Stage stage, const StageArguments& arguments) override {
    if (recording_.bounces.empty()) return;
    const WavefrontBuffers& buffers = memory_.buffers();
    RecordedConnections& bounce = recording_.bounces.back();
    if (stage == Stage::TraceClosest) {
      bounce.hits = memory_.by_slot<Hit>(buffers.hits);
      memory_.fill(buffers.radiance, 0);
    } else if (stage == Stage::CameraBounce) {
      bounce.met = memory_.by_slot<glm::vec3>(buffers.radiance);
      bounce.camera_vertices = memory_.by_slot<CameraVertex>(buffers.camera_vertices);
      bounce.pairs = memory_.pairs(arguments.bounce);
      bounce.light_samples = memory_.download<VisibilityCandidate>(
          buffers.candidates, memory_.queue_count(arguments.bounce, Queue::Visibility));
    } else if (stage == Stage::Connect) {
      const size_t light_samples = bounce.light_samples.size();
      const size_t all = memory_.queue_count(arguments.bounce, Queue::Visibility);
      bounce.connections =
          memory_.download<VisibilityCandidate>(buffers.candidates, all - light_samples, light_samples);
    } else if (stage == Stage::Merge) {
      bounce.merged = memory_.film(buffers.film);
      for (size_t i = 0; i < film_before_.size(); ++i) bounce.merged[i] -= film_before_[i];
    }
  }

 private:
  const Memory& memory_;
  ConnectionRecording& recording_;
  std::vector<glm::dvec3> film_before_;
};

// It is kernels that are recorded, whoever is to trace the rays of pictures.
uint32_t rays_of_kernels(const gpu::Device& device, const PreparedScene& prepared, const Plan& plan) {
  return plan.rays == RAYS_HARDWARE ? resolve_rays(device.info(), prepared, plan) : RAYS_SOFTWARE;
}

// A wave holds all paths of a recording.
Plan in_one_wave(Plan plan, uint32_t paths) {
  plan.wave_paths = paths;
  return plan;
}

}  // namespace

struct StageRecorder::Impl {
  Plan plan;
  uint32_t paths;
  RenderStatistics statistics;
  Wavefront wavefront;
  WaveScheduler scheduler;
  Iteration iteration;
  Memory memory;

  Impl(gpu::Device& device, const PreparedScene& prepared, const Plan& plan_in, uint32_t paths_in)
      : plan(in_one_wave(plan_in, paths_in)),
        paths(paths_in),
        wavefront(device, prepared, plan, rays_of_kernels(device, prepared, plan), statistics),
        scheduler(wavefront, [] { return true; }),
        iteration(wavefront, scheduler),
        memory(wavefront, paths) {
    if (wavefront.capacity < paths)
      throw std::logic_error("a recording needs a film with room for its paths");
  }

  template <typename Run>
  void watch(StageObserver& observer, const Run& run) {
    wavefront.watch.set_observer(&observer);
    run();
    wavefront.work.finish();
    wavefront.watch.set_observer(nullptr);
  }
};

StageRecorder::StageRecorder(gpu::Device& device, const PreparedScene& prepared, const Plan& plan,
                             uint32_t paths)
    : impl_(std::make_unique<Impl>(device, prepared, plan, paths)) {}
StageRecorder::~StageRecorder() = default;

const Plan& StageRecorder::plan() const {
  return impl_->plan;
}

Recording StageRecorder::record(Pass pass, uint32_t first_path, uint32_t sample) {
  Impl& impl = *impl_;
  // A light path that carries nothing is not started: its slot stays empty.
  impl.memory.fill(impl.wavefront.buffers.paths, 0);
  Recording recording;
  WaveObserver observer(impl.memory, recording);
  impl.watch(observer, [&] {
    impl.wavefront.core.run(pass, impl.wavefront.arguments_of(first_path, sample, impl.paths));
  });
  return recording;
}

ConnectionRecording StageRecorder::record_light_vertices(uint32_t sample, Connections connections) {
  Impl& impl = *impl_;
  WavefrontBuffers& buffers = impl.wavefront.buffers;
  ConnectionRecording recording;
  recording.connections = connections;
  buffers.connect_to_cache(impl.wavefront.device,
                           connections == Connections::Cache ? impl.plan.cache_connections : 0);
  recording.expected_vertices = impl.iteration.expect_light_vertices();
  impl.memory.fill(buffers.splat_film, 0);
  LightPassObserver observer(impl.memory, recording);
  uint32_t vertices = 0;
  impl.watch(observer, [&] { vertices = impl.iteration.run_light_pass(sample, 0); });
  recording.merge_radius = impl.wavefront.arguments_of(0, sample, impl.paths).merge_radius;
  recording.heads = impl.memory.download<LightPathHead>(buffers.light_heads, impl.plan.light_paths);
  recording.light_vertices = impl.memory.download<LightVertex>(buffers.light_vertices, vertices);
  recording.splat_film = impl.memory.film(buffers.splat_film);
  return recording;
}

void StageRecorder::record_connections(uint32_t sample, ConnectionRecording& recording) {
  Impl& impl = *impl_;
  impl.memory.fill(impl.wavefront.buffers.film, 0);
  ConnectionObserver observer(impl.memory, recording);
  impl.watch(observer, [&] { impl.iteration.run_camera_pass(sample, 0); });
}

}  // namespace regulus::render
