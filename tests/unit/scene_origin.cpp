// Scenes far from the origin of their file, and scenes that single precision cannot hold. A scene that is
// moved by a multiple of its extent's power of two is the same scene, to the bit, in its own frame.
#include <gtest/gtest.h>

#include "scene/placement.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// A tetrahedron of 1 to 2 m, its corners multiples of 1/4, around `center`.
std::vector<float> corners_around(const glm::dvec3& center) {
  const double corners[4][3] = {{-1, -1, -0.5}, {1, -0.25, 0}, {0, 1, 0.25}, {0.25, 0, 1}};
  std::vector<float> positions;
  for (const auto& corner : corners)
    for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(corner[axis] + center[axis]));
  return positions;
}

json translation_of(const glm::dvec3& by) {
  return {{"translation", {by.x, by.y, by.z}}};
}

/// A tetrahedron, a camera and a light. They stand `by_file` away in the file's floats, or `by_node` by a
/// node above all of them, or `by_parts` by nodes of their own.
Gltf small_world(const glm::dvec3& by_file, const glm::dvec3& by_node, const glm::dvec3& by_parts) {
  Gltf file;
  const size_t positions = file.positions(corners_around(by_file));
  const size_t indices =
      file.accessor(std::vector<uint16_t>{0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0}, "SCALAR", UNSIGNED_SHORT);
  json part = translation_of(by_parts);
  part["mesh"] = file.mesh({{"attributes", {{"POSITION", positions}}}, {"indices", indices}});
  file.node(part);
  file.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}}};
  part = translation_of(by_parts + by_file + glm::dvec3(0.5, 0.25, 4));
  part["camera"] = 0;
  file.node(part);
  file.light({{"type", "point"}, {"intensity", 3}}, translation_of(by_parts + by_file + glm::dvec3(1, 2, 3)));
  json root = translation_of(by_node);
  root["children"] = file.root["scenes"][0]["nodes"];
  file.root["scenes"][0]["nodes"] = json::array();
  file.node(root);
  return file;
}

void expect_same(const Scene& found, const Scene& wanted) {
  ASSERT_EQ(found.triangles.size(), wanted.triangles.size());
  ASSERT_EQ(found.vertices.size(), wanted.vertices.size());
  for (size_t i = 0; i < wanted.vertices.size(); ++i) {
    EXPECT_EQ(found.vertices[i].position, wanted.vertices[i].position) << i;
    EXPECT_EQ(found.vertices[i].normal, wanted.vertices[i].normal) << i;
  }
  ASSERT_EQ(found.instances.size(), wanted.instances.size());
  for (size_t i = 0; i < wanted.instances.size(); ++i)
    EXPECT_EQ(found.instances[i].translation, wanted.instances[i].translation) << i;
  EXPECT_EQ(found.bounds_min, wanted.bounds_min);
  EXPECT_EQ(found.bounds_max, wanted.bounds_max);
  EXPECT_EQ(found.cameras.at(0).camera_to_world, wanted.cameras.at(0).camera_to_world);
  ASSERT_EQ(found.lights.size(), wanted.lights.size());
  for (size_t i = 0; i < wanted.lights.size(); ++i)
    EXPECT_EQ(found.lights[i].position, wanted.lights[i].position) << i;
}

const glm::dvec3 NONE(0);

TEST(SceneOrigin, ScenesNearTheOriginStayWhereTheyAre) {
  // 2 m wide: up to 16 extents away.
  for (const double distance : {0.0, 3.0, 31.0}) {
    const glm::dvec3 place(distance, -distance, 0);
    const Scene scene = small_world(NONE, place, NONE).load();
    EXPECT_EQ(scene.origin, NONE);
    EXPECT_EQ(scene.vertices[0].position, glm::vec3(glm::dvec3(-1, -1, -0.5) + place));
    EXPECT_TRUE(scene.warnings.empty());
  }
  EXPECT_NE(small_world(NONE, {34, 0, 0}, NONE).load().origin, NONE);
}

