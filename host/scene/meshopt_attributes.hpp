// The newer coding of attributes and the filter of colours that KHR_meshopt_compression adds to
// EXT_meshopt_compression: meshoptimizer 0.18, which Debian has, knows neither.
#pragma once

#include <cstddef>
#include <span>

namespace regulus::scene {

/// First byte of a stream of attributes in version 1.
inline constexpr unsigned char MESHOPT_ATTRIBUTES_1 = 0xa1;

/// Decodes elements of `stride` bytes (a multiple of 4, 4 to 256) from a stream in version 1
/// (KHR_meshopt_compression, appendix A, mode 0).
/// @param elements whole elements to be filled
/// @returns false if the stream is not valid.
bool decode_meshopt_attributes(std::span<unsigned char> elements, size_t stride,
                               std::span<const unsigned char> stream);

/// Decodes colours in place: luma and chroma of four components of 1 or 2 bytes each (stride 4 or 8) to RGBA
/// (appendix B, filter 4).
void decode_meshopt_colors(std::span<unsigned char> elements, size_t stride);

}  // namespace regulus::scene
