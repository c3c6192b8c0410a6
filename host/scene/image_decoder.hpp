// The images of textures: PNG, JPEG and WebP as RGBA codes. Files are hostile: what a header declares is held
// against the file's length and a limit before memory is taken, and the work is bounded by both.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace regulus::scene {

/// What an image's header says.
struct ImageHeader {
  enum class Format { Png, Jpeg, WebP } format;
  uint32_t width, height;
  bool is_16_bit;  ///< of each channel; otherwise 8

  uint64_t pixels() const { return uint64_t{width} * height; }
  /// Of what decode_image returns.
  uint64_t bytes() const { return pixels() * (is_16_bit ? 8 : 4); }
  /// The most that decoding takes at once, its result included.
  uint64_t bytes_to_decode() const;
};

/// Reads the header of a file. @return nothing with a reason, in the form "is ...; what to do", if there is
/// no usable one: another format, sides beyond limits, more pixels than a file of that length can hold.
std::optional<ImageHeader> read_image_header(std::span<const unsigned char> file, std::string& reason);

/// The codes of an image, rows from the top, one RGBA pixel in one word of 8-bit codes (red lowest) or two of
/// 16-bit ones (red, green; blue, alpha; lower half first). @return nothing with a reason if the file is cut
/// off or corrupt.
std::optional<std::vector<uint32_t>> decode_image(std::span<const unsigned char> file,
                                                  const ImageHeader& header, std::string& reason);

}  // namespace regulus::scene
