// Morph targets and skins at rest: where vertices stand, by hand from glTF 2.0, 3.7.2.2 and 3.7.3.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "scene/placement.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

void expect_corners(const Scene& scene, uint32_t t, const std::array<glm::vec3, 3>& expected,
                    float tolerance = 0) {
  const auto found = placed_positions(scene, t);
  for (size_t i = 0; i < 3; ++i)
    for (int axis = 0; axis < 3; ++axis)
      EXPECT_NEAR(found[i][axis], expected[i][axis], tolerance) << "corner " << i << " axis " << axis;
}

// ---- morph targets

/// The triangle (0,0,0) (1,0,0) (0,1,0) with two targets: along x by its number plus 1, and the last corner
/// along z by 4.
Gltf morphed_triangle() {
  Gltf file;
  const size_t along_x = file.positions({1, 0, 0, 2, 0, 0, 3, 0, 0});
  const size_t along_z = file.positions({0, 0, 0, 0, 0, 0, 0, 0, 4});
  file.triangle({{"targets", {{{"POSITION", along_x}}, {{"POSITION", along_z}}}}});
  return file;
}

/// Adds attributes to the triangle of a file.
void add_attribute(Gltf& file, const std::string& name, size_t accessor) {
  file.root["meshes"][0]["primitives"][0]["attributes"][name] = accessor;
}

TEST(SceneMorphs, MeshWeightsAreTheDefaultNodeWeightsWinAndNeitherIsNone) {
  Gltf file = morphed_triangle();
  expect_corners(file.load(), 0, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
  file.root["meshes"][0]["weights"] = {0.5, 0.25};
  expect_corners(file.load(), 0, {{{0.5, 0, 0}, {2, 0, 0}, {1.5, 1, 1}}});
  file.root["nodes"][0]["weights"] = {0, -1};
  expect_corners(file.load(), 0, {{{0, 0, 0}, {1, 0, 0}, {0, 1, -4}}});
  // The displacement comes before the node's transform.
  file.root["nodes"][0]["scale"] = {1, 1, 2};
  expect_corners(file.load(), 0, {{{0, 0, 0}, {1, 0, 0}, {0, 1, -8}}});
  file.root["nodes"][0]["weights"] = {1};  // too few: the rest is 0
  expect_corners(file.load(), 0, {{{1, 0, 0}, {3, 0, 0}, {3, 1, 0}}});
}

TEST(SceneMorphs, FlatNormalsAreOfTheMorphedTriangle) {
  Gltf file = morphed_triangle();
  file.root["nodes"][0]["weights"] = {0, 0.25};  // (0,0,0) (1,0,0) (0,1,1)
  const Scene scene = file.load();
  for (const interface::Vertex& vertex : scene.vertices)
    EXPECT_LT(glm::length(vertex.normal - glm::vec3(0, -std::sqrt(0.5f), std::sqrt(0.5f))), 1e-6f);
}

TEST(SceneMorphs, NormalsTangentsColoursAndCoordinatesAreDisplaced) {
  Gltf file = morphed_triangle();
  add_attribute(file, "NORMAL", file.positions({0, 0, 1, 0, 0, 1, 0, 0, 1}));
  add_attribute(file, "TANGENT",
                file.accessor(std::vector<float>{1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1}, "VEC4", FLOAT));
  add_attribute(file, "COLOR_0",
                file.accessor(std::vector<float>{1, 1, 1, .5, 1, 1, 1, .5, .5, 1, 1, .5}, "VEC4", FLOAT));
  json& target = file.root["meshes"][0]["primitives"][0]["targets"][0];
  target["NORMAL"] = file.positions({0, 0, 0, 0, 2, 0, 0, 0, 0});
  target["TANGENT"] = file.positions({0, 0, 0, 0, 0, 0, 0, 2, 0});
  target["COLOR_0"] = file.positions({-1, 0, 0, 0, -1, 0, -2, 0, 1});
  target["TEXCOORD_0"] = file.accessor(std::vector<float>{0, 2, 0, 0, 1, 0}, "VEC2", FLOAT);
  const json texture = {{"index", file.texture(make_png(1, 1, 3, 8, {128, 128, 255}))}};
  file.root["materials"] = {{{"normalTexture", texture}, {"alphaMode", "BLEND"}}};
  file.root["meshes"][0]["primitives"][0]["material"] = 0;
  file.root["nodes"][0]["weights"] = {0.5};
  const Scene scene = file.load();
  ASSERT_EQ(scene.vertices.size(), 3u);
  EXPECT_EQ(scene.vertices[0].normal, glm::vec3(0, 0, 1));
  const float half = std::sqrt(0.5f);
  EXPECT_LT(glm::length(scene.vertices[1].normal - glm::vec3(0, half, half)), 1e-6f);
  EXPECT_LT(glm::length(scene.vertex_tangents[2] - glm::vec4(half, half, 0, -1)), 1e-6f);
  EXPECT_EQ(scene.vertex_tangents[0], glm::vec4(1, 0, 0, -1));
  EXPECT_EQ(scene.vertex_colors[0], glm::vec4(.5, 1, 1, .5));
  EXPECT_EQ(scene.vertex_colors[2], glm::vec4(0, 1, 1, .5)) << "clamped; alpha of a VEC3 target is 0";
  EXPECT_EQ(scene.vertices[0].uv, glm::vec2(0, 1));
  EXPECT_EQ(scene.vertices[2].uv, glm::vec2(0.5, 1));
}

TEST(SceneMorphs, SparseTargetsAndQuantizedOnesAreRead) {
  Gltf file = morphed_triangle();
  // A target without a buffer view: all zeros but for its last element.
  const size_t indices = file.view(to_bytes(std::vector<uint16_t>{2}));
  const size_t values = file.view(to_bytes(std::vector<float>{0, 8, 0}));
  const size_t sparse = file.root["accessors"].size();
  file.root["accessors"].push_back(
      {{"componentType", FLOAT},
       {"type", "VEC3"},
       {"count", 3},
       {"sparse",
        {{"count", 1},
         {"indices", {{"bufferView", indices}, {"componentType", UNSIGNED_SHORT}}},
         {"values", {{"bufferView", values}}}}}});
  // Normalized bytes (KHR_mesh_quantization): 127 is 1.
  const size_t bytes = file.accessor(std::vector<int8_t>{0, 0, 127, 0, 0, 0, 0, 0, -128}, "VEC3", BYTE);
  file.root["accessors"][bytes]["normalized"] = true;
  file.root["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", sparse}}, {{"POSITION", bytes}}};
  file.root["nodes"][0]["weights"] = {0.25, 3};
  expect_corners(file.load(), 0, {{{0, 0, 3}, {1, 0, 0}, {0, 3, -3}}});
}

