#include "bvh/collapse.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "interface/bvh.h"

namespace regulus::bvh {

namespace {

using interface::BVH_MAX_LEAF_SIZE;

// Cost of visiting a node and of testing a triangle. Their loads would make the latter 0.5, but fewer nodes
// are also a smaller tree in the caches: 0.1 to 0.3 were measured fastest.
constexpr float NODE_COST = 1.0f;
constexpr float TRIANGLE_COST = 0.2f;
// Of an instance: its ray is set up, and a tree of some nodes walked.
constexpr float INSTANCE_COST = 4.0f;

/// Cost of the cheapest ways to represent the subtree of a binary node: [i]: as a forest of at most i + 1
/// wide children.
using ForestCosts = std::array<float, WIDE_CHILDREN - 1>;

/// What those ways are.
struct Plan {
  /// split[j]: for a forest of j + 1 children (as many as WIDE_CHILDREN), how many of them go to the first
  /// binary child; 0: one child fewer is no worse.
  std::array<uint8_t, WIDE_CHILDREN> split;
  bool is_leaf;
};

/// Cost of distributing `children` roots over both sides, and how many the first side gets.
std::pair<float, uint8_t> best_split(const ForestCosts& first, const ForestCosts& second, uint32_t children) {
  std::pair<float, uint8_t> best{std::numeric_limits<float>::infinity(), 0};
  for (uint32_t k = 1; k < children; ++k) {
    const float cost = first[k - 1] + second[children - k - 1];
    if (cost < best.first) best = {cost, static_cast<uint8_t>(k)};
  }
  return best;
}

/// Cost of testing all primitives of a node in a leaf, per area of its box.
float cost_as_leaf(const BinaryTree& tree, const BinaryNode& node, uint32_t first_instance) {
  if (node.count > BVH_MAX_LEAF_SIZE) return std::numeric_limits<float>::infinity();
  const auto begin = tree.order.begin() + node.first;
  if (std::all_of(begin, begin + node.count, [&](uint32_t i) { return i < first_instance; }))
    return TRIANGLE_COST * static_cast<float>(node.count);
  return node.count == 1 ? INSTANCE_COST : std::numeric_limits<float>::infinity();
}

/// Plans an inner node. `relative_area`: of its box, 1 for the root; leaf_cost: as a leaf; first, second: of
/// its children.
std::pair<Plan, ForestCosts> plan_node(float relative_area, float leaf_cost, const ForestCosts& first,
                                       const ForestCosts& second) {
  Plan plan{};
  ForestCosts costs;
  const auto [wide_cost, wide_split] = best_split(first, second, WIDE_CHILDREN);
  plan.split[WIDE_CHILDREN - 1] = wide_split;
  plan.is_leaf = leaf_cost <= wide_cost + relative_area * NODE_COST;
  costs[0] = plan.is_leaf ? leaf_cost : wide_cost + relative_area * NODE_COST;
  for (uint32_t j = 1; j + 1 < WIDE_CHILDREN; ++j) {
    const auto [cost, split] = best_split(first, second, j + 1);
    const bool is_better = cost < costs[j - 1];
    costs[j] = is_better ? cost : costs[j - 1];
    plan.split[j] = is_better ? split : uint8_t{0};
  }
  return {plan, costs};
}

std::vector<Plan> plan_tree(const BinaryTree& tree, uint32_t first_instance) {
  std::vector<Plan> plans(tree.nodes.size());
  // Of subtrees whose parent is still to come, the one that stands first in the tree on top.
  std::vector<ForestCosts> costs;
  const double root_area = std::max(tree.nodes[0].box.half_area(), std::numeric_limits<double>::min());
  for (size_t i = plans.size(); i-- > 0;) {
    const BinaryNode& node = tree.nodes[i];
    const auto area = static_cast<float>(node.box.half_area() / root_area);
    // Not area * infinity, which of a flat box is no number.
    const float cost_of_leaf = cost_as_leaf(tree, node, first_instance);
    const float leaf_cost = std::isfinite(cost_of_leaf) ? area * cost_of_leaf : cost_of_leaf;
    if (node.count == 1) {
      plans[i] = {{}, true};
      costs.emplace_back().fill(leaf_cost);
      continue;
    }
    const ForestCosts first = costs.back();
    costs.pop_back();
    std::tie(plans[i], costs.back()) = plan_node(area, leaf_cost, first, costs.back());
  }
  return plans;
}

/// Appends the binary nodes that stand for `node` as a forest of at most `roots` children.
void gather_children(const BinaryTree& tree, const std::vector<Plan>& plans, uint32_t node, uint32_t roots,
                     std::vector<uint32_t>& children) {
  const Plan& plan = plans[node];
  while (roots > 1 && roots < WIDE_CHILDREN && plan.split[roots - 1] == 0) --roots;
  if (roots == 1) {
    children.push_back(node);
    return;
  }
  const uint32_t to_first = plan.split[roots - 1];
  gather_children(tree, plans, tree.nodes[node].children[0], to_first, children);
  gather_children(tree, plans, tree.nodes[node].children[1], roots - to_first, children);
}

/// Gives each child the slot whose corner it lies nearest to, in greedy order of how well it fits: slot bit
/// k stands for the upper end of axis k. Of equal fits the first child and slot.
std::array<uint32_t, WIDE_CHILDREN> assign_slots(const BinaryTree& tree, const Box& parent,
                                                 const std::vector<uint32_t>& children) {
  std::array<std::array<float, WIDE_CHILDREN>, WIDE_CHILDREN> gains;
  const glm::vec3 center = parent.lower + parent.upper;
  for (uint32_t child = 0; child < children.size(); ++child) {
    const Box& box = tree.nodes[children[child]].box;
    const glm::vec3 offset = box.lower + box.upper - center;
    for (uint32_t slot = 0; slot < WIDE_CHILDREN; ++slot) {
      const glm::vec3 corner(slot & 1 ? 1 : -1, slot & 2 ? 1 : -1, slot & 4 ? 1 : -1);
      gains[child][slot] = glm::dot(offset, corner);
    }
  }
  std::array<uint32_t, WIDE_CHILDREN> slots;
  slots.fill(WideNode::NO_CHILD);
  uint32_t placed = 0;
  for (size_t round = 0; round < children.size(); ++round) {
    uint32_t best_child = WIDE_CHILDREN, best_slot = 0;
    for (uint32_t child = 0; child < children.size(); ++child) {
      if ((placed >> child & 1) != 0) continue;
      for (uint32_t slot = 0; slot < WIDE_CHILDREN; ++slot) {
        if (slots[slot] != WideNode::NO_CHILD) continue;
        if (best_child < WIDE_CHILDREN && !(gains[child][slot] > gains[best_child][best_slot])) continue;
        best_child = child;
        best_slot = slot;
      }
    }
    slots[best_slot] = children[best_child];
    placed |= 1u << best_child;
  }
  return slots;
}

}  // namespace

WideTree collapse(const BinaryTree& tree, uint32_t first_instance) {
  struct Visit {
    uint32_t binary, wide, depth;
  };
  WideTree wide;
  if (tree.nodes.empty()) return wide;
  const std::vector<Plan> plans = plan_tree(tree, first_instance);
  wide.nodes.emplace_back();
  std::vector<Visit> stack{{0, 0, 1}};
  std::vector<uint32_t> children;
  while (!stack.empty()) {
    const Visit visit = stack.back();
    stack.pop_back();
    wide.depth = std::max(wide.depth, visit.depth);
    children.clear();
    if (tree.nodes[visit.binary].count <= BVH_MAX_LEAF_SIZE && plans[visit.binary].is_leaf)
      children.push_back(visit.binary);
    else
      gather_children(tree, plans, visit.binary, WIDE_CHILDREN, children);

    WideNode node;
    node.binary = assign_slots(tree, tree.nodes[visit.binary].box, children);
    node.wide.fill(WideNode::NO_CHILD);
    const size_t first_visit = stack.size();
    for (uint32_t slot = 0; slot < WIDE_CHILDREN; ++slot) {
      const uint32_t child = node.binary[slot];
      if (child == WideNode::NO_CHILD || plans[child].is_leaf) continue;
      node.wide[slot] = static_cast<uint32_t>(wide.nodes.size());
      stack.push_back({child, node.wide[slot], visit.depth + 1});
      wide.nodes.emplace_back();
    }
    std::reverse(stack.begin() + static_cast<std::ptrdiff_t>(first_visit), stack.end());
    wide.nodes[visit.wide] = node;
  }
  return wide;
}

}  // namespace regulus::bvh
