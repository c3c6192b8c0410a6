// Thin films (KHR_materials_iridescence) alone: their colours against a sum over wavelengths, energy,
// reciprocity, limits.
#include "reference/iridescence.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

#include "reference/bsdf.hpp"
#include "reference/quadrature.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;

dvec3 direction(double cosine, double angle) {
  const double sine = std::sqrt(1 - cosine * cosine);
  return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

double lobe(double wavelength, double mean, double below, double above) {
  const double x = (wavelength - mean) / (wavelength < mean ? below : above);
  return std::exp(-0.5 * x * x);
}

/// The CIE's colour matching functions of 1931 as Wyman, Sloan and Shirley fit them ("Simple Analytic
/// Approximations to the CIE XYZ Color Matching Functions", 2013): other Gaussians than the extension's, in
/// wavelength.
dvec3 colour_matching(double wavelength) {
  const auto at = [wavelength](double mean, double below, double above) {
    return lobe(wavelength, mean, below, above);
  };
  return {1.056 * at(599.8, 37.9, 31.0) + 0.362 * at(442.0, 16.0, 26.7) - 0.065 * at(501.1, 20.4, 26.2),
          0.821 * at(568.8, 46.9, 40.5) + 0.286 * at(530.9, 16.3, 31.1),
          1.217 * at(437.0, 11.8, 36.0) + 0.681 * at(459.0, 26.0, 13.8)};
}

double schlick(double n1, double n2, double cosine) {
  const double f0 = (n1 - n2) * (n1 - n2) / ((n1 + n2) * (n1 + n2));
  return f0 + (1 - f0) * std::pow(1 - cosine, 5);
}

/// What a film reflects by Airy's formula, at each wavelength the sum of all orders, seen in light of equal
/// energy: white is 1 in each channel, as the extension has it for what does not interfere.
dvec3 airy(double ior, double thickness, double base_ior, double cosine) {
  const double cosine_inside = std::sqrt(1 - (1 - cosine * cosine) / (ior * ior));
  const double first = -std::sqrt(schlick(1, ior, cosine));  // a denser medium turns the wave
  const double second = (base_ior > ior ? -1 : 1) * std::sqrt(schlick(ior, base_ior, cosine_inside));
  const double passed = 1 - first * first;
  const double mean =
      first * first + passed * passed * second * second / (1 - first * first * second * second);
  dvec3 sum(0), whole(0);
  for (double wavelength = 361; wavelength < 830; wavelength += 2) {
    const double phase = 4 * pi * ior * thickness * cosine_inside / wavelength;
    const std::complex<double> turned = second * std::exp(std::complex<double>(0, phase));
    const double reflected = std::norm((first + turned) / (1.0 + first * turned));
    sum += (reflected - mean) * colour_matching(wavelength);
    whole += colour_matching(wavelength);
  }
  const dvec3 xyz = sum / whole;
  const dvec3 rgb = {3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
                     -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
                     0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z};
  return glm::clamp(mean + rgb, 0.0, 1.0);
}

// The extension's fit is one in wave numbers, whose tails differ, and it ends with the second order.
TEST(Iridescence, ColoursAreThoseOfASumOverWavelengths) {
  double worst = 0, sum = 0;
  int count = 0;
  for (const double ior : {1.2, 1.33, 1.8, 2.2})
    for (const double base_ior : {1.5, 2.0, 4.0})
      for (double thickness = 100; thickness <= 1200; thickness += 50)
        for (const double cosine : {1.0, 0.7, 0.4}) {
          const double f0 =
              std::pow((base_ior - 1) / (base_ior + 1), 2) - 0.0001;  // which the extension adds
          const dvec3 found = ThinFilm{ior, thickness}.reflectance(dvec3(f0), cosine);
          const dvec3 error = abs(found - airy(ior, thickness, base_ior, cosine));
          worst = std::max({worst, error.r, error.g, error.b});
          sum += (error.r + error.g + error.b) / 3;
          ++count;
        }
  std::printf("largest difference of %d films %.4f, mean %.4f\n", count, worst, sum / count);
  EXPECT_LT(worst, 0.05);
  EXPECT_LT(sum / count, 0.005);
}

/// Bases of all kinds under random films.
BsdfParameters random_surface(test::Random& random) {
  BsdfParameters p;
  p.base_color = dvec3(1);
  p.film_strength = 1;
  p.film = {random.uniform(1, 3), random.uniform(0, 1200)};
  p.ior = random.uniform(1.05, 2.5);
  p.alpha = dvec2(random.log_uniform(0.005, 1));
  p.metallic = random.uniform() < 0.3 ? random.uniform() : 0;
  p.transmission = random.uniform() < 0.3 ? random.uniform() : 0;
  p.specular = random.uniform() < 0.3 ? random.uniform() : 1;
  p.is_volume = random.uniform() < 0.5;
  if (random.uniform() < 0.3) p.specular_color = {random.uniform(), random.uniform(0, 2), 0};
  return p;
}

// All samples together carry what a white surface returns of even light: never more than there is. From
// inside solids radiance grows by the index squared, so there importance counts.
TEST(Iridescence, MakesNoLight) {
  test::Random random(3);
  double most = 0, sum = 0;
  constexpr int SURFACES = 150, SAMPLES = 48;
  for (int i = 0; i < SURFACES; ++i) {
    const Bsdf bsdf(random_surface(random));
    const bool is_inside = bsdf.parameters().is_volume && bsdf.parameters().transmission > 0 && i % 2 == 0;
    const dvec3 wo = direction(random.log_uniform(0.05, 1), 0.3) * dvec3(1, 1, is_inside ? -1 : 1);
    const double shift = random.uniform();
    dvec3 returned(0);
    for (int j = 0; j < SAMPLES * SAMPLES; ++j) {
      const dvec2 u((j % SAMPLES + 0.5) / SAMPLES, (j / SAMPLES + 0.5) / SAMPLES);
      const double u_lobe = std::fmod(0.6180339887498949 * j + shift, 1.0);
      const BsdfSample s = bsdf.sample(wo, u_lobe, u, TransportMode::Importance);
      if (s.is_valid) returned += s.weight;
    }
    returned /= SAMPLES * SAMPLES;
    most = std::max({most, returned.r, returned.g, returned.b});
    sum += (returned.r + returned.g + returned.b) / 3;
    EXPECT_LT(std::max({returned.r, returned.g, returned.b}), 1.01)
        << i << " film " << bsdf.parameters().film.ior << " " << bsdf.parameters().film.thickness << " ior "
        << bsdf.parameters().ior << " alpha " << bsdf.parameters().alpha.x << " cosine " << wo.z;
  }
  std::printf("most of %d surfaces %.4f, mean %.3f\n", SURFACES, most, sum / SURFACES);
  EXPECT_GT(sum / SURFACES, 0.6);
}

TEST(Iridescence, IsReciprocal) {
  test::Random random(1);
  for (int i = 0; i < 2000; ++i) {
    const Bsdf bsdf(random_surface(random));
    const dvec3 wo = direction(random.uniform(0.01, 1), random.uniform(0, 6));
    dvec3 wi = direction(random.uniform(0.01, 1), random.uniform(0, 6));
    if (i % 2 == 0) wi = -wi;
    const dvec3 there = bsdf.value(wo, wi, TransportMode::Radiance);
    const dvec3 back = bsdf.value(wi, wo, TransportMode::Importance);
    EXPECT_LE(length(there - back), 1e-8 * length(there)) << i;
  }
}

// Half of the pdfs' mass may be missing where facets send light below the surface, never more than all found:
// the choice between lobes sums to one both ways.
TEST(Iridescence, PdfsAreDensities) {
  test::Random random(2);
  for (int i = 0; i < 12; ++i) {
    BsdfParameters p = random_surface(random);
    p.alpha = glm::max(p.alpha, dvec2(0.2));
    const Bsdf bsdf(p);
    const dvec3 wo = direction(random.uniform(0.1, 1), 0.3);
    const double mass = integrate_2d(
        [&](double z, double angle) {
          return bsdf.pdf(wo, direction(z, angle) * dvec3(1, 1, z < 0 ? 1 : 1));
        },
        -1, 1, 48, 0, 2 * pi, 24);
    EXPECT_LT(mass, 1.02) << i;
    EXPECT_GT(mass, 0.5) << i;
  }
}

// A film with the index of its base is no interface but the first; one without thickness reflects as the base
// does at normal incidence, up to Schlick's forms and the colour of equal energy in Rec. 709; at grazing and
// beyond the critical angle everything is reflected.
TEST(Iridescence, HasItsLimits) {
  const auto f0 = [](double ior) { return std::pow((ior - 1) / (ior + 1), 2); };
  const dvec3 same = ThinFilm{1.5, 300}.reflectance(dvec3(f0(1.5)), 1);
  EXPECT_LT(length(same - f0(1.5)), 0.02);  // of which .0001 more at normal incidence makes .012
  const dvec3 bare = ThinFilm{1.5, 0}.reflectance(dvec3(f0(2)), 1);
  EXPECT_NEAR(bare.g, f0(2), 0.006);  // 1 - .948 of 2 r12 r23 = .057
  EXPECT_LT(length(ThinFilm{1.5, 300}.reflectance(dvec3(0.1), 0) - 1.0), 1e-12);
  BsdfParameters p;
  p.base_color = dvec3(1);
  p.alpha = dvec2(0);
  p.transmission = p.film_strength = 1;
  p.film = {1.7, 400};
  p.is_volume = true;
  const BsdfSample total =
      Bsdf(p).sample(direction(0.5, 0) * dvec3(1, 1, -1), 0.5, {0.5, 0.5}, TransportMode::Radiance);
  EXPECT_FALSE(total.is_transmitted);
  EXPECT_LT(length(total.weight - 1.0), 1e-12);
}

}  // namespace
}  // namespace regulus::reference
