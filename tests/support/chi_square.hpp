// Pearson's chi-square test of samples against a density, and the correction for many tests.
#pragma once

#include <functional>
#include <glm/glm.hpp>
#include <span>
#include <string>
#include <vector>

#include "image/comparison.hpp"

namespace regulus::test {

/// Probability that a chi-square variable of `degrees_of_freedom` exceeds `statistic`.
double chi_square_survival(double statistic, double degrees_of_freedom);

using image::significance_per_test;

struct ChiSquare {
  double statistic = 0;
  int degrees_of_freedom = 0;
  double p_value = 1;   ///< of counts at least this far off, if the samples follow the density
  std::string problem;  ///< a count where none may be, or too few samples to test; empty: none
};

/// Compares counts with their expectations, cell by cell. Cells that expect fewer than 5 samples are pooled.
/// `observed` and `expected` have equal sums up to the samples that were found invalid, which must be given
/// a cell of their own.
ChiSquare chi_square_test(std::span<const double> observed, std::span<const double> expected);

/// Cells over the unit sphere, equal in z and azimuth (so of equal solid angle), and one for invalid samples.
class SphereHistogram {
 public:
  SphereHistogram(int z_cells, int azimuth_cells);

  void add(const glm::dvec3& direction);
  void add_invalid() { observed_.back() += 1; }

  /// Tests all added samples against `pdf`, a solid-angle density over the sphere that may integrate to less
  /// than 1: the rest is the expectation of invalid samples. Each cell is integrated with Gauss-Legendre
  /// rules of 8 x 8 points on `pieces` x `pieces` parts.
  ChiSquare test(const std::function<double(const glm::dvec3&)>& pdf, int pieces = 1) const;

  /// Integral of the density over the sphere, as in test().
  double integral(const std::function<double(const glm::dvec3&)>& pdf, int pieces = 1) const;

 private:
  std::vector<double> cell_integrals(const std::function<double(const glm::dvec3&)>& pdf, int pieces) const;

  int z_cells_, azimuth_cells_;
  std::vector<double> observed_;
};

}  // namespace regulus::test
