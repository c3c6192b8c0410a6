// Mappings from uniform numbers to points and directions, in double precision, with their densities. Each is
// the textbook inversion, written to be checked, not to be fast.
#pragma once

#include <glm/glm.hpp>

namespace regulus::reference {

/// Uniform on the unit disk (density 1 / pi). Shirley and Chiu 1997, concentric map.
glm::dvec2 sample_disk(const glm::dvec2& u);

/// Cosine-weighted on the hemisphere z > 0 (density z / pi). Malley's method.
glm::dvec3 sample_cosine_hemisphere(const glm::dvec2& u);

/// Uniform on the unit sphere (density 1 / (4 pi)).
glm::dvec3 sample_sphere(const glm::dvec2& u);

/// Uniform in the cone about z with cos(theta) >= cos_max (density 1 / (2 pi (1 - cos_max))).
glm::dvec3 sample_cone(const glm::dvec2& u, double cos_max);

/// Barycentrics (of the second and third vertex) of a uniform point of a triangle (density 1 / area).
/// Heitz 2019, A Low-Distortion Map Between Triangle and Square.
glm::dvec2 sample_triangle(const glm::dvec2& u);

}  // namespace regulus::reference
