// How large a film may be, whoever asks for it: the command line, the scene file or a camera's shape.
#pragma once

#include <cstdint>

#include "interface/wavefront.h"

namespace regulus::scene {

/// Pixels on a side. Paths hold the number of their pixel in PATH_NUMBER.
inline constexpr uint32_t MAX_FILM_SIDE = 32768;
static_assert(uint64_t{MAX_FILM_SIDE} * MAX_FILM_SIDE <= uint64_t{interface::PATH_NUMBER} + 1);

}  // namespace regulus::scene
