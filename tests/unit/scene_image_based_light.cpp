// EXT_lights_image_based: the cube map of a scene as its environment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scene_files.hpp"

namespace regulus::scene::test {
namespace {

/// Radiance of a direction, from the texel that holds it.
glm::vec3 radiance(const Scene& scene, const glm::dvec3& direction) {
  const Environment& environment = scene.environment.value();
  const uint32_t width = environment.parameters.width, height = environment.parameters.height;
  if (width == 0) return environment.parameters.radiance;
  const glm::dvec3 d = glm::normalize(direction);
  // interface::Environment
  double u = std::atan2(d.z, d.x) / (2 * std::numbers::pi) + 0.5 + environment.parameters.rotation;
  u -= std::floor(u);
  const auto column = std::min(static_cast<uint32_t>(u * width), width - 1);
  const auto row = std::min(
      static_cast<uint32_t>(std::acos(std::clamp(d.y, -1.0, 1.0)) / std::numbers::pi * height), height - 1);
  return environment.texels[size_t{row} * width + column];
}

/// A triangle under a cube whose faces are these PNG files.
Gltf under_cube(const std::vector<Bytes>& faces, const json& members = json::object()) {
  Gltf file;
  file.triangle();
  json light = {{"irradianceCoefficients", json::array()}, {"specularImageSize", 1}};
  json images = json::array();
  for (const Bytes& face : faces) {
    file.root["images"].push_back({{"uri", "data:image/png;base64," + base64(face)}});
    images.push_back(file.root["images"].size() - 1);
  }
  light["specularImages"] = {images, json::array()};
  light.update(members);
  file.root["extensionsUsed"] = {"EXT_lights_image_based"};
  file.root["extensions"]["EXT_lights_image_based"]["lights"] = {light};
  file.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 0;
  return file;
}

/// One white corner (column, row of 2 x 2) on a black face.
Bytes corner_face(size_t column, size_t row) {
  std::vector<uint16_t> samples(12, 0);
  for (size_t channel = 0; channel < 3; ++channel) samples[3 * (2 * row + column) + channel] = 255;
  return make_png(2, 2, 3, 8, samples);
}

Bytes plain_face(const std::vector<uint16_t>& rgb, uint32_t side = 1) {
  std::vector<uint16_t> samples;
  for (uint32_t i = 0; i < side * side; ++i) samples.insert(samples.end(), rgb.begin(), rgb.end());
  return make_png(side, side, static_cast<uint32_t>(rgb.size()), 8, samples);
}

std::vector<Bytes> six_greys() {
  std::vector<Bytes> faces;
  for (uint16_t i = 0; i < 6; ++i) faces.push_back(plain_face({static_cast<uint16_t>(40 * i), 0, 255}));
  return faces;
}

double srgb(double code) {
  return std::pow((code / 255 + 0.055) / 1.055, 2.4);
}

const std::vector<glm::dvec3> AXES = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};

TEST(SceneImageBasedLight, FacesAreInTheirDirections) {
  const Gltf file = under_cube(six_greys());
  EXPECT_EQ(load_error(file), "");
  const Scene scene = file.load();
  for (size_t i = 1; i < 6; ++i) {
    const glm::vec3 found = radiance(scene, AXES[i]);
    EXPECT_NEAR(found.r, srgb(40.0 * static_cast<double>(i)), 1e-3) << "face " << i;
    EXPECT_EQ(found.b, 1.0f);
  }
}

// Seen from the middle with up as on the picture: looking along +x, what is to the right is +z, and so
// around; looking up, +z is at the bottom, looking down, at the top.
TEST(SceneImageBasedLight, FacesAreSeenFromInside) {
  struct Case {
    size_t face, column, row;
    glm::dvec3 bright, dark;
  };
  const Case cases[] = {
      {0, 1, 0, {1, 0.5, 0.5}, {1, 0.5, -0.5}},     {1, 1, 0, {-1, 0.5, -0.5}, {-1, 0.5, 0.5}},
      {4, 1, 0, {-0.5, 0.5, 1}, {0.5, 0.5, 1}},     {5, 1, 0, {0.5, 0.5, -1}, {-0.5, 0.5, -1}},
      {4, 0, 1, {0.5, -0.5, 1}, {0.5, 0.5, 1}},     {2, 1, 1, {-0.5, 1, 0.5}, {-0.5, 1, -0.5}},
      {3, 1, 0, {-0.5, -1, 0.5}, {-0.5, -1, -0.5}},
  };
  for (const Case& c : cases) {
    std::vector<Bytes> faces(6, plain_face({0, 0, 0}, 2));
    faces[c.face] = corner_face(c.column, c.row);
    const Scene scene = under_cube(faces).load();
    EXPECT_GT(radiance(scene, c.bright).r, 0.9f) << "face " << c.face;
    EXPECT_LT(radiance(scene, c.dark).r, 0.1f) << "face " << c.face;
  }
}

TEST(SceneImageBasedLight, AlphaDividesAndIntensityScales) {
  // sRGB 188 over alpha 51 / 255: five times as much. White without alpha is 1.
  const double expected = 3 * srgb(188) * 5;
  const Scene scene =
      under_cube(std::vector<Bytes>(6, plain_face({188, 188, 188, 51})), {{"intensity", 3}}).load();
  EXPECT_NEAR(scene.environment.value().parameters.radiance.g, expected, 1e-4 * expected);
  const Scene white =
      under_cube(std::vector<Bytes>(6, plain_face({255, 255, 255}))).load({.environment = {.scale = 2}});
  EXPECT_EQ(white.environment.value().parameters.radiance, glm::vec3(2));
}

TEST(SceneImageBasedLight, RotationTurnsTheMap) {
  // A quarter turn about y takes +z to +x: what was face 4 is now seen along +x.
  const double s = std::sqrt(0.5);
  const Scene scene = under_cube(six_greys(), {{"rotation", {0, s, 0, s}}}).load();
  EXPECT_NEAR(radiance(scene, {1, 0, 0}).r, srgb(160), 1e-3);
  EXPECT_NEAR(radiance(scene, {0, 0, -1}).r, 0, 1e-3);
}

TEST(SceneImageBasedLight, ScenesOfTheirOwnEnvironmentKeepIt) {
  Gltf file = under_cube(six_greys());
  file.root["scenes"][0]["extras"]["regulus"]["environment"] = {{"color", {1, 2, 3}}};
  EXPECT_EQ(file.load().environment.value().parameters.radiance, glm::vec3(1, 2, 3));
}

TEST(SceneImageBasedLight, WhatIsBrokenIsLeftOut) {
  const auto fault = [](Gltf file, const std::string& pointer, const json& value) {
    file.root[json::json_pointer("/extensions/EXT_lights_image_based/lights/0" + pointer)] = value;
    const Scene scene = file.load();
    EXPECT_FALSE(scene.environment.has_value()) << pointer;
    EXPECT_TRUE(has_warning(scene, "EXT_lights_image_based")) << pointer;
    EXPECT_NE(load_error(file), "") << pointer;
  };
  const Gltf file = under_cube(six_greys());
  fault(file, "/specularImages", 3);
  fault(file, "/specularImages", json::array());
  fault(file, "/specularImages/0", {0, 1, 2});
  fault(file, "/specularImages/0/2", 99);
  fault(file, "/specularImages/0/2", "x");
  std::vector<Bytes> uneven = six_greys();
  uneven[3] = plain_face({1, 2, 3}, 2);
  fault(under_cube(uneven), "/name", "uneven");
  Gltf elsewhere = file;
  elsewhere.root["scenes"][0]["extensions"]["EXT_lights_image_based"]["light"] = 7;
  EXPECT_FALSE(elsewhere.load().environment.has_value());
  EXPECT_TRUE(has_warning(elsewhere.load(), "is not there"));
}

}  // namespace
}  // namespace regulus::scene::test
