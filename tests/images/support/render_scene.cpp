#include "images/support/render_scene.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "bvh/scene_bvh.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test {

namespace fs = std::filesystem;

PreparedScene prepare(const fs::path& path) {
  PreparedScene prepared{scene::load(path), {}};
  prepared.bvh = bvh::build_for_scene(prepared.scene);
  return prepared;
}

PreparedScene prepare(const GltfScene& scene) {
  const TemporaryFolder folder;
  const fs::path path = folder / "scene.gltf";
  scene.write(path);
  PreparedScene prepared = prepare(path);
  for (const std::string& warning : prepared.scene.warnings)
    ADD_FAILURE() << "warning of the loader: " << warning;
  return prepared;
}

Rendered render(const PreparedScene& prepared, const render::RenderSettings& settings) {
  render::Renderer renderer(*device(), prepared.scene, prepared.bvh, settings);
  renderer.render([](uint64_t, uint64_t) { return true; });
  EXPECT_EQ(renderer.statistics().non_finite, 0u);
  EXPECT_EQ(renderer.statistics().traversal_overruns, 0u);
  EXPECT_EQ(renderer.film().paths, uint64_t{settings.width} * settings.height * settings.samples);
  return {renderer.film(), resolve(renderer.film()), renderer.statistics()};
}

render::RenderSettings box_filtered(uint32_t width, uint32_t height, uint32_t samples, uint32_t max_depth) {
  render::RenderSettings settings;
  settings.width = width;
  settings.height = height;
  settings.samples = samples;
  settings.max_depth = max_depth;
  settings.filter = interface::FILTER_BOX;
  settings.filter_radius = 0.5f;
  return settings;
}

render::RenderSettings point_sampled(uint32_t width, uint32_t height, uint32_t max_depth) {
  render::RenderSettings settings = box_filtered(width, height, 1, max_depth);
  settings.filter_radius = 0;
  return settings;
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

bool is_slow_device() {
  return device()->info().name.find("SwiftShader") != std::string::npos;
}

nlohmann::json expected_of(const fs::path& gltf) {
  std::ifstream file(gltf);
  return nlohmann::json::parse(file).at("scenes").at(0).at("extras").at("regulus_expected");
}

fs::path own_scenes() {
  return fs::path(REGULUS_SOURCE_DIR) / "scenes";
}

fs::path assets() {
  return REGULUS_ASSETS_DIR;
}

}  // namespace regulus::test
