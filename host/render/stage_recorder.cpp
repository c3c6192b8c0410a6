#include "render/stage_recorder.hpp"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "render/iteration.hpp"
#include "render/rays_choice.hpp"
#include "render/stage_observers.hpp"
#include "render/wave_scheduler.hpp"

namespace regulus::render {

using namespace interface;

Plan plan_recording(const PreparedScene& prepared, RenderSettings settings, uint32_t techniques) {
  settings.techniques = settings.techniques.value_or(ALL_TECHNIQUES) & techniques;
  settings.light_paths.reset();
  // What a segment carries is compared for each, not for the few that roulette spares.
  settings.shadow_roulette = 0;
  Plan plan = make_plan(prepared, settings);
  // The same kernels connect to the cache and to a path's own light path, which may have as many vertices as
  // edges.
  if (plan.connections_per_vertex != 0)
    plan.connections_per_vertex = std::max(plan.connections_per_vertex, plan.max_depth);
  return plan;
}

namespace {

// A wave holds all paths of a recording.
Plan in_one_wave(Plan plan, uint32_t paths) {
  plan.wave_paths = paths;
  return plan;
}

// It is kernels that are recorded, whoever is to trace the rays of pictures.
uint32_t rays_of_kernels(const gpu::Device& device, const PreparedScene& prepared, const Plan& plan) {
  return plan.rays == RAYS_HARDWARE ? resolve_rays(device.info(), prepared, plan) : RAYS_SOFTWARE;
}

}  // namespace

struct StageRecorder::Impl {
  Plan plan;
  uint32_t paths;
  RenderStatistics statistics;
  Wavefront wavefront;
  WaveScheduler scheduler;
  Iteration iteration;
  RecordingMemory memory;

  Impl(gpu::Device& device, const PreparedScene& prepared, const Plan& plan_in, uint32_t paths_in)
      : plan(in_one_wave(plan_in, paths_in)),
        paths(paths_in),
        wavefront(device, prepared, plan, rays_of_kernels(device, prepared, plan), statistics),
        scheduler(wavefront, [] { return true; }),
        iteration(wavefront, scheduler),
        memory(wavefront, paths) {
    if (wavefront.capacity < paths)
      throw std::logic_error("a recording needs a film with room for its paths");
    // Passes of a wave are recorded one by one: there is room for whatever the first leaves to the second.
    if (plan.keeps(STATE_VERTICES) && plan.is_per_wave)
      wavefront.buffers.grow_light_vertices(device, vertices_per_path(plan) * wavefront.capacity);
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
