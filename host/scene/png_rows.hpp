// PNG by libpng, row by row into memory of known size. Internal to image_decoder.cpp.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace regulus::scene {

/// Whether the file can hold what its header declares: no deflate stream expands more than 1032 times.
/// Precondition: the file begins with PNG's signature.
bool png_fits(std::span<const unsigned char> file);

/// Decodes into `words` (see decode_image), of the size that the arguments say. What a file holds beyond that
/// is never inflated. @return false with a reason if it is not such an image, cut off or corrupt.
bool decode_png(std::span<const unsigned char> file, uint32_t width, uint32_t height, bool is_16_bit,
                std::vector<uint32_t>& words, std::string& reason);

}  // namespace regulus::scene
