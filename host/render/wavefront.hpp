// What all parts of a render on a device share: the scene and the arrays in its memory, the kernels, and the
// work on its way.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/device_scene.hpp"
#include "render/host_rays.hpp"
#include "render/plan.hpp"
#include "render/scan.hpp"
#include "render/stages.hpp"
#include "render/watch.hpp"
#include "render/wave_core.hpp"
#include "render/wavefront_buffers.hpp"
#include "render/work_queue.hpp"

namespace regulus::render {

struct Wavefront {
  /// Uploads the scene and builds the kernels, with rays traced by `rays_by`, see resolve_rays().
  /// `device`, `plan` and `statistics` must outlive the object, `prepared` if the host traces rays.
  /// @throws regulus::Error if memory or the device's limits do not suffice
  Wavefront(gpu::Device& device, const PreparedScene& prepared, const Plan& plan, uint32_t rays_by,
            RenderStatistics& statistics);
  Wavefront(const Wavefront&) = delete;
  Wavefront& operator=(const Wavefront&) = delete;

  /// Whether any stage of the pass is needed.
  bool has_pass(Pass pass) const;

  /// Arguments of a wave of `paths` paths that starts at path `first` of a sample of every pixel.
  interface::StageArguments arguments_of(uint64_t first, uint64_t sample, uint32_t paths) const;

  /// Records a stage over `items` items, from arguments.first_pixel on.
  void run_over(Pass pass, Stage stage, const interface::StageArguments& arguments, uint64_t items);

  /// Records the scan of the first `count` words of a buffer, which is Stage::ScanSums of the pass.
  void run_scan(Pass pass, const interface::StageArguments& arguments, const gpu::Buffer& words,
                uint32_t count);

  gpu::Device& device;
  const Plan& plan;
  RenderStatistics& statistics;
  uint64_t pixels;
  DeviceScene scene;
  uint32_t capacity;  ///< path slots
  WavefrontBuffers buffers;
  std::vector<PipelineStep> pipeline;
  Scan scan;
  std::unique_ptr<HostRays> host_rays;  ///< null: kernels trace rays
  WorkQueue work;
  Watch watch;
  WaveCore core;
};

}  // namespace regulus::render
