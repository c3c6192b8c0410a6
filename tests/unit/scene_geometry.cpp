// Meshes, accessors and the node hierarchy: expectations computed by hand from glTF 2.0.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "interface/wavefront.h"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// Twice the signed area seen from +z: positive if the triangle runs counter-clockwise.
float winding_z(const Scene& scene, size_t triangle) {
  return glm::cross(corner(scene, triangle, 1) - corner(scene, triangle, 0),
                    corner(scene, triangle, 2) - corner(scene, triangle, 0))
      .z;
}

const std::vector<float> STRIP = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};  // zig-zag upwards

TEST(SceneGeometry, UnindexedTriangleGetsItsGeometricNormal) {
  Gltf file;
  file.triangle();
  const Scene scene = file.load();
  ASSERT_EQ(scene.triangles.size(), 1u);
  ASSERT_EQ(scene.vertices.size(), 3u);
  for (const interface::Vertex& vertex : scene.vertices) EXPECT_EQ(vertex.normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(corner(scene, 0, 1), glm::vec3(1, 0, 0));
  EXPECT_EQ(scene.vertices[2].uv, glm::vec2(0, 1));
  EXPECT_EQ(scene.bounds_min, glm::vec3(0));
  EXPECT_EQ(scene.bounds_max, glm::vec3(1, 1, 0));
}

TEST(SceneGeometry, FlatTrianglesOwnTheirVertices) {
  Gltf file;
  const size_t indices = file.accessor(std::vector<uint16_t>{0, 1, 2, 0, 2, 3}, "SCALAR", UNSIGNED_SHORT);
  const size_t positions = file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}})}});
  const Scene scene = file.load();
  ASSERT_EQ(scene.vertices.size(), 6u);
  EXPECT_EQ(scene.vertices[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.vertices[3].normal, glm::vec3(1, 0, 0));
}

// glTF 2.0, 3.7.2.1: any of three component types, with or without alpha, clamped; white where not given.
TEST(SceneGeometry, VertexColoursOfAllComponentTypes) {
  const auto colors_of = [](const auto& values, const char* type, int component, bool is_normalized) {
    Gltf file;
    const size_t accessor = file.accessor(values, type, component);
    file.root["accessors"][accessor]["normalized"] = is_normalized;
    file.triangle(
        {{"attributes", {{"POSITION", file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})}, {"COLOR_0", accessor}}}});
    file.triangle();
    const Scene scene = file.load();
    EXPECT_EQ(scene.vertex_colors.size(), 6u);
    EXPECT_EQ(scene.vertex_colors.at(5), glm::vec4(1));
    EXPECT_NE(find_features(scene).bits & interface::FEATURE_VERTEX_COLORS, 0u);
    return scene.vertex_colors.at(1);
  };
  EXPECT_EQ(colors_of(std::vector<float>{0, 0, 0, 0.25, -1, 2, 0, 0, 0}, "VEC3", FLOAT, false),
            glm::vec4(0.25, 0, 1, 1));
  // Elements are padded to four bytes by their alpha.
  EXPECT_EQ(
      colors_of(std::vector<uint8_t>{0, 0, 0, 0, 51, 0, 255, 102, 0, 0, 0, 0}, "VEC4", UNSIGNED_BYTE, true),
      glm::vec4(51 / 255.0f, 0, 1, 102 / 255.0f));
  EXPECT_EQ(colors_of(std::vector<uint16_t>{0, 0, 0, 0, 13107, 0, 65535, 26214, 0, 0, 0, 0}, "VEC4",
                      UNSIGNED_SHORT, true),
            glm::vec4(13107 / 65535.0f, 0, 1, 26214 / 65535.0f));
}

TEST(SceneGeometry, WhiteVertexColoursAreNotKept) {
  Gltf file;
  file.triangle({{"attributes",
                  {{"POSITION", file.positions({0, 0, 0, 1, 0, 0, 0, 1, 0})},
                   {"COLOR_0", file.accessor(std::vector<float>(9, 1.0f), "VEC3", FLOAT)}}}});
  const Scene scene = file.load();
  EXPECT_TRUE(scene.vertex_colors.empty());
  EXPECT_EQ(find_features(scene).bits & interface::FEATURE_VERTEX_COLORS, 0u);
}