TEST(SceneMorphs, CopiesShareAMeshOnlyInOnePose) {
  Gltf file = morphed_triangle();
  file.root["meshes"][0]["weights"] = {1, 0};
  file.node({{"mesh", 0}, {"translation", {0, 5, 0}}});
  file.node({{"mesh", 0}, {"weights", {0, 0.25}}});
  file.node({{"mesh", 0}, {"weights", {0, 0}}});
  LoadOptions sharing;
  sharing.sharing_gain = 0;
  const Scene scene = file.load(sharing);
  EXPECT_EQ(scene.instances.size(), 2u);
  EXPECT_EQ(placed_triangle_count(scene), 4u);
  const auto copy = placed_positions(scene, scene.instances[1].first_number);
  EXPECT_EQ(copy[1], glm::vec3(3, 5, 0));
  expect_corners(scene, 1, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 1}}});
  expect_corners(scene, 2, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
}

TEST(SceneMorphs, BrokenTargetsAreRefusedByName) {
  Gltf file = morphed_triangle();
  file.root["nodes"][0]["weights"] = {1};
  file.root["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = file.positions({0, 0, 0});
  EXPECT_NE(load_error(file).find("target 0 POSITION (accessor"), std::string::npos) << load_error(file);
  file.root["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = 99;
  EXPECT_NE(load_error(file).find("meshes/0/primitives/0/targets/0/POSITION"), std::string::npos);
  file.root["meshes"][0]["primitives"][0]["targets"] = json::array();
  file.root["nodes"][0]["weights"] = "1";
  EXPECT_NE(load_error(file).find("nodes/0/weights must be an array of numbers"), std::string::npos);
}

// ---- skins

/// The triangle bound to joints by these numbers and weights, four per vertex; nodes 1 .. are the joints.
Gltf skinned_triangle(const std::vector<json>& joints, const std::vector<uint8_t>& numbers,
                      const std::vector<float>& weights, const std::vector<float>& inverse_bind = {}) {
  Gltf file;
  file.triangle({}, {{"skin", 0}});
  add_attribute(file, "JOINTS_0", file.accessor(numbers, "VEC4", UNSIGNED_BYTE));
  add_attribute(file, "WEIGHTS_0", file.accessor(weights, "VEC4", FLOAT));
  json skin = {{"joints", json::array()}};
  for (const json& joint : joints) skin["joints"].push_back(file.node(joint));
  if (!inverse_bind.empty()) {
    file.root["accessors"].push_back({{"bufferView", file.view(to_bytes(inverse_bind))},
                                      {"componentType", FLOAT},
                                      {"type", "MAT4"},
                                      {"count", inverse_bind.size() / 16}});
    skin["inverseBindMatrices"] = file.root["accessors"].size() - 1;
  }
  file.root["skins"] = {skin};
  return file;
}

const std::vector<uint8_t> FIRST_JOINT(12, 0);
const std::vector<float> WHOLLY = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};

TEST(SceneSkins, JointsPlaceAMeshAndItsOwnNodeDoesNot) {
  Gltf file = skinned_triangle({{{"translation", {0, 0, 3}}, {"scale", {2, 2, 2}}}}, FIRST_JOINT, WHOLLY);
  file.root["nodes"][0]["translation"] = {100, 0, 0};
  file.root["nodes"][0]["scale"] = {-1, 7, 1};
  file.root["skins"][0]["skeleton"] = 0;
  expect_corners(file.load(), 0, {{{0, 0, 3}, {2, 0, 3}, {0, 2, 3}}});
}

TEST(SceneSkins, InverseBindMatricesComeFirst) {
  // Columns: half the size, then 1 along y.
  Gltf file = skinned_triangle({{{"translation", {0, 0, 3}}, {"scale", {4, 2, 1}}}}, FIRST_JOINT, WHOLLY,
                               {.5, 0, 0, 0, 0, .5, 0, 0, 0, 0, .5, 0, 0, 1, 0, 1});
  expect_corners(file.load(), 0, {{{0, 2, 3}, {2, 2, 3}, {0, 3, 3}}});
}

TEST(SceneSkins, VerticesFollowTheirJointsByWeightInAllSets) {
  const std::vector<json> joints = {
      {{"translation", {0, 0, 1}}}, {{"translation", {0, 4, 0}}}, {{"translation", {8, 0, 0}}}};
  // The joints of the second corner are 1 and 2; those of the third 0, and in the second set 2.
  Gltf file = skinned_triangle(joints, {0, 0, 0, 0, 1, 2, 0, 0, 0, 0, 0, 0},
                               {1, 0, 0, 0, .25, .75, 0, 0, .5, 0, 0, 0});
  add_attribute(
      file, "JOINTS_1",
      file.accessor(std::vector<uint16_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 0}, "VEC4", UNSIGNED_SHORT));
  const size_t weights =
      file.accessor(std::vector<uint16_t>{0, 0, 0, 0, 0, 0, 0, 0, 0, 32768, 0, 0}, "VEC4", UNSIGNED_SHORT);
  file.root["accessors"][weights]["normalized"] = true;
  add_attribute(file, "WEIGHTS_1", weights);
  // The last weight is 32768/65535, not 1/2: the sum is not quite 1.
  expect_corners(file.load(), 0, {{{0, 0, 1}, {7, 1, 0}, {4, 1, 0.5}}}, 5e-5f);
}

