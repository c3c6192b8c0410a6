// Which texture coordinates a material's textures use: the set and KHR_texture_transform. They are applied to
// the vertices once, so kernels know one set of final coordinates.
#pragma once

#include <glm/glm.hpp>
#include <string>

#include "scene/document.hpp"

namespace regulus::scene {

/// Texture coordinates as a function of a vertex's sets.
struct UvMapping {
  int set = 0;  ///< TEXCOORD_n
  glm::dvec2 offset{0}, scale{1};
  double rotation = 0;  ///< radians, counter-clockwise as seen on the image, whose v points down

  bool operator==(const UvMapping&) const = default;

  /// offset + rotation (scale uv).
  glm::vec2 apply(const glm::vec2& uv) const;
};

/// The mapping of a material's textures (those that are read). Where they differ, the first one's is used for
/// all, with a warning that names the material.
UvMapping uv_mapping(Document& document, const tinygltf::Material& material, const std::string& name);

}  // namespace regulus::scene
