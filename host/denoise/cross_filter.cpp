#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "denoise/denoise.hpp"

namespace regulus::denoise {

namespace {

constexpr int WINDOW_RADIUS = 7, PATCH_RADIUS = 2;  // pixels
// Distances in color are in standard deviations of their difference; of albedo and normal, squared, in these.
constexpr double COLOR_BANDWIDTH = 0.7, ALBEDO_SCALE = 0.02, NORMAL_SCALE = 0.05;
constexpr double LEAST_VARIANCE = 1e-8;

class CrossFilter {
 public:
  explicit CrossFilter(const Input& input)
      : input_(input), width_(static_cast<int>(input.width)), height_(static_cast<int>(input.height)) {}

  void filter(int x, int y, float* result) const {
    double sum[3] = {0, 0, 0}, total = 0;
    for (int qy = std::max(y - WINDOW_RADIUS, 0); qy <= std::min(y + WINDOW_RADIUS, height_ - 1); ++qy)
      for (int qx = std::max(x - WINDOW_RADIUS, 0); qx <= std::min(x + WINDOW_RADIUS, width_ - 1); ++qx) {
        const double weight = weight_of(x, y, qx, qy);
        const float* color = &input_.color[at(qx, qy)];
        for (int c = 0; c < 3; ++c) sum[c] += weight * static_cast<double>(color[c]);
        total += weight;
      }
    for (int c = 0; c < 3; ++c) result[c] = static_cast<float>(sum[c] / total);  // its own weight is 1
  }

 private:
  size_t at(int x, int y) const {
    return 3 * (static_cast<size_t>(y) * input_.width + static_cast<size_t>(x));
  }

  static double squared_distance(const std::vector<float>& values, size_t p, size_t q) {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double difference = static_cast<double>(values[p + c]) - static_cast<double>(values[q + c]);
      sum += difference * difference;
    }
    return sum;
  }

  /// Squared distance of two pixels' colors beyond what their noise lets expect, in its own units.
  double color_distance(size_t p, size_t q) const {
    double sum = 0;
    for (size_t c = 0; c < 3; ++c) {
      const double difference =
          static_cast<double>(input_.color[p + c]) - static_cast<double>(input_.color[q + c]);
      const double variance_p = static_cast<double>(input_.variance[p + c]);
      const double variance_q = static_cast<double>(input_.variance[q + c]);
      const double expected = variance_p + std::min(variance_p, variance_q);
      sum += (difference * difference - expected) /
             (LEAST_VARIANCE + COLOR_BANDWIDTH * COLOR_BANDWIDTH * (variance_p + variance_q));
    }
    return sum / 3;
  }

  double weight_of(int x, int y, int qx, int qy) const {
    const size_t p = at(x, y), q = at(qx, qy);
    if (p == q) return 1;
    const double features = squared_distance(input_.albedo, p, q) / ALBEDO_SCALE +
                            squared_distance(input_.normal, p, q) / NORMAL_SCALE;
    constexpr double NEGLIGIBLE = 12;  // e^-12
    if (features > NEGLIGIBLE) return 0;
    double color = 0;
    int count = 0;
    for (int dy = -PATCH_RADIUS; dy <= PATCH_RADIUS; ++dy)
      for (int dx = -PATCH_RADIUS; dx <= PATCH_RADIUS; ++dx) {
        const bool is_inside = std::min({x + dx, y + dy, qx + dx, qy + dy}) >= 0 &&
                               std::max(x, qx) + dx < width_ && std::max(y, qy) + dy < height_;
        if (!is_inside) continue;
        color += color_distance(at(x + dx, y + dy), at(qx + dx, qy + dy));
        ++count;
      }
    return std::exp(-features - std::max(color / count, 0.0));
  }

  const Input& input_;
  int width_, height_;
};

}  // namespace

std::vector<float> by_cross_filter(const Input& input) {
  if (input.variance.empty() || input.albedo.empty() || input.normal.empty())
    throw Error(ErrorCode::BadFile,
                "the cross filter needs variance, albedo and normals; render with --aov variance,albedo,N");
  std::vector<float> result(input.color.size());
  const CrossFilter filter(input);
  for (uint32_t y = 0; y < input.height; ++y)
    for (uint32_t x = 0; x < input.width; ++x)
      filter.filter(static_cast<int>(x), static_cast<int>(y), &result[3 * (size_t{y} * input.width + x)]);
  return result;
}

}  // namespace regulus::denoise
