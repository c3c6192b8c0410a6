#include "scene/environment_file.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "image/exr_memory.hpp"
#include "image/image.hpp"

namespace regulus::scene {
namespace {

using nlohmann::json;

constexpr const char* ELEMENT = "extras.regulus.environment";
constexpr uint64_t MAX_TEXELS = uint64_t{1} << 26;
// As decoded, as radiance, and their distribution, with what making it takes.
constexpr uint64_t BYTES_OF_TEXEL = 12 + 12 + 12;
// Radiance beyond this is cut: 500 times the sun's disc, and far from overflowing when a path's throughput
// multiplies it.
constexpr double MAX_RADIANCE = 1e10;

/// Member `name` of extras as a number; `otherwise` if there is none.
double number_of(const Document& document, const json& extras, const char* name, double otherwise) {
  const auto member = extras.find(name);
  if (member == extras.end()) return otherwise;
  if (!member->is_number() || !std::isfinite(member->get<double>()))
    document.fail(fmt::format("{}.{} is not a finite number; correct it", ELEMENT, name));
  return member->get<double>();
}

glm::vec3 color_of(const Document& document, const json& color, double scale) {
  glm::vec3 radiance(0);
  bool is_valid = color.is_array() && color.size() == 3;
  for (int i = 0; is_valid && i < 3; ++i) {
    const json& channel = color[static_cast<size_t>(i)];
    is_valid =
        channel.is_number() && channel.get<double>() >= 0 && channel.get<double>() * scale <= MAX_RADIANCE;
    if (is_valid) radiance[i] = static_cast<float>(channel.get<double>() * scale);
  }
  if (!is_valid)
    document.fail(fmt::format("{}.color is not [r, g, b] with radiances from 0 to {:g}; correct it", ELEMENT,
                              MAX_RADIANCE));
  return radiance;
}

/// Values of a file that are no radiance.
struct Replaced {
  uint64_t values = 0, infinite = 0;
};

/// The radiance that a value stands for; an infinite one for `largest`, the largest of its file's format.
double radiance_of(double value, double scale, double largest, Replaced& replaced) {
  if (value >= 0 && value * scale <= MAX_RADIANCE) return value * scale;
  ++replaced.values;
  if (!(value > 0)) return 0;
  replaced.infinite += std::isinf(value) ? 1 : 0;
  return std::min(std::min(value, largest) * scale, MAX_RADIANCE);
}

/// The image's values times `scale`, made radiances.
std::vector<glm::vec3> radiances_of(Document& document, const image::Image& image, double scale,
                                    const std::string& name) {
  std::vector<glm::vec3> texels(image.rgb.size() / 3);
  const double largest = image.largest_finite;
  Replaced replaced;
  for (size_t i = 0; i < image.rgb.size(); ++i)
    texels[i / 3][static_cast<int>(i % 3)] =
        static_cast<float>(radiance_of(image.rgb[i], scale, largest, replaced));
  if (replaced.values > 0)
    document.warn(fmt::format(
        "{}: {} values are no radiance: negative ones and NaN are taken as 0, infinite ones ({}) as "
        "{:g}, the largest that its pixels hold, any beyond {:g} as that",
        name, replaced.values, replaced.infinite, largest, MAX_RADIANCE));
  return texels;
}

Environment read_map(Document& document, const Bytes& bytes, const std::string& name, double rotation,
                     double scale) {
  const uint64_t held = document.files.held_bytes();
  const bool is_radiance = image::is_radiance(bytes);
  if (!is_radiance) document.hold(image::exr_decoding_bytes(name, bytes), name);
  const uint64_t max_texels = std::min(MAX_TEXELS, document.files.free_bytes() / BYTES_OF_TEXEL);
  document.files.release_to(held);  // until the map is made there is room for both
  const image::Image image = is_radiance ? image::decode_radiance(name, bytes, max_texels)
                                         : image::decode_exr(name, bytes, max_texels);
  document.hold(uint64_t{image.width} * image.height * BYTES_OF_TEXEL, name);
  Environment environment =
      map_environment(radiances_of(document, image, scale, name), image.width, rotation / 360);
  if (!(environment.integral > 0)) document.warn(name + ": the environment is black");
  return environment;
}

}  // namespace

std::optional<Environment> read_environment(Document& document, const json* extras,
                                            const EnvironmentOptions& options) {
  const json none = json::object();
  if (extras != nullptr && !extras->is_object())
    document.fail(fmt::format("{} is not an object with \"file\" or \"color\"; correct it", ELEMENT));
  const json& source = extras != nullptr ? *extras : none;
  for (const auto& [name, value] : source.items())
    if (name != "file" && name != "color" && name != "rotation" && name != "scale")
      document.warn(fmt::format("{}.{} is not a setting of environments", ELEMENT, name));
  const double rotation = options.rotation.value_or(number_of(document, source, "rotation", 0));
  const double scale = options.scale.value_or(number_of(document, source, "scale", 1));
  if (!(scale >= 0)) document.fail(fmt::format("{}.scale is negative; correct it", ELEMENT));

  if (!options.file.empty())
    return read_map(document, document.files.read_file(options.file, "environment"), options.file.string(),
                    rotation, scale);
  if (const auto file = source.find("file"); file != source.end()) {
    if (!file->is_string()) document.fail(fmt::format("{}.file is not a string; name a file", ELEMENT));
    const auto uri = file->get<std::string>();
    const std::string name = uri.starts_with("data:") ? ELEMENT : uri;
    try {
      return read_map(document, document.read_uri(uri, ELEMENT), name, rotation, scale);
    } catch (const Error& error) {
      document.mend(error, "no environment of its own");
      return std::nullopt;
    }
  }
  if (const auto color = source.find("color"); color != source.end())
    return uniform_environment(color_of(document, *color, scale));
  if (extras != nullptr)
    document.fail(fmt::format("{} has neither \"file\" nor \"color\"; give one of them", ELEMENT));
  return std::nullopt;
}

}  // namespace regulus::scene
