#include "images/support/prepared_scene.hpp"

#include <gtest/gtest.h>

#include <fstream>

namespace regulus::test {

namespace fs = std::filesystem;

PreparedScene prepare(const fs::path& path, const scene::LoadOptions& options) {
  return regulus::prepare(scene::load(path, options));
}

namespace {

PreparedScene prepare_in(const TemporaryFolder& folder, const GltfScene& scene,
                         const scene::LoadOptions& options = {}) {
  const fs::path path = folder / "scene.gltf";
  scene.write(path);
  PreparedScene prepared = prepare(path, options);
  const std::string& expected = scene.expected_warning();
  bool is_found = expected.empty();
  for (const std::string& warning : prepared.scene.warnings) {
    const bool is_expected = !expected.empty() && warning.find(expected) != std::string::npos;
    is_found = is_found || is_expected;
    if (!is_expected) ADD_FAILURE() << "warning of the loader: " << warning;
  }
  EXPECT_TRUE(is_found) << "no warning: " << expected;
  return prepared;
}

}  // namespace

PreparedScene prepare(const GltfScene& scene, const scene::LoadOptions& options) {
  return prepare_in(TemporaryFolder(), scene, options);
}

PreparedScene prepare(GltfScene scene, const image::Image& environment, double rotation) {
  const TemporaryFolder folder;
  image::write_exr(folder / "environment.exr", environment);
  scene.set_setting("environment", {{"file", "environment.exr"}, {"rotation", rotation}});
  return prepare_in(folder, scene);
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
