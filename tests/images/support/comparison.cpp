#include "images/support/comparison.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "support/chi_square.hpp"

namespace regulus::test {

using image::Image;

namespace {

// Mean over the pixels of a tile (partial at the right and lower edge).
double tile_mean(const Image& image, uint32_t tile_x, uint32_t tile_y, uint32_t tile, uint32_t channel) {
  double sum = 0;
  int count = 0;
  for (uint32_t y = tile_y * tile; y < std::min((tile_y + 1) * tile, image.height); ++y)
    for (uint32_t x = tile_x * tile; x < std::min((tile_x + 1) * tile, image.width); ++x, ++count)
      sum += image.rgb[3 * (size_t{y} * image.width + x) + channel];
  return sum / count;
}

struct Estimate {
  double mean = 0, squared_error = 0;  // of the mean
};

Estimate estimate(const std::vector<Image>& batches, uint32_t x, uint32_t y, uint32_t tile,
                  uint32_t channel) {
  const auto count = static_cast<double>(batches.size());
  std::vector<double> values;
  Estimate result;
  for (const Image& batch : batches) values.push_back(tile_mean(batch, x, y, tile, channel));
  for (const double value : values) result.mean += value / count;
  for (const double value : values)
    result.squared_error += (value - result.mean) * (value - result.mean) / (count * (count - 1));
  return result;
}

// Calls difference(x, y, channel) -> {difference, squared error, magnitude} for every tile and keeps the
// worst.
struct Difference {
  double value, squared_error, magnitude;
};

template <typename Function>
TileTest test_tiles(uint32_t width, uint32_t height, int degrees_of_freedom, const ComparisonOptions& options,
                    const Function& difference) {
  TileTest result;
  for (uint32_t y = 0; y * options.tile < height; ++y)
    for (uint32_t x = 0; x * options.tile < width; ++x)
      for (uint32_t channel = 0; channel < 3; ++channel) {
        const Difference d = difference(x, y, channel);
        const double excess = std::max(0.0, std::abs(d.value) - options.relative_tolerance * d.magnitude);
        const double error = std::sqrt(d.squared_error);
        const double p = excess == 0  ? 1
                         : error == 0 ? 0
                                      : student_two_sided(excess / error, degrees_of_freedom);
        ++result.tests;
        if (p <= result.worst_p) {
          result.worst_p = p;
          result.worst_difference = d.value;
          result.worst_error = error;
          result.worst_x = x, result.worst_y = y, result.worst_channel = channel;
        }
      }
  result.bound = significance_per_test(options.false_alarm_rate, result.tests);
  return result;
}

void report(const char* what, const char* scope, const TileTest& test) {
  std::printf("%s, %s: smallest p %.2g of %d tests, bound %.2g (difference %.4g, standard error %.4g)\n",
              what, scope, test.worst_p, test.tests, test.bound, test.worst_difference, test.worst_error);
  EXPECT_GE(test.worst_p, test.bound)
      << what << ", " << scope << ": tile (" << test.worst_x << ", " << test.worst_y << ") channel "
      << test.worst_channel << " is off by " << test.worst_difference << " with a standard error of "
      << test.worst_error;
}

// Half of the allowed false alarms for the tiles, half for the whole image.
template <typename Test>
void expect(const char* what, uint32_t width, uint32_t height, ComparisonOptions options, const Test& test) {
  options.false_alarm_rate /= 2;
  report(what, "tiles", test(options));
  options.tile = std::max(width, height);
  report(what, "whole image", test(options));
}

}  // namespace

double student_two_sided(double t, int even_degrees_of_freedom) {
  const double theta = std::atan(std::abs(t) / std::sqrt(even_degrees_of_freedom));
  const double cosine_squared = std::cos(theta) * std::cos(theta);
  double term = 1, sum = 1;
  for (int k = 2; k < even_degrees_of_freedom; k += 2) {
    term *= cosine_squared * (k - 1) / k;
    sum += term;
  }
  return std::max(0.0, 1 - std::sin(theta) * sum);
}

TileTest test_against(const std::vector<Image>& batches, const Image& known,
                      const ComparisonOptions& options) {
  return test_tiles(known.width, known.height, static_cast<int>(batches.size()) - 1, options,
                    [&](uint32_t x, uint32_t y, uint32_t channel) {
                      const Estimate found = estimate(batches, x, y, options.tile, channel);
                      const double value = tile_mean(known, x, y, options.tile, channel);
                      return Difference{found.mean - value, found.squared_error, std::abs(value)};
                    });
}

TileTest test_equal(const std::vector<Image>& first, const std::vector<Image>& second,
                    const ComparisonOptions& options) {
  return test_tiles(first[0].width, first[0].height, static_cast<int>(first.size()) - 1, options,
                    [&](uint32_t x, uint32_t y, uint32_t channel) {
                      const Estimate a = estimate(first, x, y, options.tile, channel);
                      const Estimate b = estimate(second, x, y, options.tile, channel);
                      return Difference{a.mean - b.mean, a.squared_error + b.squared_error, std::abs(b.mean)};
                    });
}

void expect_known(const char* what, const std::vector<Image>& batches, const Image& known,
                  ComparisonOptions options) {
  expect(what, known.width, known.height, options,
         [&](const ComparisonOptions& chosen) { return test_against(batches, known, chosen); });
}

void expect_equal(const char* what, const std::vector<Image>& first, const std::vector<Image>& second,
                  ComparisonOptions options) {
  expect(what, first[0].width, first[0].height, options,
         [&](const ComparisonOptions& chosen) { return test_equal(first, second, chosen); });
}

Image uniform_image(uint32_t width, uint32_t height, const std::array<double, 3>& rgb) {
  Image image{width, height, {}};
  for (uint32_t i = 0; i < width * height; ++i)
    for (const double value : rgb) image.rgb.push_back(static_cast<float>(value));
  return image;
}

std::array<double, 3> mean_of(const Image& image) {
  std::array<double, 3> mean{};
  const auto pixels = static_cast<double>(image.rgb.size() / 3);
  for (size_t i = 0; i < image.rgb.size(); ++i) mean[i % 3] += image.rgb[i] / pixels;
  return mean;
}

Image downsampled(const Image& image, uint32_t factor) {
  Image result{image.width / factor, image.height / factor, {}};
  for (uint32_t y = 0; y < result.height; ++y)
    for (uint32_t x = 0; x < result.width; ++x)
      for (uint32_t channel = 0; channel < 3; ++channel)
        result.rgb.push_back(static_cast<float>(tile_mean(image, x, y, factor, channel)));
  return result;
}

}  // namespace regulus::test
