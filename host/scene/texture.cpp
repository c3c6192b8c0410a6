#include "scene/texture.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <glm/gtc/packing.hpp>
#include <vector>

#include "scene/image_decoder.hpp"

namespace regulus::scene {
namespace {

constexpr uint64_t MAX_TEXELS_OF_SCENE = uint64_t{1} << 31;  // the kernels' word index is 32 bits

/// The image of a texture: of EXT_texture_webp, else the plain one; -1 if it has neither.
int image_of(const tinygltf::Texture& texture) {
  const auto webp = texture.extensions.find("EXT_texture_webp");
  if (webp != texture.extensions.end() && webp->second.Has("source"))
    return webp->second.Get("source").GetNumberAsInt();
  return texture.source;
}

/// IEC 61966-2-1 decoding.
double srgb_to_linear(double encoded) {
  return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// Halfs of all code values of one channel.
std::vector<uint16_t> decoding_table(uint32_t maximum, bool is_srgb) {
  std::vector<uint16_t> table(maximum + 1);
  for (uint32_t code = 0; code <= maximum; ++code) {
    const double value = static_cast<double>(code) / maximum;
    table[code] = glm::packHalf1x16(static_cast<float>(is_srgb ? srgb_to_linear(value) : value));
  }
  return table;
}

/// Appends RGBA codes as texels of a roughness that is 1 - glossiness * alpha.
template <typename Code>
void append_roughness(const Code* codes, uint64_t count, double glossiness, std::vector<uint32_t>& texels) {
  const double maximum = static_cast<Code>(~Code{0});
  for (uint64_t i = 0; i < count; ++i) {
    const double roughness = 1 - std::clamp(glossiness, 0.0, 1.0) * codes[4 * i + 3] / maximum;
    texels.push_back(static_cast<uint32_t>(glm::packHalf1x16(static_cast<float>(roughness))) << 16);
    texels.push_back(0);
  }
}

/// Appends RGBA codes as texels. Alpha is always linear.
template <typename Code>
void append_texels(const Code* codes, uint64_t count, const TextureContent& content,
                   std::vector<uint32_t>& texels) {
  if (content.glossiness) return append_roughness(codes, count, *content.glossiness, texels);
  const uint32_t maximum = static_cast<Code>(~Code{0});
  const std::vector<uint16_t> linear = decoding_table(maximum, false);
  const std::vector<uint16_t> color = decoding_table(maximum, content.is_srgb);
  const size_t first = texels.size();
  texels.resize(first + 2 * count);
  for (uint64_t i = 0; i < count; ++i) {
    const Code* rgba = codes + 4 * i;
    texels[first + 2 * i] = color[rgba[0]] | static_cast<uint32_t>(color[rgba[1]]) << 16;
    texels[first + 2 * i + 1] = color[rgba[2]] | static_cast<uint32_t>(linear[rgba[3]]) << 16;
  }
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

int64_t wrap(int64_t i, int64_t size, uint32_t mode) {
  if (mode == interface::TEXTURE_WRAP_CLAMP) return std::clamp<int64_t>(i, 0, size - 1);
  const int64_t period = mode == interface::TEXTURE_WRAP_MIRROR ? 2 * size : size;
  const int64_t rest = ((i % period) + period) % period;
  return rest < size ? rest : period - 1 - rest;
}

}  // namespace

uint32_t TextureLoader::load(int texture, TextureContent content, const interface::Texture& placement) {
  const glm::vec3 &u = placement.map_u, &v = placement.map_v;
  const Key key(texture, content, placement.flags, {u.x, u.y, u.z, v.x, v.y, v.z});
  const auto known = textures_.find(key);
  if (known != textures_.end()) return known->second;
  document_.require_whole("textures", static_cast<size_t>(texture), fmt::format("texture {}", texture));
  const tinygltf::Texture& source = document_.model.textures[static_cast<size_t>(texture)];
  const std::string element = element_name("texture", static_cast<size_t>(texture), source.name);
  const int image = image_of(source);
  if (image < 0) document_.fail(element + " has no PNG, JPEG or WebP image; convert its image");
  interface::Texture loaded = load_image(static_cast<size_t>(image), content, element);
  loaded.flags = sampler_flags(document_, source.sampler) | placement.flags;
  loaded.map_u = placement.map_u;
  loaded.map_v = placement.map_v;
  const auto index = static_cast<uint32_t>(scene_.textures.size());
  scene_.textures.push_back(loaded);
  textures_.emplace(key, index);
  return index;
}

interface::Texture TextureLoader::load_image(size_t image, TextureContent content,
                                             const std::string& texture) {
  const auto known = decoded_.find({image, content});
  if (known != decoded_.end()) return known->second;

  const std::string element = fmt::format("{} image {}", texture, image);
  const Bytes bytes = image_bytes(image, element);
  std::string reason;
  const auto header = read_image_header(bytes, reason);
  if (!header) document_.fail(element + " " + reason);
  const uint64_t first_texel = scene_.texels.size() / 2;
  if (first_texel + header->pixels() >= MAX_TEXELS_OF_SCENE)
    document_.fail("more than 2^31 texels in all; scale textures down");
  const auto codes = decode_image(bytes, *header, reason);
  if (!codes) document_.fail(fmt::format("{} cannot be decoded ({}); export it again", element, reason));
  if (header->is_16_bit)
    append_texels(reinterpret_cast<const uint16_t*>(codes->data()), header->pixels(), content, scene_.texels);
  else
    append_texels(reinterpret_cast<const uint8_t*>(codes->data()), header->pixels(), content, scene_.texels);

  interface::Texture loaded {};
  loaded.first_texel = static_cast<uint32_t>(first_texel);
  loaded.width = header->width;
  loaded.height = header->height;
  decoded_[{image, content}] = loaded;
  return loaded;
}

Bytes TextureLoader::image_bytes(size_t image, const std::string& element) {
  document_.require_whole("images", image, element);
  const nlohmann::json& source = document_.images[image];
  if (source.contains("uri")) return document_.read_uri(source["uri"].get<std::string>(), element);
  if (!source.contains("bufferView"))
    document_.fail(element + " has neither uri nor bufferView; export the file again");
  const auto view = document_.view(source["bufferView"].get<int>(), element);
  return Bytes(view.begin(), view.end());
}

glm::vec4 texel(const Scene& scene, const interface::Texture& texture, int64_t x, int64_t y) {
  const uint32_t wrap_s = texture.flags & 3u;
  const uint32_t wrap_t = (texture.flags >> interface::TEXTURE_WRAP_T_SHIFT) & 3u;
  const uint64_t column = static_cast<uint64_t>(wrap(x, texture.width, wrap_s));
  const uint64_t row = static_cast<uint64_t>(wrap(y, texture.height, wrap_t));
  const size_t word = 2 * (texture.first_texel + row * texture.width + column);
  return {glm::unpackHalf2x16(scene.texels[word]), glm::unpackHalf2x16(scene.texels[word + 1])};
}

glm::dvec4 texture_coordinates(const Scene& scene, const interface::Triangle& triangle,
                               const glm::dvec3& weights) {
  const uint32_t corners[3] = {triangle.v0, triangle.v1, triangle.v2};
  glm::dvec4 sum(0);
  for (int i = 0; i < 3; ++i) {
    const glm::vec2 second = scene.vertex_uvs.empty() ? glm::vec2(0) : scene.vertex_uvs[corners[i]];
    sum += weights[i] * glm::dvec4(glm::dvec2(scene.vertices[corners[i]].uv), glm::dvec2(second));
  }
  return sum;
}

glm::dvec2 image_coordinates(const interface::Texture& texture, const glm::dvec4& coordinates) {
  const bool is_second = (texture.flags & interface::TEXTURE_SECOND_UVS) != 0;
  const glm::dvec2 uv = is_second ? glm::dvec2(coordinates.z, coordinates.w) : glm::dvec2(coordinates);
  if ((texture.flags & interface::TEXTURE_MAPPED) == 0) return uv;
  return {glm::dot(glm::dvec3(texture.map_u), glm::dvec3(uv, 1)),
          glm::dot(glm::dvec3(texture.map_v), glm::dvec3(uv, 1))};
}

glm::vec4 sample_texture(const Scene& scene, const interface::Texture& texture,
                         const glm::dvec4& coordinates) {
  // Coordinates beyond this have no fraction left in single precision.
  const glm::dvec2 bounded = glm::clamp(image_coordinates(texture, coordinates), -1e7, 1e7);
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
