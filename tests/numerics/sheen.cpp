// Sheen (KHR_materials_sheen) alone: its table against an independent quadrature and published numbers,
// energy, reciprocity.
#include "interface/sheen.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "reference/bsdf.hpp"
#include "reference/quadrature.hpp"
#include "scene/sheen_table.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using namespace interface;
using std::numbers::pi;

BsdfParameters cloth(const SheenTable& table, double roughness, const dvec3& color) {
  BsdfParameters p;
  p.base_color = dvec3(1);
  p.alpha = dvec2(0.3 * 0.3);
  p.sheen = &table;
  p.sheen_color = color;
  p.sheen_roughness = roughness;
  return p;
}

dvec3 direction(double cosine, double angle) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

// Both rules are within 1e-4 of one with ten times as many points (by another program, over these nodes).
TEST(Sheen, TheTableIsTheIntegral) {
  const std::vector<float> table = scene::make_sheen_table();
  ASSERT_EQ(table.size(), size_t{SHEEN_ROWS} * SHEEN_DIRECTIONS);
  constexpr double LEAST = 0.01 * SHEEN_LEAST_HUNDREDTHS;
  double worst = 0;
  for (uint32_t row = 0; row < SHEEN_ROWS; row += 3)
    for (uint32_t node = 1; node < SHEEN_DIRECTIONS; node += 5) {
      const double place = static_cast<double>(row) / (SHEEN_ROWS - 1);
      const double root = static_cast<double>(node) / (SHEEN_DIRECTIONS - 1);
      const double roughness = LEAST + (1 - LEAST) * place * place;
      const double expected = integrated_sheen(root * root, roughness * roughness);
      worst = std::max(worst, std::abs(table[size_t{row} * SHEEN_DIRECTIONS + node] / expected - 1));
    }
  std::printf("largest relative difference %.1e (bound 2e-4)\n", worst);
  EXPECT_LT(worst, 2e-4);
}

// A program of its own (Gauss and Legendre, 160 x 160 points in another mapping) gave these.
TEST(Sheen, ReflectsWhatItsFormulasSay) {
  EXPECT_NEAR(integrated_sheen(0.5, 0.25), 0.187854, 1e-5);
  EXPECT_NEAR(integrated_sheen(0.1, 0.04), 0.559740, 1e-5);
  EXPECT_NEAR(integrated_sheen(0.9, 1), 0.194281, 1e-5);
}

// What sheen and a white base return of even light: never more than there is, and of black cloth what the
// table says, less where grazing directions would get more than all.
TEST(Sheen, MakesNoLight) {
  const SheenTable table(scene::make_sheen_table());
  for (const double roughness : {0.07, 0.3, 0.6, 1.0})
    for (const double cosine : {0.02, 0.2, 0.5, 0.9}) {
      const dvec3 wo = direction(cosine, 0);
      const auto returned = [&](const Bsdf& bsdf) {
        return integrate_2d(
            [&](double v, double t) {
              const double z = t * t * (3 - 2 * t);
              const double angle = pi * (1 - v * v);
              return bsdf.value(wo, direction(z, angle), TransportMode::Radiance).r * z * 6 * t * (1 - t) *
                     2 * pi * v * 2;
            },
            0, 1, 24, 0, 1, 24);
      };
      const double all = returned(Bsdf(cloth(table, roughness, dvec3(1))));
      EXPECT_LT(all, 1.002) << roughness << " " << cosine;
      EXPECT_GT(all, 0.7) << roughness << " " << cosine;
      BsdfParameters black = cloth(table, roughness, dvec3(1));
      black.base_color = dvec3(0);
      black.specular = 0;
      const double expected = integrated_sheen(cosine, roughness * roughness);
      if (roughness >= 0.6) {
        EXPECT_NEAR(returned(Bsdf(black)), expected, 2e-3) << roughness << " " << cosine;
      }
      EXPECT_LT(returned(Bsdf(black)), std::min(expected, 1.0) + 2e-3) << roughness << " " << cosine;
    }
}

TEST(Sheen, IsReciprocal) {
  const SheenTable table(scene::make_sheen_table());
  test::Random random(1);
  for (int i = 0; i < 1000; ++i) {
    const Bsdf bsdf(cloth(table, random.uniform(0.07, 1), dvec3(random.uniform(), random.uniform(), 1)));
    const dvec3 wo = direction(random.uniform(0.01, 1), random.uniform(0, 6));
    const dvec3 wi = direction(random.uniform(0.01, 1), random.uniform(0, 6));
    const dvec3 there = bsdf.value(wo, wi, TransportMode::Radiance);
    const dvec3 back = bsdf.value(wi, wo, TransportMode::Radiance);
    EXPECT_LT(length(there - back), 1e-10 * length(there));
  }
}

}  // namespace
}  // namespace regulus::reference
