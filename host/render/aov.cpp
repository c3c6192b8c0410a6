#include "render/aov.hpp"

#include <fmt/format.h>

#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "render/settings.hpp"

namespace regulus::render {

namespace {

using interface::AovPixel;

constexpr std::pair<const char*, uint32_t> NAMES[] = {{"albedo", AOV_ALBEDO},
                                                      {"N", AOV_SHADING_NORMAL},
                                                      {"Ng", AOV_GEOMETRIC_NORMAL},
                                                      {"P", AOV_POSITION},
                                                      {"Z", AOV_DEPTH},
                                                      {"material", AOV_MATERIAL},
                                                      {"instance", AOV_INSTANCE},
                                                      {"variance", AOV_VARIANCE},
                                                      {"samples", AOV_SAMPLES},
                                                      {"sigma", AOV_SIGMA},
                                                      {"emission", AOV_EMISSION},
                                                      {"direct", AOV_DIRECT},
                                                      {"caustics", AOV_CAUSTICS},
                                                      {"indirect", AOV_INDIRECT},
                                                      {"lights", AOV_LIGHTS},
                                                      {"crypto_object", AOV_CRYPTO_OBJECT},
                                                      {"crypto_material", AOV_CRYPTO_MATERIAL}};

template <typename T, typename Value>
std::vector<T> values_of(const std::vector<AovPixel>& pixels, const Value& value) {
  std::vector<T> values;
  values.reserve(pixels.size());
  for (const AovPixel& pixel : pixels) values.push_back(value(pixel));
  return values;
}

void add_vectors(const std::vector<AovPixel>& pixels, const std::string& name, const char* components,
                 interface::vec3 AovPixel::*vector, image::Channels& channels) {
  for (int i = 0; i < 3; ++i)
    channels[name + "." + components[i]] =
        values_of<float>(pixels, [&](const AovPixel& pixel) { return (pixel.*vector)[i]; });
}

void add_positions(const std::vector<AovPixel>& pixels, const glm::dvec3& origin, image::Channels& channels) {
  for (int i = 0; i < 3; ++i)
    channels[std::string("P.") + "XYZ"[i]] = values_of<float>(pixels, [&](const AovPixel& pixel) {
      return std::isinf(pixel.depth) ? 0.0F : static_cast<float>(pixel.position[i] + origin[i]);
    });
}

/// Writes 1 + index, so that INVALID_INDEX becomes 0.
void add_indices(const std::vector<AovPixel>& pixels, const char* name, uint32_t AovPixel::*index,
                 image::Channels& channels) {
  channels[name] = values_of<uint32_t>(pixels, [&](const AovPixel& pixel) { return pixel.*index + 1; });
}

}  // namespace

std::vector<std::string> known_aovs() {
  std::vector<std::string> names;
  for (const auto& [name, bit] : NAMES) names.emplace_back(name);
  return names;
}

uint32_t parse_aovs(const std::string& list) {
  uint32_t aovs = 0;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) {
    uint32_t bit = 0;
    for (const auto& [known, known_bit] : NAMES)
      if (name == known) bit = known_bit;
    if (bit == 0) throw SettingError("aov", list, unknown_name(name, known_aovs()));
    aovs |= bit;
  }
  return aovs;
}

std::string aov_names(uint32_t aovs) {
  std::string list;
  for (const auto& [name, bit] : NAMES) {
    if ((aovs & bit) == 0) continue;
    if (!list.empty()) list += ',';
    list += name;
  }
  return list;
}

void add_surface_channels(const std::vector<AovPixel>& pixels, uint32_t aovs, const glm::dvec3& origin,
                          image::Channels& channels) {
  if ((aovs & AOV_ALBEDO) != 0) add_vectors(pixels, "albedo", "RGB", &AovPixel::albedo, channels);
  if ((aovs & AOV_SHADING_NORMAL) != 0) add_vectors(pixels, "N", "XYZ", &AovPixel::shading_normal, channels);
  if ((aovs & AOV_GEOMETRIC_NORMAL) != 0)
    add_vectors(pixels, "Ng", "XYZ", &AovPixel::geometric_normal, channels);
  if ((aovs & AOV_POSITION) != 0) add_positions(pixels, origin, channels);
  if ((aovs & AOV_DEPTH) != 0)
    channels["Z"] = values_of<float>(pixels, [](const AovPixel& pixel) { return pixel.depth; });
  if ((aovs & AOV_MATERIAL) != 0) add_indices(pixels, "material", &AovPixel::material, channels);
  if ((aovs & AOV_INSTANCE) != 0) add_indices(pixels, "instance", &AovPixel::instance, channels);
}

void add_sigma_channels(const std::vector<interface::vec3>& footprints, image::Channels& channels) {
  std::vector<float> positions, angles;
  positions.reserve(footprints.size());
  angles.reserve(footprints.size());
  for (const interface::vec3& footprint : footprints) {
    positions.push_back(std::sqrt(footprint.x));
    angles.push_back(std::sqrt(footprint.z));
  }
  channels["sigma.position"] = std::move(positions);
  channels["sigma.angle"] = std::move(angles);
}

void add_colors(const image::Image& image, const std::string& name, image::Channels& channels) {
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float> values(image.rgb.size() / 3);
    for (size_t pixel = 0; pixel < values.size(); ++pixel) values[pixel] = image.rgb[3 * pixel + c];
    channels[name + "." + "RGB"[c]] = std::move(values);
  }
}

void add_film_channels(const Film& film, uint32_t aovs, image::Channels& channels) {
  for (const LightLayer& layer : film.layers)
    add_colors(resolve(film_of_layer(film, layer)), layer.name, channels);
  if ((aovs & AOV_VARIANCE) != 0) add_colors(resolve_variance(film), "variance", channels);
  if ((aovs & AOV_SAMPLES) != 0) {
    std::vector<uint32_t> samples(film.pixels());
    for (uint64_t pixel = 0; pixel < samples.size(); ++pixel)
      samples[pixel] = static_cast<uint32_t>(film.samples(pixel));
    channels["samples"] = std::move(samples);
  }
}

}  // namespace regulus::render
