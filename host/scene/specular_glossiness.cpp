#include "scene/specular_glossiness.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

constexpr const char* SPECULAR_GLOSSINESS = "KHR_materials_pbrSpecularGlossiness";
constexpr const char* TEXTURE = "specularGlossinessTexture";

void convert(json& material) {
  const json source = material["extensions"][SPECULAR_GLOSSINESS];
  const bool has_texture = source.contains(TEXTURE);
  json base = {{"baseColorFactor", source.value("diffuseFactor", json::array({1, 1, 1, 1}))},
               {"metallicFactor", 0},
               {"roughnessFactor", has_texture ? 1 : 1 - source.value("glossinessFactor", 1.0)}};
  json specular = {{"specularColorFactor", source.value("specularFactor", json::array({1, 1, 1}))}};
  if (source.contains("diffuseTexture")) base["baseColorTexture"] = source["diffuseTexture"];
  if (has_texture) base["metallicRoughnessTexture"] = specular["specularColorTexture"] = source[TEXTURE];
  material["pbrMetallicRoughness"] = base;
  material["extensions"]["KHR_materials_specular"] = specular;
  material["extensions"]["KHR_materials_ior"] = {{"ior", 0}};
}

}  // namespace

void convert_specular_glossiness(json& document) {
  const auto materials = document.find("materials");
  if (materials == document.end()) return;
  for (json& material : *materials) {
    const auto extensions = material.find("extensions");
    if (extensions != material.end() && extensions->contains(SPECULAR_GLOSSINESS) &&
        !extensions->contains("KHR_materials_unlit"))
      convert(material);
  }
}

std::optional<double> texture_glossiness(const tinygltf::Material& material) {
  const auto found = material.extensions.find(SPECULAR_GLOSSINESS);
  if (found == material.extensions.end() || !found->second.Has(TEXTURE)) return std::nullopt;
  return found->second.Has("glossinessFactor") ? found->second.Get("glossinessFactor").GetNumberAsDouble()
                                               : 1;
}

}  // namespace regulus::scene
