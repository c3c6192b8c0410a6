// Where a material's textures look their images up: texture coordinate sets and KHR_texture_transform.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "interface/scene.h"
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

/// A texture as a material names it.
struct TextureUse {
  int texture = -1;  ///< index in the file; -1: none
  UvMapping mapping{};
};

/// A texture of the core material.
TextureUse texture_use(const tinygltf::TextureInfo& info);
TextureUse texture_use(const tinygltf::NormalTextureInfo& info);

/// A texture `member` of a material's extension.
TextureUse texture_use(const tinygltf::Material& material, const char* extension, const char* member);

/// What a material's vertices carry. Where all its textures agree, their mapping is applied to the vertices,
/// so that kernels look images up at what they interpolate; else vertices carry the sets as they are, and
/// each texture maps them.
struct MaterialUvs {
  bool has_textures = false;
  UvMapping first;                ///< applied to the vertices' own coordinates
  std::vector<int> further_sets;  ///< TEXCOORD_n of their further coordinates
  UvMapping of_normals;  ///< of the normal texture, or else the clearcoat's, relative to the sets of the file

  /// How a texture finds its coordinates from the vertices': the flags and rows of interface::Texture, the
  /// rest 0.
  interface::Texture placement(const UvMapping& mapping) const;
};

/// Of the textures that are read.
MaterialUvs material_uvs(const tinygltf::Material& material);

}  // namespace regulus::scene
