#include "render/renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <utility>

#include "render/device_scene.hpp"
#include "render/scan.hpp"
#include "render/stages.hpp"
#include "render/wavefront_buffers.hpp"

namespace regulus::render {

using namespace interface;
using Clock = std::chrono::steady_clock;

namespace {

// A wave is doubled while it takes less than the first and halved when it takes more than the second: the
// submission stays well under the 200 ms at which watchdogs of interactive systems get nervous.
constexpr double SHORT_WAVE_MS = 50, LONG_WAVE_MS = 150;
constexpr uint32_t FIRST_WAVE_PATHS = 1u << 14;
// On a CPU device a small wave stays in cache; a GPU wants enough paths to fill it at the last bounces too.
constexpr uint32_t SOFTWARE_WAVE_PATHS = 1u << 16, HARDWARE_WAVE_PATHS = 1u << 21;
// Waves handed to the device ahead of time, so that it never waits for the host.
constexpr size_t WAVES_IN_FLIGHT = 2;
constexpr double SNAPSHOT_SECONDS = 5;
// Each sends AOV_RAYS rays and one more in a submission.
constexpr uint32_t SURFACE_WAVE_PIXELS = 1u << 14;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// What can contribute, and values in place of "choose for me".
RenderSettings resolve_settings(const scene::Scene& scene, const RenderSettings& asked) {
  RenderSettings settings = asked;
  const scene::Features features = scene::find_features(scene);
  settings.regularization = effective_regularization(features, asked);
  settings.techniques = effective_techniques(features, asked);
  settings.light_sampling = effective_light_sampling(scene, settings);
  if (settings.light_paths == 0) settings.light_paths = settings.width * settings.height;
  require_merge_radius(settings);
  return settings;
}

uint32_t choose_capacity(const gpu::Device& device, const RenderSettings& settings, uint64_t bytes_each,
                         uint64_t total_paths) {
  uint64_t paths = settings.wave_paths;
  if (paths == 0) {
    paths = device.info().kind == gpu::DeviceKind::Software ? SOFTWARE_WAVE_PATHS : HARDWARE_WAVE_PATHS;
    paths = std::min(paths, device.free_bytes() / 2 / bytes_each);
  }
  const uint64_t group_limit = uint64_t{65535} * WORKGROUP_SIZE;  // groups per dimension, Vulkan's minimum
  paths = std::clamp<uint64_t>(std::min(paths, total_paths), WORKGROUP_SIZE, group_limit);
  return static_cast<uint32_t>((paths + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE * WORKGROUP_SIZE);
}

}  // namespace

struct Renderer::Impl {
  gpu::Device& device;
  RenderSettings settings;
  uint64_t pixels, total_paths;
  DeviceScene scene;
  uint64_t path_bytes;
  uint32_t capacity;
  LightVertexPlan plan;
  WavefrontBuffers buffers;
  std::vector<PipelineStep> pipeline;
  Scan scan;
  bool has_light_pass, has_camera_pass;
  Film film;
  RenderStatistics statistics;

  struct Wave {
    gpu::Submission submission;
    uint64_t paths, light_paths;
  };
  std::deque<Wave> in_flight;
  uint64_t finished = 0, finished_light = 0;  // paths
  uint64_t squared = 0;                       // paths whose samples are in film_squares
  uint32_t wave_paths = 0;                    // of the next wave
  Clock::time_point last_wave, last_snapshot;
  const ProgressCallback* progress = nullptr;
  bool is_running = true;

  Impl(gpu::Device& device_in, const scene::Scene& scene_in, const bvh::Bvh& bvh,
       const RenderSettings& settings_in)
      : device(device_in),
        settings(render::resolve_settings(scene_in, settings_in)),
        pixels(settings.window().pixels()),
        total_paths(pixels * settings.samples),
        scene(device, scene_in, bvh, settings),
        path_bytes(bytes_per_path(settings, scene.has_environment())),
        capacity(choose_capacity(device, settings, path_bytes,
                                 std::max<uint64_t>(total_paths, settings.light_paths))),
        plan(plan_light_vertices(settings)),
        buffers(device, scene,
                scene::make_camera(scene_in.cameras.at(settings.camera), settings.width, settings.height),
                settings, capacity),
        pipeline(build_pipeline(device, scene::find_features(scene_in), settings)),
        scan(device) {
    const auto has_pass = [&](Pass pass) {
      return std::ranges::any_of(pipeline,
                                 [&](const PipelineStep& entry) { return entry.step.pass == pass; });
    };
    has_light_pass = has_pass(Pass::Light);
    has_camera_pass = has_pass(Pass::Camera);
    film.width = settings.window().width;
    film.height = settings.window().height;
    film.words.resize(pixels * FILM_WORDS_PER_PIXEL);
    film.splat_words.resize(buffers.splat_film.size() / sizeof(uint32_t));
    film.light_paths_per_iteration = settings.light_paths;
    film.earlier_words.resize(buffers.film_earlier.size() / sizeof(uint32_t));
    film.square_words.resize(buffers.film_squares.size() / sizeof(uint32_t));
    statistics.wave_capacity = capacity;
    statistics.bytes_per_path = path_bytes;
    wave_paths = settings.wave_paths != 0 ? capacity : std::min(capacity, FIRST_WAVE_PATHS);
  }

