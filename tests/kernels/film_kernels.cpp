// The film's fixed-point sums against integers of 128 bits, and the pixel filters against their closed forms.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "interface/wavefront.h"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using namespace interface;
__extension__ typedef unsigned __int128 Sum;

class Film : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

// Sums on the device: values[i] goes to channel i % channels.
std::vector<Sum> device_sums(const std::vector<float>& values, uint32_t channels, int exponent = 0) {
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "film_add",
                                                 {{SPEC_FILM_EXPONENT, static_cast<uint32_t>(exponent)}});
  const gpu::Buffer in = gpu::upload_new(*device(), values, "values");
  const gpu::Buffer film = device()->create_buffer(channels * 3 * sizeof(uint32_t), "film");
  run_batch(kernel, {in.address(), film.address(), static_cast<uint32_t>(values.size()), channels});
  const auto words = gpu::download_all<uint32_t>(*device(), film, channels * 3);
  std::vector<Sum> sums;
  for (uint32_t c = 0; c < channels; ++c)
    sums.push_back(words[3 * c] | Sum{words[3 * c + 1]} << 32 | Sum{words[3 * c + 2]} << 64);
  return sums;
}

// value * 2^(40 - exponent) rounded to the nearest integer, halves up; exact because a float has 24 bits.
Sum fixed_point(float value, int exponent = 0) {
  const double scaled = std::ldexp(static_cast<double>(value), int{FILM_FRACTION_BITS} - exponent);
  if (scaled < 0x1p52) return static_cast<Sum>(std::floor(scaled + 0.5));
  int binary_exponent = 0;
  const double mantissa = std::frexp(scaled, &binary_exponent);
  return static_cast<Sum>(std::ldexp(mantissa, 53)) << (binary_exponent - 53);
}

std::string text(Sum sum) {
  char buffer[64];
  std::snprintf(buffer, sizeof buffer, "0x%llx%016llx", static_cast<unsigned long long>(sum >> 64),
                static_cast<unsigned long long>(sum));
  return buffer;
}

TEST_F(Film, OneValueIsRoundedToTheNearestUnit) {
  std::vector<float> values = {
      0.0f,       1.0f,     0.5f,       1e-20f,      1e-13f,        3e-13f, 5e-13f, 0x1p-41f, 0x1.fffffep-42f,
      0x1.8p-40f, 0x1p-40f, 255.99998f, 16777215.0f, 4294967296.0f, 1e16f,  1.7e16f};
  for (int exponent = -66; exponent <= 53; ++exponent)
    for (const float mantissa : {1.0f, 1.5f, 0x1.fffffep0f, 0x1.000002p0f})
      values.push_back(std::ldexp(mantissa, exponent));
  Random random(1);
  for (int i = 0; i < 4000; ++i) values.push_back(static_cast<float>(random.log_uniform(1e-20, 1.7e16)));
  const std::vector<Sum> sums = device_sums(values, static_cast<uint32_t>(values.size()));
  for (size_t i = 0; i < values.size(); ++i)
    ASSERT_EQ(text(sums[i]), text(fixed_point(values[i]))) << "value " << values[i];
  std::printf("%zu values exact\n", values.size());
}

// Light that is dim or bright beyond all measure is summed in a unit of its own.
TEST_F(Film, UnitsFollowTheExponent) {
  Random random(3);
  for (const int exponent : {-100, -44, -1, 1, 23, 74}) {
    std::vector<float> values;
    for (int i = 0; i < 500; ++i) {
      const double value = std::ldexp(random.log_uniform(1e-14, 0x1.fp54), exponent);
      values.push_back(static_cast<float>(std::clamp(value, 1e-37, 3e38)));
    }
    const std::vector<Sum> sums = device_sums(values, static_cast<uint32_t>(values.size()), exponent);
    for (size_t i = 0; i < values.size(); ++i)
      ASSERT_EQ(text(sums[i]), text(fixed_point(values[i], exponent))) << values[i] << " with " << exponent;
  }
}

bool is_saturated(Sum sum) {
  return (sum >> 95) != 0;
}

TEST_F(Film, HugeValuesSaturateAndDenormalsAreDropped) {
  const std::vector<float> values = {1e30f, 3.4e38f, 1e-44f, 0x1p55f, 0x1.fffffep54f};
  const std::vector<Sum> sums = device_sums(values, 5);
  for (const size_t i : {0u, 1u, 3u}) EXPECT_TRUE(is_saturated(sums[i])) << values[i];
  EXPECT_EQ(text(sums[2]), text(0));
  EXPECT_EQ(text(sums[4]), text(fixed_point(0x1.fffffep54f)));
}

