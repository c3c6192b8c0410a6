#include "scene/image_based_light.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/quaternion.hpp>
#include <vector>

#include "scene/image_decoder.hpp"
#include "scene/json_member.hpp"
#include "scene/texture.hpp"

namespace regulus::scene {
namespace {

using glm::dvec3;
using nlohmann::json;

constexpr const char* IMAGE_BASED_LIGHTS = "EXT_lights_image_based";
constexpr uint32_t LEAST_WIDTH = 256, LARGEST_WIDTH = 8192;  // of the latitude-longitude map

/// Six square faces in the order +x, -x, +y, -y, +z, -z; rows from the top, each as one sees it from the
/// middle of the cube: glTF's images are the mirror images of what graphics interfaces call the standard
/// orientation.
struct CubeMap {
  uint32_t side = 0;
  std::array<std::vector<glm::vec3>, 6> faces;

  glm::vec3 at(const dvec3& direction) const {
    const dvec3 size = abs(direction);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const bool is_negative = direction[axis] < 0;
    const double sign = is_negative ? -1 : 1;
    const glm::dvec2 across = axis == 0   ? glm::dvec2(sign * direction.z, -direction.y)
                              : axis == 1 ? glm::dvec2(-direction.x, sign * direction.z)
                                          : glm::dvec2(-sign * direction.x, -direction.y);
    const glm::dvec2 place = (across / size[axis] * 0.5 + 0.5) * static_cast<double>(side) - 0.5;
    const glm::dvec2 corner = glm::floor(place);
    const glm::vec2 weight(place - corner);
    const std::vector<glm::vec3>& face = faces[2 * static_cast<size_t>(axis) + (is_negative ? 1 : 0)];
    const auto texel = [&](int dx, int dy) {
      const auto clamped = [&](double i) {
        return static_cast<size_t>(std::clamp(i, 0.0, static_cast<double>(side) - 1));
      };
      return face[clamped(corner.y + dy) * side + clamped(corner.x + dx)];
    };
    // Exact where neighbours are equal.
    const auto between = [](const glm::vec3& a, const glm::vec3& b, float t) { return a + t * (b - a); };
    return between(between(texel(0, 0), texel(1, 0), weight.x), between(texel(0, 1), texel(1, 1), weight.x),
                   weight.y);
  }
};

/// A face: sRGB, divided by alpha, which PNG files have where radiance exceeds 1 (RGBD).
std::vector<glm::vec3> read_face(Document& document, const json& image, const std::string& element,
                                 uint32_t& side) {
  if (!image.is_number_unsigned() || image.get<uint64_t>() >= document.images.size())
    document.fail(element + " is no index of an image; export the file again");
  const auto index = image.get<size_t>();
  const Bytes bytes = image_bytes(document, index, fmt::format("{} image {}", element, index));
  std::string reason;
  const auto header = read_image_header(bytes, reason);
  if (!header) document.fail(fmt::format("{} image {} {}", element, index, reason));
  if (header->width != header->height || (side != 0 && header->width != side))
    document.fail(
        fmt::format("{} image {} has {} x {} pixels, not those of a face of a cube; export it again", element,
                    index, header->width, header->height));
  side = header->width;
  const auto codes = decode_image(bytes, *header, reason);
  if (!codes)
    document.fail(fmt::format("{} image {} cannot be decoded ({}); export it again", element, index, reason));
  const double maximum = header->is_16_bit ? 65535 : 255;
  const auto code = [&](size_t pixel, size_t channel) -> double {
    const size_t at = 4 * pixel + channel;
    return header->is_16_bit ? reinterpret_cast<const uint16_t*>(codes->data())[at]
                             : reinterpret_cast<const uint8_t*>(codes->data())[at];
  };
  std::vector<glm::vec3> texels(header->pixels());
  for (size_t i = 0; i < texels.size(); ++i)
    for (size_t channel = 0; channel < 3; ++channel)
      texels[i][static_cast<int>(channel)] = static_cast<float>(srgb_to_linear(code(i, channel) / maximum) *
                                                                maximum / std::max(code(i, 3), 1.0));
  return texels;
}

CubeMap read_cube(Document& document, const json& light, const std::string& element) {
  const auto levels = light.find("specularImages");
  if (levels == light.end() || !levels->is_array() || levels->empty() || !(*levels)[0].is_array() ||
      (*levels)[0].size() != 6)
    document.fail(element + " has no specularImages of six faces; export the file again");
  CubeMap cube;
  for (size_t face = 0; face < 6; ++face)
    cube.faces[face] = read_face(document, (*levels)[0][face], element, cube.side);
  return cube;
}

glm::dquat rotation_of(Document& document, const json& light, const std::string& element) {
  const glm::dquat none(1, 0, 0, 0);
  const auto rotation = light.find("rotation");
  if (rotation == light.end()) return none;
  const bool is_vector =
      rotation->is_array() && rotation->size() == 4 &&
      std::all_of(rotation->begin(), rotation->end(), [](const json& v) { return v.is_number(); });
  const auto part = [&](size_t i) { return (*rotation)[i].get<double>(); };
  const glm::dquat quaternion =
      is_vector ? glm::dquat(part(3), part(0), part(1), part(2)) : glm::dquat(0, 0, 0, 0);
  const double length = glm::length(quaternion);
  if (length > 0 && std::isfinite(length)) return quaternion / length;
  document.mend(element + ": its rotation is not a quaternion; correct it", "not turned");
  return none;
}

double intensity_of(Document& document, const json& light, const std::string& element) {
  const auto intensity = light.find("intensity");
  if (intensity == light.end()) return 1;
  if (intensity->is_number() && intensity->get<double>() >= 0 && intensity->get<double>() < 1e6)
    return intensity->get<double>();
  document.mend(element + ": its intensity is no factor from 0 to 1e6; correct it", "taken as 1");
  return 1;
}

Environment read_light(Document& document, const json& light, const std::string& element,
                       const EnvironmentOptions& options) {
  const CubeMap cube = read_cube(document, light, element);
  const glm::dquat to_cube = glm::inverse(rotation_of(document, light, element));
  const auto scale = static_cast<float>(intensity_of(document, light, element) * options.scale.value_or(1));
  const uint32_t width = std::clamp(4 * cube.side, LEAST_WIDTH, LARGEST_WIDTH), height = width / 2;
  std::vector<glm::vec3> texels;
  texels.reserve(size_t{width} * height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      // interface::Environment
      const double theta = glm::pi<double>() * (y + 0.5) / height;
      const double phi = glm::two_pi<double>() * ((x + 0.5) / width - 0.5);
      const dvec3 direction(std::sin(theta) * std::cos(phi), std::cos(theta),
                            std::sin(theta) * std::sin(phi));
      texels.push_back(scale * cube.at(to_cube * direction));
    }
  return map_environment(std::move(texels), width, options.rotation.value_or(0) / 360);
}

}  // namespace

std::optional<Environment> read_image_based_light(Document& document, size_t scene_index,
                                                  const EnvironmentOptions& options) {
  const json* use = member(member(&document.json["scenes"][scene_index], "extensions"), IMAGE_BASED_LIGHTS);
  if (use == nullptr) return std::nullopt;
  const json* index = member(use, "light");
  const json* lights = member(member(member(&document.json, "extensions"), IMAGE_BASED_LIGHTS), "lights");
  try {
    if (index == nullptr || !index->is_number_unsigned() || lights == nullptr || !lights->is_array() ||
        index->get<uint64_t>() >= lights->size() || !(*lights)[index->get<size_t>()].is_object())
      document.fail(fmt::format("scene {}: its light of {} is not there; export the file again", scene_index,
                                IMAGE_BASED_LIGHTS));
    const auto light = index->get<size_t>();
    return read_light(document, (*lights)[light], fmt::format("{} light {}", IMAGE_BASED_LIGHTS, light),
                      options);
  } catch (const Error& error) {
    document.mend(error, "the scene without it");
    return std::nullopt;
  }
}

}  // namespace regulus::scene
