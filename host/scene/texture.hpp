// Images to texels, and their evaluation on the host.
#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

#include "scene/document.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// What the values of a texture mean.
struct TextureContent {
  bool is_srgb = false;  ///< RGB as encoded in the file
  /// Its alpha times this is a glossiness: loaded as a metallic-roughness texture instead, roughness
  /// 1 - glossiness in G, the rest 0.
  std::optional<double> glossiness{};

  /// An order, for maps.
  bool operator<(const TextureContent& other) const {
    return std::tie(is_srgb, glossiness) < std::tie(other.is_srgb, other.glossiness);
  }

  static const TextureContent Color, Data;
};
inline constexpr TextureContent TextureContent::Color{true};
inline constexpr TextureContent TextureContent::Data{false};

/// IEC 61966-2-1 decoding of a value in [0, 1].
double srgb_to_linear(double encoded);

/// The file of an image. @throws Error naming `element` if it cannot be read.
Bytes image_bytes(Document& document, size_t image, const std::string& element);

/// What Scene::textures and Scene::images hold of a document's textures.
struct LoadedTextures {
  /// Texture, content, flags and rows of its placement.
  using Key = std::tuple<int, TextureContent, uint32_t, std::array<float, 6>>;
  std::map<Key, uint32_t> textures;                                        ///< index into Scene::textures
  std::map<std::pair<size_t, TextureContent>, interface::Texture> images;  ///< by image
  std::map<size_t, uint32_t> codes;  ///< by image of the file: where its 8-bit codes are
};

/// Decodes glTF textures into Scene::textures on demand; each image once per content, 8-bit codes stored once
/// for all.
class TextureLoader {
 public:
  /// @param loaded what the scene holds already; it is kept up to date
  TextureLoader(Document& document, Scene& scene, LoadedTextures& loaded)
      : document_(document), scene_(scene), loaded_(loaded) {}

  /// Index into Scene::textures for a glTF texture that finds its coordinates so (see
  /// MaterialUvs::placement).
  /// @throws Error if its image cannot be read.
  uint32_t load(int texture, TextureContent content, const interface::Texture& placement);

 private:
  interface::Texture load_image(size_t image, TextureContent content, const std::string& element);
  /// Index into Scene::images of an image with these TEXTURE_* flags.
  uint32_t add_image(size_t image, uint32_t flags, std::vector<uint32_t> words);

  Document& document_;
  Scene& scene_;
  LoadedTextures& loaded_;
};

/// Texel (x, y) as linear RGBA; the coordinates are wrapped by the texture's own modes first.
glm::vec4 texel(const Scene& scene, const interface::Texture& texture, int64_t x, int64_t y);

/// Least and largest value of a channel (0 to 3) of a texture, as linear.
std::pair<float, float> channel_range(const Scene& scene, const interface::Texture& texture, int channel);

/// What textures find their coordinates with at a point of a triangle.
struct TextureCoordinates {
  glm::dvec2 own{0};      ///< between the vertices' own
  glm::uvec3 corners{0};  ///< vertices, whose further sets are read
  glm::dvec3 weights{0};  ///< of the corners
};

/// Between the vertices of a triangle, whose weights sum to 1.
TextureCoordinates texture_coordinates(const Scene& scene, const interface::Triangle& triangle,
                                       const glm::dvec3& weights);

/// Where a texture is looked up (glTF: (0, 0) is the top left corner of the image) at a point with these
/// coordinates. Of a texture that reads a further set, the corners must be vertices of the scene.
glm::dvec2 image_coordinates(const Scene& scene, const interface::Texture& texture,
                             const TextureCoordinates& coordinates);

/// The texture at a point with these coordinates, bilinear or nearest as its flags say.
glm::vec4 sample_texture(const Scene& scene, const interface::Texture& texture,
                         const TextureCoordinates& coordinates);

}  // namespace regulus::scene
