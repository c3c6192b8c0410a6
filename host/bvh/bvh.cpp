#include "bvh/bvh.hpp"

#include "bvh/binary_tree.hpp"
#include "bvh/build_tree.hpp"

namespace regulus::bvh {

Bvh build(std::span<const InputTriangle> triangles) {
  return build(triangles, interface::BVH_MAX_DEPTH);
}

Bvh build(std::span<const InputTriangle> triangles, uint32_t max_depth) {
  return build_tree({triangles, {}}, max_depth);
}

}  // namespace regulus::bvh
