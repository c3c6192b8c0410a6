#include "check/reference_render.hpp"

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "reference/first_hits.hpp"
#include "render/aov.hpp"

namespace regulus::check {

namespace {

// Channels of --aov that come from the samples, as render::add_film_channels has them.
void add_film_channels(const reference::Film& film, uint32_t aovs, image::Channels& channels) {
  const size_t pixels = film.sum.size();
  if ((aovs & render::AOV_VARIANCE) != 0)
    for (int c = 0; c < 3; ++c) {
      std::vector<float> variance(pixels, std::numeric_limits<float>::infinity());
      for (size_t i = 0; i < pixels && film.iterations >= 2; ++i)
        variance[i] = static_cast<float>(film.variance_of_mean(i)[c]);
      channels[std::string("variance.") + "RGB"[c]] = std::move(variance);
    }
  if ((aovs & render::AOV_SAMPLES) != 0) channels["samples"] = std::vector<uint32_t>(pixels, film.iterations);
}

}  // namespace

reference::Settings reference_settings(const render::RenderSettings& settings) {
  // Shares with and without regularization are two contributions to the reference, and one to the device.
  if (std::isfinite(settings.largest_contribution) &&
      ((settings.regularization & interface::REGULARIZATION_BOTH) != 0 ||
       settings.sampler_quality != interface::SAMPLER_QUALITY_OFF))
    throw Error(ExitStatus::BadUsage,
                "the scalar reference has no --clamp with --regularization both or sampler quality");
  if ((settings.aovs & render::AOV_SIGMA) != 0)
    throw Error(ExitStatus::BadUsage, "the scalar reference has no --aov sigma");
  reference::Settings result;
  result.width = settings.width;
  result.height = settings.height;
  result.crop = {settings.crop.x, settings.crop.y, settings.crop.width, settings.crop.height};
  result.largest_contribution = static_cast<double>(settings.largest_contribution);
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
  const reference::World world(scene, bvh, wanted.ndf, wanted.shadowing, settings.light_sampling,
                               settings.has_energy_compensation);
  const uint64_t pixels = wanted.window().pixels();
  const reference::Film film = reference::render(
      world, wanted, [&](uint32_t done, uint32_t total) { return progress(done * pixels, total * pixels); });
  ReferenceRender result{{film.width, film.height, {}}, {}, film.iterations};
  for (size_t i = 0; i < pixels; ++i)
    for (int c = 0; c < 3; ++c) result.image.rgb.push_back(static_cast<float>(film.mean(i)[c]));
  if ((settings.aovs & render::SURFACE_AOVS) != 0) {
    const reference::Camera camera(
        scene::make_camera(scene.cameras.at(wanted.camera), wanted.width, wanted.height), wanted.width,
        wanted.height);
    render::add_surface_channels(reference::first_hits(world, camera, wanted), settings.aovs, scene.origin,
                                 result.channels);
  }
  add_film_channels(film, settings.aovs, result.channels);
  return result;
}

}  // namespace regulus::check
