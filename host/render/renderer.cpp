#include "render/renderer.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <utility>

#include "render/device_scene.hpp"
#include "render/host_rays.hpp"
#include "render/scan.hpp"
#include "render/stages.hpp"
#include "render/wave_core.hpp"
#include "render/wavefront_buffers.hpp"
#include "render/work_queue.hpp"

namespace regulus::render {

using namespace interface;
using Clock = std::chrono::steady_clock;

namespace {

// The first wave is small, so that a bad surprise is a small one.
constexpr uint32_t FIRST_WAVE_PATHS = 1u << 14;
// On a CPU device a small wave stays in cache, and always has the same size. A GPU wants enough paths to fill
// it at the last bounces too.
constexpr uint32_t SOFTWARE_WAVE_PATHS = 1u << 16, HARDWARE_WAVE_PATHS = 1u << 21;
// A snapshot of the film is taken when the last one is so many times as old as it took to make, but not more
// often than every LEAST_SNAPSHOT_SECONDS.
constexpr double SNAPSHOT_AGE = 50, LEAST_SNAPSHOT_SECONDS = 0.25;
// Where states of the film are wanted while it grows, each has at most so many times the paths of the last.
constexpr double SNAPSHOT_GROWTH = 1.5;
constexpr double FIRST_BYTES_PER_SECOND = 1e9;  // that a snapshot copies, before it has been measured
constexpr uint32_t SURFACE_WAVE_PIXELS = 1u << 14;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

uint64_t whole_groups(uint64_t paths) {
  return (paths + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE * WORKGROUP_SIZE;
}

uint32_t choose_capacity(const gpu::Device& device, const Plan& plan, uint64_t bytes_each,
                         uint64_t total_paths) {
  const gpu::DeviceInfo& info = device.info();
  uint64_t paths = plan.wave_paths;
  if (paths == 0) {
    paths = info.kind == gpu::DeviceKind::Software ? SOFTWARE_WAVE_PATHS : HARDWARE_WAVE_PATHS;
    paths = std::min(paths, device.free_bytes() / 2 / bytes_each);
  }
  const uint64_t limit = most_paths(plan, info.max_groups, info.max_allocation_bytes);
  paths = std::min(whole_groups(std::min(paths, total_paths)), limit / WORKGROUP_SIZE * WORKGROUP_SIZE);
  return static_cast<uint32_t>(std::max<uint64_t>(paths, WORKGROUP_SIZE));
}

}  // namespace

struct Renderer::Impl {
  gpu::Device& device;
  Plan plan;
  uint64_t pixels, total_paths;
  DeviceScene scene;
  uint64_t path_bytes;
  uint32_t capacity;
  WavefrontBuffers buffers;
  uint32_t rays;
  std::vector<PipelineStep> pipeline;
  Scan scan;
  bool has_light_pass, has_camera_pass;
  Film film;
  RenderStatistics statistics;
  std::optional<HostRays> host_rays;
  WorkQueue work;
  WaveCore core;

  uint64_t finished = 0, finished_light = 0;  // paths
  uint64_t squared = 0;                       // paths whose samples are in film_squares
  uint64_t reach = 0;                         // light vertices in reach of a merge, at most
  bool is_first_wave = true;
  Clock::time_point last_snapshot;
  double snapshot_seconds = 0;  // that the last one took
  const ProgressCallback* progress = nullptr;
  bool is_running = true;
  bool is_film_whole = true;  // false: the device's holds parts of a wave that was given up

