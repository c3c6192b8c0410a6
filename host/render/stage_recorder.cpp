#include "render/stage_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "render/device_scene.hpp"
#include "render/film.hpp"
#include "render/scan.hpp"
#include "render/wavefront_buffers.hpp"

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

/// Paths that there has to be room for. Room for pairs is that of connections to the cache, and a path may
/// have as many with its own light path as it has edges.
uint32_t capacity_for(const Plan& plan, uint32_t paths) {
  const uint32_t times = plan.cache_connections == 0
                             ? 1
                             : (plan.max_depth + plan.cache_connections - 1) / plan.cache_connections;
  return (times * paths + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE * WORKGROUP_SIZE;
}

}  // namespace

Plan plan_recording(const PreparedScene& prepared, RenderSettings settings, uint32_t techniques) {
  settings.techniques = settings.techniques.value_or(ALL_TECHNIQUES) & techniques;
  settings.light_paths.reset();
  return make_plan(prepared, settings);
}

struct StageRecorder::Impl {
  gpu::Device& device;
  Plan plan;
  uint32_t paths;
  int film_exponent;
  DeviceScene scene;
  WavefrontBuffers buffers;
  std::vector<PipelineStep> pipeline;
  Scan scan;

  Impl(gpu::Device& device_in, const PreparedScene& prepared, const Plan& plan_in, uint32_t paths_in)
      : device(device_in),
        plan(plan_in),
        paths(paths_in),
        film_exponent(prepared.features.film_exponents.radiance),
        scene(device, prepared, plan),
        buffers(device, scene,
                scene::make_camera(prepared.scene.cameras.at(plan.camera), plan.width, plan.height), plan,
                capacity_for(plan, paths)),
        pipeline(build_pipeline(device, plan, RAYS_SOFTWARE)),
        scan(device) {}

  template <typename T>
  std::vector<T> download(const gpu::Buffer& buffer, size_t count, size_t first = 0) {
    return gpu::download_all<T>(device, buffer, count, first * sizeof(T));
  }