  // ---- waves

  // Arguments of a wave that starts at path `first` of sample `sample`.
  StageArguments arguments_of(uint64_t first, uint64_t sample, uint32_t paths) const {
    StageArguments arguments{};
    arguments.frame = buffers.frame_address();
    arguments.wave_paths = paths;
    arguments.first_pixel = static_cast<uint32_t>(first);
    arguments.first_sample = static_cast<uint32_t>(settings.first_sample + sample);
    arguments.merge_radius = merge_radius(sample);
    return arguments;
  }

  // Of the iteration of a sample; the schedule counts from the first sample of all, not of this range.
  float merge_radius(uint64_t sample) const {
    const double iteration = static_cast<double>(settings.first_sample + sample + 1);
    return settings.merge_radius * static_cast<float>(std::pow(iteration, -double{settings.merge_reduction}));
  }

  void record_pass(gpu::CommandList& commands, Pass pass, const StageArguments& arguments,
                   uint32_t merge_rounds = 1) {
    commands.copy(buffers.empty_heads, 0, buffers.queue_heads, 0, buffers.queue_heads.size());
    const uint32_t bounces = pass == Pass::Light ? std::max(settings.max_depth, 2u) - 1 : settings.max_depth;
    record_wave(commands, pipeline, pass, {buffers.queue_heads, arguments, bounces, merge_rounds});
  }

  void submit(gpu::CommandList commands, uint64_t paths, uint64_t light_paths) {
    in_flight.push_back({device.submit(std::move(commands)), paths, light_paths});
  }

  // Waits for the oldest wave; false if the render is to stop.
  void finish_wave() {
    for (const gpu::StageTime& time : device.wait(in_flight.front().submission)) {
      StageStatistics& stage = statistics.stages[time.stage];
      ++stage.dispatches;
      stage.device_ms += time.device_ms;
      statistics.device_seconds += 1e-3 * time.device_ms;
    }
    finished += in_flight.front().paths;
    finished_light += in_flight.front().light_paths;
    in_flight.pop_front();
  }

  void finish_all_waves() {
    while (!in_flight.empty()) finish_wave();
  }

  // Waits for the oldest wave and learns from the time it took how large the next should be.
  void finish_measured_wave() {
    const Wave& wave = in_flight.front();
    const uint64_t measured = std::max(wave.paths, wave.light_paths);
    finish_wave();
    // The device always has the next wave at hand, so it spent the time since the last wave on this one.
    const double wave_ms = 1e3 * seconds_since(last_wave);
    last_wave = Clock::now();
    if (settings.wave_paths == 0 && measured == wave_paths) {
      if (wave_ms < SHORT_WAVE_MS) wave_paths = std::min(capacity, 2 * wave_paths);
      if (wave_ms > LONG_WAVE_MS) wave_paths = std::max(WORKGROUP_SIZE, wave_paths / 2);
    }
    is_running = (*progress)(finished, total_paths) && is_running;
    // A sample that is still to be squared makes no state to go on from.
    if (buffers.film_squares.size() == 0 || finished % pixels != 0) take_snapshot_if_due();
  }

  void take_snapshot_if_due() {
    const bool has_doubled = settings.keeps_doublings && finished >= std::max(pixels, 2 * film.paths);
    if (has_doubled || seconds_since(last_snapshot) > SNAPSHOT_SECONDS) {
      take_snapshot();
      last_snapshot = Clock::now();
    }
  }

