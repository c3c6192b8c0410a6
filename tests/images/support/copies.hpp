// A scene of meshes that stand in several places, turned, stretched and mirrored, with everything that their
// surfaces may carry. It can be loaded with the meshes stored once, or once for every place.
#pragma once

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "images/support/prepared_scene.hpp"
#include "images/support/room.hpp"

namespace regulus::test {

inline glm::dmat4 placed(const glm::dvec3& position, double degrees, const glm::dvec3& axis,
                         const glm::dvec3& scale) {
  const glm::dmat4 turned = glm::rotate(glm::translate(glm::dmat4(1), position), glm::radians(degrees), axis);
  return glm::scale(turned, scale);
}

/// A ball with smooth normals, tangents, colours and texture coordinates at its corners: the unit sphere.
inline void add_ball(GltfScene& scene, const nlohmann::json& material, const glm::dmat4& matrix) {
  const Polygons ball = sphere({0, 0, 0}, 1, 12);
  Corners corners;
  for (const Polygon& polygon : ball)
    for (const glm::dvec3& corner : polygon) {
      const double turn = std::atan2(corner.z, corner.x) / 6.283185307179586;
      const glm::vec3 normal(glm::normalize(corner));
      corners.normals.push_back(normal);
      // Along a slanted axis, which computed ones would not be.
      corners.tangents.emplace_back(glm::normalize(glm::cross(normal, {0.6f, 0.64f, 0.48f})), 1);
      corners.uvs.emplace_back(3 * std::abs(turn), 0.5 + 0.5 * corner.y);
      corners.colors.emplace_back(0.5 + 0.5 * corner.y, 0.8, 0.5 + 0.5 * corner.x, 1);
    }
  scene.add(ball, material, matrix, corners);
}

inline GltfScene copies_scene() {
  GltfScene scene;
  scene.add({quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-1, 3, -1}, {2, 0, 0}, {0, 0, 2})}, emitter({6, 6, 5}));

  nlohmann::json relief = bumpy(scene, plastic({0.8, 0.7, 0.6}, 0.4));
  std::vector<uint8_t> grain;  // directions that turn from texel to texel, and strengths
  for (uint32_t i = 0; i < 16; ++i)
    for (const double value : {127.5 + 120 * std::cos(i), 127.5 + 120 * std::sin(i), 255.0 - 9.0 * i, 255.0})
      grain.push_back(static_cast<uint8_t>(value));
  relief["extensions"]["KHR_materials_anisotropy"] = {
      {"anisotropyStrength", 0.6},
      {"anisotropyRotation", 0.4},
      {"anisotropyTexture", {{"index", scene.add_texture(4, grain, true)}}}};
  add_ball(scene, relief, placed({-1.2, 0.5, 0.2}, 30, {0, 1, 0}, {0.5, 0.5, 0.5}));
  scene.add_copy(placed({0, 0.6, 0.3}, 50, {1, 2, 0.5}, {0.3, 0.6, 0.4}));
  scene.add_copy(placed({1.2, 0.5, 0.1}, 70, {0.3, 1, 0}, {-0.4, 0.5, 0.6}));  // mirrored

  scene.add(box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), glass(1.5, 0, {0.4, 0.8, 0.9}),
            placed({-0.6, 0.3, 1.2}, 20, {0, 1, 0}, {0.5, 0.5, 0.5}));
  scene.add_copy(placed({0.7, 0.4, 1.1}, 40, {0, 1, 0.2}, {0.4, -0.6, 0.5}));

  std::vector<uint8_t> holes;
  for (uint32_t i = 0; i < 16; ++i)
    for (const int value : {200, 90, 60, (i + i / 4) % 2 == 0 ? 255 : 0})
      holes.push_back(static_cast<uint8_t>(value));
  nlohmann::json lattice = lambert({1, 1, 1});
  lattice["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", scene.add_texture(4, holes, true)}};
  lattice["alphaMode"] = "MASK";
  add_ball(scene, lattice, placed({-0.5, 1.4, -0.8}, 10, {1, 0, 0}, {0.5, 0.5, 0.5}));
  scene.add_copy(placed({0.8, 1.3, -0.9}, 80, {1, 1, 1}, {0.3, 0.5, -0.6}));
  scene.set_perspective(look_at({0, 1.5, 4.5}, {0, 0.7, 0}), 0.7);
  return scene;
}

/// Clearcoats whose normals are not those of what they cover, and sheen under some of them: on an opaque
/// surface, on glass and on a pane.
inline GltfScene coats_scene() {
  GltfScene scene;
  scene.add({quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-1, 3, -1}, {2, 0, 0}, {0, 0, 2})}, emitter({6, 6, 5}));
  const glm::dvec3 half(0.5);
  add_ball(scene, bumpy(scene, coated(cloth(plastic({0.8, 0.3, 0.2}, 0.5), {0.9, 0.5, 0.2}, 0.4), 0)),
           placed({-1.3, 0.5, 0.2}, 30, {0, 1, 0}, half));
  add_ball(scene, coated(metal({0.9, 0.8, 0.6}, 0), 0.4, relief(scene)),
           placed({-0.1, 0.5, 0.4}, 50, {1, 2, 0.5}, half));
  nlohmann::json brushed = bumpy(scene, metal({0.7, 0.7, 0.7}, 0.4));
  brushed["extensions"]["KHR_materials_anisotropy"] = {{"anisotropyStrength", 0.7}};
  add_ball(scene, coated(brushed, 0.1, relief(scene, 2246822519u)),
           placed({1.1, 0.5, 0.3}, 70, {0.3, 1, 0}, half));
  add_ball(scene, coated(cloth(glass(1.5, 0.3, {0.4, 0.8, 0.9}), {0.2, 0.5, 0.3}, 0.7), 0, relief(scene)),
           placed({-0.6, 0.4, 1.4}, 20, {0, 1, 0}, half));
  nlohmann::json pane = plastic({0.9, 0.9, 0.6}, 0.3);
  pane["extensions"]["KHR_materials_transmission"] = {{"transmissionFactor", 0.7}};
  add_ball(scene, coated(cloth(pane, {0.3, 0.3, 0.6}, 0.25), 0.3, relief(scene)),
           placed({0.6, 0.4, 1.4}, 40, {0, 1, 0.2}, half));
  scene.set_perspective(look_at({0, 1.5, 4.5}, {0, 0.7, 0}), 0.7);
  return scene;
}

/// The scene with each mesh stored once.
inline PreparedScene shared_copies(const GltfScene& scene) {
  scene::LoadOptions options;
  options.sharing_gain = 0;
  return prepare(scene, options);
}

/// The scene with every copy stored in world space.
inline PreparedScene stored_copies(const GltfScene& scene) {
  scene::LoadOptions options;
  options.sharing_gain = scene::NEVER_SHARE;
  return prepare(scene, options);
}

}  // namespace regulus::test
