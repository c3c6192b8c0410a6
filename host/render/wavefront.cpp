#include "render/wavefront.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::render {

using namespace interface;

namespace {

// The least bound of a submission: a wave of the size that was asked for, or else a group of paths.
uint64_t least_bound(const Plan& plan, uint32_t capacity) {
  return ITEMS_PER_PATH * (plan.wave_paths != 0 ? capacity : WORKGROUP_SIZE);
}

}  // namespace

Wavefront::Wavefront(gpu::Device& device_in, const PreparedScene& prepared, const Plan& plan_in,
                     uint32_t rays_by, RenderStatistics& statistics_in)
    : device(device_in),
      plan(plan_in),
      statistics(statistics_in),
      pixels(plan.window().pixels()),
      scene(device, prepared, plan, rays_by),
      capacity(choose_capacity(device.info(), device.free_bytes(), plan,
                               std::max<uint64_t>(pixels * plan.samples, plan.light_paths))),
      buffers(device, scene,
              scene::make_camera(prepared.scene.cameras.at(plan.camera), plan.width, plan.height), plan,
              capacity),
      pipeline(build_pipeline(device, plan, rays_by)),
      scan(device),
      host_rays(rays_by == RAYS_HOST ? std::make_unique<HostRays>(prepared, plan, buffers, statistics)
                                     : nullptr),
      work(device, least_bound(plan, capacity), statistics),
      watch(work),
      core(device, work, watch, pipeline, buffers, plan, host_rays.get()) {
  statistics.rays = rays_by;
  statistics.wave_capacity = capacity;
}

bool Wavefront::has_pass(Pass pass) const {
  return std::ranges::any_of(pipeline, [&](const PipelineStep& entry) { return entry.step.pass == pass; });
}

StageArguments Wavefront::arguments_of(uint64_t first, uint64_t sample, uint32_t paths) const {
  const auto iteration = static_cast<double>(sample + 1);
  StageArguments arguments{};
  arguments.frame = buffers.frame_address();
  arguments.wave_paths = paths;
  arguments.first_pixel = static_cast<uint32_t>(first);
  arguments.first_sample = static_cast<uint32_t>(sample);
  arguments.merge_radius =
      plan.merge_radius * static_cast<float>(std::pow(iteration, -double{plan.merge_reduction}));
  return arguments;
}

void Wavefront::run_over(Pass pass, Stage stage, const StageArguments& arguments, uint64_t items) {
  const auto entry = std::ranges::find_if(pipeline, [&](const PipelineStep& candidate) {
    return candidate.step.pass == pass && candidate.step.stage == stage;
  });
  if (entry == pipeline.end()) return;
  watch.before(pass, stage, arguments);
  StageArguments own = arguments;
  for (uint64_t done = 0, here = 0; done < items; done += here) {
    here = std::min(work.bound(), items - done);
    own.first_pixel = arguments.first_pixel + static_cast<uint32_t>(done);
    record_items(work.room_for(here), *entry, own, here, &StageArguments::first_pixel,
                 device.info().max_groups);
  }
  watch.after(pass, stage, arguments);
}

void Wavefront::run_scan(Pass pass, const StageArguments& arguments, const gpu::Buffer& words,
                         uint32_t count) {
  watch.before(pass, Stage::ScanSums, arguments);
  scan.record(work.room_for(std::min<uint64_t>(work.bound(), count / SCAN_FAN + 1)), words, count);
  watch.after(pass, Stage::ScanSums, arguments);
}

}  // namespace regulus::render
