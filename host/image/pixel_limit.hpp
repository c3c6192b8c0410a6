// The refusal that all decoders share. Internal to host/image.
#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "base/error.hpp"

namespace regulus::image {

/// @throws regulus::Error (BadFile) with both numbers if the picture `name` has more pixels than
/// `max_pixels`.
inline void require_pixels(const std::string& name, uint64_t width, uint64_t height, uint64_t max_pixels) {
  if (width * height > max_pixels)
    throw Error(ErrorCode::BadFile, fmt::format("{}: {} x {} pixels are {}, the limit is {}; scale it down",
                                                name, width, height, width * height, max_pixels));
}

}  // namespace regulus::image
