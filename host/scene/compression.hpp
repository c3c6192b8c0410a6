// Compressed geometry: EXT_meshopt_compression and KHR_draco_mesh_compression, decoded by their libraries.
#pragma once

#include <nlohmann/json.hpp>

#include "scene/document.hpp"

namespace regulus::scene {

/// Decodes every buffer view with EXT_meshopt_compression; Document::view then returns what was decoded.
/// Needs the buffers. @param reduced the JSON after check_and_reduce.
/// @throws Error naming the buffer view.
void decode_meshopt_views(Document& document, const nlohmann::json& reduced);

/// Gives the index accessors of Draco primitives, which need no buffer view, that of the compressed data:
/// tinygltf refuses indices without one. It is never read.
void complete_draco_accessors(nlohmann::json& reduced);

/// Decodes every primitive with KHR_draco_mesh_compression into Document::decoded_accessors. Needs the model.
/// The primitives become triangle lists, their accessors have as many elements as were decoded.
/// @throws Error naming the primitive.
void decode_draco_primitives(Document& document, const nlohmann::json& reduced);

}  // namespace regulus::scene
