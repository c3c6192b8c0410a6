// A closed room with two boxes, the scene that techniques are compared on.
#pragma once

#include "images/support/gltf_scene.hpp"

namespace regulus::test {

// A closed room [-1, 1]^3 with two boxes on its floor, seen from its front wall with the view turned down.
inline GltfScene room(const nlohmann::json& floor, const nlohmann::json& tall, const nlohmann::json& low) {
  GltfScene scene;
  const Polygons walls = turned(box({-1, -1, -1}, {1, 1, 1}));
  const nlohmann::json white = lambert({0.7, 0.7, 0.7});
  scene.add({walls[0]}, white);                     // back, z = -1
  scene.add({walls[1]}, white);                     // front
  scene.add({walls[2]}, floor);                     // y = -1
  scene.add({walls[3]}, white);                     // ceiling
  scene.add({walls[4]}, lambert({0.6, 0.1, 0.1}));  // left
  scene.add({walls[5]}, lambert({0.1, 0.5, 0.1}));  // right
  const double c = std::cos(0.3), s = std::sin(0.3);
  const glm::dmat4 turn = {{c, 0, -s, 0}, {0, 1, 0, 0}, {s, 0, c, 0}, {0, 0, 0, 1}};
  scene.add(box({-0.7, -1, -0.6}, {-0.2, -0.2, -0.1}), tall, turn);
  scene.add(box({0.2, -1, -0.2}, {0.6, -0.6, 0.2}), low, turn);
  scene.set_perspective(look_at({0, -0.2, 0.95}, {0, -1, -0.6}), 0.85);
  return scene;
}

/// A normal map of strong random relief; `seed` odd.
inline nlohmann::json relief(GltfScene& scene, uint32_t seed = 2654435761u) {
  std::vector<uint8_t> rgba;
  for (uint32_t i = 0; i < 16; ++i) {
    const auto code = [&](uint32_t k) { return static_cast<uint8_t>((seed * (3 * i + k + 1)) >> 24); };
    for (const int value : {int{code(0)}, int{code(1)}, 200, 255})
      rgba.push_back(static_cast<uint8_t>(value));
  }
  return {{"index", scene.add_texture(4, rgba)}};
}

/// The material with such a normal map.
inline nlohmann::json bumpy(GltfScene& scene, nlohmann::json material) {
  material["normalTexture"] = relief(scene);
  return material;
}

/// The material under a clearcoat, which has the normals of the vertices or of a texture.
inline nlohmann::json coated(nlohmann::json material, double roughness, const nlohmann::json& normals = {}) {
  nlohmann::json& coat = material["extensions"]["KHR_materials_clearcoat"];
  coat = {{"clearcoatFactor", 0.9}, {"clearcoatRoughnessFactor", roughness}};
  if (!normals.is_null()) coat["clearcoatNormalTexture"] = normals;
  return material;
}

/// The material under sheen.
inline nlohmann::json cloth(nlohmann::json material, const glm::dvec3& color, double roughness) {
  material["extensions"]["KHR_materials_sheen"] = {{"sheenColorFactor", {color.x, color.y, color.z}},
                                                   {"sheenRoughnessFactor", roughness}};
  return material;
}

/// The material under a thin film of this thickness, nm.
inline nlohmann::json filmed(nlohmann::json material, double ior, double thickness, double strength = 1) {
  material["extensions"]["KHR_materials_iridescence"] = {
      {"iridescenceFactor", strength}, {"iridescenceIor", ior}, {"iridescenceThicknessMaximum", thickness}};
  return material;
}

/// The material, which has a volume, with this dispersion: 20 over Abbe's number.
inline nlohmann::json dispersive(nlohmann::json material, double dispersion) {
  material["extensions"]["KHR_materials_dispersion"] = {{"dispersion", dispersion}};
  return material;
}

inline const nlohmann::json WHITE = lambert({0.7, 0.7, 0.7});

// Faces down.
inline Polygon ceiling_light() {
  return quad({-0.6, 0.9, -0.6}, {1.2, 0, 0}, {0, 0, 1.2});
}

}  // namespace regulus::test
