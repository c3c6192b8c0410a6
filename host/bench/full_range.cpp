#include "bench/full_range.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "image/formats.hpp"

namespace regulus::bench {

std::string full_range(const image::Image& image) {
  constexpr float LARGEST = 1e38f;  // just below 2^127, beyond which the exponent has no byte
  std::string bytes(image.rgb.size() / 3 * 4, '\0');
  for (size_t i = 0; 3 * i + 2 < image.rgb.size(); ++i) {
    std::array<float, 3> color{};
    for (size_t c = 0; c < 3; ++c) {
      const float value = image.rgb[3 * i + c];
      color[c] = value > 0 ? std::min(value, LARGEST) : 0;  // NaN becomes 0
    }
    int exponent = 0;
    if (std::frexp(*std::ranges::max_element(color), &exponent) <= 0 || exponent <= -128) continue;
    for (size_t c = 0; c < 3; ++c)
      bytes[4 * i + c] = static_cast<char>(static_cast<uint8_t>(std::ldexp(color[c], 8 - exponent)));
    bytes[4 * i + 3] = static_cast<char>(static_cast<uint8_t>(exponent + 128));
  }
  return bytes;
}

std::string encode_full_range(const image::Image& image, std::string_view name) {
  const size_t pixels = size_t{image.width} * image.height;
  const std::string bytes = full_range(image);
  std::vector<uint8_t> rgb(2 * 3 * pixels);
  for (size_t i = 0; i < pixels; ++i)
    for (size_t c = 0; c < 3; ++c) {
      rgb[3 * i + c] = static_cast<uint8_t>(bytes[4 * i + c]);
      rgb[3 * (pixels + i) + c] = static_cast<uint8_t>(bytes[4 * i + 3]);
    }
  return encode_rgb8(image::Format::Png, image.width, 2 * image.height, rgb, name);
}

}  // namespace regulus::bench
