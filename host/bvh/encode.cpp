#include "bvh/encode.hpp"

#include <algorithm>
#include <cmath>

namespace regulus::bvh {

namespace {

constexpr int EXPONENT_BIAS = 127;
// The quantum of a flat axis is this far below the float spacing of its coordinates, but never below 2^-60,
// whose square is still a normal number.
constexpr int FLAT_EXPONENT = -12;
constexpr int MIN_EXPONENT = -60;
constexpr int MAX_EXPONENT = 127;
constexpr double MAX_PLANE = 255;
// Part of a quantum by which a decoded box exceeds its child. The slab test evaluates plane q as
// q * (quantum / d) + (origin - o) / d, which errs by up to 3 * 2^-24 of the node's extent of 255 quanta
// beyond what is relative to the result: 4.6e-5 quanta.
constexpr double MARGIN = 1.0 / 1024;

/// The grid on which one axis of a node is quantized.
struct AxisGrid {
  float origin;
  int exponent;
  double quantum = std::ldexp(1.0, exponent);

  uint32_t lower_plane(float x) const {
    return static_cast<uint32_t>(
        std::clamp(std::floor((double{x} - origin) / quantum - MARGIN), 0.0, MAX_PLANE));
  }
  uint32_t upper_plane(float x) const {
    return static_cast<uint32_t>(
        std::clamp(std::ceil((double{x} - origin) / quantum + MARGIN), 0.0, MAX_PLANE));
  }
};

/// The finest grid whose planes 0 and 255 enclose [lower, upper] with the margin.
AxisGrid fit_grid(float lower, float upper) {
  const double extent = double{upper} - lower;
  const float magnitude = std::max(std::abs(lower), std::abs(upper));
  const int spacing = magnitude > 0 ? std::ilogb(magnitude) - 23 : MIN_EXPONENT;
  const int least = std::max(spacing + FLAT_EXPONENT, MIN_EXPONENT);
  const int exponent_of_extent = extent > 0 ? std::ilogb(extent / MAX_PLANE) : least;
  for (int exponent = std::max(exponent_of_extent, least); exponent < MAX_EXPONENT; ++exponent) {
    const double margin = std::ldexp(MARGIN, exponent);
    float origin = static_cast<float>(lower - margin);
    if (origin > lower - margin) origin = std::nextafter(origin, -std::numeric_limits<float>::infinity());
    if (origin + std::ldexp(MAX_PLANE, exponent) >= upper + margin) return {origin, exponent};
  }
  return {-std::numeric_limits<float>::max(), MAX_EXPONENT};
}

void set_plane(interface::BvhNode& node, uint32_t axis, bool is_upper, uint32_t slot, uint32_t plane) {
  uint32_t& word = node.planes[4 * axis + (is_upper ? 2 : 0) + slot / 4];
  const uint32_t shift = 8 * (slot % 4);
  word = (word & ~(0xFFu << shift)) | plane << shift;
}

/// Fills the grid, the planes and the mask of a node whose children have the given binary nodes.
void encode_boxes(const BinaryTree& binary, const WideNode& wide, interface::BvhNode& node) {
  Box box;
  for (uint32_t child : wide.binary)
    if (child != WideNode::NO_CHILD) box.extend(binary.nodes[child].box);
  for (uint32_t axis = 0; axis < 3; ++axis) {
    const int i = static_cast<int>(axis);
    const AxisGrid grid = fit_grid(box.lower[i], box.upper[i]);
    node.origin[i] = grid.origin;
    node.exponents |= static_cast<uint32_t>(grid.exponent + EXPONENT_BIAS) << (8 * axis);
    for (uint32_t slot = 0; slot < WIDE_CHILDREN; ++slot) {
      if (wide.binary[slot] == WideNode::NO_CHILD) continue;
      node.exponents |= 1u << (24 + slot);
      const Box& child = binary.nodes[wide.binary[slot]].box;
      set_plane(node, axis, false, slot, grid.lower_plane(child.lower[i]));
      set_plane(node, axis, true, slot, grid.upper_plane(child.upper[i]));
    }
  }
}

/// Whether the triangle has exactly no area. Differences and products of floats are exact in double for
/// coordinates of similar size, so this is decided without rounding where it matters.
bool is_degenerate(const InputTriangle& triangle) {
  const glm::dvec3 a(triangle.vertices[0]);
  const glm::dvec3 normal =
      glm::cross(glm::dvec3(triangle.vertices[1]) - a, glm::dvec3(triangle.vertices[2]) - a);
  return normal == glm::dvec3(0);
}

/// The triangle for the device; one without area shrinks to a point, which no rounding can make a hit.
interface::BvhTriangle device_triangle(const InputTriangle& triangle) {
  const auto& v = triangle.vertices;
  if (is_degenerate(triangle)) return {v[0], v[0], v[0], triangle.tag};
  return {v[0], v[1], v[2], triangle.tag};
}

/// Appends a leaf's triangles, in input order, and returns the reference to it. An instance is its own leaf.
uint32_t append_leaf(const BinaryTree& binary, const BinaryNode& leaf,
                     std::span<const InputTriangle> triangles, Bvh& bvh) {
  const uint32_t primitive = binary.order[leaf.first];
  if (primitive >= triangles.size())
    return interface::BVH_INSTANCE_BIT | (primitive - static_cast<uint32_t>(triangles.size()));
  const auto first = static_cast<uint32_t>(bvh.order.size());
  const auto begin = binary.order.begin() + leaf.first;
  bvh.order.insert(bvh.order.end(), begin, begin + leaf.count);
  std::sort(bvh.order.begin() + first, bvh.order.end());
  for (uint32_t i = first; i < bvh.order.size(); ++i)
    bvh.triangles.push_back(device_triangle(triangles[bvh.order[i]]));
  return interface::BVH_LEAF_BIT | (leaf.count - 1) << interface::BVH_LEAF_COUNT_SHIFT | first;
}

}  // namespace

interface::BvhNode empty_node() {
  interface::BvhNode node {};
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (uint32_t slot = 0; slot < WIDE_CHILDREN; ++slot) set_plane(node, axis, false, slot, 255);
  return node;
}

Bvh encode(const BinaryTree& binary, const WideTree& wide, std::span<const InputTriangle> triangles) {
  Bvh bvh;
  bvh.nodes.reserve(wide.nodes.size());
  bvh.triangles.reserve(triangles.size());
  bvh.order.reserve(triangles.size());
  const interface::BvhNode empty = empty_node();
  for (const WideNode& from : wide.nodes) {
    interface::BvhNode node = empty;
    encode_boxes(binary, from, node);
    for (uint32_t slot = 0; slot < WIDE_CHILDREN; ++slot) {
      if (from.binary[slot] == WideNode::NO_CHILD) continue;
      node.children[slot] = from.wide[slot] != WideNode::NO_CHILD
                                ? from.wide[slot]
                                : append_leaf(binary, binary.nodes[from.binary[slot]], triangles, bvh);
    }
    bvh.nodes.push_back(node);
  }
  bvh.depth = wide.depth;
  return bvh;
}

}  // namespace regulus::bvh
