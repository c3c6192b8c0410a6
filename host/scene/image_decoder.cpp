#include "scene/image_decoder.hpp"

#include <fmt/core.h>
#include <stb_image.h>
#include <webp/decode.h>

#include <cstring>
#include <memory>

#include "scene/png_rows.hpp"

namespace regulus::scene {
namespace {

using File = std::span<const unsigned char>;

constexpr uint32_t MAX_SIDE = 32768;
constexpr uint64_t MAX_PIXELS = uint64_t{1} << 28;
// A block of 8 x 8 pixels of a JPEG takes a bit at least in its first scan.
constexpr uint64_t MAX_JPEG_PIXELS_PER_BYTE = 64 * 8;
// Encoders write ten or so. Every scan visits every block, whatever its length.
constexpr uint64_t MAX_JPEG_SCANS = 100;
// Of WebP there is no such bound (one colour costs no bits): images up to this size are believed, beyond it
// this many pixels to a byte.
constexpr uint64_t MAX_UNCHECKED_PIXELS = uint64_t{1} << 24, MAX_WEBP_PIXELS_PER_BYTE = 8192;

bool starts_with(File file, std::string_view magic, size_t offset = 0) {
  return file.size() >= offset + magic.size() &&
         std::memcmp(file.data() + offset, magic.data(), magic.size()) == 0;
}

std::optional<ImageHeader::Format> format_of(File file) {
  using enum ImageHeader::Format;
  if (starts_with(file, "\x89PNG\r\n\x1A\n")) return Png;
  if (starts_with(file, "\xFF\xD8\xFF")) return Jpeg;
  if (starts_with(file, "RIFF") && starts_with(file, "WEBP", 8)) return WebP;
  return std::nullopt;
}

bool read_size(File file, ImageHeader& header) {
  int width = 0, height = 0, channels = 0;
  const bool is_read = header.format == ImageHeader::Format::WebP
                           ? WebPGetInfo(file.data(), file.size(), &width, &height) != 0
                           : stbi_info_from_memory(file.data(), static_cast<int>(file.size()), &width,
                                                   &height, &channels) != 0;
  header.width = static_cast<uint32_t>(width);
  header.height = static_cast<uint32_t>(height);
  header.is_16_bit = header.format == ImageHeader::Format::Png &&
                     stbi_is_16_bit_from_memory(file.data(), static_cast<int>(file.size())) != 0;
  return is_read && width > 0 && height > 0;
}

/// Of a JPEG; a marker of a thumbnail within it may be counted too.
uint64_t count_scans(File file) {
  uint64_t scans = 0;
  for (size_t i = 0; i + 1 < file.size(); ++i) scans += file[i] == 0xFF && file[i + 1] == 0xDA ? 1 : 0;
  return scans;
}

/// Whether a file of that length can hold that many pixels.
bool is_believable(File file, const ImageHeader& header) {
  switch (header.format) {
    case ImageHeader::Format::Png:
      return png_fits(file);
    case ImageHeader::Format::Jpeg:
      return header.pixels() <= MAX_JPEG_PIXELS_PER_BYTE * file.size();
    default:
      return header.pixels() <= MAX_UNCHECKED_PIXELS ||
             header.pixels() <= MAX_WEBP_PIXELS_PER_BYTE * file.size();
  }
}

/// RGBA codes of 8 bits with the function that frees them; null if the file cannot be decoded.
std::unique_ptr<unsigned char, void (*)(void*)> decode_rgba(File file, const ImageHeader& header) {
  int width = 0, height = 0, channels = 0;
  if (header.format == ImageHeader::Format::WebP)
    return {WebPDecodeRGBA(file.data(), file.size(), &width, &height), &WebPFree};
  return {stbi_load_from_memory(file.data(), static_cast<int>(file.size()), &width, &height, &channels, 4),
          &stbi_image_free};
}

}  // namespace

uint64_t ImageHeader::bytes_to_decode() const {
  switch (format) {
    case Format::Png:
      return bytes();
    case Format::Jpeg:  // planes, coefficients of progressive files, and a copy
      return bytes() + pixels() * (3 + 6 + 4);
    default:
      return bytes() + pixels() * (4 + 4);
  }
}

std::optional<ImageHeader> read_image_header(File file, std::string& reason) {
  const auto format = format_of(file);
  if (!format) {
    reason = "is neither PNG, JPEG nor WebP; convert it";
    return std::nullopt;
  }
  ImageHeader header{*format, 0, 0, false};
  if (file.size() > 0x7FFFFFFFu || !read_size(file, header))
    reason = "has no readable header or is too large; export it again";
  else if (header.width > MAX_SIDE || header.height > MAX_SIDE || header.pixels() > MAX_PIXELS)
    reason = fmt::format("has {} x {} pixels, the limit is {} a side and {} in all; scale it down",
                         header.width, header.height, MAX_SIDE, MAX_PIXELS);
  else if (!is_believable(file, header))
    reason = fmt::format("declares {} x {} pixels in {} bytes, which cannot be; export it again",
                         header.width, header.height, file.size());
  else if (*format == ImageHeader::Format::Jpeg && count_scans(file) > MAX_JPEG_SCANS)
    reason = fmt::format("has more than {} scans; export it again", MAX_JPEG_SCANS);
  else
    return header;
  return std::nullopt;
}

std::optional<std::vector<uint32_t>> decode_image(File file, const ImageHeader& header, std::string& reason) {
  std::vector<uint32_t> words(header.bytes() / sizeof(uint32_t));
  if (header.format == ImageHeader::Format::Png) {
    if (!decode_png(file, header.width, header.height, header.is_16_bit, words, reason)) return std::nullopt;
    return words;
  }
  const auto codes = decode_rgba(file, header);
  if (!codes) {
    reason = header.format == ImageHeader::Format::Jpeg ? stbi_failure_reason() : "no valid WebP";
    return std::nullopt;
  }
  std::memcpy(words.data(), codes.get(), header.bytes());
  return words;
}

}  // namespace regulus::scene
