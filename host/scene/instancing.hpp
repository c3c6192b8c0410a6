// Where meshes stand: one place per node, many with EXT_mesh_gpu_instancing.
#pragma once

#include <vector>

#include "scene/document.hpp"
#include "scene/nodes.hpp"

namespace regulus::scene {

/// The visible nodes that have a mesh, once for every place where it stands: skinned meshes once, where their
/// joints are. Rotations by a quaternion of length 0 are mended.
/// @throws Error on broken instance attributes and on more places than memory allows.
std::vector<PlacedNode> place_meshes(Document& document, const std::vector<PlacedNode>& nodes);

}  // namespace regulus::scene
