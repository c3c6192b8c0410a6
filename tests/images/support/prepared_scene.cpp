#include "images/support/prepared_scene.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "bvh/scene_bvh.hpp"

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
