// A ray against a triangle in single precision, to the bit as shaders/lib/traversal.glsl tests it: Woop,
// Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2013. What is contracted to fused
// multiply-adds here would differ; the project is compiled without.
#pragma once

#include <array>
#include <glm/glm.hpp>

namespace regulus::rays {

/// What is constant along a ray: its origin, and the frame in which it runs along z.
class TriangleTest {
 public:
  /// The direction must be finite and not zero, the origin finite.
  TriangleTest(const glm::vec3& origin, const glm::vec3& direction);

  struct Result {
    glm::vec3 tuv{};         ///< distance in lengths of the direction; barycentrics of corners 1 and 2
    bool is_inside = false;  ///< edges included
    bool has_area = false;   ///< as the ray sees it; without, `tuv` is not finite
  };
  /// Where the ray meets the plane of a triangle, on either side and at any distance.
  Result run(const std::array<glm::vec3, 3>& corners) const;

 private:
  glm::vec3 exchange(const glm::vec3& v) const;

  glm::vec3 origin_;
  bool x_is_longest_, y_is_longest_;
  glm::vec3 shear_;
};

}  // namespace regulus::rays
