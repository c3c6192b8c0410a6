// The structure of a scene with shared meshes: a tree for each of them, in its space, below the scene's own,
// whose leaves are triangles and copies.
#pragma once

#include <span>

#include "bvh/bvh.hpp"
#include "scene/scene.hpp"

namespace regulus::bvh {

/// Builds over the stored triangles of `scene`, given in its order, and its copies, whose roots it sets. Node
/// 0 is the root of the scene.
/// @throws regulus::Error as build()
Bvh build_two_levels(std::span<const InputTriangle> triangles, scene::Scene& scene);

}  // namespace regulus::bvh
