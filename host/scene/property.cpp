#include "scene/property.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

#include "scene/schema.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;
using Path = std::vector<std::string>;

/// The reference tokens of a JSON pointer (RFC 6901); none if it is not one.
Path split(const std::string& pointer) {
  try {
    Path path;
    for (json::json_pointer rest(pointer); !rest.empty(); rest = rest.parent_pointer())
      path.push_back(rest.back());
    std::reverse(path.begin(), path.end());
    return path;
  } catch (const json::exception&) {
    return {};
  }
}

std::optional<size_t> index_in(const std::string& token) {
  size_t index = 0;
  const auto [end, error] = std::from_chars(token.data(), token.data() + token.size(), index);
  if (error != std::errc{} || end != token.data() + token.size()) return std::nullopt;
  return index;
}

/// The value a path leads to; null if there is none.
const json* find(const json& root, const Path& path, size_t length) {
  const json* value = &root;
  for (size_t i = 0; i < length; ++i) {
    if (value->is_array()) {
      const auto index = index_in(path[i]);
      if (!index || *index >= value->size()) return nullptr;
      value = &(*value)[*index];
    } else {
      const auto member = value->is_object() ? value->find(path[i]) : value->end();
      if (!value->is_object() || member == value->end()) return nullptr;
      value = &*member;
    }
  }
  return value;
}

bool is_one_of(const std::string& name, std::initializer_list<std::string_view> names) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// Whether what lies there may change at all.
bool is_mutable(const Path& path) {
  if (path[0] == "meshes") return path[2] == "weights";
  if (path[0] == "nodes")
    return is_one_of(path[2], {"translation", "rotation", "scale", "weights", "extensions"});
  return is_one_of(path[0], {"cameras", "materials", "extensions"});
}

/// What a member is read as depends on the extension, or the kind of texture, that it is a member of.
std::string_view context_of(const Path& path) {
  if (path.size() >= 3 && path[path.size() - 3] == "extensions") return path[path.size() - 2];
  return path[path.size() - 2];
}

size_t target_count(const json& mesh) {
  size_t count = 0;
  for (const json& primitive : mesh.value("primitives", json::array()))
    count = std::max(count, primitive.value("targets", json::array()).size());
  return count;
}

/// The mesh of weights: path is /meshes/i/weights or /nodes/i/weights. Null if there is none.
const json* mesh_of_weights(const json& root, const Path& path) {
  if (path[0] == "meshes") return find(root, path, 2);
  const json* node = find(root, path, 2);
  if (node == nullptr || !node->contains("mesh")) return nullptr;
  return &root["meshes"][(*node)["mesh"].get<size_t>()];
}

/// A single weight: /meshes/i/weights/k or /nodes/i/weights/k.
std::optional<Property> find_weight(const Document& document, const std::string& pointer, const Path& path) {
  const json* mesh = mesh_of_weights(document.checked, path);
  const auto index = index_in(path[3]);
  if (mesh == nullptr || !index || *index >= target_count(*mesh)) return std::nullopt;
  Property property;
  property.pointer = json::json_pointer(pointer);
  property.length = 1;
  return property;
}

/// Makes the array that a single weight is an element of, where the file leaves it out: the mesh's weights
/// stand for those of a node, zeros for those of a mesh.
void complete_weights(json& root, const json::json_pointer& pointer) {
  const json::json_pointer array = pointer.parent_pointer();
  if (array.empty() || array.back() != "weights") return;
  json& owner = root[array.parent_pointer()];
  const json* mesh = owner.contains("mesh") ? &root["meshes"][owner["mesh"].get<size_t>()] : &owner;
  json weights = owner.contains("weights") ? owner["weights"] : mesh->value("weights", json::array());
  while (weights.size() < target_count(*mesh)) weights.push_back(0);
  owner["weights"] = weights;
}

}  // namespace

std::optional<Property> find_property(const Document& document, const std::string& pointer) {
  const Path path = split(pointer);
  if (path.size() < 3 || !is_mutable(path)) return std::nullopt;
  if (path.size() == 4 && path[2] == "weights") return find_weight(document, pointer, path);
  Property property;
  property.is_in_extras = path[2] == "extras";
  const json* parent = find(property.is_in_extras ? document.json : document.checked, path, path.size() - 1);
  if (parent == nullptr || !parent->is_object()) return std::nullopt;
  property.pointer = json::json_pointer(pointer);
  if (property.is_in_extras) {
    // Those of a thin lens are the only ones that are read.
    if (path[0] != "cameras" || path.size() != 5 || path[3] != "regulus") return std::nullopt;
    property.length = 1;
    return property;
  }
  const std::optional<MemberShape> shape = shape_of(context_of(path), path.back());
  if (!shape) return std::nullopt;
  property.length = shape->length;
  property.is_array = shape->is_array;
  property.is_boolean = shape->is_boolean;
  if (path[0] == "nodes" && is_one_of(path[2], {"translation", "rotation", "scale"}))
    property.node_of_transform = index_in(path[1]);
  return property;
}

void set_property(Document& document, const Property& property, const std::vector<double>& numbers) {
  json& root = property.is_in_extras ? document.json : document.checked;
  if (!property.is_in_extras) complete_weights(root, property.pointer);
  if (property.is_array)
    root[property.pointer] = numbers;
  else if (property.is_boolean)
    root[property.pointer] = numbers.front() != 0;
  else
    root[property.pointer] = numbers.front();
}

}  // namespace regulus::scene
