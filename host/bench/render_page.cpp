#include "bench/render_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "bench/full_range.hpp"
#include "bench/page_text.hpp"
#include "image/formats.hpp"
#include "pages.hpp"

namespace regulus::bench {
namespace {

using image::Image;

// A page of a picture with more pixels than that would be slow to look at.
constexpr uint64_t MOST_PIXELS = 1u << 20, MOST_AOV_PIXELS = 1u << 18;

/// Every how many pixels one is shown.
uint32_t reduction_for(uint64_t width, uint64_t height, uint64_t most) {
  uint32_t reduction = 1;
  while (width / reduction * (height / reduction) > most) ++reduction;
  return reduction;
}

/// Means of squares of pixels; what does not fill one at the right and the bottom is left out.
Image reduced(const Image& image, uint32_t reduction) {
  if (reduction == 1) return image;
  Image small;
  small.width = std::max(image.width / reduction, 1u);
  small.height = std::max(image.height / reduction, 1u);
  small.rgb.resize(size_t{3} * small.width * small.height);
  const uint32_t columns = std::min(reduction, image.width), rows = std::min(reduction, image.height);
  for (size_t y = 0; y < small.height; ++y)
    for (size_t x = 0; x < small.width; ++x)
      for (size_t c = 0; c < 3; ++c) {
        double sum = 0;
        for (size_t v = 0; v < rows; ++v)
          for (size_t u = 0; u < columns; ++u)
            sum += double{image.rgb[3 * ((y * reduction + v) * image.width + x * reduction + u) + c]};
        small.rgb[3 * (y * small.width + x) + c] = static_cast<float>(sum / (rows * columns));
      }
  return small;
}

/// The channels of one AOV, "albedo" or "Z", as numbers.
struct Layer {
  std::vector<std::string> names;
  std::vector<std::vector<float>> values;
  bool is_integer = false;
};

std::map<std::string, Layer> layers_of(const image::Channels& channels) {
  std::map<std::string, Layer> layers;
  for (const auto& [name, channel] : channels) {
    if (name.starts_with("Crypto")) continue;  // ids are nothing to look at
    const size_t dot = name.rfind('.');
    const std::string last = dot == std::string::npos ? "" : name.substr(dot + 1);
    const bool is_part = last.size() == 1 && std::string("RGBXYZ").find(last) != std::string::npos;
    Layer& layer = layers[is_part ? name.substr(0, dot) : name];
    layer.names.push_back(last);
    if (const auto* whole = std::get_if<std::vector<uint32_t>>(&channel)) {
      layer.is_integer = true;
      layer.values.emplace_back(whole->begin(), whole->end());
    } else {
      layer.values.push_back(std::get<std::vector<float>>(channel));
    }
  }
  return layers;
}

struct Range {
  float low = 0, high = 0;
};

Range range_of(const std::vector<float>& values) {
  Range range{std::numeric_limits<float>::infinity(), -std::numeric_limits<float>::infinity()};
  for (const float value : values)
    if (std::isfinite(value)) range = {std::min(range.low, value), std::max(range.high, value)};
  return range.low <= range.high ? range : Range{};
}

uint8_t byte_of(float value) {
  return static_cast<uint8_t>(std::lround(255 * std::clamp(std::isnan(value) ? 0.0f : value, 0.0f, 1.0f)));
}

/// A colour of its own for every number but 0, which is black.
std::array<uint8_t, 3> color_of(float number) {
  if (number == 0) return {0, 0, 0};
  std::array<uint8_t, 3> color{};
  const double hue = std::fmod(0.618033988749895 * double{number}, 1.0);  // the golden ratio keeps them apart
  for (size_t c = 0; c < 3; ++c) {
    const double phase = std::fmod(hue + static_cast<double>(c) / 3, 1.0);
    color[c] = byte_of(static_cast<float>(0.25 + 0.7 * std::abs(2 * phase - 1)));
  }
  return color;
}

/// A layer as bytes, and how they are to be read.
struct ShownLayer {
  std::vector<uint8_t> rgb;
  std::string text;
};

ShownLayer show_colors(const std::string& name, const Layer& layer, float exposure_ev) {
  const bool is_variance = name == "variance";
  ShownLayer shown{{}, is_variance ? "its root, shown as the picture is" : "shown as the picture is"};
  const float scale = name == "albedo" ? 1 : std::exp2(exposure_ev);
  for (size_t i = 0; i < layer.values[0].size(); ++i) {
    std::array<float, 3> color{};
    for (size_t c = 0; c < 3; ++c) {  // channels come as B, G, R
      const float value = layer.values[2 - c][i];
      color[c] = scale * (is_variance ? std::sqrt(value) : value);
    }
    for (const float value : image::tone_map(color)) shown.rgb.push_back(byte_of(image::srgb_encode(value)));
  }
  return shown;
}

ShownLayer show_vectors(const std::string& name, const Layer& layer) {
  const bool is_normal = name == "N" || name == "Ng";
  ShownLayer shown{{}, is_normal ? "from -1 to 1" : ""};
  std::array<Range, 3> ranges{{{-1, 1}, {-1, 1}, {-1, 1}}};
  for (size_t c = 0; c < 3 && !is_normal; ++c) {
    ranges[c] = range_of(layer.values[c]);
    shown.text += fmt::format("{}{} {:.4g} to {:.4g}", c == 0 ? "" : ", ", layer.names[c], ranges[c].low,
                              ranges[c].high);
  }
  for (size_t i = 0; i < layer.values[0].size(); ++i)
    for (size_t c = 0; c < 3; ++c)
      shown.rgb.push_back(
          byte_of((layer.values[c][i] - ranges[c].low) / std::max(ranges[c].high - ranges[c].low, 1e-30f)));
  return shown;
}

ShownLayer show_numbers(const std::string& name, const Layer& layer) {
  const Range range = range_of(layer.values[0]);
  const bool has_colors = layer.is_integer && name != "samples";
  ShownLayer shown{{},
                   has_colors ? "a colour for each number"
                              : fmt::format("black {:.4g} to white {:.4g}", range.low, range.high)};
  for (const float value : layer.values[0]) {
    const uint8_t grey = byte_of((value - range.low) / std::max(range.high - range.low, 1e-30f));
    for (const uint8_t byte : has_colors ? color_of(value) : std::array{grey, grey, grey})
      shown.rgb.push_back(byte);
  }
  return shown;
}

ShownLayer show(const std::string& name, const Layer& layer, float exposure_ev) {
  if (layer.values.size() != 3) return show_numbers(name, layer);
  return layer.names[0] == "B" ? show_colors(name, layer, exposure_ev) : show_vectors(name, layer);
}

/// One pixel of so many each way.
std::vector<uint8_t> every(uint32_t reduction, uint32_t width, uint32_t height,
                           const std::vector<uint8_t>& rgb) {
  std::vector<uint8_t> kept;
  for (size_t y = 0; y < height / reduction; ++y)
    for (size_t x = 0; x < width / reduction; ++x)
      for (size_t c = 0; c < 3; ++c) kept.push_back(rgb[3 * (y * reduction * width + x * reduction) + c]);
  return kept;
}

nlohmann::json aovs_json(const RenderReport& report) {
  const uint32_t width = report.image.width, height = report.image.height;
  const uint32_t reduction =
      std::min({reduction_for(width, height, MOST_AOV_PIXELS), std::max(width, 1u), std::max(height, 1u)});
  nlohmann::json aovs = nlohmann::json::array();
  for (const auto& [name, layer] : layers_of(report.channels)) {
    const ShownLayer shown = show(name, layer, report.exposure_ev);
    const std::string png = encode_rgb8(image::Format::Png, width / reduction, height / reduction,
                                        every(reduction, width, height, shown.rgb), name);
    aovs.push_back({{"name", name}, {"text", shown.text}, {"png", data_url(png)}});
  }
  return aovs;
}

}  // namespace

std::string render_page(const RenderReport& report) {
  const uint32_t reduction = reduction_for(report.image.width, report.image.height, MOST_PIXELS);
  nlohmann::json convergence = nlohmann::json::array();
  for (const ConvergencePoint& point : report.convergence)
    convergence.push_back({{"seconds", number(point.seconds)},
                           {"samples", number(point.samples)},
                           {"error", number(point.error)}});
  return filled_page(RENDER_PAGE,
                     {{"title", report.title},
                      {"about", report.about},
                      {"summary", report.summary},
                      {"picture", data_url(encode_full_range(reduced(report.image, reduction), "picture"))},
                      {"reduction", reduction},
                      {"exposure", report.exposure_ev},
                      {"aovs", aovs_json(report)},
                      {"statistics", report.statistics},
                      {"candidates", report.candidates},
                      {"convergence", convergence},
                      {"warnings", report.warnings}});
}

}  // namespace regulus::bench
