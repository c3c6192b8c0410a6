// Texture coordinate sets and KHR_texture_transform, against the examples of its specification.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <utility>

#include "interface/wavefront.h"
#include "scene/texture.hpp"
#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// The triangle with uv (0,0) (1,0) (0,1), and the uvs (5,6) (7,8) (9,10) in set 1, under a texture with this
/// info.
Gltf textured(const json& transform, const json& other_transform = json()) {
  Gltf file;
  const size_t texture = file.texture(make_png(1, 1, 3, 8, {10, 20, 30}));
  json info = {{"index", texture}}, other = info;
  if (!transform.is_null()) info["extensions"]["KHR_texture_transform"] = transform;
  if (!other_transform.is_null()) other["extensions"]["KHR_texture_transform"] = other_transform;
  json pbr = {{"baseColorTexture", info}};
  if (!other_transform.is_null()) pbr["metallicRoughnessTexture"] = other;
  file.triangle_of({{"pbrMetallicRoughness", pbr}});
  file.root["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] =
      file.accessor(std::vector<float>{5, 6, 7, 8, 9, 10}, "VEC2", FLOAT);
  return file;
}

std::vector<glm::vec2> uvs(const Scene& scene) {
  std::vector<glm::vec2> result;
  for (const interface::Vertex& vertex : scene.vertices) result.push_back(vertex.uv);
  return result;
}

void expect_uvs(const json& transform, const std::vector<glm::vec2>& expected) {
  const std::vector<glm::vec2> actual = uvs(textured(transform).load());
  ASSERT_EQ(actual.size(), expected.size());
  for (size_t i = 0; i < actual.size(); ++i)
    EXPECT_LT(glm::distance(actual[i], expected[i]), 1e-6f)
        << transform << ' ' << i << ": " << actual[i].x << ' ' << actual[i].y;
}

TEST(SceneUvMapping, WithoutATransformCoordinatesStay) {
  EXPECT_EQ(uvs(textured(json()).load()), (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));
  EXPECT_EQ(uvs(textured(json::object()).load()), (std::vector<glm::vec2>{{0, 0}, {1, 0}, {0, 1}}));
}

// "This example inverts the T axis": (u, v) becomes (u, 1 - v).
TEST(SceneUvMapping, TheTAxisIsInverted) {
  expect_uvs({{"offset", {0, 1}}, {"scale", {1, -1}}}, {{0, 1}, {1, 1}, {0, 0}});
}

// "This example utilizes only the lower left quadrant of the source image, rotated clockwise 90 degrees":
// what was at the lower left of that quadrant, (0, 1), is seen at the top left, uv (0, 0); going right on the
// surface goes up in the image, going down goes right.
TEST(SceneUvMapping, TheLowerLeftQuadrantIsSeenRotatedClockwise) {
  expect_uvs({{"offset", {0, 1}}, {"rotation", std::numbers::pi / 2}, {"scale", {0.5, 0.5}}},
             {{0, 1}, {0, 0.5f}, {0.5f, 1}});
}

// Scale first, then rotation, then offset: with unequal scales the order shows. cos 30 = 0.866, sin 30 = 0.5.
TEST(SceneUvMapping, ScaleComesBeforeRotationBeforeOffset) {
  const float c = std::sqrt(0.75f);
  expect_uvs({{"offset", {10, 20}}, {"rotation", std::numbers::pi / 6}, {"scale", {2, 3}}},
             {{10, 20}, {10 + 2 * c, 20 - 1}, {10 + 1.5f, 20 + 3 * c}});
}

TEST(SceneUvMapping, TheTransformsSetWinsOverTheTextures) {
  expect_uvs({{"texCoord", 1}}, {{5, 6}, {7, 8}, {9, 10}});
  expect_uvs({{"texCoord", 1}, {"scale", {2, 1}}}, {{10, 6}, {14, 8}, {18, 10}});
  Gltf file = textured(json());
  file.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
  EXPECT_EQ(uvs(file.load()), (std::vector<glm::vec2>{{5, 6}, {7, 8}, {9, 10}}));
}

/// Where a texture of the triangle's material is looked up at its second vertex.
glm::dvec2 at_second_vertex(const Scene& scene, uint32_t interface::Material::*texture) {
  const interface::Triangle& triangle = scene.triangles.at(0);
  return image_coordinates(scene, scene.textures.at(scene.materials.at(triangle.material).*texture),
                           texture_coordinates(scene, triangle, {0, 1, 0}));
}

void expect_at_second_vertex(const Scene& scene, uint32_t interface::Material::*texture,
                             const glm::dvec2& expected) {
  const glm::dvec2 actual = at_second_vertex(scene, texture);
  EXPECT_LT(glm::distance(actual, expected), 1e-6) << actual.x << ' ' << actual.y;
}

void expect_looked_up(const json& first, const json& second, const glm::dvec2& at_first,
                      const glm::dvec2& at_second) {
  const Scene scene = textured(first, second).load();
  expect_at_second_vertex(scene, &interface::Material::base_color_texture, at_first);
  expect_at_second_vertex(scene, &interface::Material::metallic_roughness_texture, at_second);
}

// The second vertex is at (1, 0) in the first set and at (7, 8) in the second.
TEST(SceneUvMapping, EachTextureHasItsOwnCoordinates) {
  const json plain = json::object(), doubled = {{"scale", {2, 2}}}, other = {{"texCoord", 1}};
  const json turned = {{"offset", {10, 20}}, {"rotation", std::numbers::pi / 2}, {"scale", {2, 3}}};
  expect_looked_up(doubled, doubled, {2, 0}, {2, 0});
  expect_looked_up(doubled, {{"scale", {3, 3}}}, {2, 0}, {3, 0});
  expect_looked_up(doubled, turned, {2, 0}, {10, 18});
  expect_looked_up(plain, other, {1, 0}, {7, 8});
  expect_looked_up(other, plain, {7, 8}, {1, 0});
  expect_looked_up(turned, {{"texCoord", 1}, {"offset", {1, 2}}}, {10, 18}, {8, 10});
  const auto bits = [](const json& a, const json& b) {
    return find_features(textured(a, b).load()).bits &
           (interface::FEATURE_UV_SETS | interface::FEATURE_TEXTURE_MAPPINGS);
  };
  EXPECT_EQ(bits(doubled, doubled), 0u);
  EXPECT_EQ(bits(doubled, plain), interface::FEATURE_TEXTURE_MAPPINGS);
  EXPECT_EQ(bits(plain, other), interface::FEATURE_UV_SETS);
}

// Four sets and a transform in one material, and a second one whose primitive lacks one of its sets.
TEST(SceneUvMapping, EveryTextureReadsItsOwnSet) {
  using interface::Material;
  Gltf file = textured(json::object(), {{"texCoord", 1}});
  auto& attributes = file.root["meshes"][0]["primitives"][0]["attributes"];
  attributes["TEXCOORD_2"] = file.accessor(std::vector<float>{0, 0, 11, 12, 0, 0}, "VEC2", FLOAT);
  attributes["TEXCOORD_5"] = file.accessor(std::vector<float>{0, 0, 13, 14, 0, 0}, "VEC2", FLOAT);
  json& material = file.root["materials"][0];
  material["emissiveTexture"] = {{"index", 0}, {"texCoord", 5}};
  material["emissiveFactor"] = {1, 1, 1};
  material["normalTexture"] = {{"index", 0}, {"texCoord", 2}};
  material["extensions"]["KHR_materials_clearcoat"] = {
      {"clearcoatFactor", 1},
      {"clearcoatTexture",
       {{"index", 0},
        {"texCoord", 1},
        {"extensions", {{"KHR_texture_transform", {{"texCoord", 2}, {"offset", {1, 1}}}}}}}}};
  const Scene scene = file.load();
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.vertex_uv_sets, 3u);
  expect_at_second_vertex(scene, &Material::base_color_texture, {1, 0});
  expect_at_second_vertex(scene, &Material::metallic_roughness_texture, {7, 8});
  expect_at_second_vertex(scene, &Material::normal_texture, {11, 12});
  expect_at_second_vertex(scene, &Material::emissive_texture, {13, 14});
  expect_at_second_vertex(scene, &Material::clearcoat_texture, {12, 13});

  attributes.erase("TEXCOORD_2");
  const Scene without = file.load();
  EXPECT_TRUE(has_warning(without, "has no TEXCOORD_2"));
  expect_at_second_vertex(without, &Material::normal_texture, {0, 0});
  expect_at_second_vertex(without, &Material::emissive_texture, {13, 14});
}

TEST(SceneUvMapping, AbsencesAreWarnings) {
  EXPECT_TRUE(has_warning(textured({{"texCoord", 7}}).load(), "has no TEXCOORD_7"));
  EXPECT_TRUE(has_warning(textured(json::object(), {{"texCoord", 7}}).load(), "has no TEXCOORD_7"));
}

TEST(SceneUvMapping, BrokenTransformsAreErrors) {
  EXPECT_NE(load_error(textured({{"scale", {1, 1, 1}}})).find("an array of 2 numbers"), std::string::npos);
  EXPECT_NE(load_error(textured({{"offset", "left"}})).find("an array of 2 numbers"), std::string::npos);
  EXPECT_NE(load_error(textured({{"rotation", {0, 0, 0, 1}}})).find("a number"), std::string::npos);
  EXPECT_NE(load_error(textured({{"texCoord", -1}})).find("an integer"), std::string::npos);
  // What leaves single precision is no coordinate.
  EXPECT_TRUE(has_warning(textured({{"scale", {1e300, 1e300}}}).load(), "not finite"));
}

}  // namespace
}  // namespace regulus::scene::test