TEST(SceneSkins, WeightsAreDividedByTheirSum) {
  const std::vector<json> joints = {{{"translation", {0, 0, 1}}}, {{"translation", {0, 0, 5}}}};
  Gltf file = skinned_triangle(joints, {1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0},
                               {0, 0, 0, 0, 3, 1, 0, 0, .125, .125, 0, 0});
  const Scene scene = file.load();
  // Without any weight the first joint listed moves the vertex.
  expect_corners(scene, 0, {{{0, 0, 5}, {1, 0, 2}, {0, 1, 3}}});
  EXPECT_TRUE(has_warning(scene, "2 skinned vertices do not sum to 1"));
  EXPECT_TRUE(has_warning(scene, "1 skinned vertices have no weight"));
}

TEST(SceneSkins, JointsThatTheSkinLacksAreLeftOutWithAWarning) {
  Gltf file = skinned_triangle({{{"translation", {0, 0, 1}}}}, {0, 9, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0},
                               {.5, .5, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0});
  const Scene scene = file.load();
  expect_corners(scene, 0, {{{0, 0, 1}, {1, 0, 1}, {0, 1, 1}}});
  EXPECT_TRUE(has_warning(scene, "1 weights are of joints that their skin does not have"));
}

TEST(SceneSkins, NormalsTurnWithJointsAndFrontsStayInFront) {
  // A quarter turn about x takes z to -y; the mirror at x = 0 keeps the front where it is seen from.
  const float half = std::sqrt(0.5f);
  Gltf file =
      skinned_triangle({{{"rotation", {half, 0, 0, half}}, {"scale", {-1, 1, 3}}}}, FIRST_JOINT, WHOLLY);
  add_attribute(file, "NORMAL", file.positions({0, 0, 1, 0, 0, 1, 0, 0, 1}));
  const Scene scene = file.load();
  for (const interface::Vertex& vertex : scene.vertices)
    EXPECT_LT(glm::length(vertex.normal - glm::vec3(0, -1, 0)), 1e-6f);
  const auto p = placed_positions(scene, 0);
  const glm::vec3 front = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
  EXPECT_LT(glm::length(front - glm::vec3(0, -1, 0)), 1e-6f);
}

