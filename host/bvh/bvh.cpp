#include "bvh/bvh.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "bvh/binary_tree.hpp"
#include "bvh/collapse.hpp"
#include "bvh/encode.hpp"

namespace regulus::bvh {

namespace {

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

  BinaryTree binary = build_surface_area_tree(boxes);
  WideTree wide = collapse(binary);
  if (binary.nodes.empty() || wide.depth > interface::BVH_MAX_DEPTH) {
    // Triangles nested at extremely different scales.
    binary = build_median_tree(boxes);
    wide = collapse(binary);
  }
  if (wide.depth > interface::BVH_MAX_DEPTH)
    throw Error(ExitStatus::Failed,
                fmt::format("acceleration structure: {} levels over {} triangles, at most {} can "
                            "be traversed; split the scene",
                            wide.depth, triangles.size(), interface::BVH_MAX_DEPTH));
  require_encodable(triangles.size(), wide.nodes.size());
  return encode(binary, wide, triangles);
}

}  // namespace regulus::bvh
