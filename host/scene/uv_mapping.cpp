#include "scene/uv_mapping.hpp"

#include <fmt/core.h>

#include <cmath>
#include <utility>
#include <vector>

namespace regulus::scene {
namespace {

using tinygltf::Value;

constexpr const char* EXTENSION = "KHR_texture_transform";

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

/// A texture of the core material.
template <typename TextureInfo>
void add(std::vector<UvMapping>& mappings, const TextureInfo& info) {
  if (info.index < 0) return;
  const auto transform = info.extensions.find(EXTENSION);
  mappings.push_back(
      mapping_of(info.texCoord, transform != info.extensions.end() ? &transform->second : nullptr));
}

/// A texture of a material extension.
void add_extended(std::vector<UvMapping>& mappings, const Value& info) {
  if (!info.Has("index")) return;
  const Value* transform = nullptr;
  if (info.Has("extensions") && info.Get("extensions").Has(EXTENSION))
    transform = &info.Get("extensions").Get(EXTENSION);
  mappings.push_back(mapping_of(info.Has("texCoord") ? info.Get("texCoord").GetNumberAsInt() : 0, transform));
}

}  // namespace

glm::vec2 UvMapping::apply(const glm::vec2& uv) const {
  if (*this == UvMapping{set, glm::dvec2(0), glm::dvec2(1), 0}) return uv;
  const glm::dvec2 scaled = scale * glm::dvec2(uv);
  const double c = std::cos(rotation), s = std::sin(rotation);
  return offset + glm::dvec2(c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x);
}

UvMapping uv_mapping(Document& document, const tinygltf::Material& material, const std::string& name) {
  std::vector<UvMapping> mappings;
  add(mappings, material.pbrMetallicRoughness.baseColorTexture);
  if (material.extensions.count("KHR_materials_unlit") != 0)  // shows nothing else
    return mappings.empty() ? UvMapping{} : mappings.front();
  add(mappings, material.pbrMetallicRoughness.metallicRoughnessTexture);
  add(mappings, material.emissiveTexture);
  add(mappings, material.normalTexture);
  for (const auto& [extension, texture] :
       {std::pair<const char*, const char*>{"KHR_materials_transmission", "transmissionTexture"},
        {"KHR_materials_clearcoat", "clearcoatTexture"},
        {"KHR_materials_clearcoat", "clearcoatRoughnessTexture"},
        {"KHR_materials_anisotropy", "anisotropyTexture"}}) {
    const auto found = material.extensions.find(extension);
    if (found != material.extensions.end() && found->second.Has(texture))
      add_extended(mappings, found->second.Get(texture));
  }
  if (mappings.empty()) return {};
  for (const UvMapping& mapping : mappings)
    if (mapping != mappings.front())
      document.warn(
          fmt::format("{}: its textures have different coordinates; those of the first are used", name));
  return mappings.front();
}

}  // namespace regulus::scene
