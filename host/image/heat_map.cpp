// The error of each pixel as a colour.
#include <algorithm>
#include <cmath>

#include "base/atomic_file.hpp"
#include "image/flip_picture.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"

namespace regulus::image {
namespace {

using Rgb8 = std::array<uint8_t, 3>;

/// Black through purple and orange to pale yellow: lightness rises evenly, so that it also reads in grey.
constexpr std::array<Rgb8, 6> SCALE{
    {{0, 0, 0}, {66, 10, 104}, {147, 38, 103}, {221, 81, 58}, {252, 165, 10}, {252, 255, 164}}};
constexpr Rgb8 NON_FINITE{0, 255, 255};  // not on the scale

Rgb8 scale_color(const double position) {
  const double x = std::clamp(position, 0.0, 1.0) * (SCALE.size() - 1);
  const size_t low = std::min(static_cast<size_t>(x), SCALE.size() - 2);
  const double t = x - static_cast<double>(low);
  Rgb8 color;
  for (size_t c = 0; c < 3; ++c)
    color[c] = static_cast<uint8_t>(std::lround((1 - t) * SCALE[low][c] + t * SCALE[low + 1][c]));
  return color;
}

Format format_of_map(const std::filesystem::path& path) {
  return format_of(path).value_or(Format::Png);
}

}  // namespace

double relative_error(const float* const pixel, const float* const reference) {
  double squared_error = 0, mean = 0;
  for (size_t c = 0; c < 3; ++c) {
    const double difference = double{pixel[c]} - reference[c];
    squared_error += difference * difference / 3;
    mean += double{reference[c]} / 3;
  }
  return std::sqrt(squared_error / (mean * mean + RELATIVE_EPSILON));
}

std::string encode_heat_map(const Format format, const Image& image, const Image& reference,
                            const std::string_view name) {
  require_same_size(image, reference);
  std::vector<uint8_t> bytes(image.rgb.size());
  for (size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const double error = relative_error(&image.rgb[i], &reference.rgb[i]);
    const Rgb8 color = std::isfinite(error) ? scale_color(1 + std::log10(error) / 3) : NON_FINITE;
    std::copy(color.begin(), color.end(), bytes.begin() + static_cast<std::ptrdiff_t>(i));
  }
  return encode_rgb8(format, image.width, image.height, bytes, name);
}

std::string encode_flip_map(const Format format, const Image& image, const Image& reference,
                            const std::string_view name) {
  std::vector<uint8_t> bytes;
  bytes.reserve(image.rgb.size());
  for (const float error : flip_map(image, reference)) {
    const Rgb8 color = scale_color(error);
    bytes.insert(bytes.end(), color.begin(), color.end());
  }
  return encode_rgb8(format, image.width, image.height, bytes, name);
}

void write_heat_map(const std::filesystem::path& path, const Image& image, const Image& reference) {
  write_file_atomically(path, encode_heat_map(format_of_map(path), image, reference, path.string()));
}

void write_flip_picture(const std::filesystem::path& path, const Image& image, const Image& reference) {
  write_file_atomically(path, encode_flip_map(format_of_map(path), image, reference, path.string()));
}

}  // namespace regulus::image
