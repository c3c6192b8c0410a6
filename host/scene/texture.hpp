// Images to texels, and their evaluation on the host.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <utility>

#include "scene/document.hpp"
#include "scene/scene.hpp"

namespace regulus::scene {

/// What the values of a texture mean: colours are sRGB-encoded in the file, data is linear.
enum class TextureContent { Color, Data };

/// Decodes glTF textures into Scene::textures on demand; each image once per content.
class TextureLoader {
 public:
  TextureLoader(Document& document, Scene& scene) : document_(document), scene_(scene) {}

  /// Index into Scene::textures for a glTF texture. @throws Error if its image cannot be read.
  uint32_t load(int texture, TextureContent content);

 private:
  interface::Texture load_image(size_t image, TextureContent content, const std::string& element);
  Bytes image_bytes(size_t image, const std::string& element);

  Document& document_;
  Scene& scene_;
  std::map<std::pair<int, TextureContent>, uint32_t> textures_;
  std::map<std::pair<size_t, TextureContent>, interface::Texture> decoded_;
};

/// Texel (x, y) as linear RGBA; the coordinates are wrapped by the texture's own modes first.
glm::vec4 texel(const Scene& scene, const interface::Texture& texture, int64_t x, int64_t y);

/// The texture at uv (glTF: (0, 0) is the top left corner), bilinear or nearest as its flags say.
glm::vec4 sample_texture(const Scene& scene, const interface::Texture& texture, const glm::vec2& uv);

}  // namespace regulus::scene
