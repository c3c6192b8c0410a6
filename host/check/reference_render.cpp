#include "check/reference_render.hpp"

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "reference/first_hits.hpp"
#include "render/aov.hpp"
#include "render/cryptomatte.hpp"
#include "render/reference_settings.hpp"

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

void add_layers(const reference::Film& film, const std::vector<std::string>& names,
                image::Channels& channels) {
  for (size_t layer = 0; layer < names.size(); ++layer)
    for (int c = 0; c < 3; ++c) {
      std::vector<float> values;
      for (const glm::dvec3& sum : film.layers[layer])
        values.push_back(static_cast<float>(sum[c] / std::max(film.iterations, 1u)));
      channels[names[layer] + "." + "RGB"[c]] = std::move(values);
    }
}

}  // namespace

ReferenceRender render_with_reference(const PreparedScene& prepared, const render::Plan& plan,
                                      const std::function<bool(uint64_t done, uint64_t total)>& progress) {
  const reference::Settings wanted = render::reference_settings(plan);
  const reference::World world(prepared, wanted.ndf, wanted.shadowing, plan.asked.light_sampling,
                               plan.has_energy_compensation, plan.light_guide, plan.walk_guide);
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
    if ((plan.aovs & render::CRYPTO_AOVS) != 0) {
      std::vector<render::RayIds> ids;
      for (const glm::uvec2& met : reference::first_ids(world, camera, wanted)) ids.push_back({met.x, met.y});
      render::add_cryptomattes(prepared.scene, ids, plan.aovs, result.channels);
    }
  }
  add_film_channels(film, plan.aovs, result.channels);
  add_layers(film, plan.layers.names, result.channels);
  return result;
}

}  // namespace regulus::check