  // Hands out waves over [begin, end) paths until all are done or the render is to stop: `record` fills the
  // command list of the wave [first, first + paths) and says how many camera and light paths it holds.
  template <typename Record>
  void run_waves(uint64_t begin, uint64_t end, const Record& record) {
    uint64_t submitted = begin;
    while (is_running && (submitted < end || !in_flight.empty())) {
      while (in_flight.size() < WAVES_IN_FLIGHT && submitted < end) {
        const auto paths = static_cast<uint32_t>(std::min<uint64_t>(wave_paths, end - submitted));
        gpu::CommandList commands(device);
        const auto [camera_paths, light_paths] = record(commands, submitted, paths);
        submit(std::move(commands), camera_paths, light_paths);
        submitted += paths;
      }
      finish_measured_wave();
    }
    finish_all_waves();
  }

  // ---- schedules

  struct WavePaths {
    uint64_t camera, light;
  };

  // Every wave is complete in itself: light paths, if any, then the camera paths that connect to them. Waves
  // run over pixels and samples alike, but stop at every sample if its square is wanted.
  void render_by_waves() {
    const bool has_variance = buffers.film_squares.size() != 0;
    while (is_running && finished < total_paths) {
      run_paths(finished, has_variance ? (finished / pixels + 1) * pixels : total_paths);
      end_sample();
    }
  }

  void run_paths(uint64_t begin, uint64_t end) {
    run_waves(begin, end, [&](gpu::CommandList& commands, uint64_t first, uint32_t paths) {
      const StageArguments arguments = arguments_of(first % pixels, first / pixels, paths);
      if (has_light_pass) {
        commands.fill(buffers.light_vertex_count, 0, buffers.light_vertex_count.size(), 0);
        record_pass(commands, Pass::Light, arguments);
      }
      if (has_camera_pass) record_pass(commands, Pass::Camera, arguments);
      return WavePaths{paths, has_light_pass ? paths : 0};
    });
  }

  // All light paths of an iteration, then one sample of every pixel.
  void render_by_iterations() {
    if (buffers.light_path_ends.size() != 0) expect_light_vertices();
    for (uint64_t sample = finished / pixels; is_running && sample < settings.samples; ++sample) {
      // A resumed render may have walked some of this iteration's light paths.
      const uint64_t before = sample * settings.light_paths;
      walk_light_paths(sample, std::clamp(finished_light, before, before + settings.light_paths) - before);
      if (!is_running) break;
      if (plan.has_vertices) make_light_vertices_fit(sample);
      const uint32_t merge_rounds = sort_light_vertices(sample);
      if (has_camera_pass) {
        run_waves(finished % pixels, pixels, [&](gpu::CommandList& commands, uint64_t first, uint32_t paths) {
          record_pass(commands, Pass::Camera, arguments_of(first, sample, paths), merge_rounds);
          return WavePaths{paths, 0};
        });
      } else {
        finished += pixels;
      }
      end_sample();
    }
  }

  // Squares the sample that has just been completed, if that is wanted.
  void end_sample() {
    if (buffers.film_squares.size() == 0 || finished % pixels != 0 || finished == squared) return;
    gpu::CommandList commands(device);
    record_step(commands, pipeline, "square_samples", arguments_of(0, 0, 0), pixels);
    submit(std::move(commands), 0, 0);
    finish_all_waves();
    squared = finished;
    take_snapshot_if_due();
  }

  // How many light vertices an iteration has, as the very first one counts them: the same for every range of
  // samples.
  void expect_light_vertices() {
    const uint32_t first_sample = std::exchange(settings.first_sample, 0);
    walk_light_paths(0, settings.light_paths);
    settings.first_sample = first_sample;
    buffers.expect_light_vertices(device, read_light_word(0));
  }

  // Walks all light paths of an iteration. The first `repeated` of them are on the film already and only
  // leave vertices.
  void walk_light_paths(uint64_t sample, uint64_t repeated) {
    gpu::CommandList clear(device);
    clear.fill(buffers.light_vertex_count, 0, buffers.light_vertex_count.size(), 0);
    submit(std::move(clear), 0, 0);
    const auto walk = [&](uint64_t begin, uint64_t end, bool is_repeated) {
      run_waves(begin, end, [&](gpu::CommandList& commands, uint64_t first, uint32_t paths) {
        StageArguments arguments = arguments_of(first, sample, paths);
        arguments.round = is_repeated ? 1 : 0;
        record_pass(commands, Pass::Light, arguments);
        return WavePaths{0, is_repeated ? 0 : paths};
      });
    };
    walk(0, repeated, true);
    walk(repeated, settings.light_paths, false);
  }