  Impl(gpu::Device& device_in, const PreparedScene& prepared, const Plan& plan_in)
      : device(device_in),
        plan(plan_in),
        pixels(plan.window().pixels()),
        total_paths(pixels * plan.samples),
        scene(device, prepared, plan),
        path_bytes(bytes_per_path(plan)),
        capacity(
            choose_capacity(device, plan, path_bytes, std::max<uint64_t>(total_paths, plan.light_paths))),
        buffers(device, scene,
                scene::make_camera(prepared.scene.cameras.at(plan.camera), plan.width, plan.height), plan,
                capacity),
        rays(resolve_rays(device.info(), prepared, plan)),
        pipeline(build_pipeline(device, plan, rays)),
        scan(device),
        work(device, ITEMS_PER_PATH * (plan.wave_paths != 0 ? capacity : WORKGROUP_SIZE), statistics),
        core(device, work, pipeline, buffers, plan, rays == RAYS_HOST ? &trace_with(prepared) : nullptr) {
    const auto has_pass = [&](Pass pass) {
      return std::ranges::any_of(pipeline,
                                 [&](const PipelineStep& entry) { return entry.step.pass == pass; });
    };
    has_light_pass = has_pass(Pass::Light);
    has_camera_pass = has_pass(Pass::Camera);
    film.width = plan.window().width;
    film.height = plan.window().height;
    film.words.resize(pixels * FILM_WORDS_PER_PIXEL);
    film.splat_words.resize(buffers.splat_film.size() / sizeof(uint32_t));
    film.light_paths_per_iteration = plan.light_paths;
    film.exponents = prepared.features.film_exponents;
    film.earlier_words.resize(buffers.film_earlier.size() / sizeof(uint32_t));
    film.square_words.resize(buffers.film_squares.size() / sizeof(uint32_t));
    statistics.rays = rays;
    statistics.wave_capacity = capacity;
    statistics.bytes_per_path = path_bytes;
    snapshot_seconds =
        static_cast<double>(pixels * FILM_WORDS_PER_PIXEL * sizeof(uint32_t)) / FIRST_BYTES_PER_SECOND;
  }

  HostRays& trace_with(const PreparedScene& prepared) {
    return host_rays.emplace(prepared, plan, buffers, statistics);
  }

  // ---- waves

  // Arguments of a wave that starts at path `first` of sample `sample`, which counts from the first of all.
  StageArguments arguments_of(uint64_t first, uint64_t sample, uint32_t paths) const {
    StageArguments arguments{};
    arguments.frame = buffers.frame_address();
    arguments.wave_paths = paths;
    arguments.first_pixel = static_cast<uint32_t>(first);
    arguments.first_sample = static_cast<uint32_t>(sample);
    arguments.merge_radius = merge_radius(sample);
    return arguments;
  }

  float merge_radius(uint64_t sample) const {
    const auto iteration = static_cast<double>(sample + 1);
    return plan.merge_radius * static_cast<float>(std::pow(iteration, -double{plan.merge_reduction}));
  }

  uint64_t next_wave_paths() const {
    if (plan.wave_paths == 0 && is_first_wave) return std::min(capacity, FIRST_WAVE_PATHS);
    return std::min({uint64_t{capacity}, work.bound() / ITEMS_PER_PATH, WaveCore::most_paths(reach)});
  }

  struct WavePaths {
    uint64_t camera, light;
  };

  // Hands out waves over [begin, end) paths until all are done or the render is to stop: `run` takes the wave
  // [first, first + paths) through its passes, and says how many camera and light paths it holds, or nothing
  // if it was given up. At most two submissions are under way, so that the device never waits.
  template <typename Run>
  void run_waves(uint64_t begin, uint64_t end, const Run& run) {
    uint64_t first = begin;
    while (is_running && first < end) {
      const auto paths = static_cast<uint32_t>(std::min(next_wave_paths(), end - first));
      const std::optional<WavePaths> done = run(first, paths);
      if (!done) return give_up_wave();
      work.when_done([this, wave = *done] {
        finished += wave.camera;
        finished_light += wave.light;
      });
      work.flush();
      first += paths;
      is_first_wave = false;
      is_running = (*progress)(finished, total_paths) && !work.is_cancelled();
      take_snapshot_if_due();
    }
    work.finish();
  }

