// Error metrics of an image against a reference.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "image/image.hpp"

namespace regulus::image {
namespace {

double square(const double x) {
  return x * x;
}

// The mean of all but the worst values.
double trimmed_mean(std::vector<double> values) {
  std::ranges::sort(values);
  const size_t kept = values.size() - static_cast<size_t>(TRIMMED_SHARE * static_cast<double>(values.size()));
  return std::accumulate(values.begin(), values.begin() + static_cast<ptrdiff_t>(kept), 0.0) /
         static_cast<double>(kept);
}

}  // namespace

void require_same_size(const Image& image, const Image& reference) {
  if (image.width == reference.width && image.height == reference.height) return;
  throw Error(ErrorCode::BadFile,
              fmt::format("{} x {} pixels against a reference of {} x {}; render at the same size",
                          image.width, image.height, reference.width, reference.height));
}

Metrics compare(const Image& image, const Image& reference) {
  require_same_size(image, reference);
  Metrics metrics;
  uint64_t count = 0;
  std::array<uint64_t, 3> channel_count{};
  double peak = 0;
  std::vector<double> relative;  // of the pixels whose values are all finite
  for (size_t pixel = 0; pixel < reference.rgb.size(); pixel += 3) {
    const float* const r_pixel = &reference.rgb[pixel];
    const double pixel_mean = (double{r_pixel[0]} + r_pixel[1] + r_pixel[2]) / 3;
    double pixel_relative = 0;
    for (size_t channel = 0; channel < 3; ++channel) {
      const double a = image.rgb[pixel + channel];
      const double r = r_pixel[channel];
      metrics.non_finite += (std::isfinite(a) ? 0u : 1u) + (std::isfinite(r) ? 0u : 1u);
      pixel_relative += square(a - r) / (square(r) + RELATIVE_EPSILON) / 3;
      if (!std::isfinite(a) || !std::isfinite(r)) continue;
      const double error = square(a - r);
      // A pixel of the reference with a non-finite neighbour channel has no mean: its own value stands in.
      const double scale = std::isfinite(pixel_mean) ? pixel_mean : r;
      metrics.mse += error;
      metrics.relmse += error / (square(r) + RELATIVE_EPSILON);
      metrics.mrse += error / (square(scale) + RELATIVE_EPSILON);
      metrics.mae += std::abs(a - r);
      metrics.mean[channel] += a;
      metrics.reference_mean[channel] += r;
      peak = std::max(peak, r);
      ++channel_count[channel];
      ++count;
    }
    if (std::isfinite(pixel_relative)) relative.push_back(pixel_relative);
  }
  const auto n = static_cast<double>(count);  // no finite value at all: 0 / 0, every metric is NaN
  for (double* sum : {&metrics.mse, &metrics.relmse, &metrics.mrse, &metrics.mae}) *sum /= n;
  metrics.trimmed_relmse = trimmed_mean(std::move(relative));
  for (size_t channel = 0; channel < 3; ++channel) {
    metrics.mean[channel] /= static_cast<double>(channel_count[channel]);
    metrics.reference_mean[channel] /= static_cast<double>(channel_count[channel]);
  }
  metrics.psnr = 10 * std::log10(square(peak) / metrics.mse);
  return metrics;
}

}  // namespace regulus::image
