// Meshes that are stored once for several copies: what is stored, what the copies' triangles are, and which
// meshes are stored for every place all the same. Expectations by hand.
#include <gtest/gtest.h>

#include <cmath>

#include "bvh/scene_bvh.hpp"
#include "interface/wavefront.h"
#include "scene/placement.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

LoadOptions sharing(uint64_t gain = 0) {
  LoadOptions options;
  options.sharing_gain = gain;
  return options;
}

/// Positions of a wavy grid of so many cells along each side of the unit square, and its triangles.
size_t grid(Gltf& file, uint32_t cells, const json& primitive_members = json::object()) {
  std::vector<float> positions;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= cells; ++y)
    for (uint32_t x = 0; x <= cells; ++x) {
      const float u = static_cast<float>(x) / static_cast<float>(cells),
                  v = static_cast<float>(y) / static_cast<float>(cells);
      for (const float value : {u, v, 0.1f * std::sin(9 * u) * std::cos(7 * v)}) positions.push_back(value);
      const uint32_t i = y * (cells + 1) + x;
      if (x < cells && y < cells)
        for (const uint32_t index : {i, i + 1, i + cells + 2, i, i + cells + 2, i + cells + 1})
          indices.push_back(index);
    }
  json primitive = {{"attributes", {{"POSITION", file.positions(positions)}}},
                    {"indices", file.accessor(indices, "SCALAR", UNSIGNED_INT)}};
  primitive.update(primitive_members);
  return file.mesh(primitive);
}

