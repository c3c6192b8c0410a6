// The wavefront: renders a sample range of a scene in waves of paths.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>

#include "gpu/gpu.hpp"
#include "prepared/prepared_scene.hpp"
#include "render/cryptomatte.hpp"
#include "render/film.hpp"
#include "render/plan.hpp"
#include "render/statistics.hpp"
#include "render/strategies.hpp"

namespace regulus::render {

/// Called between waves with the paths finished and the paths asked for; return false to stop.
using ProgressCallback = std::function<bool(uint64_t paths_done, uint64_t paths_total)>;

/// Renders with one device. The image is a function of scene and settings alone: neither wave size, timing
/// nor interruption changes the samples it consists of.
class Renderer {
 public:
  /// Uploads the scene and builds the pipelines. `prepared` must outlive the object if the host traces rays,
  /// and may be freed otherwise. @throws regulus::Error (BadUsage) if the plan's rays are not possible
  Renderer(gpu::Device& device, const PreparedScene& prepared, const Plan& plan);
  ~Renderer();

  /// Goes on where an earlier render of the same scene and settings stopped: render() then does what is left.
  /// Precondition: `film` was film() of a renderer with the same window, AOVs and effective techniques.
  void resume(const Film& film);

  /// From now on these samples of every pixel are asked for, beside those that are done: film() will hold
  /// both. Precondition: what is done are whole samples of every pixel.
  void continue_with(uint32_t first_sample, uint32_t samples);

  /// What camera rays meet first, by pixel; empty unless a bit of SURFACE_AOVS is set. Not part of render().
  std::vector<interface::AovPixel> surface_aovs();
  /// With CRYPTO_AOVS, after surface_aovs(): what each of its rays meets, AOV_RAYS of each pixel.
  std::vector<RayIds> ray_ids() const;

  /// Path diffusion's footprint (lib/footprint.glsl) where the ray through each pixel's centre first meets a
  /// surface that diffuses; a variance of the position of infinity if it meets none. Empty without AOV_SIGMA.
  /// Not part of render().
  std::vector<interface::vec3> surface_footprints();

  /// Renders until all samples are done, or `progress` returns false: what has been begun is then finished,
  /// and another call goes on from there.
  /// `is_cancelled` is asked after every submission. Once it says yes, nothing more is begun: at most one
  /// submission that was under way still runs, and film() holds the last state between two waves. If the
  /// device is lost, the error is thrown and film() holds the last snapshot; one is taken whenever the last
  /// is fifty times as old as it took to make.
  void render(const ProgressCallback& progress, const std::function<bool()>& is_cancelled = {});

  const Film& film() const;
  const RenderStatistics& statistics() const;
  /// With plan.has_strategy_images, after render(): calls `use` with the images of every strategy, one after
  /// the other.
  void for_each_strategy(const std::function<void(const StrategyImages&)>& use) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace regulus::render
