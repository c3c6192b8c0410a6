#include "scene/light_power.hpp"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

#include "scene/texture.hpp"

namespace regulus::scene {
namespace {

constexpr double PI = glm::pi<double>();
constexpr int SAMPLES_PER_EDGE = 8;  // 8 * 8 sub-triangles
constexpr int64_t MAX_TEXELS_SEARCHED = 1 << 16;
// A triangle whose samples miss its bright texels is still chosen with this share of its brightest texel.
constexpr double MIN_SHARE_OF_BRIGHTEST = 1e-3;

/// Rec. 709 luminance of linear RGB.
double luminance(const glm::dvec3& color) {
  return 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b;
}

struct TriangleUv {
  glm::vec2 uv[3];
};

TriangleUv triangle_uv(const Scene& scene, const interface::Triangle& triangle) {
  return {{scene.vertices[triangle.v0].uv, scene.vertices[triangle.v1].uv, scene.vertices[triangle.v2].uv}};
}

/// Average at the centroids of SAMPLES_PER_EDGE^2 equal sub-triangles.
glm::dvec3 average_texture(const Scene& scene, const interface::Texture& texture,
                           const TriangleUv& triangle) {
  glm::dvec3 sum(0);
  for (int row = 0; row < SAMPLES_PER_EDGE; ++row)
    for (int column = 0; column < SAMPLES_PER_EDGE - row; ++column)
      for (int inverted = 0; inverted < (column + row < SAMPLES_PER_EDGE - 1 ? 2 : 1); ++inverted) {
        const float offset = inverted != 0 ? 2.0f / 3.0f : 1.0f / 3.0f;
        const float u = (static_cast<float>(column) + offset) / SAMPLES_PER_EDGE;
        const float v = (static_cast<float>(row) + offset) / SAMPLES_PER_EDGE;
        const glm::vec2 uv = (1 - u - v) * triangle.uv[0] + u * triangle.uv[1] + v * triangle.uv[2];
        sum += glm::dvec3(sample_texture(scene, texture, uv));
      }
  return sum / static_cast<double>(SAMPLES_PER_EDGE * SAMPLES_PER_EDGE);
}

/// Brightest luminance after `factor` of the texels in the triangle's uv bounds; of white if there are too
/// many to look at.
double brightest_texel(const Scene& scene, const interface::Texture& texture, const TriangleUv& triangle,
                       const glm::dvec3& factor) {
  const glm::dvec2 size(texture.width, texture.height);
  const glm::dvec2 low =
      glm::floor(glm::dvec2(glm::min(triangle.uv[0], glm::min(triangle.uv[1], triangle.uv[2]))) * size) - 1.0;
  const glm::dvec2 high =
      glm::floor(glm::dvec2(glm::max(triangle.uv[0], glm::max(triangle.uv[1], triangle.uv[2]))) * size) + 1.0;
  const glm::dvec2 span = high - low + 1.0;
  if (span.x * span.y > static_cast<double>(MAX_TEXELS_SEARCHED) ||
      glm::any(glm::greaterThan(glm::abs(low), glm::dvec2(1e9))))
    return luminance(factor);
  double brightest = 0;
  for (int64_t y = static_cast<int64_t>(low.y); y <= static_cast<int64_t>(high.y); ++y)
    for (int64_t x = static_cast<int64_t>(low.x); x <= static_cast<int64_t>(high.x); ++x)
      brightest = std::max(brightest, luminance(factor * glm::dvec3(texel(scene, texture, x, y))));
  return brightest;
}

/// Integral of the spot's falloff over directions: glTF's clamp((c - c_o) / (c_i - c_o))^2, so
/// 2 pi ((1 - c_i) + (c_i - c_o) / 3).
double spot_solid_angle(const interface::Light& light) {
  // The cosine of the inner angle may have been raised above 1 to keep the cone's width.
  const double inner = light.cos_inner;
  const double outer = light.cos_outer;
  const double width = inner - outer;
  const double top = std::min(inner, 1.0);
  const double edge = std::pow((top - outer) / width, 3) * width / 3;
  return 2 * PI * ((1 - top) + edge);
}

}  // namespace

double punctual_power(const interface::Light& light, double scene_radius) {
  const double intensity = luminance(glm::dvec3(light.intensity));
  if (light.kind == interface::LIGHT_POINT) return 4 * PI * intensity;
  if (light.kind == interface::LIGHT_SPOT) return spot_solid_angle(light) * intensity;
  return PI * scene_radius * scene_radius * intensity;
}

double triangle_area(const Scene& scene, const interface::Triangle& triangle) {
  const glm::dvec3 p0(scene.vertices[triangle.v0].position);
  const glm::dvec3 p1(scene.vertices[triangle.v1].position);
  const glm::dvec3 p2(scene.vertices[triangle.v2].position);
  return 0.5 * glm::length(glm::cross(p1 - p0, p2 - p0));
}

double triangle_power(const Scene& scene, const interface::Triangle& triangle, double area) {
  const interface::Material& material = scene.materials[triangle.material];
  const glm::dvec3 factor(material.emission);
  double radiance = luminance(factor);
  if (material.emissive_texture != interface::INVALID_INDEX && radiance > 0) {
    const interface::Texture& texture = scene.textures[material.emissive_texture];
    const TriangleUv uv = triangle_uv(scene, triangle);
    radiance = luminance(factor * average_texture(scene, texture, uv));
    const double brightest = brightest_texel(scene, texture, uv, factor);
    radiance = std::max(radiance, MIN_SHARE_OF_BRIGHTEST * brightest);
  }
  const double sides = (material.flags & interface::MATERIAL_DOUBLE_SIDED) != 0 ? 2 : 1;
  return PI * area * radiance * sides;
}

}  // namespace regulus::scene
