// The Sobol sampler: the published sequence, the net properties that scrambling and shuffling must keep, and
// the independence of streams and blocks.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "reference/rng.hpp"
#include "support/chi_square.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

using reference::RandomBits;

/// A random seed, stream or block.
uint32_t draw(Random& random) {
  return static_cast<uint32_t>(random.uniform() * 0x1p32);
}

// The first ten points as Joe and Kuo print them beside their tables (in Gray-code order; three dimensions),
// and the first eight in four dimensions.
TEST(Sobol, IsTheSequenceOfJoeAndKuo) {
  constexpr double PUBLISHED[10][3] = {{0, 0, 0},
                                       {0.5, 0.5, 0.5},
                                       {0.75, 0.25, 0.25},
                                       {0.25, 0.75, 0.75},
                                       {0.375, 0.375, 0.625},
                                       {0.875, 0.875, 0.125},
                                       {0.625, 0.125, 0.875},
                                       {0.125, 0.625, 0.375},
                                       {0.1875, 0.3125, 0.9375},
                                       {0.6875, 0.8125, 0.4375}};
  constexpr double FOURTH[8] = {0, 0.5, 0.25, 0.75, 0.875, 0.375, 0.625, 0.125};
  for (uint32_t i = 0; i < 10; ++i) {
    const RandomBits point = reference::sobol(i ^ i >> 1);
    for (size_t d = 0; d < 3; ++d) EXPECT_EQ(point[d] * 0x1p-32, PUBLISHED[i][d]) << i << ' ' << d;
    if (i < 8) {
      EXPECT_EQ(point[3] * 0x1p-32, FOURTH[i]) << i;
    }
  }
}

/// Checks that of 2^m points every elementary interval of volume 2^(t - m) holds 2^t. `digits`: log2 of the
/// number of slices along each of the dimensions; they sum up to m - t.
void expect_equal_counts(const std::vector<RandomBits>& points, const std::array<uint32_t, 4>& digits,
                         uint32_t expected) {
  std::vector<uint32_t> counts(points.size() / expected);
  for (const RandomBits& point : points) {
    size_t cell = 0;
    for (size_t d = 0; d < 4; ++d)
      cell = cell << digits[d] | (digits[d] == 0 ? 0 : point[d] >> (32 - digits[d]));
    ++counts[cell];
  }
  for (const uint32_t count : counts)
    ASSERT_EQ(count, expected) << digits[0] << ' ' << digits[1] << ' ' << digits[2] << ' ' << digits[3];
}

/// Aligned run `run` of 2^m samples of a block.
std::vector<RandomBits> samples_of(Random& random, uint32_t m, uint32_t run) {
  const uint32_t seed = draw(random), stream = draw(random), block = draw(random);
  std::vector<RandomBits> points;
  for (uint32_t i = 0; i < 1u << m; ++i)
    points.push_back(reference::sobol_bits(seed, stream, (run << m) + i, block));
  return points;
}

// Every aligned run of 2^m samples is a (0, m, 2)-net in the first two components and a (0, m, 1)-net in
// each.
TEST(Sobol, FirstPairOfABlockIsAZeroTwoSequence) {
  Random random(62);
  for (uint32_t m = 0; m <= 10; ++m)
    for (uint32_t run = 0; run < 6; ++run) {
      const std::vector<RandomBits> points = samples_of(random, m, run);
      for (uint32_t first = 0; first <= m; ++first)
        ASSERT_NO_FATAL_FAILURE(expect_equal_counts(points, {first, m - first, 0, 0}, 1));
      for (size_t d = 0; d < 4; ++d) {
        std::array<uint32_t, 4> digits{};
        digits[d] = m;
        ASSERT_NO_FATAL_FAILURE(expect_equal_counts(points, digits, 1));
      }
    }
}

// t is the sum of (degree - 1) over the primitive polynomials (Sobol 1967): 0 + 0 + 1 + 2 for all four
// dimensions, 1 and 2 less for the pairs without one of them.
TEST(Sobol, BlockIsAThreeMFourNet) {
  constexpr uint32_t M = 10;
  const auto expect_net = [](const std::vector<RandomBits>& points, uint32_t t,
                             std::array<bool, 4> takes_part) {
    for (uint32_t code = 0; code < 1u << (4 * 4); ++code) {
      std::array<uint32_t, 4> digits{};
      uint32_t sum = 0;
      bool is_excluded = false;
      for (size_t d = 0; d < 4; ++d) {
        digits[d] = code >> (4 * d) & 15;
        sum += digits[d];
        is_excluded = is_excluded || (digits[d] != 0 && !takes_part[d]);
      }
      if (sum == M - t && !is_excluded) {
        ASSERT_NO_FATAL_FAILURE(expect_equal_counts(points, digits, 1u << t));
      }
    }
  };
  Random random(63);
  for (uint32_t run = 0; run < 8; ++run) {
    const std::vector<RandomBits> points = samples_of(random, M, run);
    ASSERT_NO_FATAL_FAILURE(expect_net(points, 3, {true, true, true, true}));
    ASSERT_NO_FATAL_FAILURE(expect_net(points, 1, {true, true, true, false}));
    ASSERT_NO_FATAL_FAILURE(expect_net(points, 2, {true, true, false, true}));
    ASSERT_NO_FATAL_FAILURE(expect_net(points, 3, {false, false, true, true}));
  }
}

