#include "scene/light_groups.hpp"

#include <fmt/format.h>

#include <unordered_map>

#include "scene/document.hpp"
#include "scene/json_member.hpp"

namespace regulus::scene {

namespace {

constexpr const char* ENVIRONMENT = "environment";
constexpr const char* UNKNOWN = "light";  // of a scene that was not read from a file

using nlohmann::json;

/// extras.regulus.light_group of a node; empty where there is none.
std::string group_in_extras(const json& document, size_t node) {
  const json* nodes = member(&document, "nodes");
  if (nodes == nullptr || !nodes->is_array() || node >= nodes->size()) return {};
  const json* group = member(member(member(&nodes->at(node), "extras"), "regulus"), "light_group");
  return group != nullptr && group->is_string() ? group->get<std::string>() : std::string();
}

std::string group_of(const Scene& scene, size_t light) {
  if (scene.lights[light].kind == interface::LIGHT_ENVIRONMENT) return ENVIRONMENT;
  const uint32_t node =
      light < scene.light_nodes.size() ? scene.light_nodes[light] : interface::INVALID_INDEX;
  return node < scene.nodes.size() ? scene.nodes[node].light_group : UNKNOWN;
}

}  // namespace

std::vector<SceneNode> read_nodes(const Document& document) {
  std::vector<SceneNode> nodes;
  for (size_t i = 0; i < document.model.nodes.size(); ++i) {
    SceneNode node;
    node.name = document.model.nodes[i].name;
    if (node.name.empty()) node.name = fmt::format("node {}", i);
    node.light_group = group_in_extras(document.json, i);
    if (node.light_group.empty()) node.light_group = node.name;
    nodes.push_back(std::move(node));
  }
  return nodes;
}

LightGroups light_groups(const Scene& scene) {
  LightGroups groups;
  std::unordered_map<std::string, uint32_t> numbers;
  for (size_t light = 0; light < scene.lights.size(); ++light) {
    const std::string name = group_of(scene, light);
    const auto [found, is_new] = numbers.emplace(name, static_cast<uint32_t>(groups.names.size()));
    if (is_new) groups.names.push_back(name);
    groups.of_light.push_back(found->second);
  }
  return groups;
}

}  // namespace regulus::scene
