// Statistical comparison of images: Student's t over independent batches, per tile and for the whole image,
// with the correction for many tests.
#pragma once

#include <vector>

#include "image/image.hpp"

namespace regulus::image {

/// Significance of each of `tests` independent tests that together raise a false alarm with probability
/// `family_rate` (Sidak).
double significance_per_test(double family_rate, int tests);

/// Probability that |T| exceeds |t| for Student's t (Abramowitz and Stegun 26.7.3 and 26.7.4).
double student_two_sided(double t, int degrees_of_freedom);

/// Mean of a channel over a tile of `tile` x `tile` pixels (partial at the right and lower edge).
double tile_mean(const Image& image, uint32_t tile_x, uint32_t tile_y, uint32_t tile, uint32_t channel);

/// A test of many tiles. `worst_p` is the smallest p-value and `bound` the significance of one test after the
/// correction: the test fails if worst_p < bound.
struct TileTest {
  int tests = 0;
  double worst_p = 1, bound = 0;
  double worst_difference = 0, worst_error = 0;  ///< of the worst tile: difference and its standard error
  uint32_t worst_x = 0, worst_y = 0, worst_channel = 0;  ///< in tiles

  bool is_passed() const { return worst_p >= bound; }
};

/// How batches are tested. Tiles of `tile` x `tile` pixels bring the batch means close to the normal
/// distribution.
struct ComparisonOptions {
  uint32_t tile = 4;
  double false_alarm_rate = 1e-4;  ///< of the whole comparison
  double relative_tolerance =
      1e-5;  ///< systematic difference that is not counted: float rounding along a path
};

/// Tests the batches against known values, one RGB triple per pixel. At least two batches.
TileTest test_against(const std::vector<Image>& batches, const Image& known,
                      const ComparisonOptions& options);

/// Tests that two sets of equally many batches have the same mean. Variances may differ: with n batches each,
/// n - 1 degrees of freedom are counted, the least that Welch's formula can give. Of two sets of the same
/// distribution differences are symmetric however skewed the values are, and rare bright ones make the test
/// milder; sets whose distributions differ need batches in which nothing is rare.
TileTest test_equal(const std::vector<Image>& first, const std::vector<Image>& second,
                    const ComparisonOptions& options);

}  // namespace regulus::image
