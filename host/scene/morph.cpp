#include "scene/morph.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

namespace regulus::scene {
namespace {

/// Type of an accessor that holds displacements of an attribute of this type: tangents keep their w, colours
/// may have an alpha or not.
int target_type(const Document& document, const std::string& name, int type, int accessor) {
  if (name == "TANGENT") return TINYGLTF_TYPE_VEC3;
  if (!name.starts_with("COLOR_")) return type;
  const int own = document.model.accessors.at(static_cast<size_t>(accessor)).type;
  return own == TINYGLTF_TYPE_VEC3 ? own : TINYGLTF_TYPE_VEC4;
}

}  // namespace

std::vector<double> morph_weights(const Document& document, size_t node) {
  const tinygltf::Node& source = document.model.nodes[node];
  const tinygltf::Mesh& mesh = document.model.meshes[static_cast<size_t>(source.mesh)];
  const std::vector<double>& weights = source.weights.empty() ? mesh.weights : source.weights;
  if (!std::all_of(weights.begin(), weights.end(), [](double w) { return std::isfinite(w); }))
    document.fail(element_name("node", node, source.name) + ": a morph weight is not finite; correct it");
  return weights;
}

MorphedAttribute::MorphedAttribute(const Document& document, const tinygltf::Primitive& primitive,
                                   const std::string& name, int type, const std::vector<double>& weights,
                                   const std::string& element)
    : base_(document, primitive.attributes.at(name), type, fmt::format("{} {}", element, name)) {
  for (size_t t = 0; t < std::min(weights.size(), primitive.targets.size()); ++t) {
    const auto accessor = primitive.targets[t].find(name);
    if (weights[t] == 0 || accessor == primitive.targets[t].end()) continue;
    AccessorReader target(document, accessor->second, target_type(document, name, type, accessor->second),
                          fmt::format("{} target {} {}", element, t, name));
    if (target.count() != base_.count())
      document.fail(fmt::format("{} has {} elements, the attribute {}; export the file again",
                                target.element(), target.count(), base_.count()));
    targets_.emplace_back(weights[t], std::move(target));
  }
}

}  // namespace regulus::scene
