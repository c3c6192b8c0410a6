// Meshes to triangles: in world space, or once for many copies.
#pragma once

#include <vector>

#include "scene/document.hpp"
#include "scene/nodes.hpp"
#include "scene/origin.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// Drops, with a warning, what is broken of the meshes that are placed: attributes that a primitive can do
/// without, or else the primitive. Call before anything else looks at them.
void drop_unreadable(Document& document, const std::vector<PlacedNode>& places);

/// Refuses more vertices than there would be memory for, before anything looks at them: accessors without
/// data claim millions in a line. @throws Error with both numbers
void require_vertices(Document& document, const std::vector<PlacedNode>& places);

/// Adds the triangles of meshes at their places to `scene`, and the copies of those meshes that are stored
/// once: together they save at least `sharing_gain` bytes (see LoadOptions). `boxes` are around the meshes in
/// their own spaces (PlacedBoxes::meshes). Triangle::material is the glTF index, or model.materials.size()
/// for primitives without a material.
/// @throws Error on broken primitives, non-finite positions, and scenes that do not fit into memory.
void add_geometry(Document& document, const std::vector<PlacedNode>& places, const std::vector<Box>& boxes,
                  uint64_t sharing_gain, Scene& scene);

}  // namespace regulus::scene
