// Damaged files: seeded byte flips, insertions and truncations of small GLBs. Any outcome but a scene that
// keeps its invariants or an Error is a bug.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <random>

#include "../unit/scene_files.hpp"

namespace regulus::scene::test {
namespace {

std::string read_file(const std::filesystem::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

size_t below(std::mt19937& random, size_t bound) {
  return random() % bound;
}

/// Damages bytes, mostly in the JSON of the first `json_size` bytes, where structure lies.
std::string mutate(std::string bytes, size_t json_size, std::mt19937& random) {
  const size_t edits = 1 + below(random, 8);
  for (size_t i = 0; i < edits; ++i) {
    const size_t range = below(random, 4) != 0 ? std::min(json_size, bytes.size()) : bytes.size();
    const size_t at = below(random, range);
    switch (below(random, 5)) {
      case 0:
        bytes[at] = static_cast<char>(random());
        break;
      case 1:
        bytes[at] = static_cast<char>(bytes[at] ^ (1 << below(random, 8)));
        break;
      case 2:  // digits stay digits: indices and counts change, the JSON stays valid
        for (size_t k = at; k < bytes.size(); ++k)
          if (bytes[k] >= '0' && bytes[k] <= '9') {
            bytes[k] = static_cast<char>('0' + below(random, 10));
            break;
          }
        break;
      case 3:
        std::swap(bytes[at], bytes[below(random, range)]);
        break;
      default:
        if (below(random, 10) == 0) bytes.resize(at + 1);
        break;
    }
  }
  return bytes;
}

void check_invariants(const Scene& scene) {
  for (const interface::Vertex& vertex : scene.vertices) {
    ASSERT_TRUE(std::isfinite(vertex.position.x + vertex.position.y + vertex.position.z));
    ASSERT_NEAR(glm::length(vertex.normal), 1.0f, 1e-5f);
  }
  for (const interface::Triangle& triangle : scene.triangles) {
    ASSERT_LT(std::max({triangle.v0, triangle.v1, triangle.v2}), scene.vertices.size());
    ASSERT_LT(triangle.material, scene.materials.size());
  }
  for (const interface::Light& light : scene.lights)
    ASSERT_TRUE(light.selection_pdf > 0 && light.selection_pdf <= 1);
  ASSERT_FALSE(scene.cameras.empty());
}

class SceneMutation : public testing::TestWithParam<const char*> {};

TEST_P(SceneMutation, GivesASceneOrAnError) {
  const auto source = std::filesystem::path(REGULUS_ASSETS_DIR) / GetParam();
  if (!std::filesystem::exists(source)) GTEST_SKIP() << source << " is not here";
  const std::string original = read_file(source);
  uint32_t json_length = 0;
  std::memcpy(&json_length, original.data() + 12, 4);
  const TemporaryFolder folder;
  size_t loaded = 0;
  const uint32_t cases = 400;
  for (uint32_t seed = 1; seed <= cases; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const auto path = folder.write("case.glb", mutate(original, 20 + json_length, random));
    std::string error;
    ASSERT_NO_THROW(error = error_of([&] {
                      Scene scene = load(path);
                      build_lights(scene);
                      find_features(scene);
                      check_invariants(scene);
                      ++loaded;
                    }));
    ASSERT_EQ(error.find("more than one line"), std::string::npos) << error;
  }
  std::printf("%s: %u cases (seeds 1 to %u), %zu loaded\n", GetParam(), cases, cases, loaded);
}

INSTANTIATE_TEST_SUITE_P(
    Files, SceneMutation,
    testing::Values("scenes/cornell-box.glb", "gltf/playcanvas/Lights.glb",
                    "gltf/playcanvas/geometry-camera-light.glb", "gltf/playcanvas/glass-table.glb",
                    "gltf/playcanvas/heart_draco.glb", "gltf/playcanvas/simple-instancing.glb",
                    "gltf/gltf-transform/packages/extensions/test/in/BoxMeshopt.glb",
                    "gltf/tinygltf/models/SparseMorphTargets-issue280/singleBlendshapeCube_sparse.glb",
                    "gltf/gltf-transform/packages/cli/test/in/chr_knight.glb"));

}  // namespace
}  // namespace regulus::scene::test
