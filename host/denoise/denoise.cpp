#include "denoise/denoise.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace regulus::denoise {

namespace {

constexpr float MOST_ALBEDO = 1;

/// Three channels interleaved; empty if one is missing, or not of floats.
std::vector<float> interleave(const image::Channels& channels, const std::string& name,
                              const char* components, size_t pixels) {
  std::vector<float> values(3 * pixels);
  for (size_t c = 0; c < 3; ++c) {
    const auto channel = channels.find(name + "." + components[c]);
    const auto* plane =
        channel == channels.end() ? nullptr : std::get_if<std::vector<float>>(&channel->second);
    if (plane == nullptr || plane->size() != pixels) return {};
    for (size_t i = 0; i < pixels; ++i) values[3 * i + c] = std::isfinite((*plane)[i]) ? (*plane)[i] : 0.0F;
  }
  return values;
}

}  // namespace

Input make_input(const image::Image& image, const image::Channels& channels) {
  const size_t pixels = size_t{image.width} * image.height;
  Input input{.width = image.width,
              .height = image.height,
              .color = image.rgb,
              .albedo = interleave(channels, "albedo", "RGB", pixels),
              .normal = interleave(channels, "N", "XYZ", pixels),
              .variance = interleave(channels, "variance", "RGB", pixels),
              .kept = interleave(channels, "emission", "RGB", pixels)};
  for (size_t i = 0; i < input.kept.size(); ++i) input.color[i] -= input.kept[i];
  for (float& value : input.color) value = std::isfinite(value) ? std::max(value, 0.0F) : 0.0F;
  for (float& value : input.albedo) value = std::clamp(value, 0.0F, MOST_ALBEDO);
  for (float& value : input.normal) value = std::clamp(value, -1.0F, 1.0F);
  for (float& value : input.variance) value = std::max(value, 0.0F);
  return input;
}

Method best_available(const std::string& library) {
  try {
    require_open_image_denoise(library);
    return Method::OpenImageDenoise;
  } catch (const Error&) {
    return Method::CrossFilter;
  }
}

std::vector<float> denoised(const Input& input, Method method, const std::string& library) {
  std::vector<float> colors =
      method == Method::CrossFilter ? by_cross_filter(input) : by_open_image_denoise(input, library);
  for (size_t i = 0; i < input.kept.size(); ++i) colors[i] += input.kept[i];
  return colors;
}

void put_denoised(std::vector<float> colors, const std::string& by, image::Image& image,
                  image::Channels& channels, image::Attributes& attributes) {
  const size_t pixels = size_t{image.width} * image.height;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float> plane(pixels);
    for (size_t i = 0; i < pixels; ++i) plane[i] = image.rgb[3 * i + c];
    channels[std::string("noisy.") + "RGB"[c]] = std::move(plane);
  }
  image.rgb = std::move(colors);
  attributes["regulus:denoised"] = by;
}

}  // namespace regulus::denoise
