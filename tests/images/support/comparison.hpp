// Statistical comparison of images: Student's t over independent batches, per tile and for the whole image,
// with the correction for many tests.
#pragma once

#include <array>
#include <vector>

#include "image/image.hpp"

namespace regulus::test {

/// Probability that |T| exceeds |t| for Student's t with an even number of degrees of freedom (Abramowitz and
/// Stegun 26.7.4).
double student_two_sided(double t, int even_degrees_of_freedom);

/// A test of many tiles. `worst_p` is the smallest p-value and `bound` the significance of one test after the
/// correction: the test fails if worst_p < bound.
struct TileTest {
  int tests = 0;
  double worst_p = 1, bound = 0;
  double worst_difference = 0, worst_error = 0;  ///< of the worst tile: difference and its standard error
  uint32_t worst_x = 0, worst_y = 0, worst_channel = 0;  ///< in tiles
};

/// Batches that average what is tested, and how it is tested. The number of batches is odd, so that degrees
/// of freedom are even. Tiles of `tile` x `tile` pixels bring the batch means close to the normal
/// distribution.
struct ComparisonOptions {
  uint32_t tile = 4;
  double false_alarm_rate = 1e-4;  ///< of the whole comparison
  double relative_tolerance =
      1e-5;  ///< systematic difference that is not counted: float rounding along a path
};

/// Tests the batches against known values, one RGB triple per pixel.
TileTest test_against(const std::vector<image::Image>& batches, const image::Image& known,
                      const ComparisonOptions& options);

/// Tests that two sets of equally many batches have the same mean. Variances may differ: with n batches each,
/// n - 1 degrees of freedom are counted, the least that Welch's formula can give.
TileTest test_equal(const std::vector<image::Image>& first, const std::vector<image::Image>& second,
                    const ComparisonOptions& options);

/// Both tests per tile and for the mean of the whole image, printed; a failure fails the calling test.
void expect_known(const char* what, const std::vector<image::Image>& batches, const image::Image& known,
                  ComparisonOptions options = {});
void expect_equal(const char* what, const std::vector<image::Image>& first,
                  const std::vector<image::Image>& second, ComparisonOptions options = {});

image::Image uniform_image(uint32_t width, uint32_t height, const std::array<double, 3>& rgb);

/// Mean of each channel.
std::array<double, 3> mean_of(const image::Image& image);

/// Mean of blocks of factor x factor pixels; the size must be a multiple.
image::Image downsampled(const image::Image& image, uint32_t factor);

}  // namespace regulus::test
