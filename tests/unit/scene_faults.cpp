// Small faults of files: a warning that names the element and what is shown instead, an error if loading is
// strict.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// Loads a file with a fault: warned of as `fault` and `shown`, an error that says `fault` if loading is
/// strict.
Scene mended(const Gltf& file, const std::string& fault, const std::string& shown) {
  Scene scene = file.load();
  bool is_said = false;
  std::string all;
  for (const std::string& warning : scene.warnings) {
    is_said |= warning.find(fault) != std::string::npos && warning.find(shown) != std::string::npos;
    all += warning + "\n";
  }
  EXPECT_TRUE(is_said) << "of: " << all;
  EXPECT_NE(load_error(file).find(fault), std::string::npos) << load_error(file);
  return scene;
}

// --- Transforms ---

Gltf with_matrix(size_t element, double value) {
  Gltf file;
  json matrix = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 0, 0, 1};
  matrix[element] = value;
  file.triangle({}, {{"matrix", matrix}});
  return file;
}

TEST(SceneFaults, LastRowsOfMatricesMayBeRounded) {
  // The single-precision neighbours of 1, and what an inverse leaves of 0.
  for (const double value : {0.9999999403953552, 1.00000011920928955, 0.999999, 1.000001})
    EXPECT_EQ(corner(mended(with_matrix(15, value), "node 0: last row of its matrix", "rounding"), 0, 0),
              glm::vec3(4, 0, 0));
  for (const size_t element : {3u, 7u, 11u})
    for (const double value : {5.9604645e-8, -1.2e-7, 1e-6})
      EXPECT_EQ(corner(mended(with_matrix(element, value), "node 0: last row", "rounding"), 0, 0),
                glm::vec3(4, 0, 0));
  EXPECT_TRUE(with_matrix(3, -0.0).load().warnings.size() <= 1u);  // of the missing light
}

TEST(SceneFaults, ProjectiveMatricesAreRefused) {
  for (const size_t element : {3u, 7u, 11u})
    for (const double value : {1.0, -0.1, 1e-3, 1e-4})
      EXPECT_NE(error_of([&] { with_matrix(element, value).load(); }).find("last row of its matrix"),
                std::string::npos);
  for (const double value : {0.0, 2.0, 0.999, 1.001, -1.0})
    EXPECT_NE(error_of([&] { with_matrix(15, value).load(); }).find("last row of its matrix"),
              std::string::npos);
}

TEST(SceneFaults, QuaternionsOfLengthZeroTurnNothing) {
  Gltf file;
  file.triangle({}, {{"rotation", {0, 0, 0, 0}}, {"translation", {0, 2, 0}}});
  const Scene scene = mended(file, "node 0: its rotation is not a quaternion", "not turned");
  EXPECT_EQ(corner(scene, 0, 1), glm::vec3(1, 2, 0));
}

TEST(SceneFaults, InstancesWithQuaternionsOfLengthZeroAreNotTurned) {
  Gltf file;
  file.triangle();
  const size_t rotations = file.accessor(std::vector<float>{0, 0, 0, 0, 0, 0, 0, 1}, "VEC4", FLOAT);
  file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = {
      {"attributes", {{"ROTATION", rotations}}}};
  const Scene scene = mended(file, "instance 0: its rotation is not a quaternion", "not turned");
  EXPECT_EQ(corner(scene, 0, 1), glm::vec3(1, 0, 0));
}

// --- Buffers, accessors, primitives ---

/// A second triangle, 5 along x, whose positions are in a buffer of its own.
Gltf two_triangles() {
  Gltf file;
  file.triangle();
  file.triangle({}, {{"translation", {5, 0, 0}}});
  return file;
}

constexpr size_t SECOND_POSITIONS = 2;  // accessor, view and buffer of two_triangles

