#include "reference/sheen.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "interface/sheen.h"
#include "reference/quadrature.hpp"

namespace regulus::reference {

using namespace interface;
using std::numbers::pi;

namespace {

constexpr double LEAST_ROUGHNESS = 0.01 * SHEEN_LEAST_HUNDREDTHS;

/// Estevez and Kulla 2017, table 1: parameters at roughness 0 and 1, between which (1 - alpha)^2 chooses.
double fitted(double x, double alpha) {
  constexpr double ROUGH[] = {21.5473, 3.82987, 0.19823, -1.97760, -4.32054};
  constexpr double SMOOTH[] = {25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
  double p[5];
  for (int i = 0; i < 5; ++i) p[i] = ROUGH[i] + (1 - alpha) * (1 - alpha) * (SMOOTH[i] - ROUGH[i]);
  return p[0] / (1 + p[1] * std::pow(x, p[2])) + p[3] * x + p[4];
}

double lambda(double cosine, double alpha) {
  if (cosine < 0.5) return std::exp(fitted(cosine, alpha));
  return std::exp(2 * fitted(0.5, alpha) - fitted(1 - cosine, alpha));
}

}  // namespace

double sheen_scattering(double cos_h, double cos_o, double cos_i, double alpha) {
  const double sine = std::sqrt((1 - cos_h) * (1 + cos_h));
  const double density = (2 + 1 / alpha) * std::pow(sine, 1 / alpha) / (2 * pi);
  return density / ((1 + lambda(cos_o, alpha) + lambda(cos_i, alpha)) * 4 * cos_o * cos_i);
}

double sheen_roughness(double roughness) {
  return std::max(roughness, LEAST_ROUGHNESS);
}

// Cells of an eight-point rule over the angle and over cos_i, mapped so that both are smooth where D is
// sharp.
double integrated_sheen(double cos_o, double alpha) {
  const double sin_o = std::sqrt(1 - cos_o * cos_o);
  const auto over_angle = [&](double t) {
    const double cos_i = t * t * (3 - 2 * t), sin_i = std::sqrt(1 - cos_i * cos_i);
    const auto at = [&](double v) {  // the angle is pi (1 - v^2): D is greatest at v = 0, where it is pi
      const double angle = pi * (1 - v * v);
      const double length = std::sqrt(2 + 2 * (cos_o * cos_i + sin_o * sin_i * std::cos(angle)));
      const double cos_h = length > 0 ? std::min((cos_o + cos_i) / length, 1.0) : 0;
      return sheen_scattering(cos_h, cos_o, cos_i, alpha) * cos_i * 2 * pi * v;
    };
    return 2 * integrate(at, 0, 1, 8) * 6 * t * (1 - t);
  };
  return integrate(over_angle, 0, 1, 8);
}

double SheenTable::albedo(double cosine, double roughness) const {
  const double x = std::sqrt(std::clamp(cosine, 0.0, 1.0)) * (SHEEN_DIRECTIONS - 1);
  const double y = std::sqrt(std::clamp((roughness - LEAST_ROUGHNESS) / (1 - LEAST_ROUGHNESS), 0.0, 1.0)) *
                   (SHEEN_ROWS - 1);
  const size_t column = std::min(static_cast<size_t>(x), size_t{SHEEN_DIRECTIONS - 2});
  const size_t row = std::min(static_cast<size_t>(y), size_t{SHEEN_ROWS - 2});
  const auto at = [&](size_t r) {
    const float* node = &nodes_[r * SHEEN_DIRECTIONS + column];
    return std::lerp(double{node[0]}, double{node[1]}, x - static_cast<double>(column));
  };
  return std::lerp(at(row), at(row + 1), y - static_cast<double>(row));
}

}  // namespace regulus::reference
