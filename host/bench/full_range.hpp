// Pictures for pages that show them with any exposure (page/picture.js).
#pragma once

#include <string>
#include <string_view>

#include "image/image.hpp"

namespace regulus::bench {

/// Four bytes a pixel, as in Radiance's RGBE: mantissas of red, green and blue, cut off to 8 bits, and their
/// common exponent plus 128. Negative values and NaN become 0.
std::string full_range(const image::Image& image);

/// The same as a PNG of twice the height: mantissas above, the exponent below.
/// @throws regulus::Error (Failed) naming `name`
std::string encode_full_range(const image::Image& image, std::string_view name);

}  // namespace regulus::bench
