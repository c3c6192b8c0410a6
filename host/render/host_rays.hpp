// Rays traced by host code in the memory of a software device, which is the host's: the ray stages beside the
// kernels.
#pragma once

#include <cstdint>

#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "prepared/prepared_scene.hpp"
#include "rays/scene_query.hpp"
#include "render/plan.hpp"
#include "render/stages.hpp"
#include "render/statistics.hpp"
#include "render/wavefront_buffers.hpp"
#include "render/workers.hpp"

namespace regulus::render {

class HostRays {
 public:
  /// All must outlive the object. Precondition: resolve_rays() says RAYS_HOST.
  HostRays(const PreparedScene& prepared, const Plan& plan, const WavefrontBuffers& buffers,
           RenderStatistics& statistics);

  /// Whether the step's rays are traced here, and whether a kernel does the rest of the step.
  static bool traces(const StageStep& step);
  static bool needs_kernel(const StageStep& step);

  /// Traces the queue of the step and bounce. Without a kernel this does the whole step: hits are written,
  /// and paths are put into the queues of what they have met. With a kernel, blocked segments get a t_max of
  /// -1. Precondition: nothing that uses the buffers is in flight.
  void trace(const StageStep& step, uint32_t bounce);

 private:
  void trace_closest(Pass pass, uint32_t bounce);
  template <typename Candidate>
  void trace_segments(const gpu::Buffer& candidates, uint32_t count);
  QueueHeads& heads_of(uint32_t bounce) const;

  rays::SceneQuery query_;
  const WavefrontBuffers& buffers_;
  RenderStatistics& statistics_;
  bool has_escapes_;  ///< camera rays that meet nothing are queued
  uint32_t capacity_;
  Workers workers_;
};

}  // namespace regulus::render
