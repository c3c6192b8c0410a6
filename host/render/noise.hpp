// How noisy a render is so far, estimated from two states of its film.
#pragma once

#include <cstdint>
#include <limits>

#include "image/image.hpp"
#include "render/film.hpp"

namespace regulus::render {

/// Follows a growing film and estimates the error of its image without a reference.
///
/// With A the mean of the first m samples of a pixel and T that of its first n, (A - T)^2 m / (n - m)
/// estimates the variance of T: without bias for independent samples, and from above for scrambled Sobol
/// points, whose halves make up for each other. Film states are kept at doublings, so m is between n / 4 and
/// n.
class NoiseEstimate {
 public:
  /// Takes in a state of the film; one with as many paths as the last is ignored.
  void observe(const Film& film);

  /// Root of the mean over pixels and channels of variance / (T^2 + image::RELATIVE_EPSILON): an estimate of
  /// the root of relmse (image::Metrics). For light that is so dim that the film's exponent is negative, the
  /// epsilon shrinks with it. NaN until there are two samples of every pixel.
  double relative_error() const { return relative_error_; }

 private:
  uint64_t earlier_paths_ = 0;
  image::Image earlier_image_;
  double relative_error_ = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace regulus::render