struct TwoSums {
  uint32_t a[3], b[3];
};
struct SumsOfTwo {
  uint32_t added[3], subtracted[3], in_film[3];
};

Sum sum_of(const uint32_t (&words)[3]) {
  return words[0] | Sum{words[1]} << 32 | Sum{words[2]} << 64;
}

// Sums of merges and squares are added and subtracted in registers, and to the film word by word: carries run
// through words that are full, and through all of them.
TEST_F(Film, SumsInWordsCarryThroughFullWords) {
  std::mt19937_64 engine(base_seed());
  constexpr uint32_t WORDS[] = {0, 1, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF};
  std::vector<TwoSums> pairs;
  for (uint32_t i = 0; i < 5 * 5 * 5 * 5; ++i)
    pairs.push_back({{WORDS[i % 5], WORDS[i / 5 % 5], 3}, {WORDS[i / 25 % 5], WORDS[i / 125], 2}});
  const auto word = [&] { return static_cast<uint32_t>(engine()); };
  for (int i = 0; i < 2000; ++i)
    pairs.push_back({{word(), word(), word() >> 2}, {word(), word(), word() >> 2}});
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "film_sums", {});
  const gpu::Buffer in = gpu::upload_new(*device(), pairs, "pairs");
  const gpu::Buffer out = gpu::upload_new(*device(), std::vector<SumsOfTwo>(pairs.size()), "sums");
  run_batch(kernel, {in.address(), out.address(), static_cast<uint32_t>(pairs.size()), 0});
  const auto found = gpu::download_all<SumsOfTwo>(*device(), out, pairs.size());
  constexpr Sum WHOLE = (Sum{1} << 96) - 1;
  for (size_t i = 0; i < pairs.size(); ++i) {
    const Sum a = sum_of(pairs[i].a), b = sum_of(pairs[i].b);
    ASSERT_EQ(text(sum_of(found[i].added)), text(a + b)) << text(a) << " + " << text(b);
    ASSERT_EQ(text(sum_of(found[i].in_film)), text(a + b)) << text(a) << " and " << text(b);
    ASSERT_EQ(text(sum_of(found[i].subtracted)), text((a - b) & WHOLE)) << text(a) << " - " << text(b);
  }
}

// A sum is saturated if and only if it reaches 2^55, in whatever order, and stays so: the highest word
// carries out many times here, and its bit comes back.
TEST_F(Film, SumsSaturateInAnyOrderAndStaySo) {
  std::mt19937_64 engine(base_seed());
  // 31 times 2^50 is below, with what is missing to 2^55 exactly there; all the rest is far beyond.
  std::vector<float> below(31, 0x1p50f), there = below, beyond;
  for (int exponent = 10; exponent < 50; ++exponent) below.push_back(std::ldexp(1.0f, exponent));
  there = below;
  there.push_back(1024);
  for (int i = 0; i < 3000; ++i) beyond.push_back(std::ldexp(1.0f, 20 + i % 35));
  Sum sum = 0;
  for (const float value : below) sum += fixed_point(value);
  for (int order = 0; order < 3; ++order) {
    for (std::vector<float>* values : {&below, &there, &beyond})
      std::shuffle(values->begin(), values->end(), engine);
    EXPECT_EQ(text(device_sums(below, 1)[0]), text(sum));
    EXPECT_TRUE(is_saturated(device_sums(there, 1)[0]));
    EXPECT_TRUE(is_saturated(device_sums(beyond, 1)[0]));
    // The bit alone, set and set again: every second time it carries out.
    EXPECT_TRUE(is_saturated(device_sums(std::vector<float>(64 + order, 3e38f), 1)[0]));
  }
}