  uint32_t read_light_word(uint64_t index) {
    return gpu::download_all<uint32_t>(device, buffers.light_vertex_count, 1, index * sizeof(uint32_t))
        .front();
  }

  // If not all vertices could be stored the walk is repeated with room for them: what it stores and what it
  // splats is the same every time.
  void make_light_vertices_fit(uint64_t sample) {
    const uint64_t counted = read_light_word(0);
    if (counted <= buffers.light_vertex_capacity()) return;
    buffers.grow_light_vertices(device, counted + counted / 4);
    walk_light_paths(sample, settings.light_paths);
  }

  // Makes the light vertices findable by place and by number; returns the rounds that merging takes.
  uint32_t sort_light_vertices(uint64_t sample) {
    if (!is_running || !plan.has_vertices) return 1;
    const StageArguments arguments = arguments_of(0, sample, 0);
    gpu::CommandList commands(device);
    if (buffers.light_path_ends.size() != 0) {
      record_step(commands, pipeline, "light_path_counts", arguments, settings.light_paths);
      scan.record(commands, buffers.light_path_ends, settings.light_paths);
    }
    if (plan.has_merges) {
      const uint64_t vertices = read_light_word(0);
      commands.fill(buffers.grid_cells, 0, buffers.grid_cells.size(), 0);
      record_step(commands, pipeline, "grid_count", arguments, vertices);
      scan.record(commands, buffers.grid_cells, buffers.grid_cell_count() + 1);
      record_step(commands, pipeline, "grid_scatter", arguments, vertices);
    }
    submit(std::move(commands), 0, 0);
    finish_all_waves();
    const uint64_t most_in_reach = 8 * uint64_t{plan.has_merges ? read_light_word(1) : 0};
    return static_cast<uint32_t>(
        std::max<uint64_t>(1, (most_in_reach + MERGE_ROUND_LENGTH - 1) / MERGE_ROUND_LENGTH));
  }

  // ---- results

  // Copies the film to the host, so that what is done survives the device.
  void take_snapshot() {
    finish_all_waves();
    // The film changes as a whole or, if the device is lost on the way, not at all.
    auto sums = gpu::download_all<uint32_t>(device, buffers.film, film.words.size());
    auto splats = gpu::download_all<uint32_t>(device, buffers.splat_film, film.splat_words.size());
    const auto words = gpu::download_all<uint32_t>(device, buffers.counters, 2 * COUNTER_COUNT);
    auto earlier = gpu::download_all<uint32_t>(device, buffers.film_earlier, film.earlier_words.size());
    auto squares = gpu::download_all<uint32_t>(device, buffers.film_squares, film.square_words.size());
    film.words.swap(sums);
    film.splat_words.swap(splats);
    film.earlier_words.swap(earlier);
    film.square_words.swap(squares);
    film.paths = finished;
    film.light_paths = finished_light;
    const auto counter = [&](uint32_t index) {
      return words[2 * index] | uint64_t{words[2 * index + 1]} << 32;
    };
    statistics.paths = finished;
    statistics.light_paths = finished_light;
    statistics.non_finite = counter(COUNTER_NON_FINITE);
    statistics.traversal_overruns = counter(COUNTER_TRAVERSAL_OVERRUN);
    for (uint32_t queue = 0; queue < QUEUES_PER_BOUNCE; ++queue) {
      statistics.camera_items[queue] =
          counter(COUNTER_QUEUE_ITEMS + COUNTED_CAMERA_PASS * QUEUES_PER_BOUNCE + queue);
      statistics.light_items[queue] =
          counter(COUNTER_QUEUE_ITEMS + COUNTED_LIGHT_PASS * QUEUES_PER_BOUNCE + queue);
    }
  }

  void resume(const Film& earlier) {
    const auto restore = [&](const gpu::Buffer& buffer, const std::vector<uint32_t>& words) {
      if (!words.empty()) device.upload(buffer, 0, gpu::bytes_of(words));
    };
    restore(buffers.film, earlier.words);
    restore(buffers.splat_film, earlier.splat_words);
    restore(buffers.film_earlier, earlier.earlier_words);
    restore(buffers.film_squares, earlier.square_words);
    film = earlier;
    finished = statistics.paths = statistics.resumed_paths = earlier.paths;
    finished_light = statistics.light_paths = earlier.light_paths;
    squared = finished / pixels * pixels;
  }