// Over streams every sample is uniform, and so is every pair of numbers that meet in a path: components of
// one block, of neighbouring blocks, of neighbouring samples and of neighbouring streams.
TEST(Sobol, NumbersAreUniformAndPairwiseIndependentOverStreams) {
  constexpr uint32_t SAMPLES = 64, BLOCKS = 6, SIDE = 16;
  constexpr uint32_t STREAMS = 8'000;
  struct Offset {
    uint32_t stream, sample, block;
  };
  constexpr Offset OFFSETS[] = {{0, 0, 0}, {0, 0, 1}, {0, 0, 2}, {0, 1, 0},
                                {1, 0, 0}, {1, 0, 1}, {1, 1, 0}, {640, 0, 0}};
  int tests = 0;
  double worst = 1;
  const auto seed = static_cast<uint32_t>(base_seed());
  const std::vector<double> expected(SIDE * SIDE, double{STREAMS} / (SIDE * SIDE));
  for (const Offset& offset : OFFSETS)
    for (const uint32_t sample : {0u, 1u, SAMPLES - 1})
      for (const uint32_t block : {0u, 1u, BLOCKS})
        for (size_t other = 0; other < 4; ++other) {
          const size_t own = offset.stream + offset.sample + offset.block == 0 ? (other + 1) % 4 : 0;
          std::vector<double> observed(SIDE * SIDE);
          for (uint32_t stream = 0; stream < STREAMS; ++stream) {
            const uint32_t x = reference::sobol_bits(seed, 2 * stream, sample, block)[own];
            const uint32_t y = reference::sobol_bits(seed, 2 * stream + offset.stream, sample + offset.sample,
                                                     block + offset.block)[other];
            observed[(x >> 28) * SIDE + (y >> 28)] += 1;
          }
          // Neighbouring samples of one component never share a half: left to the net tests.
          if (offset.sample == 1 && offset.stream == 0 && other == own) continue;
          ++tests;
          worst = std::min(worst, chi_square_test(observed, expected).p_value);
        }
  const double bound = significance_per_test(1e-6, tests);
  std::printf("%d tests, smallest p %.3g (bound %.3g)\n", tests, worst, bound);
  EXPECT_GT(worst, bound);
}

// Mean square over streams of the mean of (x - 1/2)(y - 1/2) over the first 2^m samples, x and y from two
// blocks, if order and digits are scrambled ideally (nested uniform scrambling, Owen 1995). Two points that
// agree in their first k digits and differ in the next have covariance c_k; two samples whose indices differ
// highest in bit h agree in their first k < h digits with probability 2^-(k + 1), in h of them with 2^-h, for
// x and y independently.
double ideal_interaction(uint32_t m) {
  const auto covariance = [](uint32_t k) {
    return ((1 - std::pow(4.0, -double(k))) / 3 - std::pow(4.0, -(k + 1.0))) / 4;
  };
  double sum = 1.0 / 144;
  for (uint32_t h = 0; h < m; ++h) {
    double mean = std::pow(2.0, -double(h)) * covariance(h);
    for (uint32_t k = 0; k < h; ++k) mean += std::pow(2.0, -(k + 1.0)) * covariance(k);
    sum += std::pow(2.0, double(h)) * mean * mean;
  }
  return sum / std::pow(2.0, double(m));
}

// Within a stream the samples of different blocks must meet at random: the shuffled order sees to that.
// Without it this mean square would not fall with the number of samples at all.
TEST(Sobol, BlocksOfAStreamMeetAtRandom) {
  constexpr uint32_t M = 4, STREAMS = 4000;
  const auto seed = static_cast<uint32_t>(base_seed());
  const double known = ideal_interaction(M);
  for (const size_t component : {0u, 1u, 2u, 3u})
    for (const uint32_t other_block : {2u, 3u, 7u}) {
      double sum = 0, squares = 0;
      for (uint32_t stream = 0; stream < STREAMS; ++stream) {
        double mean = 0;
        for (uint32_t sample = 0; sample < 1u << M; ++sample) {
          const double x = reference::unit_interval(reference::sobol_bits(seed, stream, sample, 1)[0]);
          const double y =
              reference::unit_interval(reference::sobol_bits(seed, stream, sample, other_block)[component]);
          mean += (x - 0.5) * (y - 0.5) / (1u << M);
        }
        sum += mean * mean;
        squares += mean * mean * mean * mean;
      }
      const double ratio = sum / STREAMS / known;
      const double error = std::sqrt((squares / STREAMS - sum / STREAMS * sum / STREAMS) / STREAMS) / known;
      std::printf("block 1 with component %zu of block %u: %.3f +- %.3f of the ideal\n", component,
                  other_block, ratio, error);
      EXPECT_NEAR(ratio, 1, 5 * error);
    }
}

