#include "scene/nodes.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>

namespace regulus::scene {
namespace {

std::string node_name(const Document& document, size_t node) {
  return element_name("node", node, document.model.nodes[node].name);
}

// So far from 0 0 0 1 a matrix's last row is what rounding leaves, in single precision or in few decimal
// digits.
constexpr double MAX_ROUNDING_OF_ROW = 1e-5;

/// Affine by specification: a projective row would make every position below it wrong.
void make_affine(Document& document, size_t index, glm::dmat4& transform) {
  double error = 0;
  for (int column = 0; column < 4; ++column)
    error = std::max(error, std::abs(transform[column][3] - (column == 3 ? 1 : 0)));
  if (error == 0) return;
  const std::string fault =
      fmt::format("{}: last row of its matrix is not 0 0 0 1; correct it", node_name(document, index));
  if (!(error <= MAX_ROUNDING_OF_ROW)) document.fail(fault);
  document.mend(fault, fmt::format("off by {:g}, taken as rounding", error));
  for (int column = 0; column < 4; ++column) transform[column][3] = column == 3 ? 1 : 0;
}

glm::dmat4 local_transform(Document& document, size_t index) {
  const tinygltf::Node& node = document.model.nodes[index];
  glm::dmat4 transform(1.0);
  if (!node.matrix.empty()) {
    for (int i = 0; i < 16; ++i) transform[i / 4][i % 4] = node.matrix[static_cast<size_t>(i)];
    make_affine(document, index, transform);
    return transform;
  }
  if (!node.translation.empty())
    transform = glm::translate(transform, {node.translation[0], node.translation[1], node.translation[2]});
  if (!node.rotation.empty()) {
    const glm::dquat rotation(node.rotation[3], node.rotation[0], node.rotation[1], node.rotation[2]);
    const double length = glm::length(rotation);
    if (length > 0 && std::isfinite(length))
      transform *= glm::mat4_cast(rotation / length);
    else
      document.mend(
          fmt::format("{}: its rotation is not a quaternion; correct it", node_name(document, index)),
          "not turned");
  }
  if (!node.scale.empty()) transform = glm::scale(transform, {node.scale[0], node.scale[1], node.scale[2]});
  return transform;
}

bool is_finite_in_single(const glm::dmat4& matrix) {
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 4; ++row)
      if (!std::isfinite(static_cast<float>(matrix[column][row]))) return false;
  return true;
}

/// KHR_node_visibility of the node itself.
bool is_shown(const tinygltf::Node& node) {
  const auto extension = node.extensions.find("KHR_node_visibility");
  return extension == node.extensions.end() || !extension->second.Has("visible") ||
         extension->second.Get("visible").Get<bool>();
}

constexpr size_t NO_PARENT = static_cast<size_t>(-1);

std::vector<size_t> find_parents(const Document& document) {
  const auto& nodes = document.model.nodes;
  std::vector<size_t> parents(nodes.size(), NO_PARENT);
  for (size_t i = 0; i < nodes.size(); ++i)
    for (const int child : nodes[i].children) {
      size_t& parent = parents[static_cast<size_t>(child)];
      if (parent != NO_PARENT)
        document.fail(fmt::format("{} is a child of both node {} and node {}; a node has one parent",
                                  node_name(document, static_cast<size_t>(child)), parent, i));
      parent = i;
    }
  return parents;
}

std::vector<size_t> find_roots(const Document& document, std::optional<size_t> scene,
                               const std::vector<size_t>& parents) {
  std::vector<size_t> roots;
  if (scene) {
    for (const int node : document.model.scenes[*scene].nodes) roots.push_back(static_cast<size_t>(node));
  } else {
    for (size_t i = 0; i < parents.size(); ++i)
      if (parents[i] == NO_PARENT) roots.push_back(i);
  }
  return roots;
}

/// Every chain of parents must end at a root: with one parent per node, a chain that does not is a cycle.
void require_acyclic(const Document& document, const std::vector<size_t>& parents) {
  enum : unsigned char { Unseen, Open, Done };
  std::vector<unsigned char> state(parents.size(), Unseen);
  std::vector<size_t> chain;
  for (size_t start = 0; start < parents.size(); ++start) {
    chain.clear();
    size_t node = start;
    for (; node != NO_PARENT && state[node] == Unseen; node = parents[node]) {
      state[node] = Open;
      chain.push_back(node);
    }
    if (node != NO_PARENT && state[node] == Open)
      document.fail(fmt::format("{} is its own ancestor; remove the cycle from the node hierarchy",
                                node_name(document, node)));
    for (const size_t seen : chain) state[seen] = Done;
  }
}

}  // namespace

std::optional<size_t> choose_scene(const Document& document, std::optional<uint32_t> wanted) {
  const size_t count = document.model.scenes.size();
  if (wanted) {
    if (*wanted >= count) document.fail(fmt::format("there is no scene {}; the file has {}", *wanted, count));
    return *wanted;
  }
  if (count == 0) return std::nullopt;
  return document.model.defaultScene >= 0 ? static_cast<size_t>(document.model.defaultScene) : 0;
}

std::vector<PlacedNode> place_nodes(Document& document, std::optional<size_t> scene) {
  const std::vector<size_t> parents = find_parents(document);
  require_acyclic(document, parents);

  std::vector<PlacedNode> placed;
  std::vector<bool> is_placed(parents.size(), false);
  std::vector<PlacedNode> stack;  // explicit: hierarchies may be as deep as there are nodes
  const std::vector<size_t> roots = find_roots(document, scene, parents);
  for (size_t i = roots.size(); i-- > 0;) stack.push_back({roots[i], glm::dmat4(1.0)});
  while (!stack.empty()) {
    const PlacedNode top = stack.back();
    stack.pop_back();
    if (is_placed[top.node]) {
      document.mend(fmt::format("{} is placed twice in the scene; list only root nodes, once each",
                                node_name(document, top.node)),
                    "once");
      continue;
    }
    is_placed[top.node] = true;
    const glm::dmat4 to_world = top.to_world * local_transform(document, top.node);
    if (!is_finite_in_single(to_world))
      document.fail(
          fmt::format("{}: its transform is not finite; correct it", node_name(document, top.node)));
    const tinygltf::Node& node = document.model.nodes[top.node];
    const bool is_visible = top.is_visible && is_shown(node);
    placed.push_back({.node = top.node, .to_world = to_world, .is_visible = is_visible});
    for (size_t i = node.children.size(); i-- > 0;)
      stack.push_back(
          {.node = static_cast<size_t>(node.children[i]), .to_world = to_world, .is_visible = is_visible});
  }
  return placed;
}

std::vector<glm::dmat4> node_transforms(Document& document, const std::vector<PlacedNode>& placed) {
  const std::vector<size_t> parents = find_parents(document);
  std::vector<std::optional<glm::dmat4>> as_placed(parents.size());
  for (const PlacedNode& node : placed) as_placed[node.node] = node.to_world;

  std::vector<glm::dmat4> transforms(parents.size(), glm::dmat4(1.0));
  std::vector<size_t> stack = find_roots(document, std::nullopt, parents);
  while (!stack.empty()) {
    const size_t node = stack.back();
    stack.pop_back();
    const glm::dmat4 parent = parents[node] == NO_PARENT ? glm::dmat4(1.0) : transforms[parents[node]];
    transforms[node] = as_placed[node] ? *as_placed[node] : parent * local_transform(document, node);
    for (const int child : document.model.nodes[node].children) stack.push_back(static_cast<size_t>(child));
  }
  return transforms;
}

}  // namespace regulus::scene