  std::vector<AovPixel> surface_aovs() {
    const uint64_t count = buffers.aovs.size() / sizeof(AovPixel);
    for (uint64_t first = 0; first < count; first += SURFACE_WAVE_PIXELS) {
      gpu::CommandList commands(device);
      StageArguments arguments = arguments_of(first, 0, 0);
      for (arguments.round = 0; arguments.round <= AOV_RAYS; ++arguments.round)
        record_step(commands, pipeline, "surface_aovs", arguments,
                    std::min<uint64_t>(SURFACE_WAVE_PIXELS, count - first));
      submit(std::move(commands), 0, 0);
    }
    finish_all_waves();
    return gpu::download_all<AovPixel>(device, buffers.aovs, count);
  }

  // Path slots serve as pixels, wave by wave.
  std::vector<vec3> surface_footprints() {
    std::vector<vec3> footprints;
    if ((settings.aovs & AOV_SIGMA) == 0) return footprints;
    const uint64_t slots = std::min<uint64_t>(SURFACE_WAVE_PIXELS, capacity);
    for (uint64_t first = 0; first < pixels; first += slots) {
      const auto count = static_cast<uint32_t>(std::min(slots, pixels - first));
      gpu::CommandList commands(device);
      StageArguments arguments = arguments_of(first, 0, count);
      for (arguments.bounce = 0; arguments.bounce < settings.max_depth; ++arguments.bounce)
        record_step(commands, pipeline, "surface_footprints", arguments, count);
      submit(std::move(commands), 0, 0);
      finish_all_waves();
      std::ranges::copy(gpu::download_all<vec3>(device, buffers.path_footprints, count),
                        std::back_inserter(footprints));
    }
    return footprints;
  }

  // The mean of one of a strategy's two films, number `index` in the buffer.
  image::Image strategy_image(const Strategy& strategy, uint64_t index) const {
    const uint64_t words = pixels * FILM_WORDS_PER_PIXEL;
    const auto sums =
        gpu::download_all<uint32_t>(device, buffers.strategy_film, words, index * words * sizeof(uint32_t));
    Film own;
    own.width = film.width;
    own.height = film.height;
    own.light_paths_per_iteration = film.light_paths_per_iteration;
    if (strategy.technique == TECHNIQUE_SPLAT) {
      own.splat_words = sums;
      own.light_paths = film.light_paths;
    } else {
      own.words = sums;
      own.paths = film.paths;
    }
    return resolve(own);
  }

  void for_each_strategy(const std::function<void(const StrategyImages&)>& use) const {
    if (!settings.has_strategy_images) return;
    uint64_t index = 0;
    for (const Strategy& strategy : list_strategies(settings.techniques, settings.max_depth)) {
      const image::Image weighted = strategy_image(strategy, index++);
      use({strategy, weighted, strategy_image(strategy, index++)});
    }
  }

  void render(const ProgressCallback& progress_in) {
    const auto start = Clock::now();
    last_snapshot = last_wave = start;
    progress = &progress_in;
    if (!has_light_pass && !has_camera_pass)
      finished = total_paths;  // no technique can contribute: the image is black
    else if (plan.is_per_wave)
      render_by_waves();
    else
      render_by_iterations();
    take_snapshot();
    statistics.render_seconds += seconds_since(start);
  }
};

Renderer::Renderer(gpu::Device& device, const scene::Scene& scene, const bvh::Bvh& bvh,
                   const RenderSettings& settings)
    : impl_(std::make_unique<Impl>(device, scene, bvh, settings)) {}
Renderer::~Renderer() = default;

void Renderer::resume(const Film& film) {
  impl_->resume(film);
}
std::vector<AovPixel> Renderer::surface_aovs() {
  return impl_->surface_aovs();
}

std::vector<vec3> Renderer::surface_footprints() {
  return impl_->surface_footprints();
}
void Renderer::render(const ProgressCallback& progress) {
  impl_->render(progress);
}
const Film& Renderer::film() const {
  return impl_->film;
}
void Renderer::for_each_strategy(const std::function<void(const StrategyImages&)>& use) const {
  impl_->for_each_strategy(use);
}
const RenderStatistics& Renderer::statistics() const {
  return impl_->statistics;
}

}  // namespace regulus::render
