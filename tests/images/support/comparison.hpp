// Statistical comparison of images (image/comparison.hpp) as expectations of a test.
#pragma once

#include <array>
#include <vector>

#include "image/comparison.hpp"

namespace regulus::test {

using image::ComparisonOptions;
using image::TileTest;

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
