// What a render has done and what it took.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "interface/wavefront.h"
#include "render/stages.hpp"

namespace regulus::render {

struct StageStatistics {
  uint64_t dispatches = 0;
  double device_ms = 0;
  double host_ms = 0;  ///< of rays traced by the host
};

/// About the submissions, which are handed to the device as a whole (render/work_queue.hpp).
struct SubmissionStatistics {
  uint64_t count = 0;
  uint64_t bound_items = 0;  ///< most items that one was allowed to hold
  uint64_t most_items = 0;   ///< most items that one could hold
  double longest_ms = 0;     ///< device time of the longest; 0 if times are not measured
};

struct RenderStatistics {
  std::map<std::string, StageStatistics> stages;  ///< by stage name
  uint64_t paths = 0;
  uint64_t light_paths = 0;
  using QueueItems = std::array<uint64_t, interface::QUEUES_PER_BOUNCE>;
  QueueItems camera_items{}, light_items{};  ///< by QUEUE_*, over all bounces of the camera and light passes
  uint64_t non_finite = 0;                   ///< samples dropped because NaN, infinite or negative: bugs
  uint64_t traversal_overruns = 0;           ///< rays whose traversal hit its step bound: bugs
  uint64_t forgotten_media = 0;              ///< solids that paths forgot, inside of more than MEDIA_SET_SIZE
  SubmissionStatistics submissions;
  uint32_t rays = interface::RAYS_SOFTWARE;  ///< RAYS_*, never _AUTO
  uint32_t wave_capacity = 0;                ///< path slots
  uint64_t bytes_per_path = 0;               ///< device memory per path in flight
  uint64_t resumed_paths = 0;                ///< of `paths`, those that Renderer::resume() brought along
  double render_seconds = 0;                 ///< wall time in render()
  double device_seconds = 0;                 ///< sum over stages

  uint64_t closest_rays() const {
    return camera_items[interface::QUEUE_RAYS] + light_items[interface::QUEUE_RAYS];
  }
  uint64_t visibility_rays() const {
    return camera_items[interface::QUEUE_VISIBILITY] + light_items[interface::QUEUE_SPLATS];
  }
  /// Number of items that a step's stage has worked on; 0 where that is not counted.
  uint64_t items(const StageStep& step) const {
    const bool is_light = step.pass == Pass::Light;
    if (step.extent == Extent::Bounce)
      return (is_light ? light_items : camera_items)[static_cast<uint32_t>(step.queue)];
    const bool is_per_path = step.extent == Extent::WaveStart || step.extent == Extent::WaveEnd;
    return !is_per_path ? 0 : is_light ? light_paths : paths;
  }
};

}  // namespace regulus::render