  // What connections, merges and splats of the wave have added to the film already cannot be taken back: the
  // last snapshot is then what was rendered. Other techniques add to it when a wave ends.
  void give_up_wave() {
    work.drop();
    is_running = false;
    constexpr uint32_t ADD_AT_ONCE = TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
    if ((plan.techniques & ADD_AT_ONCE) != 0) is_film_whole = false;
  }

  // Runs a step over so many items, from arguments.first_pixel on.
  void run_step(std::string_view name, StageArguments arguments, uint64_t items) {
    const uint32_t first = arguments.first_pixel;
    const uint64_t at_once = work.bound();
    for (uint64_t done = 0; done < items; done += at_once) {
      const uint64_t here = std::min(at_once, items - done);
      arguments.first_pixel = first + static_cast<uint32_t>(done);
      record_step(work.room_for(here), pipeline, name, arguments, here);
    }
  }

  void run_scan(const gpu::Buffer& words, uint32_t count) {
    scan.record(work.room_for(std::min<uint64_t>(work.bound(), count / SCAN_FAN + 1)), words, count);
  }

  uint64_t paths_of_next_state() const {
    return std::max(pixels, static_cast<uint64_t>(SNAPSHOT_GROWTH * static_cast<double>(film.paths)));
  }

  // A state halfway lets the last one tell its noise (render/noise.hpp), however short the render.
  uint64_t paths_of_half() const { return plan.samples / 2 * pixels; }

  bool is_half_due() const { return film.paths < paths_of_half() && finished >= paths_of_half(); }

  void take_snapshot_if_due() {
    const bool has_grown = is_half_due() || (plan.keeps_doublings && finished >= paths_of_next_state());
    const double due = std::max(LEAST_SNAPSHOT_SECONDS, SNAPSHOT_AGE * snapshot_seconds);
    if (!has_grown && seconds_since(last_snapshot) < due) return;
    work.finish();
    // A sample that is still to be squared makes no state to go on from.
    if (buffers.film_squares.size() != 0 && finished % pixels == 0 && finished != squared) return;
    take_snapshot();
  }

  // ---- schedules

  // Every wave is complete in itself: light paths, if any, then the camera paths that connect to them. Waves
  // run over pixels and samples alike, but stop at every sample if its square is wanted, and where the next
  // state of the film is due: a GPU's waves are so large that it would be long past it.
  void render_by_waves() {
    while (is_running && finished < total_paths) {
      run_paths(finished, next_stop());
      end_sample();
      if (!is_running) continue;
      take_snapshot_if_due();
      if (!plan.keeps_doublings) continue;
      is_running = (*progress)(finished, total_paths);
    }
  }

  uint64_t next_stop() const {
    uint64_t stop = finished < paths_of_half() ? paths_of_half() : total_paths;
    if (buffers.film_squares.size() != 0) stop = std::min(stop, (finished / pixels + 1) * pixels);
    if (plan.keeps_doublings) stop = std::min(stop, std::max(paths_of_next_state(), finished + 1));
    return stop;
  }

  void run_paths(uint64_t begin, uint64_t end) {
    run_waves(begin, end, [&](uint64_t first, uint32_t paths) -> std::optional<WavePaths> {
      const StageArguments arguments =
          arguments_of(first % pixels, plan.first_sample + first / pixels, paths);
      if (has_light_pass) {
        work.room_for(1).fill(buffers.light_vertex_count, 0, buffers.light_vertex_count.size(), 0);
        if (!core.run(Pass::Light, arguments)) return std::nullopt;
      }
      if (has_camera_pass && !core.run(Pass::Camera, arguments)) return std::nullopt;
      return WavePaths{paths, has_light_pass ? paths : 0};
    });
  }

