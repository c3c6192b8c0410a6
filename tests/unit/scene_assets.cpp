// The eleven scenes of the shared assets: all load, with the triangles their index lists. Triangles without
// area are the difference; they are counted here from the files' own numbers in the loader's warning.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

struct Asset {
  const char* name;
  size_t triangles;       // INDEX.md
  glm::uvec2 resolution;  // INDEX.md
};

constexpr Asset ASSETS[] = {
    {"bathroom", 380290, {1024, 1024}},         {"cornell-box", 36, {1024, 1024}},
    {"cornell-dragon100k", 100972, {512, 512}}, {"etx-sds", 9042, {1024, 1024}},
    {"living-room", 147131, {1280, 720}},       {"lumen-occluded", 3972, {1280, 720}},
    {"lux-causticcube", 18436, {1000, 600}},    {"lux-juice", 8280, {960, 540}},
    {"lux-kitchen", 86032, {640, 480}},         {"staircase", 262663, {720, 1280}},
    {"veach-mis", 27124, {1280, 720}},
};

class SceneAssets : public testing::TestWithParam<Asset> {};

/// Number N of the warning "N of M triangles have no area", 0 without it.
size_t dropped_triangles(const Scene& scene) {
  for (const std::string& warning : scene.warnings) {
    size_t dropped = 0, total = 0;
    if (std::sscanf(warning.c_str(), "%zu of %zu triangles have no area", &dropped, &total) == 2)
      return dropped;
  }
  return 0;
}

TEST_P(SceneAssets, LoadWholeAndKeepTheirInvariants) {
  const Asset& asset = GetParam();
  const auto path = std::filesystem::path(REGULUS_ASSETS_DIR) / "scenes" / (std::string(asset.name) + ".glb");
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not here";
  Scene scene = load(path);
  EXPECT_EQ(scene.triangles.size() + dropped_triangles(scene), asset.triangles);
  EXPECT_EQ(scene.resolution, asset.resolution);
  EXPECT_EQ(scene.cameras.size(), 1u);

  build_lights(scene);
  ASSERT_FALSE(scene.lights.empty());
  double total_pdf = 0;
  for (const interface::Light& light : scene.lights) total_pdf += light.selection_pdf;
  // Each pdf is rounded to float: half a spacing of a number that sums to 1.
  EXPECT_NEAR(total_pdf, 1, 0x1p-24);

  for (const interface::Vertex& vertex : scene.vertices) {
    ASSERT_TRUE(std::isfinite(vertex.position.x + vertex.position.y + vertex.position.z));
    ASSERT_TRUE(std::isfinite(vertex.uv.x + vertex.uv.y));
    ASSERT_NEAR(glm::length(vertex.normal), 1.0f, 4 * 0x1p-23f);
  }
  for (const interface::Triangle& triangle : scene.triangles) {
    ASSERT_LT(std::max({triangle.v0, triangle.v1, triangle.v2}), scene.vertices.size());
    ASSERT_LT(triangle.material, scene.materials.size());
    const glm::vec3 p0 = scene.vertices[triangle.v0].position;
    const glm::vec3 normal =
        glm::cross(scene.vertices[triangle.v1].position - p0, scene.vertices[triangle.v2].position - p0);
    ASSERT_GT(glm::dot(normal, normal), 0.0f);
  }
}

std::string test_name(const testing::TestParamInfo<Asset>& asset) {
  std::string name = asset.param.name;
  for (char& c : name)
    if (c == '-') c = '_';
  return name;
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneAssets, testing::ValuesIn(ASSETS), test_name);

}  // namespace
}  // namespace regulus::scene::test
