// Regularization at one perfect mirror, where bias, variance and the worth of each kind of weights are known.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using render::RenderSettings;

constexpr double PI = std::numbers::pi;
using namespace technique_sets;

class OneMirror : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    if (is_slow_device()) GTEST_SKIP() << "slow device";
  }
};

nlohmann::json mirror() {
  return metal({1, 1, 1}, 0);
}

/// Mirrors are raised to alpha at the first iteration.
RenderSettings raised_to(RenderSettings settings, double alpha, uint32_t mis = MIS_BLENDED) {
  settings.techniques = PT;
  settings.regularization = REGULARIZATION_ROUGHNESS;
  settings.mis = mis;
  settings.tau = tau_of_mirrors(alpha);
  return settings;
}

// A point light over a mirror lights a white receiver that stands on it and faces it: what it gets by way of
// the mirror is that of an image source.
class PointLight : public OneMirror {
 protected:
  void SetUp() override {
    OneMirror::SetUp();
    if (IsSkipped()) return;
    const glm::dvec3 receiver(2, 0.9, 0.3), light(0, 1.1, 0), image(0, -1.1, 0);
    GltfScene scene;
    scene.add({quad({-400, 0, 400}, {800, 0, 0}, {0, 0, -800})}, mirror());
    constexpr double SIDE = 1e-3;
    scene.add({quad(receiver - glm::dvec3(0, SIDE, SIDE), {0, 0, 2 * SIDE}, {0, 2 * SIDE, 0})},
              lambert({1, 1, 1}));
    scene.add_point_light(light, {PI, PI, PI});
    scene.set_orthographic(look_at(receiver - glm::dvec3(0.1, 0, 0), receiver), SIDE / 2, SIDE / 2);
    scene_ = prepare(scene);
    const auto from = [&](const glm::dvec3& source) {
      const glm::dvec3 d = source - receiver;
      return -d.x / std::pow(glm::length(d), 3);
    };
    direct_ = from(light);
    reflected_ = from(image);
  }
  /// What comes over the mirror, relative to the truth. The light's direct share has no noise.
  double reflected(const RenderSettings& settings) {
    return (mean_of(render(scene_, settings).image)[0] - direct_) / reflected_;
  }

  PreparedScene scene_;
  double direct_ = 0, reflected_ = 0;  // radiance of the receiver
};

// docs/mathematics.md 8 (e), (f): E / exact and variance alpha^2 as a program without any renderer found them
// by 8e6 samples of the same estimator, the raised lobe divided by what it reflects of even light
// (docs/derivations/one_mirror.out). What is missing or too much is the lobe's tail. Five standard errors of
// 524,288 samples.
TEST_F(PointLight, TheRaisedMirrorKeepsItsLightAndVarianceRisesWithTheBandwidth) {
  struct Known {
    double alpha, energy, variance;
  };
  for (const Known& known :
       {Known{0.4, 1.0215, 5.972}, {0.2, 0.9937, 16.35}, {0.1, 0.9851, 57.64}, {0.05, 0.9959, 228.2}}) {
    constexpr int BATCHES = 16;
    constexpr uint32_t SIDE = 16, SAMPLES = 128;
    double sum = 0, squares = 0;
    for (int batch = 0; batch < BATCHES; ++batch) {
      RenderSettings settings = raised_to(box_filtered(SIDE, SIDE, SAMPLES, 3), known.alpha);
      settings.seed = static_cast<uint32_t>(batch) + 1;
      settings.sampler = SAMPLER_HASH;
      const double energy = reflected(settings);
      sum += energy;
      squares += energy * energy;
    }
    const double mean = sum / BATCHES, paths = SIDE * SIDE * SAMPLES;
    const double variance = (squares / BATCHES - mean * mean) * BATCHES / (BATCHES - 1) * paths;
    std::printf("alpha^ %.2f: energy %.4f of %.4f, variance %.4g of %.4g\n", known.alpha, mean, known.energy,
                variance, known.variance);
    EXPECT_NEAR(mean, known.energy, 5 * std::sqrt(known.variance * (1 / (BATCHES * paths) + 1 / 8e6)));
    // The variance of 16 values: chi-square of 15 degrees, 1e-5 of it lies beyond each bound.
    EXPECT_GT(variance, known.variance * 1.70 / 15);
    EXPECT_LT(variance, known.variance * 50.5 / 15);
  }
}

