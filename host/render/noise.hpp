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
/// points, whose halves compensate for each other. Film states are kept at doublings, and an estimate takes a
/// quarter more samples than the state that it is compared with, so m is between n / 4 and 4 n / 5. Between
/// two estimates the last one is scaled by the root of the share of samples that it had.
class NoiseEstimate {
 public:
  /// Takes in a state of the film; one with no more paths than the last is ignored.
  void observe(const Film& film);

  /// Root of the mean over pixels and channels of variance / (T^2 + image::RELATIVE_EPSILON): an estimate of
  /// the root of relmse (image::Metrics). For light that is so dim that the film's exponent is negative, the
  /// epsilon shrinks with it. NaN until there are two samples of every pixel.
  double relative_error() const;

 private:
  uint64_t earlier_paths_ = 0, observed_paths_ = 0;
  image::Image earlier_image_;
  double estimate_ = std::numeric_limits<double>::quiet_NaN();  // of the film with estimated_paths_
  uint64_t estimated_paths_ = 0;
};

}  // namespace regulus::render
