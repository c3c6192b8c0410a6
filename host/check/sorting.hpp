// What an iteration's light vertices are sorted into, integers all: judged by what they have to satisfy,
// whatever the hash.
#pragma once

#include <vector>

#include "check/check.hpp"

namespace regulus::check {

/// Of each light vertex its light path; INVALID_INDEX if none of the lists holds it.
std::vector<uint32_t> light_paths_of(const render::ConnectionRecording& recording);

}  // namespace regulus::check