TEST(SceneGeometry, StripsKeepTheirOrientation) {
  Gltf file;
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", file.positions(STRIP)}}}, {"mode", 5}})}});
  const Scene scene = file.load();
  ASSERT_EQ(scene.triangles.size(), 3u);
  for (size_t i = 0; i < 3; ++i) EXPECT_EQ(winding_z(scene, i), 1.0f) << "triangle " << i;
}

TEST(SceneGeometry, FansKeepTheirOrientationAndCentre) {
  Gltf file;
  const size_t positions = file.positions({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", positions}}}, {"mode", 6}})}});
  const Scene scene = file.load();
  ASSERT_EQ(scene.triangles.size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(winding_z(scene, i), 1.0f) << "triangle " << i;
    EXPECT_EQ(corner(scene, i, 2), glm::vec3(0)) << "triangle " << i;
  }
}

TEST(SceneGeometry, PointsAndLinesAreSkippedWithAWarning) {
  Gltf file;
  file.triangle();
  file.triangle({{"mode", 0}});
  file.triangle({{"mode", 3}});
  const Scene scene = file.load();
  EXPECT_EQ(scene.triangles.size(), 1u);
  EXPECT_TRUE(has_warning(scene, "2 primitives are points, lines"));
}

TEST(SceneGeometry, IndicesOfAllWidths) {
  for (const int type : {UNSIGNED_BYTE, UNSIGNED_SHORT, UNSIGNED_INT}) {
    Gltf file;
    const size_t indices =
        type == UNSIGNED_BYTE    ? file.accessor(std::vector<uint8_t>{2, 0, 1}, "SCALAR", type)
        : type == UNSIGNED_SHORT ? file.accessor(std::vector<uint16_t>{2, 0, 1}, "SCALAR", type)
                                 : file.accessor(std::vector<uint32_t>{2, 0, 1}, "SCALAR", type);
    file.triangle({{"indices", indices}});
    EXPECT_EQ(corner(file.load(), 0, 0), glm::vec3(0, 1, 0)) << "component type " << type;
  }
}

TEST(SceneGeometry, SignedOrFloatIndicesAreRefused) {
  Gltf file;
  file.triangle({{"indices", file.accessor(std::vector<float>{0, 1, 2}, "SCALAR", FLOAT)}});
  EXPECT_NE(load_error(file).find("must hold plain unsigned integers"), std::string::npos)
      << load_error(file);
}

TEST(SceneGeometry, NormalizedIntegersFollowTheSpecification) {
  struct Case {
    int type;
    Bytes data;      // three VEC3, 4-byte aligned rows are not needed without a stride
    float expected;  // x of the second vertex
    bool is_normalized;
  };
  const Case cases[] = {
      {BYTE, to_bytes(std::vector<int8_t>{0, 0, 0, -128, 0, 0, 0, 127, 0}), -1.0f, true},
      {BYTE, to_bytes(std::vector<int8_t>{0, 0, 0, -128, 0, 0, 0, 127, 0}), -128.0f, false},
      {UNSIGNED_BYTE, to_bytes(std::vector<uint8_t>{0, 0, 0, 51, 0, 0, 0, 255, 0}), 51.0f / 255.0f, true},
      {SHORT, to_bytes(std::vector<int16_t>{0, 0, 0, -32768, 0, 0, 0, 32767, 0}), -1.0f, true},
      {UNSIGNED_SHORT, to_bytes(std::vector<uint16_t>{0, 0, 0, 13107, 0, 0, 0, 65535, 0}),
       13107.0f / 65535.0f, true},
      {UNSIGNED_SHORT, to_bytes(std::vector<uint16_t>{0, 0, 0, 13107, 0, 0, 0, 65535, 0}), 13107.0f, false},
  };
  for (const Case& c : cases) {
    Gltf file;
    file.root["extensionsRequired"] = {"KHR_mesh_quantization"};
    file.root["accessors"].push_back({{"bufferView", file.view(c.data)},
                                      {"componentType", c.type},
                                      {"type", "VEC3"},
                                      {"count", 3},
                                      {"normalized", c.is_normalized}});
    file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}})}});
    EXPECT_EQ(corner(file.load(), 0, 1).x, c.expected)
        << "component type " << c.type << " normalized " << c.is_normalized;
  }
}

