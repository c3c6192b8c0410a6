// PNG and JPEG out, by exposure, tone mapping and the sRGB curve, and Radiance HDR; encoded by
// stb_image_write.
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#include <fmt/format.h>
#include <stb_image_write.h>

#include <algorithm>
#include <cmath>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "image/color_config.hpp"
#include "image/formats.hpp"
#include "image/image.hpp"

namespace regulus::image {
namespace {

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data), static_cast<size_t>(size));
}

uint8_t to_byte(const float encoded) {
  return static_cast<uint8_t>(std::lround(255.0f * std::clamp(encoded, 0.0f, 1.0f)));
}

}  // namespace

std::array<float, 3> tone_map(const std::array<float, 3>& linear) {
  constexpr float START = 0.8f;            // up to here colours pass unchanged
  constexpr float DESATURATION = 0.15f;    // how fast highlights turn white
  constexpr float BRIGHTEST_INPUT = 1e6f;  // keeps infinity out of the ratios below
  std::array<float, 3> color = linear;
  for (float& value : color) value = value > 0 ? std::min(value, BRIGHTEST_INPUT) : 0;  // NaN becomes 0

  const float peak = *std::max_element(color.begin(), color.end());
  if (peak < START) return color;
  constexpr float RANGE = 1.0f - START;
  const float new_peak = 1.0f - RANGE * RANGE / (peak + RANGE - START);
  const float keep = 1.0f / (DESATURATION * (peak - new_peak) + 1.0f);
  for (float& value : color) value = new_peak + keep * (value * new_peak / peak - new_peak);
  return color;
}

float srgb_encode(const float linear) {
  return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

std::string encode_rgb8(const Format format, const uint32_t width, const uint32_t height,
                        const std::vector<uint8_t>& rgb, const std::string_view name) {
  constexpr int JPEG_QUALITY = 95;
  const auto fail = [&] {
    throw Error(ErrorCode::Failed, fmt::format("{}: {} x {} pixels cannot be encoded as {}", name, width,
                                               height, format == Format::Jpeg ? "JPEG" : "PNG"));
  };
  const int w = static_cast<int>(width), h = static_cast<int>(height);
  if (w <= 0 || h <= 0 || rgb.size() != size_t{3} * width * height) fail();
  std::string bytes;
  const int is_encoded = format == Format::Jpeg
                             ? stbi_write_jpg_to_func(append, &bytes, w, h, 3, rgb.data(), JPEG_QUALITY)
                             : stbi_write_png_to_func(append, &bytes, w, h, 3, rgb.data(), 0);
  if (is_encoded == 0) fail();
  return bytes;
}

std::string encode_tone_mapped(const Format format, const Image& image, const Encoding& encoding,
                               const std::string_view name) {
  const float scale = std::exp2(encoding.exposure_ev);
  std::vector<uint8_t> bytes(image.rgb.size());
  for (size_t i = 0; i + 2 < image.rgb.size(); i += 3) {
    const std::array<float, 3> linear = {scale * image.rgb[i], scale * image.rgb[i + 1],
                                         scale * image.rgb[i + 2]};
    const auto color = encoding.transform ? (*encoding.transform)(linear) : display(encoding.view, linear);
    for (size_t c = 0; c < 3; ++c) bytes[i + c] = to_byte(color[c]);
  }
  return encode_rgb8(format, image.width, image.height, bytes, name);
}

std::string encode_hdr(const Image& image, const std::string_view name) {
  constexpr float LARGEST = 1.69e38f;  // just below 2^127, beyond which the common exponent has no byte
  std::vector<float> rgb = image.rgb;
  for (size_t i = 0; i + 2 < rgb.size(); i += 3) {
    float peak = 0;
    for (size_t c = 0; c < 3; ++c) {
      rgb[i + c] = rgb[i + c] > 0 ? std::min(rgb[i + c], LARGEST) : 0;  // NaN becomes 0
      peak = std::max(peak, rgb[i + c]);
    }
    // stb cuts mantissas of 8 bits off: half a unit of the last place makes that rounding.
    int exponent = 0;
    if (std::frexp(peak, &exponent) > 0)
      for (size_t c = 0; c < 3; ++c)
        rgb[i + c] = std::min(rgb[i + c] + std::ldexp(1.0f, exponent - 9), LARGEST);
  }
  std::string bytes;
  if (rgb.empty() || !stbi_write_hdr_to_func(append, &bytes, static_cast<int>(image.width),
                                             static_cast<int>(image.height), 3, rgb.data()))
    throw Error(ErrorCode::Failed, fmt::format("{}: {} x {} pixels cannot be encoded as Radiance HDR", name,
                                               image.width, image.height));
  return bytes;
}

void write_png(const std::filesystem::path& path, const Image& image, const float exposure_ev) {
  write_file_atomically(path, encode_tone_mapped(Format::Png, image, exposure_ev, path.string()));
}

}  // namespace regulus::image
