// Radiance pictures (.hdr, .pic) in. The file is hostile: the work is bounded by its bytes and by the pixels
// that its header declares, which the bytes must be able to hold.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>

#include "base/error.hpp"
#include "image/image.hpp"
#include "image/pixel_limit.hpp"

namespace regulus::image {
namespace {

using Pixel = std::array<unsigned char, 4>;  // red, green, blue, exponent

constexpr uint32_t MAX_SIDE = 1 << 16;
constexpr uint64_t MAX_HEADER_BYTES = 1 << 16;
// Of run-length coding: two bytes for at most 127 equal ones of the four of a pixel.
constexpr uint64_t MAX_PIXELS_PER_BYTE = 127 / 8 + 1;
// Rows of other widths are never run-length coded.
constexpr uint32_t MIN_CODED_WIDTH = 8, MAX_CODED_WIDTH = 32767;

class Decoder {
 public:
  Decoder(std::string_view name, std::span<const unsigned char> bytes) : name_(name), rest_(bytes) {}

  Image decode(uint64_t max_pixels) {
    read_header();
    Image image;
    read_size(image.width, image.height);
    const uint64_t pixels = uint64_t{image.width} * image.height;
    if (pixels > MAX_PIXELS_PER_BYTE * rest_.size())
      refuse(fmt::format("declares {} x {} pixels in {} bytes", image.width, image.height, rest_.size()));
    require_pixels(std::string(name_), image.width, image.height, max_pixels);
    image.rgb.reserve(3 * pixels);
    std::vector<Pixel> row(image.width);
    for (uint32_t y = 0; y < image.height; ++y) {
      read_row(row);
      for (const Pixel& pixel : row) append(pixel, image.rgb);
    }
    return image;
  }

 private:
  [[noreturn]] void refuse(std::string_view problem) const {
    throw Error(
        ErrorCode::BadFile,
        fmt::format("{}: the Radiance file is cut off or corrupt ({}); write it again", name_, problem));
  }

  std::string_view line() {
    const auto end = std::find(rest_.begin(), rest_.begin() + std::min(rest_.size(), MAX_HEADER_BYTES), '\n');
    const auto length = static_cast<size_t>(end - rest_.begin());
    if (length == rest_.size() || *end != '\n') refuse("its header does not end");
    const std::string_view text(reinterpret_cast<const char*>(rest_.data()), length);
    rest_ = rest_.subspan(length + 1);
    return text.ends_with('\r') ? text.substr(0, length - 1) : text;
  }

  /// Everything up to the empty line before the size.
  void read_header() {
    const size_t before = rest_.size();
    for (std::string_view text = line(); !text.empty(); text = line()) {
      if (text.starts_with("FORMAT=") && text != "FORMAT=32-bit_rle_rgbe")
        throw Error(ErrorCode::BadFile,
                    fmt::format("{}: its {} is not read, only 32-bit_rle_rgbe; convert it", name_, text));
      if (before - rest_.size() > MAX_HEADER_BYTES) refuse("its header does not end");
    }
  }

  uint32_t read_side(std::string_view& text, std::string_view axis) {
    if (!text.starts_with(axis)) refuse("its size is not given as -Y height +X width");
    text.remove_prefix(axis.size());
    uint32_t side = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), side);
    if (error != std::errc{} || side < 1 || side > MAX_SIDE)
      refuse(fmt::format("its sides are not from 1 to {}", MAX_SIDE));
    text.remove_prefix(static_cast<size_t>(end - text.data()));
    return side;
  }

  void read_size(uint32_t& width, uint32_t& height) {
    std::string_view text = line();
    height = read_side(text, "-Y ");
    width = read_side(text, " +X ");
  }

  unsigned char byte() {
    if (rest_.empty()) refuse("pixels are missing");
    const unsigned char value = rest_[0];
    rest_ = rest_.subspan(1);
    return value;
  }

  Pixel pixel() {
    if (rest_.size() < 4) refuse("pixels are missing");
    const Pixel value = {rest_[0], rest_[1], rest_[2], rest_[3]};
    rest_ = rest_.subspan(4);
    return value;
  }

  void read_row(std::vector<Pixel>& row) {
    const bool may_be_coded = row.size() >= MIN_CODED_WIDTH && row.size() <= MAX_CODED_WIDTH;
    if (may_be_coded && rest_.size() >= 4 && rest_[0] == 2 && rest_[1] == 2 && rest_[2] < 128) {
      const Pixel start = pixel();
      if (size_t{start[2]} * 256 + start[3] != row.size()) refuse("a row has another length");
      for (size_t channel = 0; channel < 4; ++channel) read_coded_channel(row, channel);
    } else {
      read_plain_row(row);
    }
  }

  /// One of the four bytes of all pixels of a row: runs (128 + length, value) and literals (length, values).
  void read_coded_channel(std::vector<Pixel>& row, size_t channel) {
    for (size_t x = 0; x < row.size();) {
      const unsigned char code = byte();
      const size_t length = code > 128 ? code - 128u : code;
      if (length == 0 || length > row.size() - x) refuse("a run leaves its row");
      const unsigned char first = byte();
      for (size_t i = 0; i < length; ++i) row[x + i][channel] = i == 0 || code > 128 ? first : byte();
      x += length;
    }
  }

  /// Pixels as they are; one of mantissas 1, 1, 1 repeats the last one (the coding before 1991): its exponent
  /// is the count, of which several in a row give the digits to base 256 from the lowest.
  void read_plain_row(std::vector<Pixel>& row) {
    unsigned shift = 0;
    for (size_t x = 0; x < row.size();) {
      const Pixel value = pixel();
      if (value[0] == 1 && value[1] == 1 && value[2] == 1 && x > 0) {
        const size_t length = shift < 32 ? size_t{value[3]} << shift : row.size();
        if (length > row.size() - x) refuse("a run leaves its row");
        std::fill_n(row.begin() + static_cast<std::ptrdiff_t>(x), length, row[x - 1]);
        x += length;
        shift += 8;
      } else {
        row[x++] = value;
        shift = 0;
      }
    }
  }

  static void append(const Pixel& pixel, std::vector<float>& rgb) {
    const float scale = pixel[3] == 0 ? 0.0F : std::ldexp(1.0F, pixel[3] - (128 + 8));
    for (size_t i = 0; i < 3; ++i) rgb.push_back(static_cast<float>(pixel[i]) * scale);
  }

  std::string_view name_;
  std::span<const unsigned char> rest_;
};

}  // namespace

bool is_radiance(std::span<const unsigned char> bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  return text.starts_with("#?RADIANCE") || text.starts_with("#?RGBE");
}

Image decode_radiance(const std::string& name, std::span<const unsigned char> bytes, uint64_t max_pixels) {
  return Decoder(name, bytes).decode(max_pixels);
}

}  // namespace regulus::image
