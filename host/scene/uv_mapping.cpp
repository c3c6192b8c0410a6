#include "scene/uv_mapping.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace regulus::scene {
namespace {

using tinygltf::Value;

constexpr const char* TEXTURE_TRANSFORM = "KHR_texture_transform";

glm::dvec2 vec2_of(const Value& transform, const char* member, double otherwise) {
  if (!transform.Has(member)) return glm::dvec2(otherwise);
  const Value& value = transform.Get(member);
  return {value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble()};
}

UvMapping mapping_of(int set, const Value* transform) {
  UvMapping mapping;
  mapping.set = set;
  if (transform == nullptr) return mapping;
  mapping.offset = vec2_of(*transform, "offset", 0);
  mapping.scale = vec2_of(*transform, "scale", 1);
  if (transform->Has("rotation")) mapping.rotation = transform->Get("rotation").GetNumberAsDouble();
  if (transform->Has("texCoord")) mapping.set = transform->Get("texCoord").GetNumberAsInt();
  return mapping;
}

template <typename TextureInfo>
TextureUse use_of(const TextureInfo& info) {
  if (info.index < 0) return {};
  const auto transform = info.extensions.find(TEXTURE_TRANSFORM);
  return {info.index,
          mapping_of(info.texCoord, transform != info.extensions.end() ? &transform->second : nullptr)};
}

bool is_plain(const UvMapping& mapping) {
  return mapping == UvMapping{mapping.set};
}

/// The mappings of all textures that are read.
std::vector<UvMapping> mappings_of(const tinygltf::Material& material) {
  std::vector<TextureUse> uses = {texture_use(material.pbrMetallicRoughness.baseColorTexture)};
  // An unlit material shows nothing else.
  if (material.extensions.count("KHR_materials_unlit") == 0) {
    uses.push_back(texture_use(material.pbrMetallicRoughness.metallicRoughnessTexture));
    uses.push_back(texture_use(material.emissiveTexture));
    uses.push_back(texture_use(material.normalTexture));
    for (const auto& [extension, texture] :
         {std::pair<const char*, const char*>{"KHR_materials_transmission", "transmissionTexture"},
          {"KHR_materials_specular", "specularTexture"},
          {"KHR_materials_specular", "specularColorTexture"},
          {"KHR_materials_clearcoat", "clearcoatTexture"},
          {"KHR_materials_clearcoat", "clearcoatRoughnessTexture"},
          {"KHR_materials_clearcoat", "clearcoatNormalTexture"},
          {"KHR_materials_anisotropy", "anisotropyTexture"},
          {"KHR_materials_sheen", "sheenColorTexture"},
          {"KHR_materials_sheen", "sheenRoughnessTexture"},
          {"KHR_materials_iridescence", "iridescenceTexture"},
          {"KHR_materials_iridescence", "iridescenceThicknessTexture"}})
      uses.push_back(texture_use(material, extension, texture));
  }
  std::vector<UvMapping> mappings;
  for (const TextureUse& use : uses)
    if (use.texture >= 0) mappings.push_back(use.mapping);
  return mappings;
}

}  // namespace

glm::vec2 UvMapping::apply(const glm::vec2& uv) const {
  if (is_plain(*this)) return uv;
  const glm::dvec2 scaled = scale * glm::dvec2(uv);
  const double c = std::cos(rotation), s = std::sin(rotation);
  return offset + glm::dvec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
}

TextureUse texture_use(const tinygltf::TextureInfo& info) {
  return use_of(info);
}

TextureUse texture_use(const tinygltf::NormalTextureInfo& info) {
  return use_of(info);
}

TextureUse texture_use(const tinygltf::Material& material, const char* extension, const char* member) {
  const auto found = material.extensions.find(extension);
  if (found == material.extensions.end() || !found->second.Has(member)) return {};
  const Value& info = found->second.Get(member);
  if (!info.Has("index")) return {};
  const Value* transform = nullptr;
  if (info.Has("extensions") && info.Get("extensions").Has(TEXTURE_TRANSFORM))
    transform = &info.Get("extensions").Get(TEXTURE_TRANSFORM);
  return {info.Get("index").GetNumberAsInt(),
          mapping_of(info.Has("texCoord") ? info.Get("texCoord").GetNumberAsInt() : 0, transform)};
}

interface::Texture MaterialUvs::placement(const UvMapping& mapping) const {
  interface::Texture placed {};
  placed.map_u = {1, 0, 0};
  placed.map_v = {0, 1, 0};
  if (mapping == first) return placed;
  const auto further = std::ranges::find(further_sets, mapping.set);
  if (further != further_sets.end())
    placed.flags = static_cast<uint32_t>(further - further_sets.begin() + 1) << interface::TEXTURE_SET_SHIFT;
  if (is_plain(mapping)) return placed;
  placed.flags |= interface::TEXTURE_MAPPED;
  const double c = std::cos(mapping.rotation), s = std::sin(mapping.rotation);
  placed.map_u = {c * mapping.scale.x, s * mapping.scale.y, mapping.offset.x};
  placed.map_v = {-s * mapping.scale.x, c * mapping.scale.y, mapping.offset.y};
  return placed;
}

MaterialUvs material_uvs(const tinygltf::Material& material) {
  const std::vector<UvMapping> mappings = mappings_of(material);
  MaterialUvs uvs;
  const TextureUse of_base = texture_use(material.normalTexture);
  uvs.of_normals = of_base.texture >= 0
                       ? of_base.mapping
                       : texture_use(material, "KHR_materials_clearcoat", "clearcoatNormalTexture").mapping;
  if (mappings.empty()) return uvs;
  uvs.has_textures = true;
  uvs.first = mappings.front();
  if (std::ranges::all_of(mappings, [&](const UvMapping& mapping) { return mapping == uvs.first; }))
    return uvs;
  uvs.first = UvMapping{mappings.front().set};
  for (const UvMapping& mapping : mappings)
    if (mapping.set != uvs.first.set &&
        std::ranges::find(uvs.further_sets, mapping.set) == uvs.further_sets.end())
      uvs.further_sets.push_back(mapping.set);
  return uvs;
}

}  // namespace regulus::scene
