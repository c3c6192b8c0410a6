// The truth of the sweeps, against what is known of it without its formulas: normalization, energy,
// reciprocity and values in closed form.
#include "stability/exact_bsdf.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "interface/wavefront.h"
#include "stability/quadrature.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using namespace stability;

constexpr Exact PI = std::numbers::pi_v<Exact>;
constexpr uint32_t NDFS[] = {NDF_GGX, NDF_BECKMANN, NDF_COSINE};
constexpr uint32_t SHADOWINGS[] = {SHADOWING_SMITH, SHADOWING_SMITH_UNCORRELATED, SHADOWING_V_CAVITY};

ExactVector direction(Exact theta, Exact phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

TEST(StabilityTruth, FacetsCoverTheSurface) {
  // int D(h) cos dh = 1, down to lobes of a millionth of a radian.
  for (const uint32_t ndf : NDFS)
    for (const Exact alpha : {1e-6L, 1e-3L, 0.1L, 1.0L}) {
      const Exact area = integrate_to_ends(
          [&](Exact theta, Exact) {
            const ExactVector h{std::sin(theta), 0, std::cos(theta)};
            return 2 * PI * exact_density(ndf, ExactPair(alpha), h) * h.z * h.x;
          },
          PI / 2, 256);
      EXPECT_NEAR(static_cast<double>(area), 1, 1e-12) << ndf << " " << static_cast<double>(alpha);
    }
}

TEST(StabilityTruth, VisibleFacetsCoverTheView) {
  // int D(h) max(w.h, 0) dh = cos (1 + Lambda): what Smith's masking is defined by (Heitz 2014, eqs. 14 and
  // 43).
  for (const uint32_t ndf : NDFS)
    for (const Exact alpha : {0.3L, 1.0L})
      for (const Exact theta_w : {0.2L, 1.2L}) {
        const ExactVector w = direction(theta_w, 0);
        const Exact area = integrate_to_ends(
            [&](Exact theta, Exact) {
              // Over azimuth: int max(a + b cos phi, 0), whose zero is known.
              const Exact a = w.z * std::cos(theta), b = w.x * std::sin(theta);
              const Exact edge = a >= b ? PI : std::acos(-a / b);
              return exact_density(ndf, ExactPair(alpha), direction(theta, 0)) * std::sin(theta) * 2 *
                     (a * edge + b * std::sin(edge));
            },
            PI / 2, 512);
        const Exact expected = w.z * (1 + exact_lambda(ndf, ExactPair(alpha), w));
        EXPECT_NEAR(static_cast<double>(area / expected), 1, 1e-7)
            << ndf << " " << static_cast<double>(alpha);
      }
}

TEST(StabilityTruth, FresnelIsKnownWhereItIsSimple) {
  EXPECT_NEAR(static_cast<double>(exact_fresnel(1, 1.5L)), 0.04, 1e-17);
  EXPECT_EQ(exact_fresnel(0.5L, 1 / 1.5L), 1);  // beyond the critical angle
  // At Brewster's angle only the perpendicular half is left: ((n^2 - 1) / (n^2 + 1))^2 / 2.
  const Exact n = 1.5L, brewster = std::cos(std::atan(n));
  const Exact perpendicular = (n * n - 1) / (n * n + 1);
  EXPECT_NEAR(static_cast<double>(exact_fresnel(brewster, n)),
              static_cast<double>(perpendicular * perpendicular / 2), 1e-17);
}

TEST(StabilityTruth, MetalsReflectWhatTheyKeep) {
  // GGX of alpha 1 at normal incidence with Smith's correlated shadowing keeps 1 - ln 2
  // (docs/mathematics.md 2.5).
  const ExactLobe lobe{NDF_GGX, SHADOWING_SMITH_UNCORRELATED, ExactPair(1), 1.5L, true, true};
  const Exact kept = integrate_to_ends(
      [&](Exact theta, Exact) {
        const ExactVector wi = direction(theta, 0);
        return 2 * PI * scatter(lobe, {0, 0, 1}, wi, {BOUND_PEAK, 1e12L}).value * wi.z * wi.x;
      },
      PI / 2, 64);
  EXPECT_NEAR(static_cast<double>(kept), 1 - std::log(2.0), 2e-4);
}

TEST(StabilityTruth, PdfsIntegrateToWhatIsVisible) {
  // Reflection by visible normals, from above: what stays above the surface; from all facets it is 1. Here
  // facets are so flat that nothing leaves below.
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : SHADOWINGS) {
      const ExactLobe lobe{ndf, shadowing, ExactPair(0.02L), 1.5L, true, true};
      const Exact sum = integrate_to_ends(
          [&](Exact theta, Exact) {
            const ExactVector wi = direction(theta, 0);
            return 2 * PI * scatter(lobe, {0, 0, 1}, wi, {BOUND_PEAK, 1e12L}).forward * wi.x;
          },
          PI / 2, 64);
      EXPECT_NEAR(static_cast<double>(sum), 1, 2e-3) << ndf << " " << shadowing;
    }
}

TEST(StabilityTruth, RefractionIsReciprocal) {
  // rho(wo, wi) n_i^2 = rho(wi, wo) n_o^2, and pdfs change places.
  for (const uint32_t ndf : NDFS)
    for (const uint32_t shadowing : SHADOWINGS) {
      const ExactVector wo = direction(0.7L, 0.2L);
      const ExactVector below = direction(0.4L, 3.4L);
      const ExactBound bound{BOUND_PEAK, 10};
      const ExactLobe front{ndf, shadowing, ExactPair(0.3L), 1.5L, true, false};
      const ExactLobe back{ndf, shadowing, ExactPair(0.3L), 1.5L, false, false};
      const ExactScattering there = scatter(front, wo, {below.x, below.y, -below.z}, bound);
      const ExactScattering again = scatter(back, below, {wo.x, wo.y, -wo.z}, bound);
      ASSERT_GT(there.value, 0);
      EXPECT_NEAR(static_cast<double>(there.value * 2.25L / again.value), 1, 1e-12);
      EXPECT_NEAR(static_cast<double>(there.forward / again.reverse), 1, 1e-12);
      EXPECT_NEAR(static_cast<double>(there.reverse / again.forward), 1, 1e-12);
    }
}

TEST(StabilityTruth, RaisedPeaksMeetTheirBound) {
  // The directional bound is the lobe's value at its mean facet (docs/mathematics.md 2.4): there it equals
  // tau, for all tau that alpha can meet.
  for (const uint32_t shadowing : SHADOWINGS)
    for (const Exact theta : {0.0L, 0.7L, 1.3L})
      for (const Exact tau : {5.0L, 1e4L}) {
        const ExactLobe lobe{NDF_GGX, shadowing, ExactPair(1e-6L), 1.5L, true, true};
        const ExactVector wo = direction(theta, 0);
        const ExactScattering s = scatter(lobe, wo, {-wo.x, 0, wo.z}, {BOUND_DIRECTIONAL, tau});
        // V-cavity: 1 / (4 pi alpha^2 c^2) with c = cos: value; Smith: G2 of both directions, over their
        // cosines.
        EXPECT_NEAR(static_cast<double>(s.raised / tau), 1, 1e-9)
            << shadowing << " " << static_cast<double>(theta);
      }
}

}  // namespace
}  // namespace regulus::test
