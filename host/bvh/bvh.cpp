#include "bvh/bvh.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "bvh/binary_tree.hpp"
#include "bvh/collapse.hpp"
#include "bvh/encode.hpp"

namespace regulus::bvh {

namespace {

// Depth of the binary tree. The collapse takes two or three levels into one, so what the first limit allows
// fits the traversal stack but for contrived scenes, which are built again within the second.
constexpr uint32_t BINARY_DEPTH = 128;
constexpr uint32_t SHALLOW_BINARY_DEPTH = 40;

void require_encodable(size_t triangles, size_t nodes) {
  if (triangles > interface::BVH_LEAF_FIRST_MASK || nodes > interface::BVH_MAX_NODES)
    throw Error(
        ExitStatus::Failed,
        fmt::format("acceleration structure: {} triangles in {} nodes exceed the limit of {} triangles in {} "
                    "nodes; split the scene",
                    triangles, nodes, interface::BVH_LEAF_FIRST_MASK, interface::BVH_MAX_NODES));
}

}  // namespace

Bvh build(std::span<const InputTriangle> triangles) {
  if (triangles.empty()) return {{empty_node()}, {}, {}, 1};
  require_encodable(triangles.size(), 0);
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const InputTriangle& triangle : triangles) boxes.push_back(bounds_of(triangle));

  BinaryTree binary = build_binary_tree(boxes, BINARY_DEPTH);
  WideTree wide = collapse(binary);
  if (wide.depth > interface::BVH_MAX_DEPTH) {
    binary = build_binary_tree(boxes, SHALLOW_BINARY_DEPTH);
    wide = collapse(binary);
  }
  if (wide.depth > interface::BVH_MAX_DEPTH)
    throw Error(ExitStatus::Failed,
                fmt::format("acceleration structure: {} levels deep, at most {} can be traversed; "
                            "remove triangles nested at extremely different scales",
                            wide.depth, interface::BVH_MAX_DEPTH));
  require_encodable(triangles.size(), wide.nodes.size());
  return encode(binary, wide, triangles);
}

}  // namespace regulus::bvh
