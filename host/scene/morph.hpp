// Morph targets: the weights that a node gives them, and vertex attributes with their displacements added.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

#include "scene/accessor.hpp"
#include "scene/document.hpp"

namespace regulus::scene {

/// Weights of the targets of a node's mesh: the node's, else the mesh's (glTF 2.0, 3.7.4). Targets beyond the
/// last have weight 0. Precondition: the node has a mesh.
/// @throws Error if one is not finite
std::vector<double> morph_weights(const Document& document, size_t node);

/// An attribute of a primitive's vertices: what its accessor holds plus the weighted sum of what its targets
/// hold (glTF 2.0, 3.7.2.2). Components that a target lacks, such as the w of a tangent, stay as they are.
class MorphedAttribute {
 public:
  /// @param type TINYGLTF_TYPE_* of the attribute
  /// @param weights of the primitive's targets
  /// @param element names the primitive in errors
  /// Precondition: the primitive has the attribute.
  /// @throws Error as AccessorReader, and if a target has another number of elements
  MorphedAttribute(const Document& document, const tinygltf::Primitive& primitive, const std::string& name,
                   int type, const std::vector<double>& weights, const std::string& element);

  uint64_t count() const { return base_.count(); }
  uint64_t components() const { return base_.components(); }
  const std::string& element() const { return base_.element(); }

  glm::vec2 vec2_at(uint64_t i) const { return displaced(i, base_.vec2_at(i)); }
  glm::vec3 vec3_at(uint64_t i) const { return displaced(i, base_.vec3_at(i)); }
  glm::vec4 vec4_at(uint64_t i) const { return displaced(i, base_.vec4_at(i)); }

 private:
  template <typename Vector>
  Vector displaced(uint64_t i, const Vector& value) const;

  AccessorReader base_;
  std::vector<std::pair<double, AccessorReader>> targets_;  // those that have a weight
};

template <typename Vector>
Vector MorphedAttribute::displaced(uint64_t i, const Vector& value) const {
  if (targets_.empty()) return value;
  Vector result{};
  for (uint64_t c = 0; c < static_cast<uint64_t>(Vector::length()); ++c) {
    double sum = value[static_cast<int>(c)];
    for (const auto& [weight, target] : targets_)
      if (c < target.components()) sum += weight * double{target.component_at(i, c)};
    result[static_cast<int>(c)] = static_cast<float>(sum);
  }
  return result;
}

}  // namespace regulus::scene
