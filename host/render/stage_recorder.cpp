#include "render/stage_recorder.hpp"

#include <string_view>

#include "render/device_scene.hpp"
#include "render/wavefront_buffers.hpp"

namespace regulus::render {

using namespace interface;

namespace {

RenderSettings recorded_settings(const scene::Scene& scene, RenderSettings settings) {
  settings.techniques &= TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT;
  settings.techniques = effective_techniques(scene::find_features(scene), settings);
  settings.light_paths = settings.width * settings.height;
  return settings;
}

}  // namespace

struct StageRecorder::Impl {
  gpu::Device& device;
  RenderSettings settings;
  uint32_t paths;
  DeviceScene scene;
  WavefrontBuffers buffers;
  std::vector<PipelineStep> pipeline;

  Impl(gpu::Device& device_in, const scene::Scene& scene_in, const bvh::Bvh& bvh,
       const RenderSettings& settings_in, uint32_t paths_in)
      : device(device_in),
        settings(recorded_settings(scene_in, settings_in)),
        paths(paths_in),
        scene(device, scene_in, bvh),
        buffers(device, scene,
                scene::make_camera(scene_in.cameras.at(settings.camera), settings.width, settings.height),
                settings, (paths + WORKGROUP_SIZE - 1) / WORKGROUP_SIZE * WORKGROUP_SIZE),
        pipeline(build_pipeline(device, scene::find_features(scene_in), settings)) {}

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

  RecordedBounce record_bounce(Pass pass, const StageArguments& arguments) {
    const bool is_camera = pass == Pass::Camera;
    RecordedBounce recorded;
    recorded.slots = ray_queue(arguments.bounce);
    recorded.before = download<Path>(buffers.paths_, paths);
    gpu::CommandList clear(device);
    clear.fill(buffers.hits_, 0, buffers.hits_.size(), INVALID_INDEX);  // a ray that misses leaves no hit
    gpu::Submission cleared = device.submit(std::move(clear));
    device.wait(cleared);
    run(pass, "trace_closest", arguments);
    recorded.hits = download<Hit>(buffers.hits_, paths);
    run(pass, "escape", arguments);
    run(pass, is_camera ? "camera_bounce" : "light_bounce", arguments);
    recorded.after = download<Path>(buffers.paths_, paths);
    recorded.continuing = ray_queue(arguments.bounce + 1);
    if (!is_camera) return recorded;
    recorded.candidates =
        download<VisibilityCandidate>(buffers.candidates_, queue_count(arguments.bounce, QUEUE_VISIBILITY));
    recorded.radiance_before_visibility = download<glm::vec3>(buffers.radiance_, paths);
    run(pass, "trace_visibility", arguments);
    recorded.radiance = download<glm::vec3>(buffers.radiance_, paths);
    return recorded;
  }
};

StageRecorder::StageRecorder(gpu::Device& device, const scene::Scene& scene, const bvh::Bvh& bvh,
                             const RenderSettings& settings, uint32_t paths)
    : impl_(std::make_unique<Impl>(device, scene, bvh, settings, paths)) {}
StageRecorder::~StageRecorder() = default;

const RenderSettings& StageRecorder::settings() const {
  return impl_->settings;
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
  Recording recording;
  recording.generated = impl.download<Path>(impl.buffers.paths_, impl.paths);
  const uint32_t bounces =
      pass == Pass::Camera ? impl.settings.max_depth : std::max(impl.settings.max_depth, 2u) - 1;
  for (arguments.bounce = 0; arguments.bounce < bounces; ++arguments.bounce) {
    recording.bounces.push_back(impl.record_bounce(pass, arguments));
    if (recording.bounces.back().continuing.empty()) break;
  }
  return recording;
}

}  // namespace regulus::render