// A triangle at x = 0 and its copy, which is mirrored, stretched and moved.
TEST(SceneInstances, TrianglesOfCopiesStandWhereTheyAreAndFaceTheFront) {
  Gltf file;
  file.triangle({}, {{"translation", {0, 0, 1}}});
  file.node({{"mesh", 0}, {"translation", {5, 0, 0}}, {"scale", {-2, 3, 1}}});
  const Scene scene = file.load(sharing());
  ASSERT_EQ(scene.triangles.size(), 1u);
  ASSERT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(placed_triangle_count(scene), 2u);
  EXPECT_NEAR(scene.bounds_min.x, 0, 1e-5);
  EXPECT_NEAR(scene.bounds_max.x, 5, 1e-5);
  EXPECT_NEAR(scene.bounds_max.y, 3, 1e-5);

  const auto first = placed_positions(scene, scene.instances[0].first_number);
  EXPECT_EQ(first[0], glm::vec3(0, 0, 1));
  EXPECT_EQ(first[1], glm::vec3(1, 0, 1));
  const PlacedTriangle mirrored = placed_triangle(scene, scene.instances[1].first_number);
  EXPECT_EQ(mirrored.triangle.instance, 1u);
  const auto p = placed_positions(scene, scene.instances[1].first_number);
  EXPECT_EQ(p[0], glm::vec3(5, 0, 0));
  EXPECT_EQ(p[1], glm::vec3(5, 3, 0));
  EXPECT_EQ(p[2], glm::vec3(3, 0, 0));
  const interface::Vertex vertex = placed_vertex(scene, mirrored, mirrored.triangle.v1);
  EXPECT_EQ(vertex.normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(vertex.uv, glm::vec2(0, 1));
  EXPECT_GT(glm::cross(p[1] - p[0], p[2] - p[0]).z, 0) << "counter-clockwise seen from +z as before";
}

TEST(SceneInstances, NumbersBelongToOneCopyEach) {
  Gltf file;
  for (const uint32_t cells : {1u, 9u, 30u}) grid(file, cells);  // 2, 162 and 1800 triangles
  for (int i = 0; i < 60; ++i) file.node({{"mesh", i % 3}, {"translation", {0, 0, i}}});
  file.triangle();
  Scene scene = file.load(sharing());
  bvh::build_for_scene(scene);
  EXPECT_EQ(scene.triangles.size(), 1u + 2 + 162 + 1800);
  EXPECT_EQ(placed_triangle_count(scene), 1u + 20 * (2 + 162 + 1800));
  EXPECT_LE(scene.instance_blocks.size(), 2 * scene.instances.size());
  for (const interface::Instance& copy : scene.instances) {
    const uint32_t count = scene.shared_meshes[mesh_index_of(scene, copy)].triangle_count;
    for (const uint32_t k : {0u, count / 2, count - 1}) {
      EXPECT_EQ(placed_triangle(scene, copy.first_number + k).copy, &copy);
      const auto p = placed_positions(scene, copy.first_number + k);
      EXPECT_NEAR(p[0].z, copy.translation.z, 0.11);
    }
  }
}

// 60 x 60 cells of glass are 7,200 triangles: 72 copies have 518,400 and are solids of their own, 73 more
// than 2^19.
TEST(SceneInstances, CopiesOfGlassAreSolidsUnlessThereAreTooMany) {
  for (const auto& [copies, stored] : {std::pair(72u, 72u), std::pair(73u, 1u)}) {
    Gltf file;
    file.root["materials"] = {{{"extensions",
                                {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
                                 {"KHR_materials_volume", {{"thicknessFactor", 1}}}}}}};
    grid(file, 60, {{"material", 0}});
    for (uint32_t i = 0; i < copies; ++i) file.node({{"mesh", 0}, {"translation", {0, 0, i}}});
    const Scene scene = file.load(sharing());
    EXPECT_EQ(scene.triangles.size(), stored * 7200u);
    EXPECT_EQ(placed_triangle_count(scene), copies * 7200u);
  }
}

TEST(SceneInstances, MeshesThatGainTooLittleEmitOrCannotBePlacedAreStored) {
  Gltf file;
  file.root["materials"] = {{{"emissiveFactor", {1, 1, 1}}}};
  const size_t plain = grid(file, 10), lamp = grid(file, 10, {{"material", 0}});
  for (int i = 0; i < 4; ++i) file.node({{"mesh", plain}, {"translation", {2 * i, 0, 0}}});
  file.node({{"mesh", plain}, {"scale", {1, 1, 0}}});     // no inverse
  file.node({{"mesh", plain}, {"scale", {1, 1, 1e-4}}});  // nearly none
  file.node(
      {{"mesh", plain}, {"translation", {1e7, 0, 0}}});  // triangles of 0.1 m vanish between floats 1 m apart
  for (int i = 0; i < 4; ++i) file.node({{"mesh", lamp}, {"translation", {2 * i, 5, 0}}});
  const Scene shared = file.load(sharing());
  EXPECT_EQ(shared.instances.size(), 4u);
  EXPECT_EQ(shared.shared_meshes.size(), 1u);
  EXPECT_EQ(find_features(shared).bits & interface::FEATURE_INSTANCES, interface::FEATURE_INSTANCES);

  const Scene stored = file.load(sharing(uint64_t{1} << 20));  // 6 * 200 triangles take less
  EXPECT_TRUE(stored.instances.empty());
  EXPECT_TRUE(stored.shared_meshes.empty());
  EXPECT_EQ(find_features(stored).bits & interface::FEATURE_INSTANCES, 0u);
  EXPECT_EQ(placed_triangle_count(shared), stored.triangles.size());
}

// 10^5 copies of 1800 triangles: stored once for every place they would take some 20 GB.
TEST(SceneInstances, MemoryDoesNotGrowWithTrianglesOfCopies) {
  constexpr uint32_t COPIES = 100000;
  Gltf file;
  const size_t mesh = grid(file, 30);
  std::vector<float> translations;
  for (uint32_t i = 0; i < COPIES; ++i)
    for (const float x : {static_cast<float>(i % 300), static_cast<float>(i / 300), 0.0f})
      translations.push_back(x);
  file.root["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
  file.node(
      {{"mesh", mesh},
       {"extensions",
        {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", file.positions(translations)}}}}}}}});
  Scene scene = file.load();
  const bvh::Bvh bvh = bvh::build_for_scene(scene);
  EXPECT_EQ(placed_triangle_count(scene), uint64_t{1800} * COPIES);
  EXPECT_EQ(scene.triangles.size(), 1800u);
  const size_t bytes = scene.instances.size() * sizeof(interface::Instance) +
                       scene.instance_blocks.size() * 4 + bvh.nodes.size() * sizeof(interface::BvhNode);
  std::printf("%zu bytes per copy\n", bytes / COPIES);
  EXPECT_LT(bytes / COPIES, 200u);
}

}  // namespace
}  // namespace regulus::scene::test
