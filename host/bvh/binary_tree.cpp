#include "bvh/binary_tree.hpp"

#include <fmt/format.h>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <limits>
#include <memory>
#include <new>
#include <numeric>
#include <type_traits>
#include <utility>

#include "base/error.hpp"

namespace regulus::bvh {

namespace {

// Nodes on a path that the builder may make before it gives up; real scenes stay below 40.
constexpr unsigned MAX_DEPTH = 128;

/// A node as the builder's callbacks make it, in Embree's arena: as small as can be, since tens of millions
/// take more memory than all else while a scene is loaded. Boxes are derived from the leaves afterwards.
struct BuildNode {
  const BuildNode* children[2];  ///< of a leaf: none
  uint32_t primitive;            ///< of a leaf
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode))) BuildNode{};
}

void set_children(void* node, void** children, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i)
    static_cast<BuildNode*>(node)->children[i] = static_cast<const BuildNode*>(children[i]);
}

/// Embree insists on a function; boxes are summed up later.
void set_bounds(void*, const RTCBounds**, unsigned, void*) {}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), alignof(BuildNode)))
      BuildNode{{nullptr, nullptr}, primitives[0].primID};
}

struct EmbreeRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};
using EmbreeDevice = std::unique_ptr<std::remove_pointer_t<RTCDevice>, EmbreeRelease>;
using EmbreeBvh = std::unique_ptr<std::remove_pointer_t<RTCBVH>, EmbreeRelease>;

std::vector<RTCBuildPrimitive> build_primitives(const Primitives& primitives) {
  std::vector<RTCBuildPrimitive> result(primitives.size());
  for (uint32_t i = 0; i < result.size(); ++i) {
    const Box box = primitives.box(i);
    result[i] = {box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, i};
  }
  return result;
}

/// Where a node hangs: its parent's index and which child it is.
struct Place {
  uint32_t parent = 0, side = 0;
};

/// Appends a node that begins at primitive `first` of the order, and hangs it there; the first node of a tree
/// is the root and hangs nowhere. @returns its index.
uint32_t append_node(BinaryTree& tree, Place place, uint32_t first) {
  const auto index = static_cast<uint32_t>(tree.nodes.size());
  if (index > 0) tree.nodes[place.parent].children[place.side] = index;
  tree.nodes.emplace_back().first = first;
  return index;
}

/// Copies Embree's tree over so many primitives into arrays, depth first; boxes and ranges of inner nodes are
/// left open.
BinaryTree flatten(const BuildNode* root, size_t primitives) {
  struct Visit {
    const BuildNode* node;
    Place place;
  };
  BinaryTree tree;
  tree.nodes.reserve(2 * primitives - 1);
  tree.order.reserve(primitives);
  std::vector<Visit> stack{{root, {}}};
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const uint32_t index = append_node(tree, visit.place, static_cast<uint32_t>(tree.order.size()));
    if (visit.node->children[0] == nullptr) {
      tree.nodes[index].count = 1;
      tree.order.push_back(visit.node->primitive);
    } else {
      stack.push_back({visit.node->children[1], {index, 1}});
      stack.push_back({visit.node->children[0], {index, 0}});
    }
  }
  return tree;
}

/// Derives boxes and counts of all nodes from the leaves up.
void sum_up(BinaryTree& tree, const Primitives& primitives) {
  for (size_t i = tree.nodes.size(); i-- > 0;) {
    BinaryNode& node = tree.nodes[i];
    if (node.count == 1) {
      node.box = primitives.box(tree.order[node.first]);
      continue;
    }
    node.count = 0;
    for (uint32_t child : node.children) {
      node.box.extend(tree.nodes[child].box);
      node.count += tree.nodes[child].count;
    }
  }
}

glm::dvec3 center_of(const Box& box) {
  return 0.5 * (glm::dvec3(box.lower) + glm::dvec3(box.upper));
}

/// Halves a range of primitives at the median of the axis along which their centres spread most.
void halve(std::span<uint32_t> range, const Primitives& primitives) {
  glm::dvec3 lower(std::numeric_limits<double>::infinity());
  glm::dvec3 upper = -lower;
  for (const uint32_t primitive : range) {
    lower = glm::min(lower, center_of(primitives.box(primitive)));
    upper = glm::max(upper, center_of(primitives.box(primitive)));
  }
  const glm::dvec3 extent = upper - lower;
  const int xy = extent.x >= extent.y ? 0 : 1;
  const int axis = extent[xy] >= extent.z ? xy : 2;
  const auto key = [&](uint32_t primitive) {
    return std::pair(center_of(primitives.box(primitive))[axis], primitive);
  };
  const auto middle = range.begin() + static_cast<std::ptrdiff_t>(range.size() / 2);
  std::nth_element(range.begin(), middle, range.end(),
                   [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
}

}  // namespace

Box Primitives::box(uint32_t primitive) const {
  if (primitive >= triangles.size()) return copies[primitive - triangles.size()];
  Box box;
  for (const glm::vec3& vertex : triangles[primitive].vertices) box.extend({vertex, vertex});
  return box;
}

BinaryTree build_surface_area_tree(const Primitives& primitives) {
  const EmbreeDevice device(rtcNewDevice(nullptr));
  const EmbreeBvh bvh(device ? rtcNewBVH(device.get()) : nullptr);
  if (!bvh) throw Error(ErrorCode::Failed, "acceleration structure: Embree cannot make a device");
  std::vector<RTCBuildPrimitive> boxes = build_primitives(primitives);

  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 2;
  arguments.maxDepth = MAX_DEPTH;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 1;
  arguments.bvh = bvh.get();
  arguments.primitives = boxes.data();
  arguments.primitiveCount = boxes.size();
  arguments.primitiveArrayCapacity = boxes.size();
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  arguments.createLeaf = create_leaf;
  const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
  boxes = {};  // needed no longer, and as large as the arrays to come
  if (root != nullptr) {
    BinaryTree tree = flatten(root, primitives.size());
    sum_up(tree, primitives);
    return tree;
  }
  const RTCError error = rtcGetDeviceError(device.get());
  // Embree reports its depth limit as an unknown error.
  if (error == RTC_ERROR_UNKNOWN) return {};
  throw Error(
      ErrorCode::Failed,
      fmt::format("acceleration structure over {} triangles: Embree failed (error {}); is memory short?",
                  primitives.size(), static_cast<int>(error)));
}

BinaryTree build_median_tree(const Primitives& primitives) {
  struct Visit {
    uint32_t first, count;
    Place place;
  };
  BinaryTree tree;
  tree.nodes.reserve(2 * primitives.size() - 1);
  tree.order.resize(primitives.size());
  std::iota(tree.order.begin(), tree.order.end(), 0u);
  std::vector<Visit> stack{{0, static_cast<uint32_t>(primitives.size()), {}}};
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const uint32_t index = append_node(tree, visit.place, visit.first);
    tree.nodes[index].count = visit.count;
    if (visit.count == 1) continue;
    halve(std::span(tree.order).subspan(visit.first, visit.count), primitives);
    const uint32_t half = visit.count / 2;
    stack.push_back({visit.first + half, visit.count - half, {index, 1}});
    stack.push_back({visit.first, half, {index, 0}});
  }
  sum_up(tree, primitives);
  return tree;
}

}  // namespace regulus::bvh
