#include "render/renderer.hpp"

#include <algorithm>
#include <chrono>
#include <deque>

#include "base/error.hpp"
#include "render/device_scene.hpp"
#include "render/stages.hpp"

namespace regulus::render {

using namespace interface;
using Clock = std::chrono::steady_clock;

namespace {

// Device memory of one path slot, over all queues.
constexpr uint64_t BYTES_PER_PATH = sizeof(Path) + sizeof(Hit) + sizeof(vec3) + 2 * sizeof(uint32_t) +
                                    MATERIAL_CLASS_COUNT * sizeof(uint32_t) + sizeof(VisibilityCandidate);

// A wave is doubled while it takes less than the first and halved when it takes more than the second: the
// submission stays well under the 200 ms at which watchdogs of interactive systems get nervous.
constexpr double SHORT_WAVE_MS = 50, LONG_WAVE_MS = 150;
constexpr uint32_t FIRST_WAVE_PATHS = 1u << 14;
// On a CPU device a small wave stays in cache; a GPU wants enough paths to fill it at the last bounces too.
constexpr uint32_t SOFTWARE_WAVE_PATHS = 1u << 16, HARDWARE_WAVE_PATHS = 1u << 21;
// Waves handed to the device ahead of time, so that it never waits for the host.
constexpr size_t WAVES_IN_FLIGHT = 2;
constexpr double SNAPSHOT_SECONDS = 5;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

uint32_t choose_capacity(const gpu::Device& device, const RenderSettings& settings, uint64_t total_paths) {
  uint64_t paths = settings.wave_paths;
  if (paths == 0) {
    paths = device.info().kind == gpu::DeviceKind::Software ? SOFTWARE_WAVE_PATHS : HARDWARE_WAVE_PATHS;
    paths = std::min(paths, device.free_bytes() / 2 / BYTES_PER_PATH);
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
  uint32_t capacity;
  DeviceScene scene;
  gpu::Buffer paths, hits, radiance, ray_queues, bounce_queues, candidates, queue_heads, empty_heads,
      film_sums, counters, frame_buffer;
  std::vector<PipelineStep> pipeline;
  Film film;
  RenderStatistics statistics;

  struct Wave {
    gpu::Submission submission;
    uint32_t paths;
  };
  std::deque<Wave> in_flight;
  uint64_t submitted = 0, finished = 0;  // paths

  Impl(gpu::Device& device_in, const scene::Scene& scene_in, const bvh::Bvh& bvh,
       const RenderSettings& settings_in)
      : device(device_in),
        settings(settings_in),
        pixels(uint64_t{settings.width} * settings.height),
        total_paths(pixels * settings.samples),
        capacity(choose_capacity(device, settings, total_paths)),
        scene(device, scene_in, bvh) {
    if (settings.techniques & LIGHT_SUBPATH_TECHNIQUES)
      throw Error(ExitStatus::BadUsage, "techniques splat, connect and merge are not built for devices yet");
    create_buffers();
    write_frame(scene_in);
    pipeline = build_pipeline(device, scene::find_features(scene_in), settings);
    film = {settings.width, settings.height, std::vector<uint32_t>(pixels * FILM_WORDS_PER_PIXEL), 0};
    statistics.wave_capacity = capacity;
    statistics.bytes_per_path = BYTES_PER_PATH;
  }

  void create_buffers() {
    const auto per_path = [&](uint64_t bytes, const char* name) {
      return device.create_buffer(capacity * bytes, name);
    };
    paths = per_path(sizeof(Path), "paths");
    hits = per_path(sizeof(Hit), "hits");
    radiance = per_path(sizeof(vec3), "radiance");
    ray_queues = per_path(2 * sizeof(uint32_t), "ray queues");
    bounce_queues = per_path(MATERIAL_CLASS_COUNT * sizeof(uint32_t), "bounce queues");
    candidates = per_path(sizeof(VisibilityCandidate), "visibility candidates");
    // One head more than bounces: the last bounce still names the queue after it.
    const std::vector<QueueHead> heads((settings.max_depth + 1) * QUEUES_PER_BOUNCE, {0, 1, 1, 0});
    empty_heads = gpu::upload_new(device, heads, "empty queue heads");
    queue_heads = gpu::upload_new(device, heads, "queue heads");
    film_sums = device.create_buffer(pixels * FILM_WORDS_PER_PIXEL * sizeof(uint32_t), "film");
    counters = device.create_buffer(COUNTER_COUNT * 2 * sizeof(uint32_t), "counters");
  }

  void write_frame(const scene::Scene& scene_in) {
    const auto address = [](const gpu::Buffer& buffer) { return device_address(buffer.address()); };
    Frame frame{};
    scene.fill(frame);
    frame.paths = address(paths);
    frame.hits = address(hits);
    frame.radiance = address(radiance);
    frame.ray_queues = address(ray_queues);
    frame.bounce_queues = address(bounce_queues);
    frame.candidates = address(candidates);
    frame.queue_heads = address(queue_heads);
    frame.film = address(film_sums);
    frame.counters = address(counters);
    frame.width = settings.width;
    frame.height = settings.height;
    frame.seed = settings.seed;
    frame.max_depth = settings.max_depth;
    frame.wave_capacity = capacity;
    frame.filter_radius = settings.filter_radius;
    frame.filter_sigma = settings.filter_sigma;
    frame.camera = scene::make_camera(scene_in.cameras.at(settings.camera), settings.width, settings.height);
    frame_buffer = gpu::upload_new(device, std::vector<Frame>{frame}, "frame");
  }

  void submit_wave(uint32_t wave_paths) {
    StageArguments arguments{};
    arguments.frame = device_address(frame_buffer.address());
    arguments.wave_paths = wave_paths;
    arguments.first_pixel = static_cast<uint32_t>(submitted % pixels);
    arguments.first_sample = static_cast<uint32_t>(settings.first_sample + submitted / pixels);
    gpu::CommandList commands(device);
    commands.copy(empty_heads, 0, queue_heads, 0, queue_heads.size());
    record_wave(commands, pipeline, {queue_heads, arguments, settings.max_depth});
    in_flight.push_back({device.submit(std::move(commands)), wave_paths});
    submitted += wave_paths;
  }

  // Waits for the oldest wave.
  void finish_wave() {
    for (const gpu::StageTime& time : device.wait(in_flight.front().submission)) {
      StageStatistics& stage = statistics.stages[time.stage];
      ++stage.dispatches;
      stage.device_ms += time.device_ms;
      statistics.device_seconds += 1e-3 * time.device_ms;
    }
    finished += in_flight.front().paths;
    in_flight.pop_front();
  }

  // Copies the film to the host, so that what is done survives the device.
  void take_snapshot() {
    while (!in_flight.empty()) finish_wave();
    // The film changes as a whole or, if the device is lost on the way, not at all.
    std::vector<uint32_t> sums = gpu::download_all<uint32_t>(device, film_sums, film.words.size());
    const auto words = gpu::download_all<uint32_t>(device, counters, 2 * COUNTER_COUNT);
    film.words.swap(sums);
    film.paths = finished;
    const auto counter = [&](uint32_t index) {
      return words[2 * index] | uint64_t{words[2 * index + 1]} << 32;
    };
    statistics.paths = finished;
    statistics.non_finite = counter(COUNTER_NON_FINITE);
    statistics.traversal_overruns = counter(COUNTER_TRAVERSAL_OVERRUN);
    for (uint32_t queue = 0; queue < QUEUES_PER_BOUNCE; ++queue)
      statistics.queue_items[queue] = counter(COUNTER_QUEUE_ITEMS + queue);
  }

  void render(const ProgressCallback& progress) {
    const auto start = Clock::now();
    auto last_snapshot = start, last_wave = start;
    uint32_t wave_paths = settings.wave_paths != 0 ? capacity : std::min(capacity, FIRST_WAVE_PATHS);
    bool running = true;
    while (running && finished < total_paths) {
      while (in_flight.size() < WAVES_IN_FLIGHT && submitted < total_paths)
        submit_wave(static_cast<uint32_t>(std::min<uint64_t>(wave_paths, total_paths - submitted)));
      const uint32_t measured_paths = in_flight.front().paths;
      finish_wave();
      // The device always has the next wave at hand, so it spent the time since the last wave on this one.
      const double wave_ms = 1e3 * seconds_since(last_wave);
      last_wave = Clock::now();
      if (settings.wave_paths == 0 && measured_paths == wave_paths) {
        if (wave_ms < SHORT_WAVE_MS) wave_paths = std::min(capacity, 2 * wave_paths);
        if (wave_ms > LONG_WAVE_MS) wave_paths = std::max(WORKGROUP_SIZE, wave_paths / 2);
      }
      running = progress(finished, total_paths);
      if (seconds_since(last_snapshot) > SNAPSHOT_SECONDS) {
        take_snapshot();
        last_snapshot = Clock::now();
      }
    }
    take_snapshot();
    statistics.render_seconds += seconds_since(start);
  }
};

Renderer::Renderer(gpu::Device& device, const scene::Scene& scene, const bvh::Bvh& bvh,
                   const RenderSettings& settings)
    : impl_(std::make_unique<Impl>(device, scene, bvh, settings)) {}
Renderer::~Renderer() = default;

void Renderer::render(const ProgressCallback& progress) {
  impl_->render(progress);
}
const Film& Renderer::film() const {
  return impl_->film;
}
const RenderStatistics& Renderer::statistics() const {
  return impl_->statistics;
}

}  // namespace regulus::render