TEST(SceneGeometry, StridesAndOffsetsAreHonoured) {
  Gltf file;
  // 4 bytes of offset, then x y z and one float of padding per vertex.
  const std::vector<float> data = {9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0};
  file.root["accessors"].push_back({{"bufferView", file.view(to_bytes(data))},
                                    {"byteOffset", 4},
                                    {"componentType", FLOAT},
                                    {"type", "VEC3"},
                                    {"count", 3}});
  file.root["bufferViews"][0]["byteStride"] = 16;
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}})}});
  const Scene scene = file.load();
  EXPECT_EQ(corner(scene, 0, 1), glm::vec3(1, 0, 0));
  EXPECT_EQ(corner(scene, 0, 2), glm::vec3(0, 1, 0));
}

Gltf sparse_triangle(const std::vector<uint8_t>& sparse_indices, bool has_base) {
  Gltf file;
  json accessor = {{"componentType", FLOAT}, {"type", "VEC3"}, {"count", 3}};
  if (has_base) accessor["bufferView"] = file.view(to_bytes(std::vector<float>{0, 0, 0, 7, 7, 7, 8, 8, 8}));
  const size_t indices = file.view(sparse_indices);
  const size_t values = file.view(to_bytes(std::vector<float>{1, 0, 0, 0, 1, 0}));
  accessor["sparse"] = {{"count", 2},
                        {"indices", {{"bufferView", indices}, {"componentType", UNSIGNED_BYTE}}},
                        {"values", {{"bufferView", values}}}};
  file.root["accessors"].push_back(accessor);
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", 0}}}})}});
  return file;
}

TEST(SceneGeometry, SparseAccessorsReplaceElementsOfABaseOrOfZeros) {
  for (const bool has_base : {true, false}) {
    const Scene scene = sparse_triangle({1, 2}, has_base).load();
    EXPECT_EQ(corner(scene, 0, 0), glm::vec3(0)) << has_base;
    EXPECT_EQ(corner(scene, 0, 1), glm::vec3(1, 0, 0)) << has_base;
    EXPECT_EQ(corner(scene, 0, 2), glm::vec3(0, 1, 0)) << has_base;
  }
}

TEST(SceneGeometry, SparseIndicesOutOfRangeOrOrderAreRefused) {
  EXPECT_NE(load_error(sparse_triangle({1, 3}, true)).find("sparse index 3"), std::string::npos);
  EXPECT_NE(load_error(sparse_triangle({2, 1}, true)).find("sparse index 1"), std::string::npos);
}

TEST(SceneGeometry, HierarchiesMultiplyTransforms) {
  Gltf file;
  file.triangle({}, {{"scale", {2, 1, 1}}});
  // Parent: a quarter turn about z, then 10 along x. x of the child points along +y.
  file.root["nodes"].push_back(
      {{"children", {0}}, {"translation", {10, 0, 0}}, {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}});
  file.root["scenes"][0]["nodes"] = {1};
  const Scene scene = file.load();
  const glm::vec3 expected[3] = {{10, 0, 0}, {10, 2, 0}, {9, 0, 0}};
  for (int i = 0; i < 3; ++i)
    EXPECT_LT(glm::length(corner(scene, 0, i) - expected[i]), 4 * 10 * std::numeric_limits<float>::epsilon());
}

TEST(SceneGeometry, MatricesAreColumnMajor) {
  Gltf file;
  file.triangle({}, {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1}}});
  EXPECT_EQ(corner(file.load(), 0, 0), glm::vec3(5, 6, 7));
}

TEST(SceneGeometry, MirroringKeepsTheFrontFace) {
  Gltf file;
  const json normal = {0, 0, 1};
  file.triangle({}, {{"scale", {-1, 1, 1}}});
  file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.accessor(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 1}, "VEC3", FLOAT);
  const Scene scene = file.load();
  EXPECT_EQ(winding_z(scene, 0), 1.0f);
  EXPECT_EQ(scene.vertices[0].normal, glm::vec3(0, 0, 1));
}

TEST(SceneGeometry, NormalsGoByTheInverseTranspose) {
  Gltf file;
  file.triangle({}, {{"scale", {2, 1, -1}}});
  const float s = std::sqrt(0.5f);
  file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.accessor(std::vector<float>{s, s, 0, 0, 0, 1, s, s, 0}, "VEC3", FLOAT);
  const Scene scene = file.load();
  // (1, 1, 0) / (2, 1, -1) normalized; z points the other way.
  const glm::vec3 expected = glm::normalize(glm::vec3(0.5f, 1, 0));
  EXPECT_LT(glm::length(scene.vertices[0].normal - expected), 4 * std::numeric_limits<float>::epsilon());
  EXPECT_EQ(scene.vertices[1].normal, glm::vec3(0, 0, -1));
}

