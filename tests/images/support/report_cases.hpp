// The files of tests/cases that are one number: what a picture's mean is by specification or closed form.
#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <vector>

#include "image/image.hpp"
#include "interface/wavefront.h"

namespace regulus::test {

enum class Part { Whole, Left, Right };

struct ReportCase {
  const char* file;         ///< below tests/cases
  double radiance;          ///< mean of the part
  double bound;             ///< on the error of the mean
  Part part = Part::Whole;  ///< of the picture
  uint32_t camera = 0;
  uint32_t size = 8;  ///< of the square film, whose pixels have a box filter
  uint32_t samples = 16;
  uint32_t max_depth = 12;
};

/// All by technique `hit` and `nee`, without regularization.
std::vector<ReportCase> report_cases();

std::filesystem::path report_file(const ReportCase& c);

/// Mean of the red channel over a part of the picture.
double mean_of_part(const image::Image& image, Part part);

}  // namespace regulus::test
