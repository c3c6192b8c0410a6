// Compressed geometry: EXT_meshopt_compression and KHR_draco_mesh_compression, decoded by their libraries.
#pragma once

#include <array>
#include <nlohmann/json.hpp>

#include "scene/document.hpp"

namespace regulus::scene {

/// The second is the first with a newer coding of attributes and a filter for colours.
inline constexpr std::array<const char*, 2> MESHOPT_EXTENSIONS = {"EXT_meshopt_compression",
                                                                  "KHR_meshopt_compression"};

/// Decodes every buffer view with one of MESHOPT_EXTENSIONS; Document::view then returns what was decoded.
/// Needs the buffers. @param reduced the JSON after check_and_reduce.
/// What cannot be decoded is a broken buffer view.
void decode_meshopt_views(Document& document, const nlohmann::json& reduced);

/// Decodes every primitive with KHR_draco_mesh_compression into Document::decoded_accessors. Needs the model.
/// The primitives become triangle lists, their accessors have as many elements as were decoded.
/// @throws Error naming the primitive.
void decode_draco_primitives(Document& document, const nlohmann::json& reduced);

}  // namespace regulus::scene
