// Components of vectors.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace regulus {

/// The largest of the three.
inline double largest_component(const glm::dvec3& v) {
  return std::max({v.x, v.y, v.z});
}

/// The largest absolute value of the three.
inline double largest_magnitude(const glm::dvec3& v) {
  return largest_component(glm::abs(v));
}

}  // namespace regulus