// The mean over streams is the integral, and its error with n samples falls faster than independent numbers
// allow.
TEST(Sobol, EstimatesAreUnbiasedAndTheirErrorFallsFaster) {
  constexpr uint32_t STREAMS = 2000, SAMPLES = 256;
  const auto seed = static_cast<uint32_t>(base_seed());
  // A smooth function of four variables with integral 1 and variance (13/12)^4 - 1, and the quarter disk,
  // which has an edge: pi / 4.
  const auto smooth = [](const std::array<double, 4>& u) {
    return (u[0] + 0.5) * (u[1] + 0.5) * (u[2] + 0.5) * (u[3] + 0.5);
  };
  const auto disk = [](const std::array<double, 4>& u) { return u[0] * u[0] + u[1] * u[1] < 1 ? 1.0 : 0.0; };
  const auto test = [&](const char* name, const auto& function, double integral, double variance,
                        double gain) {
    double sum = 0, squares = 0;
    for (uint32_t stream = 0; stream < STREAMS; ++stream) {
      double mean = 0;
      for (uint32_t sample = 0; sample < SAMPLES; ++sample) {
        const RandomBits bits = reference::sobol_bits(seed, stream, sample, 3);
        std::array<double, 4> u{};
        for (size_t d = 0; d < 4; ++d) u[d] = reference::unit_interval(bits[d]);
        mean += function(u) / SAMPLES;
      }
      sum += mean - integral;
      squares += (mean - integral) * (mean - integral);
    }
    const double mean_square = squares / STREAMS, ratio = mean_square * SAMPLES / variance;
    const double sigmas = sum / STREAMS / std::sqrt(mean_square / STREAMS);
    std::printf("%s: variance %.4f of independent samples' (bound %g), mean off by %.2f standard errors\n",
                name, ratio, gain, sigmas);
    EXPECT_LT(std::abs(sigmas), 5);
    EXPECT_LT(ratio, gain);
  };
  test("smooth", smooth, 1, std::pow(13.0 / 12, 4) - 1, 0.05);
  // An edge crosses about 2 sqrt(n) of the n elementary squares: variance n^-1.5 instead of n^-1 within a
  // factor.
  test("quarter disk", disk, M_PI / 4, M_PI / 4 * (1 - M_PI / 4), 0.25);
}

/// Variance of the mean over samples 0 .. count - 1 of f(a, b), a and b of two blocks, over that of as many
/// independent numbers (`variance` for one); over so many streams.
template <typename Function>
double variance_ratio(uint32_t count, uint32_t streams, double variance, const Function& f) {
  double sum = 0, squares = 0;
  for (uint32_t stream = 0; stream < streams; ++stream) {
    double mean = 0;
    for (uint32_t i = 0; i < count; ++i) {
      const double a = reference::sobol_bits(1, stream, i, 3)[0] * 0x1p-32;
      const double b = reference::sobol_bits(1, stream, i, 8)[0] * 0x1p-32;
      mean += f(a, b) / count;
    }
    sum += mean;
    squares += mean * mean;
  }
  const double average = sum / streams;
  return (squares / streams - average * average) * count / variance;
}

// The price of nested shuffles: samples 2k and 2k + 1 lie in opposite halves in every block, so the sign of a
// product is the same for both, and has twice the variance of independent ones. A linear factor is a sum of
// such signs for each digit, of variances 3/4, 3/16, ..: 1 + (3/4)^2 + 2 (3/32)^2. docs/results/error.md says
// why other orders are no better.
TEST(Sobol, ProductsOfBlocksHaveTheVarianceOfPairedSamples) {
  constexpr uint32_t STREAMS = 10000;
  const double linear =
      variance_ratio(16, STREAMS, 1.0 / 144, [](double a, double b) { return (a - 0.5) * (b - 0.5); });
  const double sign = variance_ratio(16, STREAMS, 0.25,
                                     [](double a, double b) { return (a < 0.5) != (b < 0.5) ? 1.0 : 0.0; });
  const double bound = 5 * std::sqrt(2.0 / STREAMS);  // of a variance of nearly normal means
  EXPECT_NEAR(linear, 1 + 9.0 / 16 + 2 * 9.0 / 1024, 1.58 * bound);
  EXPECT_NEAR(sign, 2, 2 * bound);
}

}  // namespace
}  // namespace regulus::test