TEST(SceneFaults, OnlyWhatNeedsABufferWithoutUriIsLeftOut) {
  Gltf file = two_triangles();
  file.root["buffers"][SECOND_POSITIONS].erase("uri");
  const Scene scene =
      mended(file, "mesh 1 primitive 0 POSITION (accessor 2): buffer 2 has no uri", "left out");
  ASSERT_EQ(scene.triangles.size(), 1u);
  EXPECT_EQ(corner(scene, 0, 0).x, 0.0f);
}

TEST(SceneFaults, BuffersWithoutUriThatNothingReadsAreNoFault) {
  Gltf file;
  file.triangle();
  file.root["buffers"].push_back({{"byteLength", 1000}});
  EXPECT_EQ(load_error(file), "");
}

TEST(SceneFaults, IfNothingIsLeftTheErrorSaysWhy) {
  Gltf file;
  file.triangle();
  file.root["buffers"][0].erase("uri");
  const std::string error = error_of([&] { file.load(); });
  EXPECT_NE(error.find("nothing to render: mesh 0 primitive 0 POSITION (accessor 0): buffer 0 has no uri"),
            std::string::npos)
      << error;
}

TEST(SceneFaults, MissingBufferFilesCostOnlyWhatNeedsThem) {
  Gltf file = two_triangles();
  file.root["buffers"][SECOND_POSITIONS]["uri"] = "gone.bin";
  EXPECT_EQ(mended(file, "no such file", "what needs it is left out").triangles.size(), 1u);
}

TEST(SceneFaults, BuffersMayDeclareMoreThanTheyHave) {
  Gltf file = two_triangles();
  file.root["buffers"][SECOND_POSITIONS]["byteLength"] =
      40;  // 36 are there and needed: padding that was not written
  EXPECT_EQ(mended(file, "buffer 2 declares 40 bytes but has 36", "left out").triangles.size(), 2u);
  file.root["bufferViews"][SECOND_POSITIONS]["byteLength"] = 40;
  EXPECT_EQ(file.load().triangles.size(), 1u) << "the view is cut off";
}

TEST(SceneFaults, WhatNothingUsesMayBeBroken) {
  const json accessor = {{"bufferView", 0}, {"componentType", FLOAT}, {"type", "VEC3"}, {"count", 3}};
  const auto with = [&](const char* array, const json& broken) {
    Gltf file;
    file.triangle();
    file.root[array].push_back(broken);
    return file;
  };
  const auto changed = [&](const char* member, const json& value) {
    json result = accessor;
    result[member] = value;
    return result;
  };
  // Broken in itself: said, since a user may wonder.
  EXPECT_EQ(mended(with("accessors", changed("bufferView", 99)), "accessors/2/bufferView is 99", "left out")
                .triangles.size(),
            1u);
  EXPECT_EQ(
      mended(with("accessors", changed("type", "VEC9")), "accessors/2 must be", "left out").triangles.size(),
      1u);
  EXPECT_EQ(mended(with("accessors", changed("componentType", 7)), "accessors/2 must be", "left out")
                .triangles.size(),
            1u);
  EXPECT_EQ(mended(with("accessors", changed("count", -1)), "accessors/2/count must be", "left out")
                .triangles.size(),
            1u);
  EXPECT_EQ(mended(with("accessors", json::object()), "accessors/2 must be", "left out").triangles.size(),
            1u);
  EXPECT_EQ(mended(with("accessors", "x"), "accessors/2 must be an object", "left out").triangles.size(), 1u);
  EXPECT_EQ(mended(with("bufferViews", {{"buffer", 77}, {"byteLength", 4}}), "bufferViews/2/buffer is 77",
                   "left out")
                .triangles.size(),
            1u);
  EXPECT_EQ(mended(with("bufferViews", {{"buffer", 0}, {"byteLength", 4}, {"byteStride", 7}}),
                   "bufferViews/2 must be", "left out")
                .triangles.size(),
            1u);
  EXPECT_EQ(mended(with("meshes", {{"primitives", 3}}), "meshes/1/primitives must be an array", "left out")
                .triangles.size(),
            1u);
  EXPECT_EQ(mended(with("materials", {{"doubleSided", 1}}), "materials/0/doubleSided", "default material")
                .triangles.size(),
            1u);
  // Wrong only where it is used: not even looked at.
  EXPECT_EQ(load_error(with("accessors", changed("count", 1000))), "");
  EXPECT_EQ(load_error(with("bufferViews", {{"buffer", 0}, {"byteOffset", 9999}, {"byteLength", 4}})), "");
}

