// Moves the numbers of a walk as single precision may, to measure how well conditioned its results are.
#pragma once

#include <cstdint>

#include "reference/world.hpp"

namespace regulus::reference {

constexpr double UNIT_ROUNDOFF = 0x1p-24;  ///< of single precision

/// A sequence of moves, different for every pattern, stream, sample and place.
class Rounding {
 public:
  /// Pattern 0 moves nothing.
  Rounding(uint32_t pattern, uint32_t stream, uint32_t sample, uint32_t place);

  bool is_on() const { return is_on_; }

  /// x moved up or down, evenly distributed, by `amount` in the root mean square.
  double moved(double x, double amount);

 private:
  bool is_on_;
  uint64_t bits_;
};

/// How far off a surface, in m, rays in single precision have to start so as not to meet it again: the
/// triangle test for an origin on the triangle errs by 20 roundings of E (E^2 / 2 area), E being the distance
/// to its farthest vertex. For needles only a part of that is provided.
double clearance(const World& world, const Surface& surface);

/// The ray as single precision may have left it: origin and direction moved by two roundings. From a surface
/// it starts anywhere between there and the distance at which single precision is sure not to meet the
/// surface's own triangle again. `start`: that surface, or null.
Ray rounded(const World& world, const Ray& ray, const Surface* start, Rounding& rounding);

}  // namespace regulus::reference
