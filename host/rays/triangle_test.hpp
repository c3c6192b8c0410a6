// A ray against a triangle in single precision, to the bit as shaders/lib/traversal.glsl tests it: Woop,
// Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013. What is contracted to fused
// multiply-adds here would differ; the project is compiled without. All inline: it
// runs for every ray that meets something.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/glm.hpp>

namespace regulus::rays {

/// What is constant along a ray: its origin, and the frame in which it runs along z.
class TriangleTest {
 public:
  /// The direction must be finite and not zero, the origin finite.
  TriangleTest(const glm::vec3& origin, const glm::vec3& direction) : origin_(origin) {
    const glm::vec3 size = glm::abs(direction);
    const bool x_is_longest = size.x > size.y && size.x >= size.z;
    const bool y_is_longest = !x_is_longest && size.y > size.z;
    if (x_is_longest) axes_ = {2, 1, 0};
    if (y_is_longest) axes_ = {0, 2, 1};
    const glm::vec3 exchanged = exchange(direction);
    shear_ = {exchanged.x / exchanged.z, exchanged.y / exchanged.z, 1 / exchanged.z};
  }

  struct Result {
    glm::vec3 tuv{};         ///< distance in lengths of the direction; barycentrics of corners 1 and 2
    bool is_inside = false;  ///< edges included
    bool has_area = false;   ///< as the ray sees it; without, `tuv` is not finite
  };
  /// Where the ray meets the plane of a triangle, on either side and at any distance.
  Result run(const std::array<glm::vec3, 3>& corners) const {
    const glm::vec3 a = exchange(corners[0] - origin_);
    const glm::vec3 b = exchange(corners[1] - origin_);
    const glm::vec3 c = exchange(corners[2] - origin_);
    const glm::vec2 a_sheared = sheared(a), b_sheared = sheared(b), c_sheared = sheared(c);
    const float edge_a = edge(c_sheared, b_sheared);
    const float edge_b = edge(a_sheared, c_sheared);
    const float edge_c = edge(b_sheared, a_sheared);
    const float determinant = edge_a + edge_b + edge_c;
    const float inverse = 1 / determinant;
    const float t = (edge_a * a.z + edge_b * b.z + edge_c * c.z) * shear_.z;
    const bool is_inside = std::min({edge_a, edge_b, edge_c}) >= 0 || std::max({edge_a, edge_b, edge_c}) <= 0;
    return {glm::vec3(t, edge_b, edge_c) * inverse, is_inside, determinant != 0 && std::isfinite(inverse)};
  }

 private:
  glm::vec3 exchange(const glm::vec3& v) const { return {v[axes_[0]], v[axes_[1]], v[axes_[2]]}; }
  glm::vec2 sheared(const glm::vec3& v) const { return {v.x - shear_.x * v.z, v.y - shear_.y * v.z}; }
  static float edge(const glm::vec2& p, const glm::vec2& q) { return p.x * q.y - p.y * q.x; }

  glm::vec3 origin_;
  std::array<int, 3> axes_ = {0, 1, 2};  ///< exchanges the longest axis of the direction with z
  glm::vec3 shear_;
};

}  // namespace regulus::rays
