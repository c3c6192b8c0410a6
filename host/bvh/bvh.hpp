// Building the acceleration structure: triangles in, the device's node and triangle arrays out. The tree is
// built by Embree's builder and converted to the layout of shaders/interface/bvh.h.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "interface/bvh.h"

namespace regulus::bvh {

/// One triangle to build over: world-space vertices and the tag traversal hands back. All coordinates must
/// be finite; zero-area triangles are allowed and never hit.
struct InputTriangle {
  std::array<glm::vec3, 3> vertices;
  uint32_t tag = 0;
};

/// The structure in device layout.
struct Bvh {
  std::vector<interface::BvhNode> nodes;          ///< root first; empty scene: one node without children
  std::vector<interface::BvhTriangle> triangles;  ///< in leaf order
  std::vector<uint32_t> order;                    ///< order[leaf index] = index of the input triangle
  uint32_t depth = 0;                             ///< nodes on the longest path from the root
};

/// Builds over `triangles` (may be empty) on all cores. The same triangles give the same structure on any
/// number of cores.
/// @throws regulus::Error (Failed) if memory runs out or the scene is too large for the node references
/// or the traversal stack.
Bvh build(std::span<const InputTriangle> triangles);

/// The same of at most `max_depth` levels.
Bvh build(std::span<const InputTriangle> triangles, uint32_t max_depth);

}  // namespace regulus::bvh
