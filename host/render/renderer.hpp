// The wavefront: renders a sample range of a scene in waves of paths.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "bvh/bvh.hpp"
#include "gpu/gpu.hpp"
#include "render/film.hpp"
#include "render/settings.hpp"
#include "render/stages.hpp"
#include "render/strategies.hpp"
#include "scene/scene.hpp"

namespace regulus::render {

struct StageStatistics {
  uint64_t dispatches = 0;
  double device_ms = 0;
};

struct RenderStatistics {
  std::map<std::string, StageStatistics> stages;  ///< by stage name
  uint64_t paths = 0;
  uint64_t light_paths = 0;
  using QueueItems = std::array<uint64_t, interface::QUEUES_PER_BOUNCE>;
  QueueItems camera_items{}, light_items{};  ///< by QUEUE_*, over all bounces of the camera and light passes
  uint64_t non_finite = 0;                   ///< samples dropped because NaN, infinite or negative: bugs
  uint64_t traversal_overruns = 0;           ///< rays whose traversal hit its step bound: bugs
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
  /// Items the stage of a step has worked on; 0 where that is not counted.
  uint64_t items(const StageStep& step) const {
    const bool is_light = step.pass == Pass::Light;
    if (step.extent == Extent::Bounce) return (is_light ? light_items : camera_items)[step.queue];
    const bool is_per_path = step.extent == Extent::WaveStart || step.extent == Extent::WaveEnd;
    return !is_per_path ? 0 : is_light ? light_paths : paths;
  }
};

/// Called between waves with the paths finished and the paths asked for; return false to stop.
using ProgressCallback = std::function<bool(uint64_t paths_done, uint64_t paths_total)>;

/// Renders with one device. The image is a function of scene and settings alone: neither wave size, timing
/// nor interruption changes the samples it consists of.
class Renderer {
 public:
  /// Uploads the scene and builds the pipelines. The scene must have been prepared by
  /// bvh::build_for_scene; `bvh` is its result. Scene and bvh may be freed afterwards.
  Renderer(gpu::Device& device, const scene::Scene& scene, const bvh::Bvh& bvh,
           const RenderSettings& settings);
  ~Renderer();

  /// Goes on where an earlier render of the same scene and settings stopped: render() then does what is left.
  /// Precondition: `film` was film() of a renderer with the same window, AOVs and effective techniques.
  void resume(const Film& film);

  /// What camera rays meet first, by pixel; empty unless a bit of SURFACE_AOVS is set. Not part of render().
  std::vector<interface::AovPixel> surface_aovs();

  /// Path diffusion's footprint (lib/footprint.glsl) where the ray through each pixel's centre first meets a
  /// surface that diffuses; a variance of the position of infinity if it meets none. Empty without AOV_SIGMA.
  /// Not part of render().
  std::vector<interface::vec3> surface_footprints();

  /// Renders until all samples are done or `progress` returns false. If the device is lost the error is
  /// thrown, and film() holds the last snapshot (at most a few seconds old).
  void render(const ProgressCallback& progress);

  const Film& film() const;
  const RenderStatistics& statistics() const;
  /// With settings.has_strategy_images, after render(): of every strategy, one after the other, each with
  /// `use`.
  void for_each_strategy(const std::function<void(const StrategyImages&)>& use) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace regulus::render
