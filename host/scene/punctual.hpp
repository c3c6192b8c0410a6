// KHR_lights_punctual and cameras: what nodes carry besides meshes.
#pragma once

#include <vector>

#include "scene/document.hpp"
#include "scene/nodes.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// Appends the point, spot and directional lights of the placed nodes. Intensities as written (cd, lx).
void add_punctual_lights(Document& document, const std::vector<PlacedNode>& nodes, Scene& scene);

/// Appends the cameras of the placed nodes.
void add_cameras(Document& document, const std::vector<PlacedNode>& nodes, Scene& scene);

/// A camera that sees all of the scene's bounds, from the front, a little to the right and above.
SceneCamera frame_bounds(const glm::vec3& bounds_min, const glm::vec3& bounds_max);

}  // namespace regulus::scene