TEST_F(Film, CarriesRunThroughAllWords) {
  // 2^24 - 1 units over and over: the low word overflows every 257th time.
  const float nearly = std::ldexp(16777215.0f, -40);
  std::vector<float> values(100'000, nearly);
  EXPECT_EQ(text(device_sums(values, 1)[0]), text(Sum{100'000} * 16777215u));

  // 2^64 - 1 units exactly, then one unit: both lower words overflow at once, by a carry alone.
  values.clear();
  for (const int exponent : {40, 16}) values.push_back(std::ldexp(16777215.0f, exponent - 40));
  Sum sum = 0;
  for (const float value : values) sum += fixed_point(value);
  while (sum < (Sum{1} << 64) - 1) {
    const Sum missing = (Sum{1} << 64) - 1 - sum;
    const auto piece = static_cast<double>(static_cast<uint64_t>(std::min<Sum>(missing, 16777215u)));
    values.push_back(static_cast<float>(std::ldexp(piece, -40)));
    sum += static_cast<Sum>(piece);
    ASSERT_LT(values.size(), 1000u);
  }
  EXPECT_EQ(text(device_sums(values, 1)[0]), text(sum));
  values.push_back(0x1p-40f);
  EXPECT_EQ(text(device_sums(values, 1)[0]), text(Sum{1} << 64));
}

TEST_F(Film, OrderDoesNotMatterAndSumsAreExact) {
  constexpr uint32_t CHANNELS = 3;
  Random random(2);
  std::vector<float> values;
  for (int i = 0; i < 60'000; ++i) values.push_back(static_cast<float>(random.log_uniform(1e-14, 1e9)));
  std::vector<Sum> expected(CHANNELS, 0);
  for (size_t i = 0; i < values.size(); ++i) expected[i % CHANNELS] += fixed_point(values[i]);

  std::mt19937_64 engine(base_seed());
  for (int order = 0; order < 3; ++order) {
    const std::vector<Sum> sums = device_sums(values, CHANNELS);
    for (uint32_t c = 0; c < CHANNELS; ++c) EXPECT_EQ(text(sums[c]), text(expected[c])) << "order " << order;
    // Shuffles within the channels.
    for (size_t i = values.size(); i-- > CHANNELS;)
      std::swap(values[i], values[engine() % (i / CHANNELS + 1) * CHANNELS + i % CHANNELS]);
  }
}

// Offsets of a grid x grid of stratified u.
std::vector<glm::vec2> filter_offsets(uint32_t filter, int grid, float radius, float sigma) {
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "film_filter", {{SPEC_FILTER, filter}});
  std::vector<glm::vec4> inputs;
  for (int y = 0; y < grid; ++y)
    for (int x = 0; x < grid; ++x)
      inputs.emplace_back((static_cast<float>(x) + 0.5f) / static_cast<float>(grid),
                          (static_cast<float>(y) + 0.5f) / static_cast<float>(grid), radius, sigma);
  return map_on_device<glm::vec2>(kernel, inputs);
}

TEST_F(Film, BoxFilterIsUniformOverItsSquare) {
  constexpr int GRID = 64;
  for (const float radius : {0.5f, 0.0f, 1.25f}) {
    const auto offsets = filter_offsets(FILTER_BOX, GRID, radius, 0.5f);
    for (int i = 0; i < GRID * GRID; ++i) {
      const glm::dvec2 u((i % GRID + 0.5) / GRID, (i / GRID + 0.5) / GRID);
      ASSERT_NEAR(offsets[i].x, (2 * u.x - 1) * radius, 1.2e-7 * radius);
      ASSERT_NEAR(offsets[i].y, (2 * u.y - 1) * radius, 1.2e-7 * radius);
    }
  }
}

// The distribution function at the offset must give u back: (erf(x / (sigma sqrt 2)) / erf(r / (sigma sqrt
// 2)) + 1) / 2. Numbers u of the renderer have 24 bits; an error of 1e-6 in u is a sixteenth of a thousandth
// of a pixel at the filter's centre. At the rim the density is exp(-4.5) of the centre's, so the offset may
// be off more, the share not.
TEST_F(Film, GaussianFilterInvertsItsDistribution) {
  constexpr int GRID = 128;
  constexpr double BOUND = 1e-6;
  const struct { float radius, sigma; } filters[] = {{1.5f, 0.5f}, {1.0f, 0.5f}, {3.0f, 1.0f}, {1.5f, 5.0f}};
  for (const auto& filter : filters) {
    const auto offsets = filter_offsets(FILTER_GAUSSIAN, GRID, filter.radius, filter.sigma);
    const double scale = filter.sigma * std::sqrt(2.0), inside = std::erf(filter.radius / scale);
    double worst = 0, furthest = 0;
    for (int i = 0; i < GRID * GRID; ++i) {
      const double u[] = {(i % GRID + 0.5) / GRID, (i / GRID + 0.5) / GRID};
      for (int axis = 0; axis < 2; ++axis) {
        const double share = (std::erf(offsets[i][axis] / scale) / inside + 1) / 2;
        worst = std::max(worst, std::abs(share - u[axis]));
        furthest = std::max(furthest, std::abs(double{offsets[i][axis]}));
      }
    }
    std::printf("radius %g sigma %g: worst error of the distribution %.3g (bound %.1g), furthest offset %g\n",
                filter.radius, filter.sigma, worst, BOUND, furthest);
    EXPECT_LE(worst, BOUND);
    EXPECT_LE(furthest, filter.radius);
  }
}

// As for the Gaussian, with the distribution function of the window a0 + a1 cos + a2 cos 2 + a3 cos 3 of pi x
// / r (Harris 1978, minimum four-term).
TEST_F(Film, BlackmanHarrisFilterInvertsItsDistribution) {
  constexpr int GRID = 256;
  constexpr double BOUND = 1e-6;
  constexpr double A[] = {0.35875, 0.48829, 0.14128, 0.01168};
  for (const float radius : {1.5f, 0.75f, 4.0f}) {
    const auto offsets = filter_offsets(FILTER_BLACKMAN_HARRIS, GRID, radius, 0.5f);
    double worst = 0, furthest = 0;
    for (int i = 0; i < GRID * GRID; ++i) {
      const double u[] = {(i % GRID + 0.5) / GRID, (i / GRID + 0.5) / GRID};
      for (int axis = 0; axis < 2; ++axis) {
        const double t = offsets[i][axis] / double{radius};
        double share = A[0] * t;
        for (int k = 1; k <= 3; ++k) share += A[k] * std::sin(k * M_PI * t) / (k * M_PI);
        worst = std::max(worst, std::abs((share / A[0] + 1) / 2 - u[axis]));
        furthest = std::max(furthest, std::abs(t));
      }
    }
    std::printf("radius %g: worst error of the distribution %.3g (bound %.1g), furthest %g\n", radius, worst,
                BOUND, furthest);
    EXPECT_LE(worst, BOUND);
    EXPECT_LE(furthest, 1);
  }
}

// The rim: shares within a thousandth of either end, down to the last of the 24 bits.
TEST_F(Film, BlackmanHarrisFilterHoldsAtTheRim) {
  const gpu::Kernel kernel =
      create_batch_kernel(test_kernels::spirv, "film_filter", {{SPEC_FILTER, FILTER_BLACKMAN_HARRIS}});
  std::vector<glm::vec4> inputs;
  for (int i = 0; i < 4096; ++i)
    inputs.emplace_back(static_cast<float>(i) * 0x1p-24f, 1 - static_cast<float>(i + 1) * 0x1p-24f, 1.0f,
                        0.5f);
  const auto offsets = map_on_device<glm::vec2>(kernel, inputs);
  for (size_t i = 0; i < offsets.size(); ++i) {
    ASSERT_TRUE(offsets[i].x >= -1 && offsets[i].x < -0.8) << i << ' ' << offsets[i].x;
    ASSERT_TRUE(offsets[i].y <= 1 && offsets[i].y > 0.8) << i << ' ' << offsets[i].y;
  }
}

// Moments of a Gaussian cut at a = radius / sigma, in units of sigma. With m0 = erf(a / sqrt 2) and q = 2 a
// phi(a): m2 = 1 - q / m0, m4 = 3 m2 - a^2 q / m0. Two errors add up: an error of 1e-6 in u (the test above)
// moves the mean of x^k by up to 1e-6 * 2 a^k, and the midpoint rule with step h over u is off by h^2 / 24
// times the difference of the slopes at both ends, k a^(k - 1) x'(u) each, where x'(u) = m0 sqrt(2 pi)
// exp(a^2 / 2).
TEST_F(Film, GaussianFilterHasTheMomentsOfTheCutGaussian) {
  constexpr int GRID = 512;
  constexpr double SIGMA = 0.5, RADIUS = 1.5, A = RADIUS / SIGMA;
  const double m0 = std::erf(A / std::sqrt(2.0)), q = 2 * A * std::exp(-A * A / 2) / std::sqrt(2 * M_PI);
  const double m2 = 1 - q / m0, known[] = {1, 0, m2, 0, 3 * m2 - A * A * q / m0};
  const double slope = m0 * std::sqrt(2 * M_PI) * std::exp(A * A / 2);
  const auto offsets = filter_offsets(FILTER_GAUSSIAN, GRID, RADIUS, SIGMA);
  for (int power = 1; power <= 4; ++power) {
    double sum = 0;
    for (const glm::vec2& offset : offsets) sum += std::pow(offset.x / SIGMA, power);
    const double moment = sum / static_cast<double>(offsets.size());
    const double midpoint =
        power % 2 == 0 ? 2 * power * std::pow(A, power - 1) * slope / (24.0 * GRID * GRID) : 0;
    const double bound = 2e-6 * std::pow(A, power) + 1.1 * midpoint;
    std::printf("moment %d: %.6f, known %.6f, bound %.2g\n", power, moment, known[power], bound);
    EXPECT_NEAR(moment, known[power], bound);
  }
}

}  // namespace
}  // namespace regulus::test
