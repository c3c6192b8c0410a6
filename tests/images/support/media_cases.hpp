// Solids that nest, overlap and touch, with what is seen through them in closed form: for device and
// reference alike.
#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "images/support/gltf_scene.hpp"

namespace regulus::test {

/// A picture that is one colour.
struct MediaCase {
  std::string name;
  GltfScene scene;
  double radiance;
  double relative = 1e-4;  ///< of single precision, and of what the number leaves out
  bool is_random = true;   ///< paths are cut by roulette or choose between reflection and refraction

  /// Bound on the error of the mean over so many paths, none of which carries more than 1: five standard
  /// errors.
  double bound(double paths) const {
    return relative * radiance +
           (is_random ? 5 * std::sqrt(radiance * std::max(1 - radiance, 0.0) / paths) : 0);
  }
};

/// Cameras within media, media within media, overlaps with and without priorities, contacts.
std::vector<MediaCase> media_cases();

/// Slabs of an index of 1 and one of 1.5 that are as thin as single precision has them, upright and tilted,
/// with what the thickness in the file absorbs.
std::vector<MediaCase> thin_slabs();

/// An emitter seen on a film of which a half, as wide as the block's half, lies in an absorbing block.
MediaCase half_in_a_block();

/// A floor below a lamp that stands in an absorbing block without an index: radiance of the floor at its
/// points.
GltfScene lamp_in_block();
double floor_below_lamp(const glm::dvec3& point);

/// A lit panel over a floor, one half of it in an absorbing block without an index.
GltfScene panel_across_block();

/// A floor below two lamps of radiance 10 and 30 in the plane of a black ceiling, which overlap by a quarter,
/// where the first one is: mean radiance of the floor that the camera sees.
GltfScene overlapping_lamps();
double floor_below_lamps();

}  // namespace regulus::test
