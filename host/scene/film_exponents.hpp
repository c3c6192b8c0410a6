// Which numbers a film of the scene has to hold: its sums are fixed-point numbers of 96 bits.
#pragma once

#include <limits>

#include "scene/scene.hpp"

namespace regulus::scene {

/// Estimates what a picture of the scene shows, from its lights.
class FilmRange {
 public:
  FilmRange(const glm::dvec3& scene_center, double scene_radius)
      : center_(scene_center), radius_(scene_radius) {}

  /// Surfaces that show this radiance to the camera, whether they light anything or not. `area`: of all of
  /// them, m^2
  void add_visible(const glm::dvec3& radiance, double area = std::numeric_limits<double>::infinity());
  void add_punctual(const interface::Light& light);
  /// Power of an emissive triangle, as luminance.
  void add_power(double power);
  void add_environment(const Environment& environment);

  /// 0 for ordinary light: what is seen is between 2^-20 and 2^31 at its brightest, and what is lit at least
  /// 2^-30. Otherwise, if it is too bright, the least in whose range 2^24 samples of the brightest fit (fewer
  /// of what is smaller than 2^-23 of the scene, so that it does not hide what it lights); if it is too dim,
  /// the one that makes what is lit about 1, or again the least for the brightest. The exponent of squares
  /// follows in the same way from the squares of these radiances.
  FilmExponents exponents() const;

 private:
  glm::dvec3 center_;
  double radius_;
  double brightest_ = 0;                                 // radiance that is seen
  double largest_sum_ = 0, largest_sum_of_squares_ = 0;  // of samples of what is seen
  double level_ =
      0;  // radiance of a white surface that all lights light, where the scene is its bounding sphere
};

}  // namespace regulus::scene
