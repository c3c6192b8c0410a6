#include "reference/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace regulus::reference {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

dvec2 sample_disk(const dvec2& u) {
  const dvec2 square = 2.0 * u - 1.0;
  if (square.x == 0 && square.y == 0) return dvec2(0);
  const bool x_is_longer = std::abs(square.x) > std::abs(square.y);
  const double radius = x_is_longer ? square.x : square.y;
  const double angle = x_is_longer ? pi / 4 * square.y / square.x : pi / 2 - pi / 4 * square.x / square.y;
  return radius * dvec2(std::cos(angle), std::sin(angle));
}

dvec3 sample_cosine_hemisphere(const dvec2& u) {
  const dvec2 disk = sample_disk(u);
  return {disk, std::sqrt(std::max(0.0, 1 - dot(disk, disk)))};
}

dvec3 sample_sphere(const dvec2& u) {
  const double z = 1 - 2 * u.x;
  const double sin_theta = std::sqrt(std::max(0.0, 1 - z * z));
  return {sin_theta * std::cos(2 * pi * u.y), sin_theta * std::sin(2 * pi * u.y), z};
}

dvec3 sample_cone(const dvec2& u, double cos_max) {
  const double z = 1 - u.x * (1 - cos_max);
  const double sin_theta = std::sqrt(std::max(0.0, 1 - z * z));
  return {sin_theta * std::cos(2 * pi * u.y), sin_theta * std::sin(2 * pi * u.y), z};
}

dvec2 sample_triangle(const dvec2& u) {
  if (u.y > u.x) return {0.5 * u.x, u.y - 0.5 * u.x};
  return {u.x - 0.5 * u.y, 0.5 * u.y};
}

}  // namespace regulus::reference