TEST(SceneOrigin, FarScenesAreTheSameInTheirOwnFrame) {
  const Scene wanted = small_world(NONE, NONE, NONE).load();
  // Multiples of 2 m: of its extent. The file's floats hold quarters of a metre up to 4e6 m.
  for (const glm::dvec3& place :
       {glm::dvec3(100, 0, 0), glm::dvec3(-3761604, 4105280, 3870314), glm::dvec3(2e12, 0, -4e12)})
    for (const Gltf& file : {small_world(NONE, place, NONE), small_world(NONE, NONE, place),
                             small_world(NONE, -3.0 * place, 4.0 * place)}) {
      const Scene found = file.load();
      EXPECT_EQ(found.origin, place);
      EXPECT_TRUE(found.warnings.empty());
      expect_same(found, wanted);
    }
  const glm::dvec3 place(-3000000, 2000000, 1000002);
  const Scene found = small_world(place, NONE, NONE).load();
  EXPECT_EQ(found.origin, place);
  expect_same(found, wanted);
}

// Wherever it is: what is left is the fraction of the extent that the origin's lattice leaves, at most half
// of it.
TEST(SceneOrigin, AnywhereElsePositionsKeepMostOfTheirBits) {
  const glm::dvec3 place(-3761603.743620786, 4105279.00727716, 3870314.849074384);
  const Scene scene = small_world(NONE, place, NONE).load();
  EXPECT_LE(length(scene.origin - place), 1 * std::sqrt(3.0));
  for (const interface::Vertex& vertex : scene.vertices) {
    const glm::dvec3 local = scene.origin + glm::dvec3(vertex.position) - place;
    // Corners are multiples of 1/4: a rounding of coordinates below 2 and one of double precision.
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(4 * local[axis], std::round(4 * local[axis]), 4 * (0x1p-24 + 0x1p-29));
  }
}

