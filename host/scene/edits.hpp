// Edits of a scene from outside: values given to members of its document before anything reads them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace regulus::scene {

/// Applies edits like "materials.Glass.roughness=0.1": an array (materials, cameras, nodes, lights), an
/// element by name or index, a property, and numbers with commas, true or false. Properties have short names
/// (roughness), or those that the file has (pbrMetallicRoughness.roughnessFactor). What they need of the
/// document is made. Of two edits of one property the later counts.
/// @param document the JSON of a glTF file, of which nothing is checked yet
/// @returns what was done, one "materials/0/pbrMetallicRoughness/roughnessFactor=0.1" for each property,
/// sorted
/// @throws regulus::SettingError ("define") for what there is not, with near names, and for values of another
/// shape
std::vector<std::string> apply_edits(nlohmann::json& document, const std::vector<std::string>& edits);

}  // namespace regulus::scene
