// KHR_materials_variants: a file's sets of materials, of which one can be chosen by name.
#pragma once

#include <string>
#include <vector>

#include "scene/document.hpp"

namespace regulus::scene {

/// The names of the file's variants, in its order.
std::vector<std::string> variant_names(const Document& document);

/// Gives primitives the materials that they have in a variant; those without one in it keep their own.
/// @throws Error that lists the variants if there is none of the name.
void choose_variant(Document& document, const std::string& name);

}  // namespace regulus::scene
