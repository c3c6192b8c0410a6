#include "bvh/bvh.hpp"

#include "bvh/binary_tree.hpp"
#include "bvh/build_tree.hpp"

namespace regulus::bvh {

Bvh build(std::span<const InputTriangle> triangles) {
  return build(triangles, interface::BVH_MAX_DEPTH);
}

Bvh build(std::span<const InputTriangle> triangles, uint32_t max_depth) {
  std::vector<Box> boxes;
  boxes.reserve(triangles.size());
  for (const InputTriangle& triangle : triangles) boxes.push_back(bounds_of(triangle));
  return build_tree(triangles, boxes, max_depth);
}

}  // namespace regulus::bvh
