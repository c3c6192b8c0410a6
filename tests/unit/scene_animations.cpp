// Animations: what poses a scene at a time, by hand from glTF 2.0, 3.11 and appendix C, and
// KHR_animation_pointer.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "scene/placement.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

LoadOptions posed(double time, const std::string& animation = "") {
  LoadOptions options;
  options.animation = animation;
  options.time = time;
  return options;
}

/// Adds a channel to the last animation of a file, or to its first.
void add_channel(Gltf& file, const json& target, const std::vector<float>& times, size_t output,
                 const std::string& interpolation = "LINEAR") {
  json& animations = file.root["animations"];
  if (animations.empty()) animations.push_back({{"channels", json::array()}, {"samplers", json::array()}});
  json& animation = animations.back();
  animation["samplers"].push_back({{"input", file.accessor(times, "SCALAR", FLOAT)},
                                   {"output", output},
                                   {"interpolation", interpolation}});
  animation["channels"].push_back({{"sampler", animation["samplers"].size() - 1}, {"target", target}});
}

json of_node(size_t node, const std::string& path) {
  return {{"node", node}, {"path", path}};
}

json pointer(const std::string& to) {
  return {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", to}}}}}};
}

size_t numbers(Gltf& file, const std::vector<float>& values) {
  return file.accessor(values, "SCALAR", FLOAT);
}

size_t quaternions(Gltf& file, const std::vector<float>& values) {
  return file.accessor(values, "VEC4", FLOAT);
}

/// Where the first corner of the first triangle, the node's origin, is.
glm::vec3 origin_of(const Gltf& file, double time) {
  return placed_positions(file.load(posed(time)), 0)[0];
}

/// Where the node's x axis points.
glm::dvec3 axis_of(const Gltf& file, double time) {
  const auto p = placed_positions(file.load(posed(time)), 0);
  return glm::dvec3(p[1]) - glm::dvec3(p[0]);
}

TEST(SceneAnimations, LinearKeysAreJoinedAndHoldBeyondTheEnds) {
  Gltf file;
  file.triangle();
  add_channel(file, of_node(0, "translation"), {1, 2, 4}, file.positions({0, 0, 0, 4, 0, 0, 4, 8, 0}));
  EXPECT_EQ(origin_of(file, -3), glm::vec3(0, 0, 0));
  EXPECT_EQ(origin_of(file, 1), glm::vec3(0, 0, 0));
  EXPECT_EQ(origin_of(file, 1.25), glm::vec3(1, 0, 0));
  EXPECT_EQ(origin_of(file, 2), glm::vec3(4, 0, 0));
  EXPECT_EQ(origin_of(file, 3.5), glm::vec3(4, 6, 0));
  EXPECT_EQ(origin_of(file, 100), glm::vec3(4, 8, 0));
}

TEST(SceneAnimations, StepsHoldUntilTheNextKey) {
  Gltf file;
  file.triangle();
  add_channel(file, of_node(0, "translation"), {0, 1}, file.positions({1, 0, 0, 2, 0, 0}), "STEP");
  EXPECT_EQ(origin_of(file, 0.999), glm::vec3(1, 0, 0));
  EXPECT_EQ(origin_of(file, 1), glm::vec3(2, 0, 0));
}

// In-tangent, value, out-tangent of each key.
TEST(SceneAnimations, CubicSplinesFollowTheirTangents) {
  Gltf file;
  file.triangle();
  add_channel(file, of_node(0, "translation"), {1, 3},
              file.positions({9, 9, 9, 1, 0, 0, 0, 2, 0, 0, 0, 4, 5, 0, 0, 9, 9, 9}), "CUBICSPLINE");
  EXPECT_EQ(origin_of(file, 0), glm::vec3(1, 0, 0));
  EXPECT_EQ(origin_of(file, 3), glm::vec3(5, 0, 0));
  // Half way: (v0 + v1) / 2 + duration (b0 - a1) / 8.
  EXPECT_EQ(origin_of(file, 2), glm::vec3(3, 0.5, -1));
  // A quarter: t^3 = 1/64, t^2 = 1/16.
  EXPECT_LT(glm::length(origin_of(file, 1.5) - glm::vec3(1 + 4 * (3. / 16 - 2. / 64),
                                                         2 * 2 * (1. / 64 - 2. / 16 + 1. / 4),
                                                         2 * 4 * (1. / 64 - 1. / 16))),
            1e-6f);
}

TEST(SceneAnimations, RotationsTakeTheShortArcAtConstantSpeed) {
  const float half = std::sqrt(0.5f);
  Gltf file;
  file.triangle();
  // A quarter turn about z, its quaternion written with the other sign.
  add_channel(file, of_node(0, "rotation"), {0, 1}, quaternions(file, {0, 0, 0, 1, 0, 0, -half, -half}));
  for (const double t : {0.0, 0.25, 0.5, 0.9, 1.0}) {
    const double angle = t * std::numbers::pi / 2;
    EXPECT_LT(glm::length(axis_of(file, t) - glm::dvec3(std::cos(angle), std::sin(angle), 0)), 1e-6) << t;
  }
}

TEST(SceneAnimations, NormalizedBytesTurnToo) {
  Gltf file;
  file.triangle();
  const size_t bytes = file.accessor(std::vector<int8_t>{0, 0, 0, 127, 0, 0, 127, 0}, "VEC4", BYTE);
  file.root["accessors"][bytes]["normalized"] = true;
  add_channel(file, of_node(0, "rotation"), {0, 2}, bytes);
  EXPECT_LT(glm::length(axis_of(file, 1) - glm::dvec3(0, 1, 0)), 1e-6);
}

TEST(SceneAnimations, CubicRotationsAreNormalized) {
  Gltf file;
  file.triangle();
  const float half = std::sqrt(0.5f);
  add_channel(
      file, of_node(0, "rotation"), {0, 1},
      quaternions(file, {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, half, half, 0, 0, 0, 0}),
      "CUBICSPLINE");
  const glm::dvec3 axis = axis_of(file, 0.5);  // the mean of both quaternions, an eighth of a turn
  EXPECT_LT(glm::length(axis - glm::dvec3(half, half, 0)), 1e-6);
}

TEST(SceneAnimations, MorphWeightsOfANodeAndJointsOfASkinMove) {
  Gltf file;
  file.triangle({{"targets",
                  {{{"POSITION", file.positions({1, 0, 0, 1, 0, 0, 1, 0, 0})}},
                   {{"POSITION", file.positions({0, 1, 0, 0, 1, 0, 0, 1, 0})}}}}});
  const size_t joints = file.accessor(std::vector<uint8_t>(12, 0), "VEC4", UNSIGNED_BYTE);
  const size_t weights = file.accessor(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, "VEC4", FLOAT);
  file.root["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"] = joints;
  file.root["meshes"][0]["primitives"][0]["attributes"]["WEIGHTS_0"] = weights;
  file.root["nodes"][0]["skin"] = 0;
  const size_t joint = file.node(json::object());
  file.root["skins"] = {{{"joints", {joint}}}};
  add_channel(file, of_node(0, "weights"), {0, 1}, numbers(file, {0, 0, 2, 6}));
  add_channel(file, of_node(joint, "scale"), {0, 1}, file.positions({1, 1, 1, 3, 3, 3}));
  EXPECT_EQ(origin_of(file, 0), glm::vec3(0));
  EXPECT_EQ(origin_of(file, 0.5), glm::vec3(2, 6, 0));
  EXPECT_EQ(origin_of(file, 1), glm::vec3(6, 18, 0));
}

// Three parts of two weights each per key.
TEST(SceneAnimations, CubicWeightsAreGroupedByKey) {
  Gltf file;
  file.triangle({{"targets",
                  {{{"POSITION", file.positions({1, 0, 0, 1, 0, 0, 1, 0, 0})}},
                   {{"POSITION", file.positions({0, 1, 0, 0, 1, 0, 0, 1, 0})}}}}});
  add_channel(file, of_node(0, "weights"), {0, 1}, numbers(file, {9, 9, 1, 2, 8, 0, 0, 16, 3, 4, 9, 9}),
              "CUBICSPLINE");
  EXPECT_EQ(origin_of(file, 0.5), glm::vec3(2 + 8 / 8., 3 - 16 / 8., 0));
}

TEST(SceneAnimations, AMatrixThatIsAnimatedIsTakenApart) {
  Gltf file;
  file.triangle();
  // Columns: mirrored x, twice as long; y; z; moved.
  file.root["nodes"][0]["matrix"] = {-2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 5, 6, 7, 1};
  add_channel(file, of_node(0, "translation"), {0}, file.positions({1, 0, 0}));
  const Scene scene = file.load(posed(0));
  const auto p = placed_positions(scene, 0);
  EXPECT_EQ(p[0], glm::vec3(1, 0, 0));
  EXPECT_LT(glm::length(p[2] - glm::vec3(-1, 0, 0)), 1e-6f) << "corners swap: it mirrors";
  EXPECT_TRUE(has_warning(scene, "node 0 has a matrix and is animated"));
}

TEST(SceneAnimations, PointersMoveMaterialsLightsCamerasAndVisibility) {
  Gltf file;
  file.triangle_of({{"pbrMetallicRoughness", {{"metallicFactor", 0}}},
                    {"extensions", {{"KHR_materials_ior", {{"ior", 1.25}}}}}});
  file.light({{"type", "spot"}, {"intensity", 1}, {"spot", json::object()}});
  file.root["cameras"] = {{{"type", "perspective"},
                           {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}},
                           {"extras", {{"regulus", {{"lens_radius", 0.1}, {"focus_distance", 1}}}}}}};
  file.node({{"camera", 0}});
  const std::string material = "/materials/0/", light = "/extensions/KHR_lights_punctual/lights/0/";
  const auto move = [&](const std::string& to, const std::vector<float>& values) {
    add_channel(file, pointer(to), {0, 1}, numbers(file, values));
  };
  add_channel(file, pointer(material + "pbrMetallicRoughness/baseColorFactor"), {0, 1},
              quaternions(file, {0, 0, 0, 1, 1, 0.5, 0, 1}));
  move(material + "pbrMetallicRoughness/roughnessFactor", {1, 0});
  add_channel(file, pointer(material + "emissiveFactor"), {0, 1}, file.positions({0, 0, 0, 1, 1, 0.5}));
  move(material + "extensions/KHR_materials_ior/ior", {1.5, 2});
  move(light + "intensity", {0, 8});
  add_channel(file, pointer(light + "color"), {0, 1}, file.positions({1, 1, 1, 0, 1, 1}));
  move(light + "spot/outerConeAngle", {0.5, 1});
  move("/cameras/0/perspective/yfov", {0.5, 1.5});
  move("/cameras/0/extras/regulus/focus_distance", {1, 3});
  add_channel(file, pointer("/nodes/2/translation"), {0, 1}, file.positions({0, 0, 0, 0, 0, 8}));
  const Scene scene = file.load(posed(0.5));
  EXPECT_EQ(scene.materials[0].base_color, glm::vec3(0.5, 0.25, 0));
  EXPECT_EQ(scene.materials[0].roughness, 0.5f);
  EXPECT_EQ(scene.materials[0].emission, glm::vec3(0.5, 0.5, 0.25));
  EXPECT_EQ(scene.materials[0].ior, 1.75f);
  ASSERT_EQ(scene.lights.size(), 1u);
  EXPECT_EQ(scene.lights[0].intensity, glm::vec3(2, 4, 4));
  EXPECT_NEAR(scene.lights[0].outer_height, 1 - std::cos(0.75), 1e-7);
  EXPECT_EQ(scene.cameras[0].y_fov, 1.0f);
  EXPECT_EQ(scene.cameras[0].focus_distance, 2.0f);
  EXPECT_EQ(scene.cameras[0].camera_to_world[3], glm::vec4(0, 0, 4, 1));
}

