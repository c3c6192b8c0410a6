// What a film takes of the host's memory, counted before it is made.
#pragma once

#include <cstdint>

#include "render/settings.hpp"

namespace regulus::session {

/// Refuses a film that cannot be held and written within the memory that is allowed. The scene is counted
/// apart (scene::LoadOptions::memory_bytes).
/// @param holds_sums the file written is a part or a checkpoint
/// @param is_in_bands only the picture is held as a whole
/// @param memory_bytes allowed; 0: the default
/// @throws regulus::Error (Failed) with both numbers
void require_film_memory(const render::RenderSettings& settings, bool holds_sums, bool is_in_bands,
                         uint64_t memory_bytes);

}  // namespace regulus::session