TEST(SceneGeometry, NormalsWithoutDirectionBecomeGeometric) {
  Gltf file;
  const float nan = std::numeric_limits<float>::quiet_NaN();
  file.triangle();
  file.root["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
      file.accessor(std::vector<float>{0, 0, 0, nan, 0, 1, 1, 0, 0}, "VEC3", FLOAT);
  const Scene scene = file.load();
  EXPECT_EQ(scene.vertices[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.vertices[1].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.vertices[2].normal, glm::vec3(1, 0, 0));
  EXPECT_TRUE(has_warning(scene, "2 vertex normals"));
}

TEST(SceneGeometry, TrianglesWithoutAreaAreDroppedAndCounted) {
  Gltf file;
  file.triangle();
  const size_t flat = file.positions({0, 0, 0, 1, 1, 1, 2, 2, 2, 0, 0, 0, 0, 0, 0, 1, 0, 0});
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", flat}}}})}});
  const Scene scene = file.load();
  EXPECT_EQ(scene.triangles.size(), 1u);
  EXPECT_TRUE(has_warning(scene, "2 of 3 triangles have no area"));
}

TEST(SceneGeometry, NonFinitePositionsNameTheirAccessor) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Gltf file;
    file.node({{"mesh",
                file.mesh({{"attributes", {{"POSITION", file.positions({0, 0, 0, bad, 0, 0, 0, 1, 0})}}}})}});
    const std::string error = load_error(file);
    EXPECT_NE(error.find("mesh 0 primitive 0 POSITION (accessor 0): vertex 1 is not finite"),
              std::string::npos)
        << error;
  }
}

TEST(SceneGeometry, IndicesBeyondTheVerticesAreRefused) {
  Gltf file;
  file.triangle({{"indices", file.accessor(std::vector<uint16_t>{0, 1, 3}, "SCALAR", UNSIGNED_SHORT)}});
  EXPECT_NE(load_error(file).find("refers to vertex 3 of 3"), std::string::npos) << load_error(file);
}

TEST(SceneGeometry, AccessorsBeyondTheirViewAreRefused) {
  Gltf file;
  file.triangle();
  file.root["accessors"][0]["count"] = 4;
  EXPECT_NE(load_error(file).find("accessor 0"), std::string::npos) << load_error(file);
}

TEST(SceneGeometry, CyclesAndSecondParentsAreRefused) {
  Gltf cycle;
  cycle.triangle();
  cycle.root["nodes"].push_back({{"children", {2}}});
  cycle.root["nodes"].push_back({{"children", {1}}});
  EXPECT_NE(load_error(cycle).find("is its own ancestor"), std::string::npos) << load_error(cycle);

  Gltf shared;
  shared.triangle();
  shared.root["nodes"].push_back({{"children", {0}}});
  shared.root["nodes"].push_back({{"children", {0}}});
  EXPECT_NE(load_error(shared).find("child of both node 1 and node 2"), std::string::npos)
      << load_error(shared);
}

TEST(SceneGeometry, ScenesAreChosenByIndex) {
  Gltf file;
  file.triangle();
  file.triangle({}, {{"translation", {3, 0, 0}}});
  file.root["scenes"] = {{{"nodes", {0}}}, {{"nodes", {1}}}};
  EXPECT_EQ(corner(file.load(), 0, 0).x, 0.0f);
  LoadOptions second;
  second.scene = 1;
  EXPECT_EQ(corner(file.load(second), 0, 0).x, 3.0f);
  second.scene = 2;
  EXPECT_NE(error_of([&] { file.load(second); }).find("there is no scene 2"), std::string::npos);
  file.root["scene"] = 1;
  EXPECT_EQ(corner(file.load(), 0, 0).x, 3.0f);
}

TEST(SceneGeometry, ReorderingPermutesTriangles) {
  Gltf file;
  file.node({{"mesh", file.mesh({{"attributes", {{"POSITION", file.positions(STRIP)}}}, {"mode", 5}})}});
  Scene scene = file.load();
  const glm::vec3 first = corner(scene, 0, 0), last = corner(scene, 2, 0);
  reorder_triangles(scene, {2, 1, 0});
  EXPECT_EQ(corner(scene, 0, 0), last);
  EXPECT_EQ(corner(scene, 2, 0), first);
}

}  // namespace
}  // namespace regulus::scene::test
