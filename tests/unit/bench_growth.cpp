// Exponents of growth against powers that are known.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "bench/growth.hpp"
#include "bench/growth_scene.hpp"
#include "prepared/prepared_scene.hpp"
#include "scene/placement.hpp"
#include "unit/image_files.hpp"

namespace regulus::bench {
namespace {

using Points = std::vector<std::pair<double, double>>;

TEST(PowerFit, IsThePower) {
  for (const double exponent : {-0.5, 0.0, 1.0, 2.5}) {
    Points points;
    for (const double x : {1.0, 7.0, 30.0, 1e4}) points.emplace_back(x, 3 * std::pow(x, exponent));
    const PowerFit fit = fit_power(points);
    EXPECT_NEAR(fit.exponent, exponent, 1e-12);
    EXPECT_NEAR(fit.last, exponent, 1e-12);
    EXPECT_NEAR(fit.deviation, 0, 1e-6);
  }
}

// A cost that is always there flattens the small sizes: the last two say more.
TEST(PowerFit, LastSizesSeeLessOfFixedCosts) {
  Points points;
  for (const double x : {1.0, 10.0, 100.0, 1000.0}) points.emplace_back(x, 10 + x);
  const PowerFit fit = fit_power(points);
  EXPECT_LT(fit.exponent, 0.75);
  EXPECT_NEAR(fit.last, std::log10(1010.0 / 110.0), 1e-12);
}

// Of 2,000 fits to points with 10 % of noise the standard errors are those of Student's t with 3 degrees of
// freedom: |t| < 3.182 in 95 % of them. 5 standard deviations of the count are 2.4 %.
TEST(PowerFit, DeviationIsThatOfTheFits) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.1);
  int within = 0;
  constexpr int FITS = 2000;
  for (int i = 0; i < FITS; ++i) {
    Points points;
    for (const double x : {1.0, 3.0, 10.0, 30.0, 100.0}) points.emplace_back(x, x * std::exp(noise(random)));
    const PowerFit fit = fit_power(points);
    within += std::abs(fit.exponent - 1) < 3.182 * fit.deviation ? 1 : 0;
  }
  EXPECT_NEAR(within / double{FITS}, 0.95, 0.024);
}

TEST(GrowthSweep, ExponentOfNLogN) {
  const GrowthSweep sweep{"", "", {{.size = 10}, {.size = 1000}, {.size = 1e5}}};
  EXPECT_NEAR(log_linear_exponent(sweep),
              std::log(1e5 * std::log(1e5) / (1e3 * std::log(1e3))) / std::log(100.0), 1e-12);
}

// The scene has as much of everything as was asked for, and a stone is stored once.
TEST(GrowthScene, HasWhatIsAskedFor) {
  const test::TemporaryFolder folder;
  const PreparedScene plain = prepare(load_growth_scene(write_growth_scene({}, folder.path())));
  EXPECT_EQ(scene::placed_triangle_count(plain.scene), 2 * 32 * 32 + 1u);
  EXPECT_EQ(plain.scene.lights.size(), 1u);
  const PreparedScene more = prepare(load_growth_scene(
      write_growth_scene({.triangles = 200, .lights = 50, .instances = 30}, folder.path())));
  EXPECT_EQ(more.scene.lights.size(), 50u);
  EXPECT_EQ(scene::placed_triangle_count(more.scene), 200 + 50 + 8 * 30u);
  EXPECT_EQ(more.scene.triangles.size(), 200 + 50 + 8u);
}

}  // namespace
}  // namespace regulus::bench
