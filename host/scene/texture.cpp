#include "scene/texture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <limits>
#include <vector>

#include "interface/srgb.h"
#include "scene/image_decoder.hpp"

namespace regulus::scene {
namespace {

/// The image of a texture: of EXT_texture_webp, else the plain one; -1 if it has neither.
int image_of(const tinygltf::Texture& texture) {
  const auto webp = texture.extensions.find("EXT_texture_webp");
  if (webp != texture.extensions.end() && webp->second.Has("source"))
    return webp->second.Get("source").GetNumberAsInt();
  return texture.source;
}

uint32_t half_bits(double value) {
  return glm::packHalf1x16(static_cast<float>(value));
}

/// Calls `change` for the words of every texel of 16-bit codes with the codes as fractions.
template <typename Change>
void change_wide_texels(std::vector<uint32_t>& words, const Change& change) {
  for (size_t i = 0; i < words.size(); i += 2) {
    const glm::dvec4 codes(words[i] & 0xFFFFu, words[i] >> 16, words[i + 1] & 0xFFFFu, words[i + 1] >> 16);
    const glm::dvec4 value = change(codes / 65535.0);
    words[i] = half_bits(value.r) | half_bits(value.g) << 16;
    words[i + 1] = half_bits(value.b) | half_bits(value.a) << 16;
  }
}

/// 8-bit codes as 16-bit ones of the same fractions.
std::vector<uint32_t> widened(const std::vector<uint32_t>& words) {
  std::vector<uint32_t> wide;
  wide.reserve(2 * words.size());
  for (const uint32_t word : words) {
    wide.push_back((word & 0xFFu) * 257 | (word >> 8 & 0xFFu) * 257 << 16);
    wide.push_back((word >> 16 & 0xFFu) * 257 | (word >> 24) * 257 << 16);
  }
  return wide;
}

/// Makes codes the texels that kernels read: those of 8 bits are, of a glossiness or of 16-bit colours become
/// half floats. @return TEXTURE_* flags
uint32_t make_texels(const TextureContent& content, bool is_16_bit, std::vector<uint32_t>& words) {
  if (content.glossiness) {
    if (!is_16_bit) words = widened(words);
    const double factor = std::clamp(*content.glossiness, 0.0, 1.0);
    change_wide_texels(words,
                       [&](const glm::dvec4& rgba) { return glm::dvec4(0, 1 - factor * rgba.a, 0, 0); });
    return interface::TEXTURE_HALF;
  }
  if (!is_16_bit) return content.is_srgb ? interface::TEXTURE_SRGB : 0;
  if (!content.is_srgb) return interface::TEXTURE_UNORM16;
  change_wide_texels(words, [](const glm::dvec4& rgba) {
    return glm::dvec4(srgb_to_linear(rgba.r), srgb_to_linear(rgba.g), srgb_to_linear(rgba.b), rgba.a);
  });
  return interface::TEXTURE_HALF;
}

uint32_t wrap_flag(int gltf_mode) {
  if (gltf_mode == TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE) return interface::TEXTURE_WRAP_CLAMP;
  if (gltf_mode == TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT) return interface::TEXTURE_WRAP_MIRROR;
  return interface::TEXTURE_WRAP_REPEAT;
}

uint32_t sampler_flags(const Document& document, int sampler) {
  if (sampler < 0) return interface::TEXTURE_WRAP_REPEAT;
  const tinygltf::Sampler& source = document.model.samplers[static_cast<size_t>(sampler)];
  return wrap_flag(source.wrapS) | wrap_flag(source.wrapT) << interface::TEXTURE_WRAP_T_SHIFT |
         (source.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST ? interface::TEXTURE_NEAREST : 0u);
}

float value_of_code(uint32_t code, bool is_srgb) {
  const auto number = static_cast<float>(code);
  return is_srgb ? interface::srgb_code_to_linear(number) : interface::code_to_fraction(number);
}

/// Texel i of an image with these TEXTURE_* flags.
glm::vec4 stored_texel(const std::vector<uint32_t>& words, uint32_t flags, size_t i) {
  if ((flags & interface::TEXTURE_HALF) != 0)
    return {glm::unpackHalf2x16(words[2 * i]), glm::unpackHalf2x16(words[2 * i + 1])};
  if ((flags & interface::TEXTURE_UNORM16) != 0) {
    const uint32_t low = words[2 * i], high = words[2 * i + 1];
    return glm::vec4(low & 0xFFFFu, low >> 16, high & 0xFFFFu, high >> 16) / 65535.0f;
  }
  const bool is_srgb = (flags & interface::TEXTURE_SRGB) != 0;
  glm::vec4 value;
  for (int c = 0; c < 4; ++c) value[c] = value_of_code(words[i] >> (8 * c) & 0xFFu, is_srgb && c < 3);
  return value;
}

int64_t wrap(int64_t i, int64_t size, uint32_t mode) {
  if (mode == interface::TEXTURE_WRAP_CLAMP) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = mode == interface::TEXTURE_WRAP_MIRROR ? 2 * size : size;
  const int64_t rest = ((i % period) + period) % period;
  return rest < size ? rest : period - 1 - rest;
}

}  // namespace

double srgb_to_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

uint32_t TextureLoader::load(int texture, TextureContent content, const interface::Texture& placement) {
  const glm::vec3 &u = placement.map_u, &v = placement.map_v;
  const LoadedTextures::Key key(texture, content, placement.flags, {u.x, u.y, u.z, v.x, v.y, v.z});
  const auto known = loaded_.textures.find(key);
  if (known != loaded_.textures.end()) return known->second;
  document_.require_whole("textures", static_cast<size_t>(texture), fmt::format("texture {}", texture));
  const tinygltf::Texture& source = document_.model.textures[static_cast<size_t>(texture)];
  const std::string element = element_name("texture", static_cast<size_t>(texture), source.name);
  const int image = image_of(source);
  if (image < 0) document_.fail(element + " has no PNG, JPEG or WebP image; convert its image");
  interface::Texture loaded = load_image(static_cast<size_t>(image), content, element);
  loaded.flags |= sampler_flags(document_, source.sampler) | placement.flags;
  loaded.map_u = placement.map_u;
  loaded.map_v = placement.map_v;
  const auto index = static_cast<uint32_t>(scene_.textures.size());
  scene_.textures.push_back(loaded);
  loaded_.textures.emplace(key, index);
  return index;
}

interface::Texture TextureLoader::load_image(size_t image, TextureContent content,
                                             const std::string& texture) {
  const auto known = loaded_.images.find({image, content});
  if (known != loaded_.images.end()) return known->second;

  const std::string element = fmt::format("{} image {}", texture, image);
  const uint64_t held = document_.files.held_bytes();
  const Bytes bytes = image_bytes(document_, image, element);
  std::string reason;
  const auto header = read_image_header(bytes, reason);
  if (!header) document_.fail(element + " " + reason);
  const std::string size = fmt::format("{} of {} x {} pixels", element, header->width, header->height);
  const uint64_t stored = content.glossiness ? 8 * header->pixels() : header->bytes();
  document_.hold(header->bytes_to_decode() + (stored - header->bytes()), size);
  auto words = decode_image(bytes, *header, reason);
  if (!words) document_.fail(fmt::format("{} cannot be decoded ({}); export it again", element, reason));
  interface::Texture loaded {};
  loaded.flags = make_texels(content, header->is_16_bit, *words);
  loaded.width = header->width;
  loaded.height = header->height;
  loaded.image = add_image(image, loaded.flags, std::move(*words));
  document_.files.release_to(held);
  document_.hold(stored, size);
  return loaded_.images[{image, content}] = loaded;
}

uint32_t TextureLoader::add_image(size_t image, uint32_t flags, std::vector<uint32_t> words) {
  // Codes are the same whatever they stand for.
  const auto codes = loaded_.codes.find(image);
  const bool has_codes = (flags & (interface::TEXTURE_HALF | interface::TEXTURE_UNORM16)) == 0;
  if (has_codes && codes != loaded_.codes.end()) return codes->second;
  const auto index = static_cast<uint32_t>(scene_.images.size());
  scene_.images.push_back(std::move(words));
  if (has_codes) loaded_.codes[image] = index;
  return index;
}

Bytes image_bytes(Document& document, size_t image, const std::string& element) {
  document.require_whole("images", image, element);
  const nlohmann::json& source = document.images[image];
  if (source.contains("uri")) return document.read_uri(source["uri"].get<std::string>(), element);
  if (!source.contains("bufferView"))
    document.fail(element + " has neither uri nor bufferView; export the file again");
  const auto view = document.view(source["bufferView"].get<int>(), element);
  return Bytes(view.begin(), view.end());
}

glm::vec4 texel(const Scene& scene, const interface::Texture& texture, int64_t x, int64_t y) {
  const uint32_t wrap_s = texture.flags & 3u;
  const uint32_t wrap_t = (texture.flags >> interface::TEXTURE_WRAP_T_SHIFT) & 3u;
  const uint64_t column = static_cast<uint64_t>(wrap(x, texture.width, wrap_s));
  const uint64_t row = static_cast<uint64_t>(wrap(y, texture.height, wrap_t));
  return stored_texel(scene.images[texture.image], texture.flags, row * texture.width + column);
}

std::pair<float, float> channel_range(const Scene& scene, const interface::Texture& texture, int channel) {
  const std::vector<uint32_t>& words = scene.images[texture.image];
  if ((texture.flags & (interface::TEXTURE_HALF | interface::TEXTURE_UNORM16)) == 0) {
    uint32_t least = 255, largest = 0;
    for (const uint32_t word : words) {
      const uint32_t code = word >> (8 * channel) & 0xFFu;
      least = std::min(least, code);
      largest = std::max(largest, code);
    }
    const bool is_srgb = (texture.flags & interface::TEXTURE_SRGB) != 0;
    return {value_of_code(least, is_srgb && channel < 3), value_of_code(largest, is_srgb && channel < 3)};
  }
  std::pair<float, float> range(std::numeric_limits<float>::infinity(),
                                -std::numeric_limits<float>::infinity());
  const size_t count = static_cast<size_t>(texture.width) * texture.height;
  for (size_t i = 0; i < count; ++i) {
    const float value = stored_texel(words, texture.flags, i)[channel];
    range = {std::min(range.first, value), std::max(range.second, value)};
  }
  return range;
}

TextureCoordinates texture_coordinates(const Scene& scene, const interface::Triangle& triangle,
                                       const glm::dvec3& weights) {
  const glm::uvec3 corners(triangle.v0, triangle.v1, triangle.v2);
  glm::dvec2 own(0);
  for (int i = 0; i < 3; ++i) own += weights[i] * glm::dvec2(scene.vertices[corners[i]].uv);
  return {own, corners, weights};
}

glm::dvec2 image_coordinates(const Scene& scene, const interface::Texture& texture,
                             const TextureCoordinates& coordinates) {
  glm::dvec2 uv = coordinates.own;
  const uint32_t set = texture.flags >> interface::TEXTURE_SET_SHIFT & interface::TEXTURE_SET_MASK;
  if (set != 0) {
    uv = glm::dvec2(0);
    for (int i = 0; i < 3; ++i) {
      const size_t first = size_t{coordinates.corners[i]} * scene.vertex_uv_sets;
      uv += coordinates.weights[i] * glm::dvec2(scene.vertex_uvs[first + set - 1]);
    }
  }
  if ((texture.flags & interface::TEXTURE_MAPPED) == 0) return uv;
  return {glm::dot(glm::dvec3(texture.map_u), glm::dvec3(uv, 1)),
          glm::dot(glm::dvec3(texture.map_v), glm::dvec3(uv, 1))};
}

glm::vec4 sample_texture(const Scene& scene, const interface::Texture& texture,
                         const TextureCoordinates& coordinates) {
  // Coordinates beyond this have no fraction left in single precision.
  const glm::dvec2 bounded = glm::clamp(image_coordinates(scene, texture, coordinates), -1e7, 1e7);
  const glm::dvec2 position = bounded * glm::dvec2(texture.width, texture.height);
  if ((texture.flags & interface::TEXTURE_NEAREST) != 0)
    return texel(scene, texture, static_cast<int64_t>(std::floor(position.x)),
                 static_cast<int64_t>(std::floor(position.y)));
  const glm::dvec2 corner = glm::floor(position - 0.5);
  const glm::vec2 weight(position - 0.5 - corner);
  const int64_t x = static_cast<int64_t>(corner.x);
  const int64_t y = static_cast<int64_t>(corner.y);
  const glm::vec4 top = glm::mix(texel(scene, texture, x, y), texel(scene, texture, x + 1, y), weight.x);
  const glm::vec4 bottom =
      glm::mix(texel(scene, texture, x, y + 1), texel(scene, texture, x + 1, y + 1), weight.x);
  return glm::mix(top, bottom, weight.y);
}

}  // namespace regulus::scene
