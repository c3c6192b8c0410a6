// Meshes to world-space triangles.
#pragma once

#include <vector>

#include "scene/document.hpp"
#include "scene/nodes.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// Appends the triangles of all placed meshes to `scene`. Triangle::material is the glTF index, or
/// model.materials.size() for primitives without a material.
/// @throws Error on broken primitives, non-finite positions, and scenes that do not fit into memory.
void add_geometry(Document& document, const std::vector<PlacedNode>& nodes, Scene& scene);

}  // namespace regulus::scene
