#include "bvh/two_level.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "bvh/build_tree.hpp"
#include "scene/placement.hpp"

namespace regulus::bvh {
namespace {

using interface::BvhNode;
using interface::Instance;

// Both levels share the traversal stack.
constexpr uint32_t MAX_DEPTH_OF_LEVEL = interface::BVH_MAX_DEPTH / 2;
constexpr uint32_t SLOTS = 8;

bool is_occupied(const BvhNode& node, uint32_t slot) {
  return (node.exponents >> (24 + slot) & 1u) != 0;
}

/// The box of a child as it is stored.
Box child_box(const BvhNode& node, uint32_t slot) {
  Box box;
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const int exponent = static_cast<int>(node.exponents >> (8 * axis) & 0xFFu) - 127;
    const auto plane = [&](uint32_t side) {
      const uint32_t q = node.planes[4 * axis + 2 * side + slot / 4] >> (8 * (slot % 4)) & 0xFFu;
      return node.origin[static_cast<int>(axis)] +
             static_cast<float>(std::ldexp(static_cast<double>(q), exponent));
    };
    box.lower[static_cast<int>(axis)] = plane(0);
    box.upper[static_cast<int>(axis)] = plane(1);
  }
  return box;
}

/// A box around a copy: that of the boxes which the children of its mesh's root become.
Box bounds_of_copy(const Instance& copy, const BvhNode& root) {
  Box bounds;
  for (uint32_t slot = 0; slot < SLOTS; ++slot) {
    if (!is_occupied(root, slot)) continue;
    const Box child = child_box(root, slot);
    const auto [lower, upper] = scene::placed_box(copy, child.lower, child.upper);
    bounds.extend(Box{lower, upper});
  }
  return bounds;
}

/// Appends a tree to another, whose node references and triangles it follows.
void append(Bvh&& part, uint32_t first_triangle, Bvh& bvh) {
  const auto first_node = static_cast<uint32_t>(bvh.nodes.size());
  for (BvhNode& node : part.nodes) {
    for (uint32_t slot = 0; slot < SLOTS; ++slot) {
      uint32_t& child = node.children[slot];
      if (!is_occupied(node, slot)) continue;
      if (child < interface::BVH_INSTANCE_BIT)
        child += first_node;
      else if (child >= interface::BVH_LEAF_BIT)
        child += first_triangle;
    }
    bvh.nodes.push_back(node);
  }
  for (uint32_t i = 0; i < part.triangles.size(); ++i) {
    bvh.triangles[first_triangle + i] = part.triangles[i];
    bvh.order[first_triangle + i] = first_triangle + part.order[i];
  }
}

}  // namespace

Bvh build_two_levels(std::span<const InputTriangle> triangles, scene::Scene& scene) {
  std::vector<Bvh> parts;
  for (const scene::SharedMesh& mesh : scene.shared_meshes)
    parts.push_back(build(triangles.subspan(mesh.first_triangle, mesh.triangle_count), MAX_DEPTH_OF_LEVEL));

  const auto first_placed = static_cast<uint32_t>(scene::first_placed_triangle(scene));
  const auto placed = triangles.subspan(first_placed);
  std::vector<Box> boxes;
  boxes.reserve(scene.instances.size());
  for (const Instance& copy : scene.instances)
    boxes.push_back(bounds_of_copy(copy, parts[scene::mesh_index_of(scene, copy)].nodes[0]));

  Bvh bvh;
  bvh.triangles.resize(triangles.size());
  bvh.order.resize(triangles.size());
  Bvh top = build_tree({placed, boxes}, MAX_DEPTH_OF_LEVEL);
  for (const Bvh& part : parts) bvh.depth = std::max(bvh.depth, part.depth);
  bvh.depth += top.depth;
  append(std::move(top), first_placed, bvh);
  std::vector<uint32_t> roots;
  for (size_t i = 0; i < parts.size(); ++i) {
    roots.push_back(static_cast<uint32_t>(bvh.nodes.size()));
    append(std::move(parts[i]), scene.shared_meshes[i].first_triangle, bvh);
  }
  for (Instance& copy : scene.instances) copy.root = roots[scene::mesh_index_of(scene, copy)];
  require_encodable(triangles.size(), bvh.nodes.size(), scene.instances.size());
  return bvh;
}

}  // namespace regulus::bvh
