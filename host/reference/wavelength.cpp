#include "reference/wavelength.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "interface/wavelengths.h"
#include "reference/quadrature.hpp"
#include "reference/rng.hpp"
#include "scene/wavelengths.hpp"

namespace regulus::reference {

using glm::dvec3;
using namespace interface;

namespace {

// Of the Fraunhofer lines F and C.
constexpr double F_LINE = 486.13, C_LINE = 656.27;
constexpr double D_LINE = Wavelength{}.nanometres;

double of_channel(double wavelength, int channel) {
  return scene::clipped_color_matching(wavelength)[channel];
}

/// Integral of the clipped responses over a range, in pieces of a quarter of a nanometre at most: they have
/// kinks.
dvec3 response_over(double from, double to) {
  const int pieces = std::max(1, static_cast<int>(std::ceil(4 * (to - from))));
  dvec3 sum(0);
  for (int channel = 0; channel < 3; ++channel)
    sum[channel] = integrate([channel](double x) { return of_channel(x, channel); }, from, to, pieces);
  return sum;
}

/// All wavelengths, by walking along the spectrum.
std::array<Wavelength, WAVELENGTH_COUNT> all_wavelengths() {
  const dvec3 whole = response_over(scene::SHORTEST_WAVELENGTH, scene::LONGEST_WAVELENGTH);
  const auto share = [&](double from, double to) {
    const dvec3 part = response_over(from, to) / whole;
    return (part.r + part.g + part.b) / 3;
  };
  // Where the share of [from, x] reaches `wanted`.
  const auto advance = [&](double from, double wanted) {
    double low = from, step = 0.25;
    while (share(from, from + step) < wanted) step *= 2;
    double high = from + step;
    for (int i = 0; i < 30; ++i) {
      const double middle = 0.5 * (low + high);
      (share(from, middle) < wanted ? low : high) = middle;
    }
    return 0.5 * (low + high);
  };
  std::array<Wavelength, WAVELENGTH_COUNT> all;
  double from = scene::SHORTEST_WAVELENGTH;
  for (uint32_t i = 0; i < WAVELENGTH_COUNT; ++i) {
    const double middle = advance(from, 0.5 / WAVELENGTH_COUNT);
    const double to =
        i + 1 == WAVELENGTH_COUNT ? scene::LONGEST_WAVELENGTH : advance(middle, 0.5 / WAVELENGTH_COUNT);
    all[i] = {middle, double{WAVELENGTH_COUNT} * response_over(from, to) / whole};
    from = to;
  }
  return all;
}

}  // namespace

Wavelength numbered_wavelength(uint32_t number) {
  static const std::array<Wavelength, WAVELENGTH_COUNT> ALL = all_wavelengths();
  return ALL[number];
}

Wavelength wavelength_of(uint32_t seed, uint32_t iteration) {
  const uint32_t start = hash_bits(seed, WAVELENGTH_STREAM, 0, 0)[0];
  return numbered_wavelength((start + iteration * WAVELENGTH_STEP) >> (32 - WAVELENGTH_BITS));
}

double index_at(const Material& material, const Wavelength& wavelength) {
  const double n_d = material.ior;
  if (!scene::is_dispersive(material) || wavelength.nanometres == D_LINE) return n_d;
  const auto power = [](double x) { return 1 / (x * x); };
  const double abbe = 20.0 / material.dispersion;
  const double b = (n_d - 1) / (abbe * (power(F_LINE) - power(C_LINE)));
  const double a = n_d - b * power(D_LINE);
  return std::clamp(a + b * power(wavelength.nanometres), 1.0, 1e6);
}

}  // namespace regulus::reference
