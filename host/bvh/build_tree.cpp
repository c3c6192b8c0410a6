#include "bvh/build_tree.hpp"

#include <fmt/format.h>

#include "base/error.hpp"
#include "bvh/collapse.hpp"
#include "bvh/encode.hpp"

namespace regulus::bvh {

void require_encodable(size_t triangles, size_t nodes, size_t instances) {
  if (triangles > interface::BVH_LEAF_FIRST_MASK || nodes > interface::BVH_MAX_NODES)
    throw Error(
        ErrorCode::Failed,
        fmt::format("acceleration structure: {} triangles in {} nodes exceed the limit of {} triangles in {} "
                    "nodes; split the scene",
                    triangles, nodes, interface::BVH_LEAF_FIRST_MASK, interface::BVH_MAX_NODES));
  if (instances > interface::BVH_MAX_INSTANCES)
    throw Error(ErrorCode::Failed,
                fmt::format("acceleration structure: {} instances exceed the limit of {}; split "
                            "the scene",
                            instances, interface::BVH_MAX_INSTANCES));
}

Bvh build_tree(const Primitives& primitives, uint32_t max_depth) {
  const std::span<const InputTriangle> triangles = primitives.triangles;
  if (primitives.size() == 0) return {{empty_node()}, {}, {}, 1};
  const auto first_instance = static_cast<uint32_t>(triangles.size());
  require_encodable(triangles.size(), 0, primitives.copies.size());
  BinaryTree binary = build_surface_area_tree(primitives);
  WideTree wide = collapse(binary, first_instance);
  if (binary.nodes.empty() || wide.depth > max_depth) {
    // Triangles nested at extremely different scales.
    binary = build_median_tree(primitives);
    wide = collapse(binary, first_instance);
  }
  if (wide.depth > max_depth)
    throw Error(ErrorCode::Failed,
                fmt::format("acceleration structure: {} levels over {} triangles, at most {} can "
                            "be traversed; split the scene",
                            wide.depth, triangles.size(), max_depth));
  require_encodable(triangles.size(), wide.nodes.size(), 0);
  return encode(binary, wide, triangles);
}

}  // namespace regulus::bvh
