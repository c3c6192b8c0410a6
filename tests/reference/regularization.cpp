// What regularization does at a vertex and when it stops, each against what defines it.
#include "reference/regularization.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "reference/estimator.hpp"
#include "reference/support/reference_images.hpp"
#include "support/random.hpp"

namespace regulus::reference {
namespace {

using glm::dvec2;
using glm::dvec3;
using std::numbers::pi;
using namespace interface;

dvec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

// The schedule shrinks alpha_tau. In each iteration a path is sampled well enough if q reaches the square of
// the tau that this iteration's alpha_tau belongs to, whatever the power of alpha in the bound.
TEST(SamplerQuality, ThresholdIsTheTauOfTheIterationsAlpha) {
  const PreparedScene prepared = test::prepare(test::own_scenes() / "cornell" / "cornell.gltf");
  const Camera camera(scene::make_camera(prepared.scene.cameras[0], 8, 8), 8, 8);
  BsdfParameters mirror;
  mirror.metallic = 1;
  mirror.alpha = dvec2(0);
  struct Case {
    uint32_t bound, shadowing, ndf;
  };
  for (const Case& tried :
       {Case{BOUND_PEAK, SHADOWING_SMITH, NDF_GGX}, Case{BOUND_SMITH, SHADOWING_SMITH, NDF_GGX},
        Case{BOUND_SMITH, SHADOWING_SMITH_UNCORRELATED, NDF_BECKMANN},
        Case{BOUND_SMITH, SHADOWING_V_CAVITY, NDF_GGX}}) {
    const World world(prepared, tried.ndf, tried.shadowing);
    Settings settings = test::reference_settings(8, 8, 1, 4);
    settings.techniques = test::BPT;
    settings.regularization = REGULARIZATION_ROUGHNESS | REGULARIZATION_CONSISTENT;
    settings.sampler_quality = SAMPLER_QUALITY_ON;
    settings.bound = tried.bound;
    settings.shadowing = tried.shadowing;
    settings.ndf = tried.ndf;
    settings.tau = 300;
    mirror.shadowing = tried.shadowing;
    mirror.ndf = tried.ndf;
    const Bsdf bsdf(mirror);
    const dvec3 up(0, 0, 1);
    for (const uint32_t sample : {0U, 6U, 700U}) {
      const double alpha = raised_alpha(bsdf, up, up, regularization_of(settings, sample)).x;
      // The tau under which the first iteration raises to this alpha, by bisection.
      double low = 1, high = 1e8;
      for (int i = 0; i < 100; ++i) {
        settings.tau = std::sqrt(low * high);
        (raised_alpha(bsdf, up, up, regularization_of(settings, 0)).x > alpha ? low : high) = settings.tau;
      }
      const double expected = high * high;
      settings.tau = 300;
      const double found = Estimator(world, camera, settings).techniques(sample).enough_quality;
      EXPECT_NEAR(found / expected, 1, 1e-9) << "bound " << tried.bound << " sample " << sample;
    }
  }
}

/// A rough base, of more alpha than any bound here raises to, under a clearcoat.
BsdfParameters coated(double alpha) {
  BsdfParameters parameters;
  parameters.base_color = {0.5, 0.3, 0.1};
  parameters.alpha = dvec2(0.9);
  parameters.clearcoat = 0.7;
  parameters.coat_alpha = dvec2(alpha);
  return parameters;
}

Regularization virtual_merges() {
  Regularization regularization;
  regularization.is_on = true;
  regularization.is_virtual = true;
  regularization.tau = regularization.full_tau = 40;
  regularization.alpha_scale = 0.8;
  return regularization;
}

VirtualTries many_tries(int count) {
  test::Random random(11);
  VirtualTries tries;
  for (int i = 0; i < count; ++i)
    for (std::vector<dvec3>* numbers : {&tries.of_base, &tries.of_coat})
      numbers->push_back({random.uniform(), random.uniform(), random.uniform()});
  return tries;
}

Surface flat() {
  Surface surface;
  surface.geometric_normal = surface.shading_normal = {0, 0, 1};
  return surface;
}

// All that a smooth coat reflects falls into a cone around the mirrored direction, and nothing of it into one
// beside it (Kaplanyan and Dachsbacher 2013). The base under it is measured as it is.
TEST(VirtualMerges, ConeHoldsWhatASmoothCoatReflects) {
  const Regularization regularization = virtual_merges();
  const double solid_angle = 0.8 * 0.8 / 40;  // 2 pi (1 - cos)
  const double half_angle = std::acos(1 - solid_angle / (2 * pi));
  const Bsdf bsdf(coated(0));
  const dvec3 w_camera = direction(0.6, 0);
  const double cosine = w_camera.z;
  const double reflected = 0.7 * (0.04 + 0.96 * std::pow(1 - cosine, 5));
  for (const double off : {0.0, 0.9 * half_angle, 1.1 * half_angle}) {
    const dvec3 w_light = direction(0.6 + off, pi);
    const VertexScattering found =
        scattering_between(flat(), bsdf, w_light, w_camera, regularization, many_tries(4));
    ASSERT_TRUE(found.raised);
    const double coat = off > half_angle ? 0 : reflected / (solid_angle * w_light.z);
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(found.raised->value[c], found.value[c] + coat, 1e-9 * (1 + coat)) << off;
  }
}

// Of a rough coat as much as falls into the cone: the mean of 40,000 tries against an integral over the cone.
TEST(VirtualMerges, ConeHoldsItsShareOfARoughCoat) {
  const Regularization regularization = virtual_merges();
  const double height = 0.8 * 0.8 / 40 / (2 * pi);
  const Bsdf bsdf(coated(0.03)), base = bsdf.with_coat_alpha(dvec2(0));
  const dvec3 w_camera = direction(0.5, 0), axis = direction(0.55, pi + 0.03);
  const Basis basis(axis);
  double mean = 0;
  constexpr int STEPS = 400;
  for (int i = 0; i < STEPS; ++i)
    for (int k = 0; k < STEPS; ++k) {
      const double z = 1 - height * (i + 0.5) / STEPS, phi = 2 * pi * (k + 0.5) / STEPS;
      const double r = std::sqrt(1 - z * z);
      const dvec3 w = basis.to_world({r * std::cos(phi), r * std::sin(phi), z});
      mean += (bsdf.value(w_camera, w, TransportMode::Radiance) -
               base.value(w_camera, w, TransportMode::Radiance))
                  .x *
              w.z / (STEPS * STEPS);
    }
  constexpr int TRIES = 40000;
  const VertexScattering found =
      scattering_between(flat(), bsdf, axis, w_camera, regularization, many_tries(TRIES));
  const VertexScattering below = scattering_between(flat(), base, axis, w_camera);
  ASSERT_TRUE(found.raised);
  const double coat = (found.raised->value.x - below.value.x) * axis.z;
  // A share P of the tries falls into the cone, with weights that hardly differ: 5 standard deviations.
  const double bound = 5 * mean * std::sqrt(1 / (0.3 * TRIES));
  std::printf("%.5g in the cone by %d tries, %.5g by the integral (bound %.2g)\n", coat, TRIES, mean, bound);
  EXPECT_NEAR(coat, mean, bound);
}

}  // namespace
}  // namespace regulus::reference
