#include "reference/rounding.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace regulus::reference {

using glm::dvec3;

namespace {

/// Steele, Lea and Flood, "Fast Splittable Pseudorandom Number Generators", 2014.
uint64_t mixed(uint64_t z) {
  z += 0x9E3779B97F4A7C15;
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EB;
  return z ^ (z >> 31);
}

}  // namespace

double clearance(const World& world, const Surface& surface) {
  constexpr double MOST_OF_A_NEEDLE = 64;
  double extent = 0;
  for (const glm::vec3& vertex : placed_positions(world.scene(), surface.triangle))
    extent = std::max(extent, length(dvec3(vertex) - surface.position));
  return 20 * UNIT_ROUNDOFF * extent * std::min(extent * extent / (2 * surface.area), MOST_OF_A_NEEDLE);
}

Rounding::Rounding(uint32_t pattern, uint32_t stream, uint32_t sample, uint32_t place)
    : is_on_(pattern != 0), bits_(pattern) {
  for (const uint32_t key : {stream, sample, place}) bits_ = mixed(bits_ ^ key);
}

double Rounding::moved(double x, double amount) {
  if (!is_on_) return x;
  bits_ = mixed(bits_);
  // If all moves had one size, those of a segment's two ends would often cancel exactly, as roundings do not.
  const double share = std::numbers::sqrt3 * (std::ldexp(static_cast<double>(bits_ >> 11), -52) - 1);
  return x + share * amount;
}

Ray rounded(const World& world, const Ray& ray, const Surface* start, Rounding& rounding) {
  Ray moved = ray;
  if (start != nullptr) {
    const double side = dot(ray.direction, start->geometric_normal) < 0 ? -1 : 1;
    const double share = std::clamp(rounding.moved(0.5, 0.5), 0.0, 1.0);
    moved.origin += side * share * clearance(world, *start) * start->geometric_normal;
  }
  const dvec3 size = glm::abs(ray.origin);
  const double largest = std::max({size.x, size.y, size.z});
  for (int axis = 0; axis < 3; ++axis) {
    moved.origin[axis] = rounding.moved(moved.origin[axis], 2 * UNIT_ROUNDOFF * largest);
    moved.direction[axis] = rounding.moved(ray.direction[axis], 2 * UNIT_ROUNDOFF);
  }
  moved.direction = normalize(moved.direction);
  return moved;
}

}  // namespace regulus::reference
