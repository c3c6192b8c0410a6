#include "scene/light_power.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "scene/texture.hpp"

namespace regulus::scene {
namespace {

using std::numbers::pi;
constexpr int SAMPLES = 64;
constexpr uint32_t BLOCK = 16;         // texels a side of a block of BlockMaxima
constexpr uint64_t MAX_BLOCKS = 1024;  // looked at per triangle; beyond, the whole texture's maximum serves
// A triangle whose samples miss its bright texels is still chosen with this share of its brightest texel.
constexpr double MIN_SHARE_OF_BRIGHTEST = 1e-3;

/// Average over the triangle at points of the R2 sequence (Roberts 2018), which no regular pattern aliases
/// with.
glm::dvec3 average_texture(const Scene& scene, const interface::Texture& texture,
                           const interface::Triangle& triangle) {
  glm::dvec3 sum(0);
  for (int i = 0; i < SAMPLES; ++i) {
    double u = std::fmod(0.5 + 0.7548776662466927 * i, 1.0);
    double v = std::fmod(0.5 + 0.5698402909980532 * i, 1.0);
    if (u + v > 1) {
      u = 1 - u;
      v = 1 - v;
    }
    sum +=
        glm::dvec3(sample_texture(scene, texture, texture_coordinates(scene, triangle, {1 - u - v, u, v})));
  }
  return sum / static_cast<double>(SAMPLES);
}

/// Blocks that the texels low - 1 .. high + 1 of one axis touch; all of them if the range wraps around.
std::pair<uint32_t, uint32_t> block_range(float low, float high, uint32_t size) {
  const double first = std::floor(static_cast<double>(low) * size) - 1;
  const double last = std::floor(static_cast<double>(high) * size) + 1;
  if (!(first >= 0) || !(last < size)) return {0u, (size - 1) / BLOCK};
  return {static_cast<uint32_t>(first) / BLOCK, static_cast<uint32_t>(last) / BLOCK};
}

/// Integral of the spot's falloff over directions: glTF's clamp((c - c_o) / (c_i - c_o))^2, so
/// 2 pi ((1 - c_i) + (c_i - c_o) / 3).
double spot_solid_angle(const interface::Light& light) {
  const double inner = light.inner_height;
  return 2 * pi * (inner + (light.outer_height - inner) / 3);
}

}  // namespace

double luminance(const glm::dvec3& color) {
  return 0.2126 * color.r + 0.7152 * color.g + 0.0722 * color.b;
}

double punctual_power(const interface::Light& light, double scene_radius) {
  const double intensity = luminance(glm::dvec3(light.intensity));
  if (light.kind == interface::LIGHT_POINT) return 4 * pi * intensity;
  if (light.kind == interface::LIGHT_SPOT) return spot_solid_angle(light) * intensity;
  return pi * scene_radius * scene_radius * intensity;
}

double environment_power(const Environment& environment, double scene_radius) {
  return pi * scene_radius * scene_radius * environment.integral;
}

double triangle_area(const Scene& scene, const interface::Triangle& triangle) {
  const glm::dvec3 p0(scene.vertices[triangle.v0].position);
  const glm::dvec3 p1(scene.vertices[triangle.v1].position);
  const glm::dvec3 p2(scene.vertices[triangle.v2].position);
  return 0.5 * glm::length(glm::cross(p1 - p0, p2 - p0));
}

const TrianglePower::BlockMaxima& TrianglePower::block_maxima(uint32_t texture_index) {
  const auto [entry, is_new] = maxima_.try_emplace(texture_index);
  BlockMaxima& blocks = entry->second;
  if (!is_new) return blocks;
  const interface::Texture& texture = scene_.textures[texture_index];
  blocks.columns = (texture.width - 1) / BLOCK + 1;
  blocks.rows = (texture.height - 1) / BLOCK + 1;
  blocks.maximum.assign(static_cast<size_t>(blocks.columns) * blocks.rows, glm::vec3(0));
  for (uint32_t y = 0; y < texture.height; ++y)
    for (uint32_t x = 0; x < texture.width; ++x) {
      glm::vec3& maximum = blocks.maximum[static_cast<size_t>(y / BLOCK) * blocks.columns + x / BLOCK];
      maximum = glm::max(maximum, glm::vec3(texel(scene_, texture, x, y)));
      blocks.overall = glm::max(blocks.overall, maximum);
    }
  return blocks;
}

glm::vec3 TrianglePower::brightest(uint32_t texture_index, const glm::vec2& uv_min, const glm::vec2& uv_max) {
  const interface::Texture& texture = scene_.textures[texture_index];
  const BlockMaxima& blocks = block_maxima(texture_index);
  const auto [first_column, last_column] = block_range(uv_min.x, uv_max.x, texture.width);
  const auto [first_row, last_row] = block_range(uv_min.y, uv_max.y, texture.height);
  if (uint64_t{last_column - first_column + 1} * (last_row - first_row + 1) > MAX_BLOCKS)
    return blocks.overall;
  glm::vec3 maximum(0);
  for (uint32_t row = first_row; row <= last_row; ++row)
    for (uint32_t column = first_column; column <= last_column; ++column)
      maximum = glm::max(maximum, blocks.maximum[static_cast<size_t>(row) * blocks.columns + column]);
  return maximum;
}

double TrianglePower::operator()(const interface::Triangle& triangle, double area) {
  const interface::Material& material = scene_.materials[triangle.material];
  const glm::dvec3 factor(material.emission);
  double radiance = luminance(factor);
  if (material.emissive_texture != interface::INVALID_INDEX) {
    const interface::Texture& texture = scene_.textures[material.emissive_texture];
    glm::vec2 uv[3];
    for (int i = 0; i < 3; ++i)
      uv[i] =
          image_coordinates(scene_, texture, texture_coordinates(scene_, triangle, {i == 0, i == 1, i == 2}));
    const glm::dvec3 largest(brightest(material.emissive_texture, glm::min(uv[0], glm::min(uv[1], uv[2])),
                                       glm::max(uv[0], glm::max(uv[1], uv[2]))));
    radiance = MIN_SHARE_OF_BRIGHTEST * luminance(factor * largest);
    if (radiance > 0)
      radiance = std::max(radiance, luminance(factor * average_texture(scene_, texture, triangle)));
  }
  const double sides = (material.flags & interface::MATERIAL_DOUBLE_SIDED) != 0 ? 2 : 1;
  return pi * area * radiance * sides;
}

}  // namespace regulus::scene
