#include "images/support/comparison.hpp"

#include <gtest/gtest.h>

#include <cstdio>

namespace regulus::test {

using image::Image;

namespace {

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

Image downsampled(const Image& source, uint32_t factor) {
  Image result{source.width / factor, source.height / factor, {}};
  for (uint32_t y = 0; y < result.height; ++y)
    for (uint32_t x = 0; x < result.width; ++x)
      for (uint32_t channel = 0; channel < 3; ++channel)
        result.rgb.push_back(static_cast<float>(image::tile_mean(source, x, y, factor, channel)));
  return result;
}

}  // namespace regulus::test