TEST(SceneFaults, ABrokenPrimitiveIsLeftOut) {
  Gltf indices = two_triangles();
  indices.root["meshes"][1]["primitives"][0]["indices"] =
      indices.accessor(std::vector<uint16_t>{0, 1, 3}, "SCALAR", UNSIGNED_SHORT);
  EXPECT_EQ(mended(indices, "refers to vertex 3 of 3", "left out").triangles.size(), 1u);

  Gltf not_finite = two_triangles();
  not_finite.root["meshes"][1]["primitives"][0]["attributes"]["POSITION"] =
      not_finite.positions({0, 0, 0, std::numeric_limits<float>::quiet_NaN(), 0, 0, 0, 1, 0});
  const Scene scene = mended(not_finite, "vertex 1 is not finite", "left out");
  EXPECT_EQ(scene.triangles.size(), 1u);
  EXPECT_EQ(scene.vertices.size(), 3u);

  Gltf member = two_triangles();
  member.root["meshes"][1]["primitives"][0]["material"] = 4;
  EXPECT_EQ(mended(member, "meshes/1/primitives/0/material is 4", "left out").triangles.size(), 1u);
}

TEST(SceneFaults, SharedMeshesWithABrokenPrimitiveKeepTheOthers) {
  Gltf file;
  file.triangle({}, {{"translation", {1, 0, 0}}});
  const size_t bad = file.positions({0, 0, 0, std::numeric_limits<float>::infinity(), 0, 0, 0, 1, 0});
  file.root["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", bad}}}});
  file.node({{"mesh", 0}});
  const Scene scene = file.load({.sharing_gain = 0});
  EXPECT_TRUE(has_warning(scene, "mesh 0 primitive 1 POSITION (accessor 2): vertex 1 is not finite"));
  EXPECT_EQ(scene.triangles.size(), 2u) << "one for each place: the mesh has a vertex that no space fits";
}

TEST(SceneFaults, BrokenAttributesThatCanBeDoneWithoutAreDropped) {
  Gltf file;
  file.triangle();
  json& attributes = file.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["NORMAL"] = file.accessor(std::vector<float>{0, 0, 1, 0, 0, 1}, "VEC3", FLOAT);
  attributes["TEXCOORD_0"] = file.accessor(std::vector<float>{0, 0, 1, 0, 0, 1, 0, 0, 0}, "VEC3", FLOAT);
  const Scene scene = mended(file, "NORMAL (accessor 2) has 2 elements, POSITION has 3", "without it");
  EXPECT_TRUE(has_warning(scene, "TEXCOORD_0 (accessor 3) has the wrong type"));
  ASSERT_EQ(scene.triangles.size(), 1u);
  EXPECT_EQ(scene.vertices[0].normal, glm::vec3(0, 0, 1));
  EXPECT_EQ(scene.vertices[1].uv, glm::vec2(0));
}