TEST(SceneAnimations, PointersHideAndShowNodes) {
  Gltf file;
  file.triangle();
  file.triangle({}, {{"extensions", {{"KHR_node_visibility", {{"visible", false}}}}}});
  const size_t flags = file.accessor(std::vector<uint8_t>{1, 0}, "SCALAR", UNSIGNED_BYTE);
  add_channel(file, pointer("/nodes/1/extensions/KHR_node_visibility/visible"), {0, 1}, flags, "STEP");
  EXPECT_EQ(file.load().triangles.size(), 1u);
  EXPECT_EQ(file.load(posed(0.9)).triangles.size(), 2u);
  EXPECT_EQ(file.load(posed(1)).triangles.size(), 1u);
}

// What a sequence keeps from frame to frame makes no difference.
TEST(SceneAnimations, AFilePosedAgainIsTheSceneOfThatTime) {
  Gltf file;
  file.triangle_of({{"pbrMetallicRoughness",
                     {{"baseColorTexture", {{"index", file.texture(make_png(1, 1, 3, 8, {255, 0, 0}))}}}}}});
  file.root["scenes"][0]["extras"]["regulus"] = {{"environment", {{"color", {1, 2, 3}}}}};
  add_channel(file, of_node(0, "translation"), {0, 1}, file.positions({0, 0, 0, 4, 0, 0}));
  const TemporaryFolder folder;
  const auto path = folder.write("test.gltf", file.root.dump());
  SceneFile open(path);
  Scene scene = open.load();
  EXPECT_FALSE(scene.pose);
  for (const double time : {0.75, 0.25}) {
    build_lights(scene);  // as a render does
    open.pose(scene, time);
    const Scene fresh = load(path, posed(time));
    EXPECT_EQ(scene.hash, fresh.hash);
    EXPECT_EQ(scene.images, fresh.images);
    EXPECT_EQ(scene.textures.size(), 1u);
    EXPECT_EQ(scene.lights.size(), fresh.lights.size());
    ASSERT_TRUE(scene.environment);
    EXPECT_EQ(scene.environment->parameters.radiance, glm::vec3(1, 2, 3));
    EXPECT_EQ(placed_positions(scene, 0), placed_positions(fresh, 0));
  }
}

