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
  std::vector<uint32_t> nodes;                    ///< words of the nodes; empty scene: one node without children
  std::vector<interface::BvhTriangle> triangles;  ///< in leaf order
  std::vector<uint32_t> order;                    ///< order[leaf index] = index of the input triangle
  uint32_t node_count = 0;
  uint32_t depth = 0;                             ///< longest path from the root; the traversal stack holds it
};

/// Builds over `triangles` (may be empty) on all cores.
/// @throws regulus::Error (Failed) if memory runs out or the tree is deeper than the traversal stack.
Bvh build(std::span<const InputTriangle> triangles);

}  // namespace regulus::bvh
