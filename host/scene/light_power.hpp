// Emitted power of lights, by which they are selected.
#pragma once

#include <cstdint>
#include <map>
#include <vector>

#include "scene/scene.hpp"

namespace regulus::scene {

/// Rec. 709 luminance of linear RGB.
double luminance(const glm::dvec3& color);

/// Radiant flux of a punctual light, as luminance: W for radiometric units. Directional lights: the flux
/// through the scene's bounding sphere.
double punctual_power(const interface::Light& light, double scene_radius);

/// Flux of the environment through the scene's bounding sphere, summed over directions.
double environment_power(const Environment& environment, double scene_radius);

/// Flux of emissive triangles.
class TrianglePower {
 public:
  explicit TrianglePower(const Scene& scene) : scene_(scene) {}

  /// With a texture: its average over the triangle by samples, but never 0 unless the texels near the
  /// triangle are all black.
  double operator()(const interface::Triangle& triangle, double area);

 private:
  /// Largest RGB of each block of texels: bounds what a triangle can show without looking at every texel.
  struct BlockMaxima {
    uint32_t columns = 0, rows = 0;
    std::vector<glm::vec3> maximum;
    glm::vec3 overall{0};
  };

  const BlockMaxima& block_maxima(uint32_t texture);
  glm::vec3 brightest(uint32_t texture, const glm::vec2& uv_min, const glm::vec2& uv_max);

  const Scene& scene_;
  std::map<uint32_t, BlockMaxima> maxima_;
};

/// Area of a triangle.
double triangle_area(const Scene& scene, const interface::Triangle& triangle);

}  // namespace regulus::scene
