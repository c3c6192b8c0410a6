#include "scene/sheen_table.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "interface/sheen.h"

namespace regulus::scene {

using namespace interface;

namespace {

constexpr int STEPS = 44;      // per coordinate
constexpr double REACH = 3.1;  // of the variable of the double-exponential rule

/// Shadowing term of Estevez and Kulla 2017, a fit over the cosine for each roughness.
class Shadowing {
 public:
  explicit Shadowing(double alpha) : t_((1 - alpha) * (1 - alpha)), middle_(fit(0.5)) {}

  double operator()(double cosine) const {
    return std::exp(cosine < 0.5 ? fit(cosine) : 2 * middle_ - fit(1 - cosine));
  }

 private:
  double fit(double x) const {
    const double a = std::lerp(21.5473, 25.3245, t_), b = std::lerp(3.82987, 3.32435, t_),
                 c = std::lerp(0.19823, 0.16801, t_), d = std::lerp(-1.97760, -1.27393, t_),
                 e = std::lerp(-4.32054, -4.85967, t_);
    return a / (1 + b * std::pow(x, c)) + d * x + e;
  }

  double t_, middle_;
};

/// A node of the double-exponential rule on [0, 1] (Takahasi and Mori 1974), which roots and peaks at the
/// ends, where sheen is brightest, do not disturb.
struct Step {
  double place, share;
};

Step step(int i) {
  const double t = REACH * (2 * (i + 0.5) / STEPS - 1);
  const double u = 0.5 * std::numbers::pi * std::sinh(t);
  const double slope = 0.25 * std::numbers::pi * std::cosh(t) / (std::cosh(u) * std::cosh(u));
  return {1 / (1 + std::exp(-2 * u)), slope * 2 * REACH / STEPS};
}

/// int D V cos_i dw_i over the hemisphere.
double albedo(double cos_o, double alpha) {
  const double sin_o = std::sqrt(1 - cos_o * cos_o);
  const Shadowing shadowing(alpha);
  const double at_o = shadowing(cos_o);
  double sum = 0;
  for (int i = 0; i < STEPS; ++i) {
    const Step height = step(i);
    const double cos_i = height.place, sin_i = std::sqrt(std::max(1 - cos_i * cos_i, 0.0));
    double over_angles = 0;
    for (int j = 0; j < STEPS; ++j) {
      const Step turn = step(j);
      const double angle = std::numbers::pi * turn.place;
      const double hx = sin_o + sin_i * std::cos(angle), hy = sin_i * std::sin(angle), hz = cos_o + cos_i;
      const double across = hx * hx + hy * hy;
      over_angles += std::pow(across / (across + hz * hz), 0.5 / alpha) * turn.share;
    }
    sum += over_angles * height.share / (1 + at_o + shadowing(cos_i));
  }
  // The angle runs over half a turn; D's factor is (2 + 1 / alpha) / (2 pi), V's 1 / (4 cos_o cos_i).
  return 2 * std::numbers::pi * sum * (2 + 1 / alpha) / (2 * std::numbers::pi) / (4 * cos_o);
}

}  // namespace

std::vector<float> make_sheen_table() {
  constexpr double LEAST = 0.01 * SHEEN_LEAST_HUNDREDTHS;
  constexpr double LEAST_COSINE = 1e-6;
  std::vector<float> table;
  table.reserve(size_t{SHEEN_ROWS} * SHEEN_DIRECTIONS);
  for (uint32_t row = 0; row < SHEEN_ROWS; ++row) {
    const double place = static_cast<double>(row) / (SHEEN_ROWS - 1);
    const double roughness = LEAST + (1 - LEAST) * place * place;
    for (uint32_t node = 0; node < SHEEN_DIRECTIONS; ++node) {
      const double root = static_cast<double>(node) / (SHEEN_DIRECTIONS - 1);
      table.push_back(static_cast<float>(albedo(std::max(root * root, LEAST_COSINE), roughness * roughness)));
    }
  }
  return table;
}

}  // namespace regulus::scene
