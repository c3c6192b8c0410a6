#include "scene/variants.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace regulus::scene {
namespace {

using tinygltf::Value;

constexpr const char* VARIANTS = "KHR_materials_variants";

/// Member `name` of an extension as an array; null if it has none.
const Value* array_of(const tinygltf::ExtensionMap& extensions, const char* name) {
  const auto found = extensions.find(VARIANTS);
  return found != extensions.end() && found->second.Has(name) ? &found->second.Get(name) : nullptr;
}

bool holds(const Value& mapping, int variant) {
  const Value& variants = mapping.Get("variants");
  for (int i = 0; i < static_cast<int>(variants.ArrayLen()); ++i)
    if (variants.Get(i).GetNumberAsInt() == variant) return true;
  return false;
}

void apply(tinygltf::Primitive& primitive, int variant) {
  const Value* mappings = array_of(primitive.extensions, "mappings");
  for (int i = 0; mappings != nullptr && i < static_cast<int>(mappings->ArrayLen()); ++i) {
    const Value& mapping = mappings->Get(i);
    if (!mapping.Has("material") || !holds(mapping, variant)) continue;
    primitive.material = mapping.Get("material").GetNumberAsInt();
    return;
  }
}

}  // namespace

std::vector<std::string> variant_names(const Document& document) {
  std::vector<std::string> names;
  const Value* variants = array_of(document.model.extensions, "variants");
  for (int i = 0; variants != nullptr && i < static_cast<int>(variants->ArrayLen()); ++i) {
    const Value& variant = variants->Get(i);
    names.push_back(variant.Has("name") ? variant.Get("name").Get<std::string>() : "");
  }
  return names;
}

void choose_variant(Document& document, const std::string& name) {
  const std::vector<std::string> names = variant_names(document);
  const auto found = std::ranges::find(names, name);
  if (found == names.end())
    document.fail(fmt::format(
        "has no material variant \"{}\", {}", name,
        names.empty() ? "nor any other; ask for none" : "choose one of " + nlohmann::json(names).dump()));
  for (tinygltf::Mesh& mesh : document.model.meshes)
    for (tinygltf::Primitive& primitive : mesh.primitives)
      apply(primitive, static_cast<int>(found - names.begin()));
}

}  // namespace regulus::scene
