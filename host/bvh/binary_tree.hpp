// The binary tree that Embree's builder makes, in arrays; the input of the collapse to wide nodes.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <limits>
#include <span>
#include <vector>

#include "bvh/bvh.hpp"

namespace regulus::bvh {

/// Axis-aligned box; empty (lower > upper) by default.
struct Box {
  glm::vec3 lower{std::numeric_limits<float>::infinity()};
  glm::vec3 upper{-std::numeric_limits<float>::infinity()};

  void extend(const Box& other) {
    lower = glm::min(lower, other.lower);
    upper = glm::max(upper, other.upper);
  }
  /// Half the surface area; in double, where no finite box overflows.
  double half_area() const {
    const glm::dvec3 e = glm::dvec3(upper) - glm::dvec3(lower);
    return e.x * e.y + e.y * e.z + e.z * e.x;
  }
};

/// What a tree is built over, by index: triangles, and behind them copies of meshes, of which only boxes are
/// known. Boxes of triangles are computed whenever they are wanted: a list of them is hundreds of megabytes
/// in a large scene.
struct Primitives {
  std::span<const InputTriangle> triangles;
  std::span<const Box> copies;

  size_t size() const { return triangles.size() + copies.size(); }
  /// The smallest box around a primitive.
  Box box(uint32_t primitive) const;
};

/// A node over a range of `BinaryTree::order`. Children come after their parent.
struct BinaryNode {
  Box box;
  std::array<uint32_t, 2> children{};  ///< meaningful if count > 1
  uint32_t first = 0;                  ///< of the primitives below, in BinaryTree::order
  uint32_t count = 0;                  ///< 1: a leaf
};

/// Root is nodes[0]; leaves hold one primitive each. Nodes stand depth first: an inner node's first child
/// follows it, the second follows all that is below the first.
struct BinaryTree {
  std::vector<BinaryNode> nodes;
  std::vector<uint32_t> order;  ///< primitives in depth-first order
};

/// Builds over at least one primitive, on all cores, by Embree's binned surface area heuristic. The same
/// primitives give the same tree on any number of cores.
/// @returns an empty tree if it would be deeper than 128 nodes.
/// @throws regulus::Error (Failed) if Embree fails or memory runs out.
BinaryTree build_surface_area_tree(const Primitives& primitives);

/// Builds over at least one primitive by splitting at the median of the longest axis: slower to traverse,
/// but of the least possible depth whatever the scene.
BinaryTree build_median_tree(const Primitives& primitives);

}  // namespace regulus::bvh
