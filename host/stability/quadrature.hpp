// Integration in extended precision by double exponential substitution (Takahasi and Mori 1974), whose nodes
// crowd towards both ends as far as the exponent reaches: features there of any width are resolved.
#pragma once

#include <cmath>
#include <numbers>

#include "stability/sweep.hpp"

namespace regulus::stability {

/// Integral over (0, length) of f, which is given the distance from the lower end and that from the upper
/// one.
template <typename Function>
Exact integrate_to_ends(const Function& f, Exact length, int steps_per_unit = 32) {
  const Exact half_pi = std::numbers::pi_v<Exact> / 2;
  const Exact step = Exact{1} / steps_per_unit;
  Exact sum = 0;
  const int last = 7 * steps_per_unit / 2;  // at 3.5 nodes are within 1e-22 of the ends
  for (int k = -last; k <= last; ++k) {
    const Exact t = step * k;
    const Exact s = half_pi * std::sinh(t);
    const Exact low = length / (1 + std::exp(-2 * s));  // from the lower end
    const Exact high = length / (1 + std::exp(2 * s));
    const Exact weight = half_pi * std::cosh(t) * 2 * low * high / length;
    if (low > 0 && high > 0 && weight > 0) sum += weight * f(low, high);
  }
  return sum * step;
}

}  // namespace regulus::stability
