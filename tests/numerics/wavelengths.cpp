// The wavelengths of dispersion: against the CIE's table, the device's table against the reference's
// definition, how evenly iterations have them, and what follows for colours.
#include "scene/wavelengths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <vector>

#include "reference/wavelength.hpp"
#include "support/standard_observer.hpp"

namespace regulus::reference {
namespace {

using glm::dvec3;
using interface::WAVELENGTH_COUNT;

// The fit's own error is a hundredth or two.
TEST(Wavelengths, ColourMatchingIsTheStandardObservers) {
  for (size_t i = 0; i < test::observer().size(); ++i) {
    const dvec3 found = scene::color_matching(test::observed(i));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], test::observer()[i][c], 0.05) << i << " " << c;
  }
}

// The device's table is made by interpolation in a cumulative sum, the reference's numbers by quadrature and
// bisection.
TEST(Wavelengths, TableOfTheDeviceIsTheDefinition) {
  const std::vector<interface::Wavelength> table = scene::make_wavelengths();
  ASSERT_EQ(table.size(), WAVELENGTH_COUNT);
  interface::Material glass {};
  glass.ior = 2;
  glass.dispersion = 20;  // V_d = 1
  dvec3 sum(0);
  double worst_bend = 0, worst_response = 0;
  for (uint32_t i = 0; i < WAVELENGTH_COUNT; ++i) {
    const Wavelength wanted = numbered_wavelength(i);
    const double bend = table[i].bend, index = index_at(glass, wanted);
    if (index > 1) worst_bend = std::max(worst_bend, std::abs(2 + bend - index));
    worst_response = std::max(worst_response, length(dvec3(table[i].response) - wanted.response));
    EXPECT_NEAR(table[i].response.r + table[i].response.g + table[i].response.b, 3, 1e-5);
    sum += dvec3(table[i].response);
    for (int c = 0; c < 3; ++c) EXPECT_FALSE(std::signbit(table[i].response[c])) << i;
  }
  std::printf("largest differences: bend %.2g, response %.2g\n", worst_bend, worst_response);
  EXPECT_LT(worst_bend, 2e-5);
  EXPECT_LT(worst_response, 1e-4);
  EXPECT_LT(length(sum / double{WAVELENGTH_COUNT} - 1.0), 1e-6);
}

// What the responses are for: the mean of a function of the wavelength, here a steep one, is its mean in
// light of equal energy as the standard observer sees it, white being 1 in each channel.
TEST(Wavelengths, ResponsesShowWhatTheObserverSees) {
  const auto passed = [](double wavelength) { return 1 / (1 + std::exp((wavelength - 545) / 20)); };
  dvec3 known(0), whole(0), found(0);
  for (size_t i = 0; i < test::observer().size(); ++i) {
    const dvec3 response = test::seen(test::observer()[i]);
    known += passed(test::observed(i)) * response;
    whole += response;
  }
  known /= whole;
  for (uint32_t i = 0; i < WAVELENGTH_COUNT; ++i) {
    const Wavelength wavelength = numbered_wavelength(i);
    found += passed(wavelength.nanometres) * wavelength.response / double{WAVELENGTH_COUNT};
  }
  std::printf("seen %.4f %.4f %.4f, known %.4f %.4f %.4f\n", found.r, found.g, found.b, known.r, known.g,
              known.b);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], known[c], 0.012);
}

// The definition of Abbe's number, and the extension's rounded formula.
TEST(Wavelengths, IndicesFollowAbbesNumber) {
  interface::Material glass {};
  glass.ior = 1.5168f;
  glass.dispersion = 20 / 64.17f;
  const auto index = [&](double nanometres) { return index_at(glass, {nanometres}); };
  EXPECT_NEAR((index(587.56) - 1) / (index(486.13) - index(656.27)), 64.17, 1e-4);
  EXPECT_EQ(index(587.56), double{glass.ior});
  for (double nanometres = 380; nanometres < 780; nanometres += 20)
    EXPECT_NEAR(index(nanometres),
                glass.ior + (glass.ior - 1.0) / 64.17 * (523655 / (nanometres * nanometres) - 1.5168), 1e-6);
  glass.dispersion = 1000;
  EXPECT_EQ(index(700), 1);  // as the extension has it
}

// Every run of iterations is spread: no interval has many more or fewer of them than its share. The bound is
// twice the discrepancy of multiples of the golden ratio, .312 ln n (Dupain and Sos 1984), as a run may begin
// anywhere.
TEST(Wavelengths, EveryRunOfIterationsIsSpread) {
  std::vector<double> all;
  for (uint32_t i = 0; i < WAVELENGTH_COUNT; ++i) all.push_back(numbered_wavelength(i).nanometres);
  const auto place_of = [&](uint32_t seed, uint32_t iteration) {
    const auto found = std::ranges::lower_bound(all, wavelength_of(seed, iteration).nanometres);
    return (static_cast<double>(found - all.begin()) + 0.5) / WAVELENGTH_COUNT;
  };
  for (const uint32_t seed : {0u, 1u, 77u})
    for (const uint32_t first : {0u, 5u, 1000003u})
      for (const uint32_t length : {2u, 5u, 16u, 100u, 1000u}) {
        std::vector<double> places;
        for (uint32_t i = 0; i < length; ++i) places.push_back(place_of(seed, first + i));
        std::ranges::sort(places);
        double worst = 0;
        for (uint32_t i = 0; i < length; ++i)
          worst = std::max(worst, std::abs(places[i] * length - (i + 0.5)));
        EXPECT_LT(worst, 2 * 0.312 * std::log(length) + 2 + length * 1.0 / WAVELENGTH_COUNT)
            << seed << " " << first << " " << length;
      }
}

// Seeds begin anywhere: the first iteration of many has all wavelengths alike.
TEST(Wavelengths, SeedsBeginAnywhere) {
  constexpr int SEEDS = 20000, CELLS = 16;
  const double edge = numbered_wavelength(WAVELENGTH_COUNT / CELLS).nanometres;
  int below = 0;
  for (uint32_t seed = 0; seed < SEEDS; ++seed) below += wavelength_of(seed, 0).nanometres < edge ? 1 : 0;
  const double deviation = std::sqrt(SEEDS * (1.0 / CELLS) * (1 - 1.0 / CELLS));
  EXPECT_NEAR(below, static_cast<double>(SEEDS) / CELLS, 5 * deviation);
}

}  // namespace
}  // namespace regulus::reference
