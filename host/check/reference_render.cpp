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

reference::Settings reference_settings(const render::Plan& plan) {
  // Shares with and without regularization are two contributions to the reference, and one to the device.
  if (std::isfinite(plan.largest_contribution) &&
      ((plan.regularization & interface::REGULARIZATION_BOTH) != 0 ||
       plan.sampler_quality != interface::SAMPLER_QUALITY_OFF))
    throw Error(ErrorCode::BadUsage,
                "the scalar reference cannot clamp with regularization both or sampler quality");
  if ((plan.aovs & render::AOV_SIGMA) != 0)
    throw Error(ErrorCode::BadUsage, "the scalar reference has no aov sigma");
  reference::Settings result;
  result.width = plan.width;
  result.height = plan.height;
  result.crop = {plan.crop.x, plan.crop.y, plan.crop.width, plan.crop.height};
  result.largest_contribution = static_cast<double>(plan.largest_contribution);
  result.camera = plan.camera;
  result.first_sample = plan.first_sample;
  result.samples = plan.samples;
  result.max_depth = plan.max_depth;
  result.seed = plan.seed;
  result.sampler = plan.sampler;
  result.techniques = plan.techniques;
  result.light_paths = plan.light_paths;
  result.merge_radius = plan.merge_radius;
  result.merge_reduction = plan.merge_reduction;
  result.cache_connections = plan.cache_connections;
  result.regularization = plan.regularization;
  result.bound = plan.bound;
  result.mis = plan.mis;
  result.tau = plan.tau;
  result.sampler_quality = plan.sampler_quality;
  result.ndf = plan.ndf;
  result.shadowing = plan.shadowing;
  result.filter = {plan.filter, plan.filter_radius, plan.filter_sigma};
  return result;
}

ReferenceRender render_with_reference(const PreparedScene& prepared, const render::Plan& plan,
                                      const std::function<bool(uint64_t done, uint64_t total)>& progress) {
  const reference::Settings wanted = reference_settings(plan);
  const reference::World world(prepared, wanted.ndf, wanted.shadowing, plan.asked.light_sampling,
                               plan.has_energy_compensation);
  const uint64_t pixels = wanted.window().pixels();
  const reference::Film film = reference::render(
      world, wanted, [&](uint32_t done, uint32_t total) { return progress(done * pixels, total * pixels); });
  ReferenceRender result{{film.width, film.height, {}}, {}, film.iterations};
  for (size_t i = 0; i < pixels; ++i)
    for (int c = 0; c < 3; ++c) result.image.rgb.push_back(static_cast<float>(film.mean(i)[c]));
  if ((plan.aovs & render::SURFACE_AOVS) != 0) {
    const reference::Camera camera(
        scene::make_camera(prepared.scene.cameras.at(wanted.camera), wanted.width, wanted.height),
        wanted.width, wanted.height);
    render::add_surface_channels(reference::first_hits(world, camera, wanted), plan.aovs,
                                 prepared.scene.origin, result.channels);
  }
  add_film_channels(film, plan.aovs, result.channels);
  return result;
}

}  // namespace regulus::check
