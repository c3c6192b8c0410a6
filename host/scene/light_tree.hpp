// The light tree (Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting",
// 2018), by which next-event estimation chooses among many lights: shaders/lib/light_tree.glsl.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

/// What a light, or several, can send where: from within a box, at most `theta_e` away from normals that lie
/// in a cone.
struct LightBounds {
  glm::dvec3 lower{0}, upper{0};  ///< m
  glm::dvec3 axis{0, 0, 1};       ///< of the cone, unit
  double theta_o = 0;             ///< half angle of the cone, [0, pi]
  double theta_e = 0;             ///< largest angle between a normal and a direction that it sends light to
  double intensity = 0;           ///< largest radiant intensity, luminance; W/sr
  bool is_two_sided = false;      ///< the normals' opposites are normals as well
};

/// The least bounds in this form that hold both, but for the cone, whose axis lies between theirs.
LightBounds united(const LightBounds& a, const LightBounds& b);

/// What interface::LightTreeRoot points to.
struct LightTree {
  std::vector<interface::LightPair> pairs;
  std::vector<uint32_t> trails;  ///< by light
  glm::vec3 center{0};           ///< of the root's sphere
  float radius = 0;
};

/// A light for the tree: bounds if it is near, otherwise its power.
struct TreeLight {
  bool is_distant = false;
  LightBounds bounds{};  ///< unless it is distant
  double power = 0;      ///< of a distant light: in proportion to it they share what is theirs
};

/// Splits by the surface area orientation heuristic. All n distant lights together are chosen with the
/// probability n / (n + 1), or 1 if there are no others (as in pbrt-v4). Fewer than two lights have no tree.
/// Deterministic.
LightTree build_light_tree(const std::vector<TreeLight>& lights);

/// What a request for LIGHT_SAMPLING_* comes to for so many lights: never AUTO, and by power where there is
/// nothing to choose; AUTO is the tree where there are many.
uint32_t resolve_light_sampling(uint32_t asked, size_t lights);

}  // namespace regulus::scene
