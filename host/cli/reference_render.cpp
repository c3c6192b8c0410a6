#include "cli/reference_render.hpp"

#include <cmath>

#include "base/error.hpp"

namespace regulus::cli {

reference::Settings reference_settings(const render::RenderSettings& settings) {
  if (std::isfinite(settings.largest_contribution))
    throw Error(ExitStatus::BadUsage, "the scalar reference has no --clamp");
  if (settings.crop.pixels() != 0 || settings.aovs != 0 || settings.has_energy_compensation)
    throw Error(ExitStatus::BadUsage, "the scalar reference has no --crop, --aov or --energy-compensation");
  reference::Settings result;
  result.width = settings.width;
  result.height = settings.height;
  result.camera = settings.camera;
  result.first_sample = settings.first_sample;
  result.samples = settings.samples;
  result.max_depth = settings.max_depth;
  result.seed = settings.seed;
  result.sampler = settings.sampler;
  result.techniques = settings.techniques;
  result.light_paths = settings.light_paths;
  result.merge_radius = settings.merge_radius;
  result.merge_reduction = settings.merge_reduction;
  result.cache_connections = settings.cache_connections;
  result.regularization = settings.regularization;
  result.bound = settings.bound;
  result.mis = settings.mis;
  result.tau = settings.tau;
  result.sampler_quality = settings.sampler_quality;
  result.ndf = settings.ndf;
  result.shadowing = settings.shadowing;
  result.filter = {settings.filter, settings.filter_radius, settings.filter_sigma};
  return result;
}

ReferenceRender render_with_reference(const scene::Scene& scene, const bvh::Bvh& bvh,
                                      const render::RenderSettings& settings,
                                      const std::function<bool(uint64_t done, uint64_t total)>& progress) {
  const reference::Settings wanted = reference_settings(settings);
  const reference::World world(scene, bvh, wanted.ndf, wanted.shadowing, settings.light_sampling);
  const uint64_t pixels = uint64_t{wanted.width} * wanted.height;
  const reference::Film film = reference::render(
      world, wanted, [&](uint32_t done, uint32_t total) { return progress(done * pixels, total * pixels); });
  ReferenceRender result{{wanted.width, wanted.height, {}}, film.iterations};
  for (size_t i = 0; i < pixels; ++i)
    for (int c = 0; c < 3; ++c) result.image.rgb.push_back(static_cast<float>(film.mean(i)[c]));
  return result;
}

}  // namespace regulus::cli