TEST(SceneAnimations, PointersMoveSingleWeights) {
  Gltf file;
  file.triangle({{"targets",
                  {{{"POSITION", file.positions({1, 0, 0, 1, 0, 0, 1, 0, 0})}},
                   {{"POSITION", file.positions({0, 1, 0, 0, 1, 0, 0, 1, 0})}}}}});
  file.root["meshes"][0]["weights"] = {5, 0};
  add_channel(file, pointer("/nodes/0/weights/1"), {0, 1}, numbers(file, {0, 2}));
  add_channel(file, pointer("/nodes/0/weights/2"), {0, 1}, numbers(file, {0, 2}));  // no such target
  EXPECT_EQ(origin_of(file, 1), glm::vec3(5, 2, 0)) << "the other one is the mesh's";
  Gltf of_mesh = file;
  of_mesh.root["animations"] = json::array();
  add_channel(of_mesh, pointer("/meshes/0/weights"), {0, 1}, numbers(of_mesh, {0, 0, 3, 4}));
  EXPECT_EQ(origin_of(of_mesh, 1), glm::vec3(3, 4, 0));
}

TEST(SceneAnimations, WhatIsNotReadStaysWithOneWarning) {
  Gltf file;
  file.triangle_of({{"name", "m"}});
  for (const char* to : {"/materials/0/occlusionTexture/strength", "/materials/0/extensions/KHR_none/x",
                         "/accessors/0/count", "/nodes/0/matrix", "/meshes/0/primitives/0/mode", "nonsense",
                         "/nodes/7/translation", "/materials/0/name"})
    add_channel(file, pointer(to), {0}, numbers(file, {1}));
  add_channel(file, {{"path", "translation"}}, {0}, file.positions({1, 1, 1}));  // no node: to be ignored
  const Scene scene = file.load(posed(0));
  EXPECT_TRUE(has_warning(scene,
                          "animation 0 moves what is not read, and stays as it is: "
                          "/materials/0/occlusionTexture/strength, "));
  EXPECT_TRUE(has_warning(scene, "moves nothing that is read"));
}