TEST(SceneSkins, AMorphedMeshIsDisplacedBeforeItsJointsMoveIt) {
  Gltf file = skinned_triangle({{{"scale", {2, 2, 2}}}}, FIRST_JOINT, WHOLLY);
  file.root["meshes"][0]["primitives"][0]["targets"] = {
      {{"POSITION", file.positions({0, 0, 1, 0, 0, 1, 0, 0, 1})}}};
  file.root["meshes"][0]["weights"] = {1.5};
  expect_corners(file.load(), 0, {{{0, 0, 3}, {2, 0, 3}, {0, 2, 3}}});
}

TEST(SceneSkins, NodesThatShareAMeshStandByTheirOwnSkins) {
  Gltf file = skinned_triangle({{{"translation", {0, 0, 1}}}}, FIRST_JOINT, WHOLLY);
  const size_t joint = file.node({{"translation", {0, 0, 2}}});
  file.root["skins"].push_back({{"joints", {joint}}});
  file.node({{"mesh", 0}, {"skin", 1}});
  file.node({{"mesh", 0}, {"translation", {0, 0, 3}}});
  LoadOptions sharing;
  sharing.sharing_gain = 0;
  for (const LoadOptions& options : {LoadOptions(), sharing}) {
    const Scene scene = file.load(options);
    std::vector<float> heights;
    for (uint32_t t = 0; t < 3; ++t) heights.push_back(placed_positions(scene, t)[1].z);
    std::sort(heights.begin(), heights.end());
    EXPECT_EQ(heights, (std::vector<float>{1, 2, 3}));
  }
}

TEST(SceneSkins, JointsNeedNotBeInTheShownScene) {
  Gltf file = skinned_triangle({{{"translation", {0, 0, 1}}}}, FIRST_JOINT, WHOLLY);
  // The joint becomes the child of a node that no scene lists.
  file.root["nodes"].push_back({{"translation", {0, 0, 5}}, {"children", {1}}});
  file.root["scenes"][0]["nodes"] = {0};
  expect_corners(file.load(), 0, {{{0, 0, 6}, {1, 0, 6}, {0, 1, 6}}});
}

TEST(SceneSkins, FarJointsLoseNothing) {
  // In single precision 1e9 + 1 would be 1e9.
  Gltf file = skinned_triangle({{{"translation", {1e9, 0, 0}}}}, FIRST_JOINT, WHOLLY,
                               {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1e9, 0, 0, 1});
  expect_corners(file.load(), 0, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}});
}

TEST(SceneSkins, BrokenSkinsAreRefusedAndHalfOnesWarnedOf) {
  Gltf file = skinned_triangle({{{"translation", {0, 0, 1}}}}, FIRST_JOINT, WHOLLY,
                               {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1});
  Gltf broken = file;
  broken.root["skins"][0]["joints"] = {1, 1};
  EXPECT_NE(load_error(broken).find("skin 0: 1 inverse bind matrices for 2 joints"), std::string::npos);
  broken.root["skins"][0]["joints"] = json::array();
  EXPECT_NE(load_error(broken).find("skin 0 has no joints"), std::string::npos);
  broken.root["skins"][0]["joints"] = {7};
  EXPECT_NE(load_error(broken).find("skins/0/joints/0 is 7"), std::string::npos);
  broken = file;
  broken.root["nodes"][0]["skin"] = 1;
  EXPECT_NE(load_error(broken).find("nodes/0/skin is 1"), std::string::npos);
  broken = file;
  add_attribute(broken, "JOINTS_0", broken.accessor(std::vector<uint8_t>(8, 0), "VEC4", UNSIGNED_BYTE));
  EXPECT_NE(load_error(broken).find("JOINTS_0 (accessor"), std::string::npos);

  file.root["nodes"][0]["translation"] = {0, 0, 9};
  file.root["meshes"][0]["primitives"][0]["attributes"].erase("WEIGHTS_0");
  const Scene scene = file.load();
  expect_corners(scene, 0, {{{0, 0, 9}, {1, 0, 9}, {0, 1, 9}}});
  EXPECT_TRUE(has_warning(scene, "has no joints and weights for its skin"));
}

}  // namespace
}  // namespace regulus::scene::test
