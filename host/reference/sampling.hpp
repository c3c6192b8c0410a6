// Mappings from uniform numbers to points and directions, in double precision, with their densities. Each is
// the textbook inversion, written to be checked, not to be fast.
#pragma once

#include <glm/glm.hpp>

namespace regulus::reference {

/// The largest number below 1 that single precision has.
inline constexpr double BELOW_ONE = 1 - 0x1p-24;

/// Uniform on the unit disk (density 1 / pi). Shirley and Chiu 1997, concentric map.
glm::dvec2 sample_disk(const glm::dvec2& u);

/// Cosine-weighted on the hemisphere z > 0 (density z / pi). Malley's method.
glm::dvec3 sample_cosine_hemisphere(const glm::dvec2& u);

/// Uniform on the unit sphere (density 1 / (4 pi)).
glm::dvec3 sample_sphere(const glm::dvec2& u);

/// Its inverse, below 1.
glm::dvec2 sphere_numbers(const glm::dvec3& w);

/// Share of a turn, in [0, 1), at which a direction lies around the z axis.
double turn_of(const glm::dvec3& w);

/// Uniform in the cone about z with cos(theta) >= cos_max (density 1 / (2 pi (1 - cos_max))).
glm::dvec3 sample_cone(const glm::dvec2& u, double cos_max);

/// Barycentrics (of the second and third vertex) of a uniform point of a triangle (density 1 / area).
/// Heitz 2019, A Low-Distortion Map Between Triangle and Square.
glm::dvec2 sample_triangle(const glm::dvec2& u);

/// x with erf(x) = y, |y| < 1. Found by bisection of the library's erf; absolute error below 1e-15.
double erf_inverse(double y);

/// x >= 0 with erfc(x) = complement, complement in (0, 1]: accurate where erf(x) is near 1.
double erfc_inverse(double complement);

/// Tangents that complete a unit normal to a right-handed orthonormal basis.
/// Duff et al. 2017, Building an Orthonormal Basis, Revisited.
struct Basis {
  glm::dvec3 tangent, bitangent, normal;

  explicit Basis(const glm::dvec3& unit_normal);
  /// With a given unit tangent, orthogonal to the normal.
  Basis(const glm::dvec3& unit_tangent, const glm::dvec3& unit_normal)
      : tangent(unit_tangent), bitangent(cross(unit_normal, unit_tangent)), normal(unit_normal) {}
  glm::dvec3 to_local(const glm::dvec3& w) const {
    return {dot(w, tangent), dot(w, bitangent), dot(w, normal)};
  }
  glm::dvec3 to_world(const glm::dvec3& w) const { return w.x * tangent + w.y * bitangent + w.z * normal; }
};

}  // namespace regulus::reference
