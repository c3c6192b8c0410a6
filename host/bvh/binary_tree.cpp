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
#include "bvh/bvh.hpp"

namespace regulus::bvh {

namespace {

// Nodes on a path that the builder may make before it gives up; real scenes stay below 40.
constexpr unsigned MAX_DEPTH = 128;

/// A node as the builder's callbacks make it: in Embree's arena, without constructor calls afterwards.
struct BuildNode {
  RTCBounds bounds[2];
  BuildNode* children[2];
  uint32_t primitive;
  bool is_leaf;
};

void* create_node(RTCThreadLocalAllocator allocator, unsigned, void*) {
  return new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode{};
}

void set_children(void* node, void** children, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i)
    static_cast<BuildNode*>(node)->children[i] = static_cast<BuildNode*>(children[i]);
}

void set_bounds(void* node, const RTCBounds** bounds, unsigned count, void*) {
  for (unsigned i = 0; i < count; ++i) static_cast<BuildNode*>(node)->bounds[i] = *bounds[i];
}

void* create_leaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t, void*) {
  auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(BuildNode), 16)) BuildNode{};
  leaf->primitive = primitives[0].primID;
  leaf->is_leaf = true;
  return leaf;
}

struct EmbreeRelease {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCBVH bvh) const { rtcReleaseBVH(bvh); }
};
using EmbreeDevice = std::unique_ptr<std::remove_pointer_t<RTCDevice>, EmbreeRelease>;
using EmbreeBvh = std::unique_ptr<std::remove_pointer_t<RTCBVH>, EmbreeRelease>;

std::vector<RTCBuildPrimitive> build_primitives(std::span<const Box> boxes) {
  std::vector<RTCBuildPrimitive> primitives(boxes.size());
  for (uint32_t i = 0; i < boxes.size(); ++i) {
    const Box& box = boxes[i];
    primitives[i] = {box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z, i};
  }
  return primitives;
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

/// Copies Embree's tree into arrays, depth first; boxes and ranges of inner nodes are left open.
BinaryTree flatten(const BuildNode* root) {
  struct Visit {
    const BuildNode* node;
    Place place;
  };
  BinaryTree tree;
  std::vector<Visit> stack{{root, {}}};
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const uint32_t index = append_node(tree, visit.place, static_cast<uint32_t>(tree.order.size()));
    if (visit.node->is_leaf) {
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
void sum_up(BinaryTree& tree, std::span<const Box> boxes) {
  for (size_t i = tree.nodes.size(); i-- > 0;) {
    BinaryNode& node = tree.nodes[i];
    if (node.count == 1) {
      node.box = boxes[tree.order[node.first]];
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
void halve(std::span<uint32_t> primitives, std::span<const Box> boxes) {
  glm::dvec3 lower(std::numeric_limits<double>::infinity());
  glm::dvec3 upper = -lower;
  for (uint32_t primitive : primitives) {
    lower = glm::min(lower, center_of(boxes[primitive]));
    upper = glm::max(upper, center_of(boxes[primitive]));
  }
  const glm::dvec3 extent = upper - lower;
  const int xy = extent.x >= extent.y ? 0 : 1;
  const int axis = extent[xy] >= extent.z ? xy : 2;
  const auto key = [&](uint32_t primitive) {
    return std::pair(center_of(boxes[primitive])[axis], primitive);
  };
  const auto middle = primitives.begin() + static_cast<std::ptrdiff_t>(primitives.size() / 2);
  std::nth_element(primitives.begin(), middle, primitives.end(),
                   [&](uint32_t a, uint32_t b) { return key(a) < key(b); });
}

}  // namespace

Box bounds_of(const InputTriangle& triangle) {
  Box box;
  for (const glm::vec3& vertex : triangle.vertices) box.extend({vertex, vertex});
  return box;
}

BinaryTree build_surface_area_tree(std::span<const Box> boxes) {
  const EmbreeDevice device(rtcNewDevice(nullptr));
  const EmbreeBvh bvh(device ? rtcNewBVH(device.get()) : nullptr);
  if (!bvh) throw Error(ErrorCode::Failed, "acceleration structure: Embree cannot make a device");
  std::vector<RTCBuildPrimitive> primitives = build_primitives(boxes);

  RTCBuildArguments arguments = rtcDefaultBuildArguments();
  arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
  arguments.maxBranchingFactor = 2;
  arguments.maxDepth = MAX_DEPTH;
  arguments.minLeafSize = 1;
  arguments.maxLeafSize = 1;
  arguments.bvh = bvh.get();
  arguments.primitives = primitives.data();
  arguments.primitiveCount = primitives.size();
  arguments.primitiveArrayCapacity = primitives.size();
  arguments.createNode = create_node;
  arguments.setNodeChildren = set_children;
  arguments.setNodeBounds = set_bounds;
  arguments.createLeaf = create_leaf;
  const auto* root = static_cast<const BuildNode*>(rtcBuildBVH(&arguments));
  if (root != nullptr) {
    BinaryTree tree = flatten(root);
    sum_up(tree, boxes);
    return tree;
  }
  const RTCError error = rtcGetDeviceError(device.get());
  // Embree reports its depth limit as an unknown error.
  if (error == RTC_ERROR_UNKNOWN) return {};
  throw Error(
      ErrorCode::Failed,
      fmt::format("acceleration structure over {} triangles: Embree failed (error {}); is memory short?",
                  boxes.size(), static_cast<int>(error)));
}

BinaryTree build_median_tree(std::span<const Box> boxes) {
  struct Visit {
    uint32_t first, count;
    Place place;
  };
  BinaryTree tree;
  tree.order.resize(boxes.size());
  std::iota(tree.order.begin(), tree.order.end(), 0u);
  std::vector<Visit> stack{{0, static_cast<uint32_t>(boxes.size()), {}}};
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    const uint32_t index = append_node(tree, visit.place, visit.first);
    tree.nodes[index].count = visit.count;
    if (visit.count == 1) continue;
    halve(std::span(tree.order).subspan(visit.first, visit.count), boxes);
    const uint32_t half = visit.count / 2;
    stack.push_back({visit.first + half, visit.count - half, {index, 1}});
    stack.push_back({visit.first, half, {index, 0}});
  }
  sum_up(tree, boxes);
  return tree;
}

}  // namespace regulus::bvh
