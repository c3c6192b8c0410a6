// The points of the sampler `sobol`, block by block and combined.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <vector>

#include "reference/rng.hpp"

namespace regulus::reference {
namespace {

double number(uint32_t stream, uint32_t sample, uint32_t block, size_t dimension) {
  return sobol_bits(1, stream, sample, block)[dimension] * 0x1p-32;
}

/// Variance of the mean over samples 0 .. count - 1 of f(a, b), a and b of two blocks, over that of
/// independent numbers
/// (`variance` for one); over so many streams.
template <typename Function>
double variance_ratio(uint32_t count, uint32_t streams, double variance, const Function& f) {
  double sum = 0, squares = 0;
  for (uint32_t stream = 0; stream < streams; ++stream) {
    double mean = 0;
    for (uint32_t i = 0; i < count; ++i) mean += f(number(stream, i, 3, 0), number(stream, i, 8, 0)) / count;
    sum += mean;
    squares += mean * mean;
  }
  const double average = sum / streams;
  return (squares / streams - average * average) * count / variance;
}

// Which half of its interval a number lies in is balanced in a group of four. Two samples of a group have
// opposite signs with probability 2/3 (correlation -1/3) in each of two blocks that are paired independently:
// the product of both signs has the variance 1 + 3 (1/3)^2 of independent ones. Were samples 2k and 2k + 1
// opposite in both, it would be 1 + 1. A linear factor is a sum of such signs for each digit, of variances
// 3/4, 3/16, 3/64 ..: two of the group correlate by -(3/4 + 3/16) / 3, the four of the next group by -3/64 /
// 4; that makes 1.2935, where fixed pairs have 1 + (3/4)^2 + 2 (3/32)^2 = 1.5801.
TEST(SobolPoints, ProductsOfBlocksHaveHardlyMoreVarianceThanIndependentNumbers) {
  const double linear = 1 + 3 * std::pow(5.0 / 16, 2) + 4 * std::pow(3.0 / 256, 2);
  for (const auto& [count, streams] : {std::pair(4U, 40000U), {16U, 20000U}, {256U, 2000U}}) {
    const double product =
        variance_ratio(count, streams, 1.0 / 144, [](double a, double b) { return (a - 0.5) * (b - 0.5); });
    const double exclusive = variance_ratio(
        count, streams, 0.25, [](double a, double b) { return (a < 0.5) != (b < 0.5) ? 1.0 : 0.0; });
    // A variance of nearly normal means is known to sqrt(2 / streams), of four samples not quite so well: 5
    // deviations.
    const double bound = 5 * std::sqrt((count == 4 ? 4.0 : 2.0) / streams);
    std::printf("%u samples: product %.3f (%.3f expected), exclusive or %.3f (%.3f), bound %.1f %%\n", count,
                product, linear, exclusive, 4.0 / 3, 100 * bound);
    EXPECT_NEAR(product, linear, bound * linear);
    EXPECT_NEAR(exclusive, 4.0 / 3, bound * 4 / 3);
  }
}

// Whatever a block does with the order, an aligned range of 4, 8, 16 .. samples holds one number in each of
// as many equal intervals, in every dimension; and of the first two, one point in each of as many boxes of
// any shape.
TEST(SobolPoints, AlignedRangesAreNets) {
  for (const uint32_t count : {4U, 8U, 16U, 64U, 256U})
    for (uint32_t stream = 0; stream < 8; ++stream)
      for (const uint32_t first : {0U, count, 3 * count, 16 * count})
        for (uint32_t wide = 1; wide <= count; wide *= 2) {
          std::vector<int> boxes(count, 0), third(count, 0), fourth(count, 0);
          for (uint32_t i = first; i < first + count; ++i) {
            const RandomBits bits = sobol_bits(7, stream, i, 5);
            const auto cell = [&](size_t dimension, uint32_t cells) {
              return static_cast<uint32_t>(bits[dimension] * 0x1p-32 * cells);
            };
            ++boxes[cell(0, wide) * (count / wide) + cell(1, count / wide)];
            ++third[cell(2, count)];
            ++fourth[cell(3, count)];
          }
          const std::vector<int> once(count, 1);
          ASSERT_EQ(boxes, once) << count << " from " << first << ", boxes " << wide << " wide";
          ASSERT_EQ(third, once);
          ASSERT_EQ(fourth, once);
        }
}

}  // namespace
}  // namespace regulus::reference