// In consistent mode, where the bandwidth falls from alpha^ 0.4 as i^(-1/6), the energy is the mean of what
// its bandwidths have, as the same program found it: it goes by the lobe's tail from too much to too little,
// and from there to the truth. Four standard errors of the mean.
TEST_F(PointLight, ConsistentModeGoesThroughTheBandwidths) {
  const auto energy = [&](uint32_t samples, uint32_t schedule) {
    constexpr int RUNS = 4;
    double mean = 0;
    for (uint32_t run = 0; run < RUNS; ++run) {
      RenderSettings settings = raised_to(box_filtered(32, 32, samples, 3), 0.4);
      *settings.regularization |= schedule;
      settings.seed = run + 1;
      mean += reflected(settings) / RUNS;
    }
    std::printf("%u samples, schedule %u: %.4f\n", samples, schedule, mean);
    return mean;
  };
  EXPECT_NEAR(energy(2048, REGULARIZATION_CONSISTENT), 1 - 0.0126, 0.008);
  EXPECT_NEAR(energy(256, 0), 1 + 0.0223, 0.01);
}

// A disk of light over a mirror, seen by parallel rays that start below it: hits by the walk and light
// sampling at the raised mirror both find it. By how much the two together exceed the truth hangs on the
// weights alone (docs/mathematics.md 3.9: the closed form of the corrected ones; the radius is that of their
// maximum).
TEST_F(OneMirror, WeightsDecideWhatTwoSamplersOfADiskGiveTogether) {
  constexpr double ALPHA = 0.025, HEIGHT = 1, RADIUS = 3.65 * ALPHA * HEIGHT, HALF = 1;
  GltfScene scene;
  scene.add({quad({-400, 0, 400}, {800, 0, 0}, {0, 0, -800})}, mirror());
  scene.add({disk({0, HEIGHT, 0}, {0, -1, 0}, RADIUS, 256)}, emitter({1, 1, 1}));
  scene.set_orthographic(look_at({0, HEIGHT / 2, 0}, {0, 0, 0}, {0, 0, -1}), HALF, HALF);
  const PreparedScene prepared = prepare(scene);
  const double truth = PI * RADIUS * RADIUS / (4 * HALF * HALF);
  const auto energy = [&](uint32_t mis) {
    const RenderSettings settings = raised_to(box_filtered(64, 64, 512, 2), ALPHA, mis);
    const double ratio = mean_of(render(prepared, settings).image)[0] / truth;
    std::printf("weights %u: %.4f of the truth\n", mis, ratio);
    return ratio;
  };
  const double kappa = 4 * ALPHA * ALPHA * HEIGHT * HEIGHT / (RADIUS * RADIUS);
  const double corrected = std::sqrt(kappa) * std::atan(1 / std::sqrt(kappa)) + 1 / (1 + kappa);
  // The closed form is that of small angles (at alpha^ = 0.1 blended weights give 1.03); of the lobe's tail
  // (1 + x^2 / (2 alpha h)^2)^-1 = 0.25 % lies beyond the film, and the spread over seeds is 0.3 %.
  EXPECT_NEAR(energy(MIS_CORRECTED), corrected, 0.015);
  EXPECT_NEAR(energy(MIS_UNMODIFIED), 2, 0.02);
  EXPECT_NEAR(energy(MIS_BLENDED), 1.003, 0.015);
}

}  // namespace
}  // namespace regulus::test
