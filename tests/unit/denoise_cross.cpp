// The cross filter where its result is known: what is even stays, noise goes, edges that albedo or normals
// show stay.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "denoise/denoise.hpp"

namespace regulus::denoise {
namespace {

constexpr uint32_t SIDE = 48;

Input even(float color, float variance) {
  const size_t values = 3 * size_t{SIDE} * SIDE;
  return {.width = SIDE,
          .height = SIDE,
          .color = std::vector<float>(values, color),
          .albedo = std::vector<float>(values, 0.5F),
          .normal = std::vector<float>(values, 0.6F),
          .variance = std::vector<float>(values, variance),
          .kept = {}};
}

bool is_left(size_t value) {
  return value / 3 % SIDE < SIDE / 2;
}

TEST(CrossFilter, LeavesAnEvenPictureAsItIs) {
  const Input input = even(0.25F, 0.01F);
  EXPECT_EQ(by_cross_filter(input), input.color);  // a power of two: sums of it are exact
}

// A mean over many pixels: the squared error falls by much, the mean of the picture by nothing.
TEST(CrossFilter, TakesNoiseAwayAndNoLight) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    constexpr float DEVIATION = 0.3F;
    Input input = even(1, DEVIATION * DEVIATION);
    std::mt19937 random(seed);
    std::normal_distribution<float> noise(0, DEVIATION);
    for (float& value : input.color) value += noise(random);
    const std::vector<float> result = by_cross_filter(input);
    double before = 0, after = 0, mean_before = 0, mean_after = 0;
    const auto count = static_cast<double>(result.size());
    for (size_t i = 0; i < result.size(); ++i) {
      before += std::pow(input.color[i] - 1, 2) / count;
      after += std::pow(result[i] - 1, 2) / count;
      mean_before += input.color[i] / count;
      mean_after += result[i] / count;
    }
    std::printf("seed %u: squared error %.4f before, %.4f after; mean %.4f and %.4f\n", seed, before, after,
                mean_before, mean_after);
    EXPECT_LT(after, before / 10);
    // The means differ by what weights that depend on the noise make of it: less than the noise of either.
    EXPECT_LT(std::abs(mean_after - mean_before), 4 * DEVIATION / std::sqrt(count));
  }
}

TEST(CrossFilter, KeepsEdgesOfAlbedoAndNormals) {
  for (std::vector<float> Input::*feature : {&Input::albedo, &Input::normal}) {
    Input input = even(1, 100);  // noise that would let any color pass for any other
    for (size_t i = 0; i < input.color.size(); ++i)
      if (!is_left(i)) {
        (input.*feature)[i] = -0.4F;
        input.color[i] = 4;
      }
    EXPECT_EQ(by_cross_filter(input), input.color);
  }
}

TEST(CrossFilter, KeepsWhatNoNoiseExplains) {
  Input input = even(1, 1e-6F);
  for (size_t i = 0; i < input.color.size(); ++i)
    if (!is_left(i)) input.color[i] = 4;
  const std::vector<float> result = by_cross_filter(input);
  for (size_t i = 0; i < result.size(); ++i) EXPECT_NEAR(result[i], input.color[i], 1e-5) << i;
}

TEST(CrossFilter, NeedsFeatures) {
  Input input = even(1, 1);
  input.variance.clear();
  EXPECT_THROW(by_cross_filter(input), Error);
}

}  // namespace
}  // namespace regulus::denoise
