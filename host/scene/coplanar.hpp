// Triangles that overlap in one plane, within what single precision tells apart.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <optional>
#include <vector>

namespace regulus::scene {

struct Scene;

/// A stored triangle that stands for itself.
struct Face {
  std::array<glm::dvec3, 3> corners;
  glm::dvec3 normal;  ///< unit
  double area;        ///< m^2
  uint32_t triangle;
};

/// Nothing if the triangle has no normal.
std::optional<Face> face_of(const Scene& scene, uint32_t triangle);

/// Surfaces that are no further apart count as one: what rays cannot tell apart, a share of the scene's
/// coordinates. m
double distance_of_coincidence(const Scene& scene);

/// True if two faces are in one plane, whichever way they face, and overlap by more than neighbours do.
bool overlap_in_plane(const Face& a, const Face& b, double distance);

/// Calls `visit` for pairs of faces whose planes are near each other, at least all that are one and overlap,
/// until it returns true. Some pairs are visited twice. False if there were too many pairs to visit all.
bool visit_coplanar_pairs(const std::vector<Face>& faces, double distance,
                          const std::function<bool(const Face&, const Face&)>& visit);

}  // namespace regulus::scene
