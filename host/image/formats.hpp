// The formats a picture can be written in, by the name of its file.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "image/encoding.hpp"
#include "image/image.hpp"

namespace regulus::image {

enum class Format { Exr, Png, Jpeg, Hdr };

/// The format that a file's extension stands for (.exr, .png, .jpg or .jpeg, .hdr, in any case); none for
/// any other.
std::optional<Format> format_of(const std::filesystem::path& path);

/// The format that a picture at `path` is to have: by its extension; where there is none to choose, because
/// `path` is a device or pipe, the first of `allowed`.
/// @param option what the error calls it
/// @throws regulus::Error (BadUsage) that lists `allowed` if it is none of them
Format require_format(const std::string& option, const std::filesystem::path& path,
                      const std::vector<Format>& allowed);

/// The bytes of a picture in a format. Channels, attributes and placement are OpenEXR's alone; PNG and JPEG
/// are exposed and seen as `encoding` says, whose storage is OpenEXR's alone; HDR has 8 bits of mantissa and
/// no negative values.
/// @throws regulus::Error (Failed) naming `name`
std::string encode_picture(Format format, const Image& image, const Encoding& encoding,
                           const Attributes& attributes, const Channels& channels, const Placement& placement,
                           std::string_view name);

/// 8-bit PNG or JPEG of the image, exposed and seen as `encoding` says.
/// @throws regulus::Error (Failed) naming `name`
std::string encode_tone_mapped(Format format, const Image& image, const Encoding& encoding,
                               std::string_view name);

/// PNG or JPEG of encoded 8-bit RGB triples, rows from the top. @throws regulus::Error (Failed) naming `name`
std::string encode_rgb8(Format format, uint32_t width, uint32_t height, const std::vector<uint8_t>& rgb,
                        std::string_view name);

/// Radiance HDR (RGBE). NaN and negative values become 0, values beyond 1.69e38 that.
/// @throws regulus::Error (Failed) naming `name`
std::string encode_hdr(const Image& image, std::string_view name);

/// What write_heat_map and write_flip_picture write, as PNG or JPEG by the name of the file.
/// @throws regulus::Error (BadFile, Failed)
std::string encode_heat_map(Format format, const Image& image, const Image& reference, std::string_view name);
std::string encode_flip_map(Format format, const Image& image, const Image& reference, std::string_view name);

}  // namespace regulus::image
