// KHR_materials_pbrSpecularGlossiness, archived but still found in files, in terms of what replaced it.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>

#include "scene/document.hpp"

namespace regulus::scene {

/// Rewrites the materials of a checked document: diffuse colour as base colour of a dielectric whose
/// reflectance at normal incidence is the specular colour (KHR_materials_specular under the index 0 of
/// KHR_materials_ior, which exists for this conversion) and whose roughness is 1 - glossiness. A glossiness
/// texture becomes the metallic-roughness texture, its alpha to be read as texture_glossiness says. Unlit
/// materials stay as they are.
void convert_specular_glossiness(nlohmann::json& document);

/// The factor of a converted material's glossiness texture: alpha times it is the glossiness. Empty: the
/// metallic-roughness texture, if there is one, holds what its name says.
std::optional<double> texture_glossiness(const tinygltf::Material& material);

}  // namespace regulus::scene