TEST(SceneAnimations, BrokenChannelsAreWarnedOfAndLeaveTheOthers) {
  Gltf file;
  file.triangle();
  add_channel(file, of_node(0, "translation"), {0, 1}, file.positions({0, 0, 0, 4, 0, 0}));
  add_channel(file, of_node(0, "scale"), {1, 1}, file.positions({1, 1, 1, 2, 2, 2}));
  add_channel(file, of_node(0, "rotation"), {0, 1}, quaternions(file, {0, 0, 0, 1}));
  add_channel(file, of_node(0, "rotation"), {0}, file.positions({0, 0, 0}));
  add_channel(file, of_node(0, "scale"), {0}, file.positions({1, 1, 1}), "BEZIER");
  file.root["animations"][0]["channels"].push_back({{"sampler", 77}, {"target", of_node(0, "scale")}});
  file.root["animations"][0]["channels"].push_back(7);
  const Scene scene = file.load(posed(0.5));
  EXPECT_EQ(placed_positions(scene, 0)[0], glm::vec3(2, 0, 0));
  EXPECT_TRUE(has_warning(scene, "animation 0 channel 1 input"));
  EXPECT_TRUE(has_warning(scene, "animation 0 channel 2 output"));
  EXPECT_TRUE(has_warning(scene, "animation 0 channel 3 output"));
  EXPECT_TRUE(has_warning(scene, "interpolation 'BEZIER' is not known"));
  EXPECT_TRUE(has_warning(scene, "animation 0 channel 5 has no valid sampler"));
}

