#include "images/support/render_scene.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "render/aov.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {

Rendered render(const PreparedScene& prepared, const render::RenderSettings& settings) {
  render::Renderer renderer(*device(), prepared, make_plan(prepared, settings));
  renderer.render([](uint64_t, uint64_t) { return true; });
  EXPECT_EQ(renderer.statistics().non_finite, 0u);
  EXPECT_EQ(renderer.statistics().traversal_overruns, 0u);
  EXPECT_EQ(renderer.film().paths, settings.window().pixels() * settings.samples);
  return {renderer.film(), resolve(renderer.film()), renderer.statistics()};
}

render::RenderSettings box_filtered(uint32_t width, uint32_t height, uint32_t samples, uint32_t max_depth) {
  render::RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples = samples;
  settings.max_depth = max_depth;
  settings.filter = interface::FILTER_BOX;
  settings.keeps_merge_radius = true;
  settings.filter_radius = 0.5f;
  return settings;
}

render::RenderSettings point_sampled(uint32_t width, uint32_t height, uint32_t max_depth) {
  render::RenderSettings settings = box_filtered(width, height, 1, max_depth);
  settings.filter_radius = 0;
  return settings;
}

image::Channels surface_channels(const PreparedScene& prepared, render::RenderSettings settings) {
  settings.aovs = render::SURFACE_AOVS;
  render::Renderer renderer(*device(), prepared, make_plan(prepared, settings));
  image::Channels channels;
  render::add_surface_channels(renderer.surface_aovs(), settings.aovs, prepared.scene.origin, channels);
  return channels;
}

float tau_of_mirrors(double alpha) {
  return static_cast<float>(1 / (4 * std::numbers::pi * alpha * alpha));
}

std::vector<image::Image> render_batches(const PreparedScene& prepared, render::RenderSettings settings,
                                         int count, uint32_t stream) {
  std::vector<image::Image> images;
  const auto first = static_cast<uint32_t>(base_seed()) + 1000 * stream;
  for (int i = 0; i < count; ++i) {
    settings.seed = first + static_cast<uint32_t>(i);
    images.push_back(render(prepared, settings).image);
  }
  return images;
}

}  // namespace regulus::test