TEST(SceneFaults, IndicesWithoutABufferViewAreZeros) {
  Gltf file = two_triangles();
  // Zeros but for what a sparse accessor puts in: 0, 1, 2.
  json accessor = {{"componentType", UNSIGNED_SHORT}, {"type", "SCALAR"}, {"count", 3}};
  accessor["sparse"] = {{"count", 2},
                        {"indices", {{"bufferView", file.view({1, 2})}, {"componentType", UNSIGNED_BYTE}}},
                        {"values", {{"bufferView", file.view(to_bytes(std::vector<uint16_t>{1, 2}))}}}};
  file.root["accessors"].push_back(accessor);
  file.root["meshes"][1]["primitives"][0]["indices"] = file.root["accessors"].size() - 1;
  EXPECT_EQ(load_error(file), "");
  EXPECT_EQ(file.load().triangles.size(), 2u);
  file.root["accessors"].back().erase("sparse");  // one point three times over
  const Scene scene = file.load();
  EXPECT_EQ(scene.triangles.size(), 1u);
  EXPECT_TRUE(has_warning(scene, "1 of 2 triangles have no area"));
}

TEST(SceneFaults, MaterialsAndNodesWithAWrongMemberGiveWay) {
  Gltf material = two_triangles();
  material.root["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.5}}}}}};
  material.root["meshes"][1]["primitives"][0]["material"] = 0;
  EXPECT_EQ(mended(material, "materials/0/pbrMetallicRoughness/baseColorFactor must be an array of 4",
                   "default material")
                .triangles.size(),
            2u);
  Gltf node = two_triangles();
  node.root["nodes"][1]["mesh"] = 9;
  EXPECT_EQ(mended(node, "nodes/1/mesh is 9", "left out with its children").triangles.size(), 1u);
}

TEST(SceneFaults, SpotLightsWithoutASpotHaveTheDefaultCone) {
  Gltf file;
  file.triangle();
  file.light({{"type", "spot"}});
  EXPECT_EQ(load_error(file), "");
  EXPECT_NEAR(file.load().lights.at(0).outer_height, 1 - std::sqrt(0.5), 1e-6);
}

// --- Texture coordinates ---

TEST(SceneFaults, MissingTextureCoordinatesAreNamedForEverySet) {
  for (const int set : {0, 1, 2, 7}) {
    Gltf file;
    const size_t texture = file.texture(make_png(1, 1, 3, 8, {10, 20, 30}));
    file.triangle_of(
        {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}, {"texCoord", set}}}}}});
    file.root["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
    mended(file, "mesh 0 primitive 0 has no TEXCOORD_" + std::to_string(set), "(0, 0)");
  }
  Gltf plain;
  plain.triangle_of(json::object());
  plain.root["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
  EXPECT_EQ(load_error(plain), "") << "without textures nothing is missing";
}

// --- What is empty says why ---

TEST(SceneFaults, ScenesWithoutATriangleSayWhy) {
  const auto reason = [](const Gltf& file) { return error_of([&] { file.load(); }); };
  EXPECT_NE(reason(Gltf()).find("nothing to render: the file has no mesh"), std::string::npos)
      << reason(Gltf());

  Gltf unplaced = two_triangles();
  unplaced.root["nodes"] = {json::object()};
  unplaced.root["scenes"] = {{{"nodes", {0}}}};
  EXPECT_NE(reason(unplaced).find("2 meshes, but no node places them"), std::string::npos)
      << reason(unplaced);

  Gltf elsewhere = two_triangles();
  elsewhere.root["scenes"] = {{{"nodes", json::array()}}, {{"nodes", {0, 1}}}};
  EXPECT_NE(reason(elsewhere).find("2 meshes, but no node of scene 0 places them; choose another scene"),
            std::string::npos)
      << reason(elsewhere);

  Gltf points;
  points.triangle({{"mode", 0}});
  EXPECT_NE(reason(points).find("has a triangle with an area"), std::string::npos) << reason(points);
}

TEST(SceneFaults, ManyFaultsAreCounted) {
  Gltf file;
  file.triangle();
  for (int i = 0; i < 150; ++i) file.root["accessors"].push_back(json::object());
  const Scene scene = file.load();
  EXPECT_LE(scene.warnings.size(), 102u);
  EXPECT_TRUE(has_warning(scene, "50 more warnings"));
}

}  // namespace
}  // namespace regulus::scene::test