TEST(SceneAnimations, AreChosenByNameIndexOrByTheScene) {
  Gltf file;
  file.triangle();
  for (const float x : {1.0f, 2.0f}) {
    file.root["animations"].push_back({{"channels", json::array()}, {"samplers", json::array()}});
    add_channel(file, of_node(0, "translation"), {0, 1}, file.positions({0, 0, 0, x, 0, 0}));
  }
  file.root["animations"][1]["name"] = "walk";
  const auto at = [&](const LoadOptions& options) { return placed_positions(file.load(options), 0)[0].x; };
  EXPECT_EQ(at({}), 0) << "at rest";
  EXPECT_EQ(at(posed(1)), 1) << "the first";
  EXPECT_EQ(at(posed(1, "1")), 2);
  EXPECT_EQ(at(posed(1, "walk")), 2);
  EXPECT_EQ(file.load(posed(1, "1")).pose->animation, "walk");
  file.root["scenes"][0]["extras"]["regulus"] = {{"animation", "walk"}, {"at", 0.25}};
  EXPECT_EQ(at({}), 0.5f);
  EXPECT_EQ(at(posed(1)), 2);
  EXPECT_TRUE(file.load().settings.empty()) << "not settings of a render";
  const std::string error = error_of([&] { file.load(posed(0, "run")); });
  EXPECT_NE(error.find("has no animation \"run\", choose one by name or index: [\"\",\"walk\"]"),
            std::string::npos)
      << error;
  const Scene scene = file.load();
  ASSERT_EQ(scene.inventory.animations.size(), 2u);
  EXPECT_EQ(scene.inventory.animations[1].name, "walk");
  EXPECT_EQ(scene.inventory.animations[1].seconds, 1);
}

TEST(SceneAnimations, PosesHaveDifferentHashes) {
  Gltf file;
  file.triangle();
  for (int i = 0; i < 2; ++i) {
    file.root["animations"].push_back({{"channels", json::array()}, {"samplers", json::array()}});
    add_channel(file, of_node(0, "translation"), {0, 1}, file.positions({0, 0, 0, 1, 0, 0}));
  }
  const uint64_t at_rest = file.load().hash, first = file.load(posed(0)).hash;
  EXPECT_NE(at_rest, first);
  EXPECT_NE(first, file.load(posed(1.0 / 3)).hash);
  EXPECT_NE(first, file.load(posed(0, "1")).hash);
  EXPECT_EQ(first, file.load(posed(0, "0")).hash);
}

}  // namespace
}  // namespace regulus::scene::test
