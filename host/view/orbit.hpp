// A camera that turns about a point.
#pragma once

#include <glm/glm.hpp>

#include "scene/scene.hpp"

namespace regulus::view {

/// World space of the scene, metres and radians. Yaw 0 and pitch 0 look along -z, level.
struct Orbit {
  double yaw = 0, pitch = 0, distance = 1;
  glm::dvec3 target{0};
  bool operator==(const Orbit&) const = default;
};

/// The orbit that a camera is on, about what it looks at: a point on its axis as far away as the middle of
/// the scene.
Orbit orbit_of(const scene::SceneCamera& camera, const scene::Scene& scene);

/// The camera moved to another orbit, upright; what it sees and its focus grow with the distance as it moves
/// from `home`. Preconditions: distances above 0, |pitch| below pi / 2.
scene::SceneCamera moved(scene::SceneCamera camera, const Orbit& home, const Orbit& orbit);

}  // namespace regulus::view
