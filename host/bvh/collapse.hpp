// From the binary tree to wide nodes: which binary nodes become wide nodes and leaves, chosen to minimize the
// surface area cost (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through
// Compressed Wide BVHs", HPG 2017, section 3), and in which of the eight slots each child stands.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "bvh/binary_tree.hpp"

namespace regulus::bvh {

inline constexpr uint32_t WIDE_CHILDREN = 8;

/// A wide node: for each slot the binary node that stands there (NO_CHILD: empty) and, for an inner child,
/// the index of its wide node (NO_CHILD: a leaf over the binary node's primitives).
struct WideNode {
  static constexpr uint32_t NO_CHILD = 0xFFFFFFFFu;
  std::array<uint32_t, WIDE_CHILDREN> binary;
  std::array<uint32_t, WIDE_CHILDREN> wide;
};

struct WideTree {
  std::vector<WideNode> nodes;  ///< root first, parents before children, the children of a node in a row
  uint32_t depth = 0;           ///< nodes on the longest path from the root
};

/// An empty tree gives an empty tree. Primitives from `first_instance` on are instances, each a leaf of its
/// own.
WideTree collapse(const BinaryTree& tree, uint32_t first_instance = 0xFFFFFFFFu);

}  // namespace regulus::bvh