  // All light paths of an iteration, then one sample of every pixel.
  void render_by_iterations() {
    if (buffers.light_path_ends.size() != 0) expect_light_vertices();
    for (uint64_t done = finished / pixels; is_running && done < plan.samples; ++done) {
      const uint64_t sample = plan.first_sample + done;
      // A resumed render may have walked some of this iteration's light paths.
      const uint64_t before = done * plan.light_paths;
      walk_light_paths(sample, std::clamp(finished_light, before, before + plan.light_paths) - before);
      if (is_running && plan.light_vertices.has_vertices) make_light_vertices_fit(sample);
      if (is_running) sort_light_vertices(sample);
      if (!is_running) break;
      if (has_camera_pass) {
        run_waves(finished % pixels, pixels, [&](uint64_t first, uint32_t paths) -> std::optional<WavePaths> {
          if (!core.run(Pass::Camera, arguments_of(first, sample, paths), reach)) return std::nullopt;
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
    if (buffers.film_squares.size() == 0 || finished % pixels != 0 || finished == squared || !is_film_whole)
      return;
    run_step("square_samples", arguments_of(0, 0, 0), pixels);
    work.finish();
    squared = finished;
    take_snapshot_if_due();
  }

  // How many light vertices an iteration has, as the very first one counts them: the same for every range of
  // samples.
  void expect_light_vertices() {
    walk_light_paths(0, plan.light_paths);
    buffers.expect_light_vertices(device, read_light_word(LIGHT_COUNT_VERTICES));
  }

  // Walks all light paths of an iteration. The first `repeated` of them are on the film already and only
  // leave vertices.
  void walk_light_paths(uint64_t sample, uint64_t repeated) {
    work.room_for(1).fill(buffers.light_vertex_count, 0, buffers.light_vertex_count.size(), 0);
    const auto walk = [&](uint64_t begin, uint64_t end, bool is_repeated) {
      run_waves(begin, end, [&](uint64_t first, uint32_t paths) -> std::optional<WavePaths> {
        StageArguments arguments = arguments_of(first, sample, paths);
        arguments.round = is_repeated ? 1 : 0;
        if (!core.run(Pass::Light, arguments)) return std::nullopt;
        return WavePaths{0, is_repeated ? 0 : paths};
      });
    };
    walk(0, repeated, true);
    walk(repeated, plan.light_paths, false);
  }

  uint32_t read_light_word(uint64_t index) {
    work.finish();
    return gpu::download_all<uint32_t>(device, buffers.light_vertex_count, 1, index * sizeof(uint32_t))
        .front();
  }

  // If not all vertices could be stored the walk is repeated with room for them: what it stores and what it
  // splats is the same every time.
  void make_light_vertices_fit(uint64_t sample) {
    const uint64_t counted = read_light_word(LIGHT_COUNT_VERTICES);
    if (counted <= buffers.light_vertex_capacity()) return;
    buffers.grow_light_vertices(device, counted + counted / 4);
    walk_light_paths(sample, plan.light_paths);
  }

  // Makes the light vertices findable by place and by number, and learns how many may be in reach of a merge.
  void sort_light_vertices(uint64_t sample) {
    if (!plan.light_vertices.has_vertices) return;
    const StageArguments arguments = arguments_of(0, sample, 0);
    if (buffers.light_path_ends.size() != 0) {
      run_step("light_path_counts", arguments, plan.light_paths);
      run_scan(buffers.light_path_ends, plan.light_paths);
    }
    if (!plan.light_vertices.has_merges) return work.finish();
    const uint64_t vertices = read_light_word(LIGHT_COUNT_VERTICES);
    work.room_for(1).fill(buffers.grid_cells, 0, buffers.grid_cells.size(), 0);
    run_step("grid_count", arguments, vertices);
    run_scan(buffers.grid_cells, buffers.grid_cell_count() + 1);
    run_step("grid_scatter", arguments, vertices);
    // A merge looks at eight cells.
    const uint64_t crowd = std::max(read_light_word(LIGHT_COUNT_CROWD), CROWDED_CELL);
    reach = std::min(vertices, 8 * crowd);
  }

  // ---- results

  // Copies the film to the host, so that what is done survives the device.
  void take_snapshot() {
    work.finish();
    const auto start = Clock::now();
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
    for (const FilmLayer& layer : FILM_LAYERS) settle_saturated(film.*layer.words);
    film.paths = finished;
    film.light_paths = finished_light;
    const auto counter = [&](uint32_t index) {
      return words[2 * index] | uint64_t{words[2 * index + 1]} << 32;
    };
    statistics.paths = finished;
    statistics.light_paths = finished_light;
    statistics.non_finite = counter(COUNTER_NON_FINITE);
    statistics.traversal_overruns = counter(COUNTER_TRAVERSAL_OVERRUN);
    statistics.forgotten_media = counter(COUNTER_MEDIA_OVERFLOW);
    for (uint32_t queue = 0; queue < QUEUES_PER_BOUNCE; ++queue) {
      statistics.camera_items[queue] =
          counter(COUNTER_QUEUE_ITEMS + COUNTED_CAMERA_PASS * QUEUES_PER_BOUNCE + queue);
      statistics.light_items[queue] =
          counter(COUNTER_QUEUE_ITEMS + COUNTED_LIGHT_PASS * QUEUES_PER_BOUNCE + queue);
    }
    last_snapshot = Clock::now();
    snapshot_seconds = seconds_since(start);
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
      StageArguments arguments = arguments_of(first, 0, 0);
      for (arguments.round = 0; arguments.round <= AOV_RAYS; ++arguments.round)
        run_step("surface_aovs", arguments, std::min<uint64_t>(SURFACE_WAVE_PIXELS, count - first));
    }
    work.finish();
    return gpu::download_all<AovPixel>(device, buffers.aovs, count);
  }

  // Path slots serve as pixels, wave by wave.
  std::vector<vec3> surface_footprints() {
    std::vector<vec3> footprints;
    if ((plan.aovs & AOV_SIGMA) == 0) return footprints;
    const uint64_t slots = std::min<uint64_t>(SURFACE_WAVE_PIXELS, capacity);
    for (uint64_t first = 0; first < pixels; first += slots) {
      const auto count = static_cast<uint32_t>(std::min(slots, pixels - first));
      StageArguments arguments = arguments_of(first, 0, count);
      for (arguments.bounce = 0; arguments.bounce < plan.max_depth; ++arguments.bounce)
        run_step("surface_footprints", arguments, count);
      work.finish();
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
    own.exponents = film.exponents;
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
    if (!plan.has_strategy_images) return;
    uint64_t index = 0;
    for (const Strategy& strategy : list_strategies(plan.techniques, plan.max_depth)) {
      const image::Image weighted = strategy_image(strategy, index++);
      use({strategy, weighted, strategy_image(strategy, index++)});
    }
  }

  void render(const ProgressCallback& progress_in, const std::function<bool()>& is_cancelled) {
    const auto start = Clock::now();
    last_snapshot = start;
    progress = &progress_in;
    is_running = is_film_whole;
    // Images of strategies have no snapshots.
    if (!plan.has_strategy_images) work.set_cancellation(is_cancelled);
    if (!has_light_pass && !has_camera_pass)
      finished = total_paths;  // no technique can contribute: the image is black
    else if (plan.light_vertices.is_per_wave)
      render_by_waves();
    else
      render_by_iterations();
    if (is_film_whole) take_snapshot();
    if (is_running) progress_in(finished, total_paths);
    statistics.render_seconds += seconds_since(start);
  }
};

Renderer::Renderer(gpu::Device& device, const PreparedScene& prepared, const Plan& plan)
    : impl_(std::make_unique<Impl>(device, prepared, plan)) {}
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
void Renderer::render(const ProgressCallback& progress, const std::function<bool()>& is_cancelled) {
  impl_->render(progress, is_cancelled);
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