  // Runs the steps of a pass whose shader is `shader`, and waits.
  void run(Pass pass, std::string_view shader, const StageArguments& arguments) {
    gpu::CommandList commands(device);
    for (const PipelineStep& entry : pipeline) {
      if (entry.step.pass != pass || shader != entry.step.shader) continue;
      if (entry.step.extent == Extent::Bounce) {
        const uint64_t head = uint64_t{arguments.bounce} * QUEUES_PER_BOUNCE + entry.step.queue;
        commands.dispatch_indirect(entry.kernel, gpu::bytes_of(arguments), buffers.queue_heads,
                                   head * sizeof(QueueHead));
      } else {
        commands.dispatch(entry.kernel, gpu::bytes_of(arguments),
                          (paths + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE);
      }
    }
    gpu::Submission submission = device.submit(std::move(commands));
    device.wait(submission);
  }

  uint32_t queue_count(uint32_t bounce, uint32_t queue) {
    return download<QueueHead>(buffers.queue_heads, 1, size_t{bounce} * QUEUES_PER_BOUNCE + queue)
        .front()
        .count;
  }

  std::vector<uint32_t> ray_queue(uint32_t bounce) {
    const size_t capacity = buffers.frame_.wave_capacity;
    return download<uint32_t>(buffers.ray_queues_, queue_count(bounce, QUEUE_RAYS), (bounce & 1u) * capacity);
  }

  void fill(const gpu::Buffer& buffer, uint32_t word) {
    gpu::CommandList commands(device);
    commands.fill(buffer, 0, buffer.size(), word);
    gpu::Submission submission = device.submit(std::move(commands));
    device.wait(submission);
  }

  // Nothing without FEATURE_CONTACTS.
  std::vector<PathMedia> media(const gpu::Buffer& buffer, size_t count) {
    return buffer.size() == 0 ? std::vector<PathMedia>() : download<PathMedia>(buffer, count);
  }

  std::vector<Hit> trace_closest(Pass pass, const StageArguments& arguments) {
    fill(buffers.hits_, INVALID_INDEX);  // a ray that misses leaves no hit
    run(pass, "trace_closest", arguments);
    return download<Hit>(buffers.hits_, paths);
  }

  RecordedBounce record_bounce(Pass pass, const StageArguments& arguments) {
    const bool is_camera = pass == Pass::Camera;
    RecordedBounce recorded;
    recorded.slots = ray_queue(arguments.bounce);
    recorded.before = download<Path>(buffers.paths_, paths);
    recorded.media_before = media(buffers.path_media_, paths);
    recorded.hits = trace_closest(pass, arguments);
    recorded.media_on_arrival = media(buffers.path_media_, paths);
    run(pass, "escape", arguments);
    run(pass, is_camera ? "camera_bounce" : "light_bounce", arguments);
    recorded.after = download<Path>(buffers.paths_, paths);
    recorded.continuing = ray_queue(arguments.bounce + 1);
    if (!is_camera) return recorded;
    recorded.candidates =
        download<VisibilityCandidate>(buffers.candidates_, queue_count(arguments.bounce, QUEUE_VISIBILITY));
    recorded.candidate_media = media(buffers.candidate_media_, recorded.candidates.size());
    recorded.radiance_before_visibility = download<glm::vec3>(buffers.radiance_, paths);
    run(pass, "trace_visibility", arguments);
    recorded.radiance = download<glm::vec3>(buffers.radiance_, paths);
    if ((plan.techniques & TECHNIQUE_NEE) != 0) {
      for (const float share : {1 - PROBE_MARGIN, 1 + PROBE_MARGIN}) probe(arguments, share, recorded);
      device.upload(buffers.radiance_, 0, gpu::bytes_of(recorded.radiance));
    }
    return recorded;
  }

  // Segments along the rays of the bounce of `share` times the distance to what they hit. Of each path there
  // is one, and its radiance tells whether it is open.
  void probe(const StageArguments& arguments, float share, RecordedBounce& recorded) {
    std::vector<VisibilityCandidate> segments;
    std::vector<PathMedia> segment_media;
    for (const uint32_t slot : recorded.slots) {
      const Path& path = recorded.before[slot];
      const Hit& hit = recorded.hits[slot];
      if (hit.triangle == INVALID_INDEX) continue;
      segments.push_back({path.origin, share * hit.t, path.direction, slot, glm::vec3(1)});
      if (!recorded.media_before.empty()) segment_media.push_back(recorded.media_before[slot]);
    }
    if (segments.empty()) return;
    const auto count = static_cast<uint32_t>(segments.size());
    const QueueHead head{(count + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE, 1, 1, count};
    const size_t place = size_t{arguments.bounce} * QUEUES_PER_BOUNCE + QUEUE_VISIBILITY;
    device.upload(buffers.candidates_, 0, gpu::bytes_of(segments));
    if (!segment_media.empty()) device.upload(buffers.candidate_media_, 0, gpu::bytes_of(segment_media));
    device.upload(buffers.queue_heads, place * sizeof(QueueHead), gpu::bytes_of(head));
    fill(buffers.radiance_, 0);
    run(Pass::Camera, "trace_visibility", arguments);
    const auto radiance = download<glm::vec3>(buffers.radiance_, paths);
    for (const VisibilityCandidate& segment : segments)
      recorded.probes.push_back({segment, radiance[segment.path].r > 0});
  }

  // ---- connections and merges

  StageArguments arguments_of(uint32_t sample) const {
    StageArguments arguments{};
    arguments.frame = buffers.frame_address();
    arguments.wave_paths = paths;
    arguments.first_sample = sample;
    arguments.merge_radius =
        plan.merge_radius * static_cast<float>(std::pow(sample + 1.0, -double{plan.merge_reduction}));
    return arguments;
  }

  void start_wave(const gpu::Buffer* cleared) {
    gpu::CommandList commands(device);
    commands.copy(buffers.empty_heads, 0, buffers.queue_heads, 0, buffers.queue_heads.size());
    if (cleared != nullptr) commands.fill(*cleared, 0, cleared->size(), 0);
    gpu::Submission submission = device.submit(std::move(commands));
    device.wait(submission);
  }

  // Walks all light paths; returns how many vertices they have, all of which are stored.
  uint32_t walk_light_paths(uint32_t sample, ConnectionRecording& recording) {
    std::vector<SplatCandidate>& splats = recording.splats;
    recording.light_hits.clear();
    start_wave(&buffers.light_vertex_count);
    if (buffers.splat_film.size() != 0) start_wave(&buffers.splat_film);
    splats.clear();
    recording.splat_media.clear();
    StageArguments arguments = arguments_of(sample);
    run(Pass::Light, "light_generate", arguments);
    run(Pass::Light, "start_media", arguments);
    for (uint32_t bounce = 0; bounce + 1 < std::max(plan.max_depth, 2u); ++bounce) {
      arguments.bounce = bounce;
      recording.light_hits.push_back(trace_closest(Pass::Light, arguments));
      run(Pass::Light, "light_bounce", arguments);
      const auto queued = download<SplatCandidate>(buffers.splats_, queue_count(bounce, QUEUE_SPLATS));
      splats.insert(splats.end(), queued.begin(), queued.end());
      const std::vector<PathMedia> own = media(buffers.splat_media_, queued.size());
      recording.splat_media.insert(recording.splat_media.end(), own.begin(), own.end());
      run(Pass::Light, "trace_splats", arguments);
    }
    const auto count = download<uint32_t>(buffers.light_vertex_count, 1).front();
    if (count <= buffers.light_vertex_capacity()) return count;
    buffers.grow_light_vertices(device, count);
    return walk_light_paths(sample, recording);
  }

  void scan_words(const gpu::Buffer& words, uint32_t count) {
    gpu::CommandList commands(device);
    scan.record(commands, words, count);
    gpu::Submission submission = device.submit(std::move(commands));
    device.wait(submission);
  }

  void run_over(std::string_view name, const StageArguments& arguments, uint64_t items) {
    gpu::CommandList commands(device);
    record_step(commands, pipeline, name, arguments, items);
    gpu::Submission submission = device.submit(std::move(commands));
    device.wait(submission);
  }

  void sort_light_vertices(const StageArguments& arguments, ConnectionRecording& recording) {
    const auto vertices = static_cast<uint32_t>(recording.light_vertices.size());
    run_over("light_path_counts", arguments, plan.light_paths);
    recording.path_counts = download<uint32_t>(buffers.light_path_ends, plan.light_paths);
    scan_words(buffers.light_path_ends, plan.light_paths);
    recording.path_ends = download<uint32_t>(buffers.light_path_ends, plan.light_paths);

    fill(buffers.grid_cells, 0);
    const uint32_t cells = buffers.grid_cell_count() + 1;
    run_over("grid_count", arguments, vertices);
    recording.cell_counts = download<uint32_t>(buffers.grid_cells, cells);
    recording.ranks = download<uint32_t>(buffers.grid_ranks_, vertices);
    scan_words(buffers.grid_cells, cells);
    recording.cell_ends = download<uint32_t>(buffers.grid_cells, cells);
    run_over("grid_scatter", arguments, vertices);
    recording.entries = download<GridEntry>(buffers.grid_entries_, vertices);
  }

  RecordedConnections record_bounce_connections(const StageArguments& arguments) {
    RecordedConnections recorded;
    recorded.slots = ray_queue(arguments.bounce);
    recorded.hits = trace_closest(Pass::Camera, arguments);
    fill(buffers.radiance_, 0);
    run(Pass::Camera, "escape", arguments);
    run(Pass::Camera, "camera_bounce", arguments);
    recorded.met = download<glm::vec3>(buffers.radiance_, paths);
    recorded.camera_vertices = download<PathVertex>(buffers.camera_vertices_, paths);
    for (uint32_t c = 0; c < MATERIAL_CLASS_COUNT; ++c) {
      const auto queued =
          download<ConnectionPair>(buffers.pairs_, queue_count(arguments.bounce, QUEUE_PAIRS + c),
                                   size_t{c} * buffers.frame_.pair_capacity);
      recorded.pairs.insert(recorded.pairs.end(), queued.begin(), queued.end());
    }
    const uint32_t light_samples = queue_count(arguments.bounce, QUEUE_VISIBILITY);
    run(Pass::Camera, "connect", arguments);
    const uint32_t all = queue_count(arguments.bounce, QUEUE_VISIBILITY);
    recorded.light_samples = download<VisibilityCandidate>(buffers.candidates_, light_samples);
    recorded.connections =
        download<VisibilityCandidate>(buffers.candidates_, all - light_samples, light_samples);
    const size_t words = size_t{paths} * FILM_WORDS_PER_PIXEL;
    const auto before = film_values(download<uint32_t>(buffers.film, words), film_exponent);
    run(Pass::Camera, "merge", arguments);
    recorded.merged = film_values(download<uint32_t>(buffers.film, words), film_exponent);
    for (size_t i = 0; i < before.size(); ++i) recorded.merged[i] -= before[i];
    return recorded;
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
  gpu::CommandList reset(impl.device);
  reset.copy(impl.buffers.empty_heads, 0, impl.buffers.queue_heads, 0, impl.buffers.queue_heads.size());
  // A light path that carries nothing is not started: its slot stays empty.
  reset.fill(impl.buffers.paths_, 0, impl.buffers.paths_.size(), 0);
  gpu::Submission submission = impl.device.submit(std::move(reset));
  impl.device.wait(submission);

  StageArguments arguments{};
  arguments.frame = impl.buffers.frame_address();
  arguments.wave_paths = impl.paths;
  arguments.first_pixel = first_path;
  arguments.first_sample = sample;
  impl.run(pass, pass == Pass::Camera ? "camera_generate" : "light_generate", arguments);
  impl.run(pass, "start_media", arguments);
  Recording recording;
  recording.generated = impl.download<Path>(impl.buffers.paths_, impl.paths);
  const uint32_t bounces = pass == Pass::Camera ? impl.plan.max_depth : std::max(impl.plan.max_depth, 2u) - 1;
  for (arguments.bounce = 0; arguments.bounce < bounces; ++arguments.bounce) {
    recording.bounces.push_back(impl.record_bounce(pass, arguments));
    if (recording.bounces.back().continuing.empty()) break;
  }
  return recording;
}

ConnectionRecording StageRecorder::record_light_vertices(uint32_t sample, Connections connections) {
  Impl& impl = *impl_;
  ConnectionRecording recording;
  recording.connections = connections;
  impl.buffers.frame_.cache_connections = connections == Connections::Cache ? impl.plan.cache_connections : 0;
  recording.expected_vertices = impl.walk_light_paths(0, recording);
  impl.buffers.expect_light_vertices(impl.device, recording.expected_vertices);
  const uint32_t vertices = impl.walk_light_paths(sample, recording);
  const StageArguments arguments = impl.arguments_of(sample);
  recording.merge_radius = arguments.merge_radius;
  recording.heads = impl.download<LightPathHead>(impl.buffers.light_heads_, impl.plan.light_paths);
  recording.light_vertices = impl.download<PathVertex>(impl.buffers.light_vertices_, vertices);
  if (impl.buffers.splat_film.size() != 0)
    recording.splat_film = film_values(
        impl.download<uint32_t>(impl.buffers.splat_film, size_t{impl.paths} * FILM_WORDS_PER_PIXEL),
        impl.film_exponent);
  impl.sort_light_vertices(arguments, recording);
  return recording;
}

void StageRecorder::record_connections(uint32_t sample, ConnectionRecording& recording) {
  Impl& impl = *impl_;
  StageArguments arguments = impl.arguments_of(sample);
  impl.start_wave(&impl.buffers.film);
  impl.run(Pass::Camera, "camera_generate", arguments);
  impl.run(Pass::Camera, "start_media", arguments);
  for (arguments.bounce = 0; arguments.bounce < impl.plan.max_depth; ++arguments.bounce) {
    recording.bounces.push_back(impl.record_bounce_connections(arguments));
    if (impl.queue_count(arguments.bounce + 1, QUEUE_RAYS) == 0) break;
  }
}

}  // namespace regulus::render
