#include "view/orbit.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::view {

Orbit orbit_of(const scene::SceneCamera& camera, const scene::Scene& scene) {
  const glm::dmat4 to_world(camera.camera_to_world);
  const glm::dvec3 back = glm::normalize(glm::dvec3(to_world[2])), position(to_world[3]);
  const glm::dvec3 low(scene.bounds_min), high(scene.bounds_max);
  const double least = std::max(1e-3 * glm::length(high - low), 1e-6);
  Orbit orbit;
  orbit.distance = std::max(glm::dot(position - 0.5 * (low + high), back), least);
  orbit.target = position - orbit.distance * back;
  orbit.yaw = std::atan2(back.x, back.z);
  orbit.pitch = std::asin(std::clamp(back.y, -1.0, 1.0));
  return orbit;
}

scene::SceneCamera moved(scene::SceneCamera camera, const Orbit& home, const Orbit& orbit) {
  const glm::dvec3 back(std::cos(orbit.pitch) * std::sin(orbit.yaw), std::sin(orbit.pitch),
                        std::cos(orbit.pitch) * std::cos(orbit.yaw));
  const glm::dvec3 right(std::cos(orbit.yaw), 0, -std::sin(orbit.yaw));
  camera.camera_to_world =
      glm::mat4(glm::dmat4(glm::dvec4(right, 0), glm::dvec4(glm::cross(back, right), 0), glm::dvec4(back, 0),
                           glm::dvec4(orbit.target + orbit.distance * back, 1)));
  const auto growth = static_cast<float>(orbit.distance / home.distance);
  camera.focus_distance *= growth;
  camera.x_magnification *= growth;
  camera.y_magnification *= growth;
  return camera;
}

}  // namespace regulus::view
