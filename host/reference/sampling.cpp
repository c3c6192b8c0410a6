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

double turn_of(const dvec3& w) {
  const double turn = std::atan2(w.y, w.x) / (2 * pi);
  return std::min(turn < 0 ? turn + 1 : turn, BELOW_ONE);
}

dvec2 sphere_numbers(const dvec3& w) {
  return {std::clamp((1 - w.z) / 2, 0.0, BELOW_ONE), turn_of(w)};
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

double erfc_inverse(double complement) {
  double low = 0;
  double high = 30;  // erfc(30) underflows
  for (int step = 0; step < 64; ++step) {
    const double middle = 0.5 * (low + high);
    (std::erfc(middle) > complement ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

double erf_inverse(double y) {
  const double magnitude = erfc_inverse(1 - std::abs(y));
  return y < 0 ? -magnitude : magnitude;
}

Basis::Basis(const dvec3& n) : normal(n) {
  const double side = n.z < 0 ? -1 : 1;
  const double a = -1 / (side + n.z);
  const double b = n.x * n.y * a;
  tangent = dvec3(1 + side * n.x * n.x * a, side * b, -side * n.x);
  bitangent = dvec3(b, side + n.y * n.y * a, -n.y);
}

}  // namespace regulus::reference
