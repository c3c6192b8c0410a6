#include "support/chi_square.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "reference/quadrature.hpp"

namespace regulus::test {

using std::numbers::pi;

namespace {

constexpr double SMALLEST_EXPECTATION = 5;

/// Lower regularized incomplete gamma function by its series; for x < a + 1. Abramowitz and Stegun 6.5.29.
double lower_gamma_series(double a, double x) {
  double term = 1 / a;
  double sum = term;
  for (double n = a + 1; term > sum * 1e-16; n += 1) sum += term *= x / n;
  return sum * std::exp(a * std::log(x) - x - std::lgamma(a));
}

/// Upper regularized incomplete gamma function by its continued fraction, evaluated from far down; for
/// x >= a + 1. Abramowitz and Stegun 6.5.31.
double upper_gamma_fraction(double a, double x) {
  double tail = 0;
  for (int n = 2000; n >= 1; --n) tail = n * (a - n) / (x + 2 * n + 1 - a + tail);
  return std::exp(a * std::log(x) - x - std::lgamma(a)) / (x + 1 - a + tail);
}

}  // namespace

double chi_square_survival(double statistic, double degrees_of_freedom) {
  const double a = 0.5 * degrees_of_freedom;
  const double x = 0.5 * statistic;
  if (x <= 0) return 1;
  return x < a + 1 ? 1 - lower_gamma_series(a, x) : upper_gamma_fraction(a, x);
}

ChiSquare chi_square_test(std::span<const double> observed, std::span<const double> expected) {
  ChiSquare result;
  double pooled_observed = 0;
  double pooled_expected = 0;
  int cells = 0;
  const auto add_cell = [&](double count, double expectation) {
    result.statistic += (count - expectation) * (count - expectation) / expectation;
    ++cells;
  };
  for (size_t cell = 0; cell < observed.size(); ++cell) {
    if (expected[cell] < SMALLEST_EXPECTATION) {
      pooled_observed += observed[cell];
      pooled_expected += expected[cell];
    } else {
      add_cell(observed[cell], expected[cell]);
    }
  }
  if (pooled_expected >= SMALLEST_EXPECTATION) {
    add_cell(pooled_observed, pooled_expected);
  } else if (pooled_observed > pooled_expected + 25) {
    // The pool is Poisson with a mean below 5: more than 30 counts have a probability below 1e-13.
    result.problem = "samples where the density is (almost) zero: " + std::to_string(pooled_observed) +
                     " against " + std::to_string(pooled_expected);
  }
  result.degrees_of_freedom = cells - 1;
  if (cells < 2) {
    if (result.problem.empty()) result.problem = "too few cells with enough samples";
    return result;
  }
  result.p_value = chi_square_survival(result.statistic, result.degrees_of_freedom);
  return result;
}

SphereHistogram::SphereHistogram(int z_cells, int azimuth_cells)
    : z_cells_(z_cells), azimuth_cells_(azimuth_cells), observed_(z_cells * azimuth_cells + 1) {}

void SphereHistogram::add(const glm::dvec3& direction) {
  const double azimuth = std::atan2(direction.y, direction.x) / (2 * pi);
  const int row = static_cast<int>(0.5 * (direction.z + 1) * z_cells_);
  const int column = static_cast<int>((azimuth < 0 ? azimuth + 1 : azimuth) * azimuth_cells_);
  observed_[std::clamp(row, 0, z_cells_ - 1) * azimuth_cells_ + std::clamp(column, 0, azimuth_cells_ - 1)] +=
      1;
}

std::vector<double> SphereHistogram::cell_integrals(const std::function<double(const glm::dvec3&)>& pdf,
                                                    int pieces) const {
  std::vector<double> integrals(observed_.size());
  const auto density = [&](double z, double phi) {
    const double sin_theta = std::sqrt(1 - z * z);
    return pdf({sin_theta * std::cos(phi), sin_theta * std::sin(phi), z});
  };
  const double z_step = 2.0 / z_cells_;
  const double phi_step = 2 * pi / azimuth_cells_;
  for (int row = 0; row < z_cells_; ++row)
    for (int column = 0; column < azimuth_cells_; ++column)
      integrals[row * azimuth_cells_ + column] =
          reference::integrate_2d(density, -1 + row * z_step, -1 + (row + 1) * z_step, pieces,
                                  column * phi_step, (column + 1) * phi_step, pieces);
  return integrals;
}

double SphereHistogram::integral(const std::function<double(const glm::dvec3&)>& pdf, int pieces) const {
  const std::vector<double> integrals = cell_integrals(pdf, pieces);
  return std::accumulate(integrals.begin(), integrals.end(), 0.0);
}

ChiSquare SphereHistogram::test(const std::function<double(const glm::dvec3&)>& pdf, int pieces) const {
  std::vector<double> expected = cell_integrals(pdf, pieces);
  expected.back() = std::max(0.0, 1 - std::accumulate(expected.begin(), expected.end(), 0.0));
  const double samples = std::accumulate(observed_.begin(), observed_.end(), 0.0);
  for (double& expectation : expected) expectation *= samples;
  return chi_square_test(observed_, expected);
}

}  // namespace regulus::test