// Copies by EXT_mesh_gpu_instancing, whose file has far floats or whose node is far, stored once and for each
// place.
TEST(SceneOrigin, FarInstancesAreTheSameInTheirOwnFrame) {
  const auto instanced = [](const glm::dvec3& by_file, const glm::dvec3& by_instance,
                            const glm::dvec3& by_node) {
    Gltf file = small_world(by_file, by_node, NONE);
    std::vector<float> translations;
    for (const double x : {0.0, 4.0, 8.0})
      for (const double value : {x + by_instance.x, by_instance.y, by_instance.z})
        translations.push_back(static_cast<float>(value));
    file.root["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    file.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        file.positions(translations);
    // Camera and light stay where the mesh is.
    for (const size_t node : {1u, 2u})
      for (int axis = 0; axis < 3; ++axis)
        file.root["nodes"][node]["translation"][axis] =
            file.root["nodes"][node]["translation"][axis].get<double>() + by_instance[axis];
    return file;
  };
  const glm::dvec3 place(-3000000, 2000000, 1000048);  // multiples of 16 m
  for (const uint64_t gain : {uint64_t{0}, NEVER_SHARE}) {
    LoadOptions options;
    options.sharing_gain = gain;
    const Scene wanted = instanced(NONE, NONE, NONE).load(options);
    EXPECT_EQ(wanted.instances.size(), gain == 0 ? 3u : 0u);
    for (const Gltf& file :
         {instanced(place, NONE, NONE), instanced(NONE, place, NONE), instanced(NONE, NONE, place)}) {
      const Scene found = file.load(options);
      EXPECT_EQ(found.origin, place);
      expect_same(found, wanted);
    }
  }
}

// Joints place the vertices of a skinned mesh, whether the scene shows their nodes or not; its own node does
// not.
TEST(SceneOrigin, FarSkinnedMeshesAreTheSameInTheirOwnFrame) {
  const auto skinned = [](const glm::dvec3& by_joint, const glm::dvec3& by_node) {
    Gltf file = small_world(NONE, by_node, NONE);
    json& primitive = file.root["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] = file.accessor(
        std::vector<uint8_t>{0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0}, "VEC4", UNSIGNED_BYTE);
    primitive["attributes"]["WEIGHTS_0"] = file.accessor(
        std::vector<float>{0.5, 0.5, 0, 0, 1, 0, 0, 0, 0.25, 0.75, 0, 0, 1, 0, 0, 0}, "VEC4", FLOAT);
    for (const double x : {0.0, 2.0})
      file.root["nodes"].push_back(translation_of(by_joint + glm::dvec3(x, 0, 0)));
    const size_t joints = file.root["nodes"].size() - 2;
    file.root["nodes"][joints - 1]["children"].push_back(joints);  // one below all, one that no scene shows
    file.root["nodes"][joints + 1]["translation"][0] = by_node.x + by_joint.x + 2;
    for (int axis = 1; axis < 3; ++axis)
      file.root["nodes"][joints + 1]["translation"][axis] = by_node[axis] + by_joint[axis];
    file.root["skins"] = {{{"joints", {joints, joints + 1}}}};
    file.root["nodes"][0]["skin"] = 0;
    for (const size_t node : {1u, 2u})
      for (int axis = 0; axis < 3; ++axis)
        file.root["nodes"][node]["translation"][axis] =
            file.root["nodes"][node]["translation"][axis].get<double>() + by_joint[axis];
    return file;
  };
  const Scene wanted = skinned(NONE, NONE).load();
  EXPECT_EQ(wanted.origin, NONE);
  const glm::dvec3 place(-3000000, 2000000, 1000048);
  for (const Gltf& file : {skinned(place, NONE), skinned(NONE, place)}) {
    const Scene found = file.load();
    EXPECT_EQ(found.origin, place);
    expect_same(found, wanted);
  }
}

TEST(SceneOrigin, WhatIsLostToRoundingIsSaid) {
  // The file's floats are multiples of 1/16 m there, 3.1 % of 2 m.
  const Scene in_file = small_world({1e6, 0, 0}, NONE, NONE).load();
  EXPECT_TRUE(has_warning(in_file,
                          "mesh 0: its vertices lie up to 1e+06 units from its own origin, where the file's "
                          "floats are multiples of 0.062, 3.1 % of its size"));
  // A second mesh at the origin keeps it there.
  Gltf apart = small_world(NONE, {4e6, 0, 0}, NONE);
  apart.triangle();
  const Scene in_scene = apart.load();
  EXPECT_EQ(in_scene.origin, NONE);
  EXPECT_TRUE(has_warning(in_scene,
                          "mesh 0: lies 4e+06 units from the scene's centre, where single precision holds "
                          "multiples of 0.25, 12 % of its size"));
  EXPECT_EQ(in_scene.warnings.size(), 1u);
}

TEST(SceneOrigin, ScenesThatSinglePrecisionCannotComputeWithSaySo) {
  const auto scaled = [](double scale) {
    Gltf file = small_world(NONE, NONE, NONE);
    file.root["nodes"].back()["scale"] = {scale, scale, scale};
    return file;
  };
  for (const double scale : {1e-6, 1e6, 0.9e9}) EXPECT_EQ(scaled(scale).load().triangles.size(), 4u) << scale;
  EXPECT_NE(load_error(scaled(1e10)).find("the scene is 2e+10 units wide, more than the 2e+09"),
            std::string::npos)
      << load_error(scaled(1e10));
  EXPECT_NE(load_error(scaled(1e30)).find("units wide"), std::string::npos) << load_error(scaled(1e30));
  EXPECT_NE(load_error(scaled(1e-12)).find("in a scene 2e-12 units wide; scale it up"), std::string::npos)
      << load_error(scaled(1e-12));
}

}  // namespace
}  // namespace regulus::scene::test
