// The two sides of a surface, for the lobes of a Bsdf.
#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>

namespace regulus::reference {

inline glm::dvec3 mirror_z(const glm::dvec3& w) {
  return {w.x, w.y, -w.z};
}

/// The cosine on the thin side of an interface of relative index `eta`; 0 where a direction on the dense one
/// is reflected totally.
inline double thin_cosine(double cosine, double eta) {
  return eta < 1 ? std::sqrt(std::max(1 - (1 - cosine * cosine) / (eta * eta), 0.0)) : cosine;
}

}  // namespace regulus::reference
