// Statistical comparison of images: Student's t over independent batches, per tile and for the whole image,
// with the correction for many tests.
#pragma once

#include <functional>
#include <utility>
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

/// A tile that fails its test.
struct Alarm {
  uint32_t tile = 1;                   ///< pixels of its side
  uint32_t x = 0, y = 0, channel = 0;  ///< in tiles
  double difference = 0;               ///< first less second
};

/// A test of many tiles. `worst_p` is the smallest p-value and `bound` the significance of one test after the
/// correction: the test fails if worst_p < bound.
struct TileTest {
  int tests = 0;
  double worst_p = 1, bound = 0;
  double worst_difference = 0, worst_error = 0;  ///< of the worst tile: difference and its standard error
  uint32_t worst_x = 0, worst_y = 0, worst_channel = 0;  ///< in tiles
  std::vector<Alarm> alarms;                             ///< all that fail

  bool is_passed() const { return worst_p >= bound; }
};

/// How batches are tested. Tiles of `tile` x `tile` pixels bring the batch means close to the normal
/// distribution.
struct ComparisonOptions {
  uint32_t tile = 4;
  double false_alarm_rate = 1e-4;  ///< of the whole comparison
  double relative_tolerance =
      1e-5;  ///< systematic difference that is not counted: float rounding along a path
  /// How many samples of a pixel the batches of a set hold when they raise an alarm: for settle(). 0: both
  /// sets meet the same light as often, so that none can be hidden from one of them.
  uint64_t samples = 0;
  double brightest = 0;  ///< the most that a sample is known to be, whether or not the batches met it
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

/// How many standard errors a difference has from which on one of `tests` tests of so many batches raises an
/// alarm. Of few batches the standard error is so uncertain that it takes thousands.
double standard_errors_of_alarm(int batches, int tests, double false_alarm_rate);

/// Two sets of equally many batches of as many samples as `times` says, over those that raised the alarm, and
/// independent of all that were asked for before.
using FreshBatches = std::function<std::pair<std::vector<Image>, std::vector<Image>>(uint32_t times)>;

/// What more samples made of alarms.
struct Settled {
  std::vector<Alarm> confirmed, withdrawn;
  std::vector<Alarm> open;  ///< neither, with the most samples that were tried
  uint32_t times = 1;       ///< how many samples the last round had, over those of the alarm

  bool is_passed() const { return confirmed.empty() && open.empty(); }
  bool is_undecided() const { return confirmed.empty() && !open.empty(); }
};

/// Settles the alarms of test_equal() on fresh batches with 4, 16 and 64 times the samples. An alarm is
/// confirmed if its tile differs again, to the same side; and withdrawn if the interval of confidence of its
/// difference leaves out half of the difference that raised it. A set that light reaches once in more samples
/// than it has does not see that light, nor does its spread. What can hide so, if it is as bright as the
/// brightest sample that either set met anywhere in the picture, or as `options.brightest`, is no difference
/// that confirms. All tests of all rounds together raise a false alarm with `options.false_alarm_rate`, and
/// withdraw a difference that is half of what was seen, or more, with that probability.
Settled settle(std::vector<Alarm> alarms, const FreshBatches& fresh, const ComparisonOptions& options);

}  // namespace regulus::image
