// Numerical integration for the reference: composite Gauss-Legendre rules. Used where the model defines a
// quantity by an integral, so that no closed form has to be trusted.
#pragma once

#include <array>
#include <cmath>

namespace regulus::reference {

/// Nodes and weights of the 8-point Gauss-Legendre rule on [-1, 1] (exact for polynomials of degree 15). Only
/// the positive half: the rule is symmetric. Abramowitz and Stegun, table 25.4.
struct GaussLegendre8 {
  static constexpr std::array<double, 4> NODES = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267,
                                                  0.9602898564975363};
  static constexpr std::array<double, 4> WEIGHTS = {0.3626837833783620, 0.3137066458778873,
                                                    0.2223810344533745, 0.1012285362903763};
};

/// Integral of `f` (double -> double) over [a, b], cut into `pieces` equal parts.
template <typename Function>
double integrate(const Function& f, double a, double b, int pieces = 1) {
  const double half = 0.5 * (b - a) / pieces;
  double sum = 0;
  for (int piece = 0; piece < pieces; ++piece) {
    const double middle = a + (2 * piece + 1) * half;
    for (size_t k = 0; k < GaussLegendre8::NODES.size(); ++k) {
      const double offset = half * GaussLegendre8::NODES[k];
      sum += GaussLegendre8::WEIGHTS[k] * (f(middle - offset) + f(middle + offset));
    }
  }
  return sum * half;
}

/// Integral of f(x, y) over the rectangle [ax, bx] x [ay, by], cut into pieces_x times pieces_y cells.
template <typename Function>
double integrate_2d(const Function& f, double ax, double bx, int pieces_x, double ay, double by,
                    int pieces_y) {
  return integrate([&](double x) { return integrate([&](double y) { return f(x, y); }, ay, by, pieces_y); },
                   ax, bx, pieces_x);
}

/// Integral of `f` over [0, 1] with cells that halve towards 0, for integrands whose features sit there at
/// an unknown scale down to 2^-levels.
template <typename Function>
double integrate_graded(const Function& f, int levels = 40, int pieces = 2) {
  double sum = 0;
  double upper = 1;
  for (int level = 0; level < levels; ++level, upper *= 0.5) sum += integrate(f, 0.5 * upper, upper, pieces);
  return sum + integrate(f, 0, upper);
}

}  // namespace regulus::reference
