// Light that is dim or bright beyond all measure: the film's unit follows it, and the picture is that of
// ordinary light times a factor. Factors are powers of two, so that every contribution is the same but for
// its exponent, and the pictures differ by the resolution of their films alone.
#include <gtest/gtest.h>

#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;

class FilmRange : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

constexpr uint32_t SIZE = 12;

/// A room with a rough metal body under a lamp that the camera sees.
PreparedScene room(double radiance) {
  GltfScene scene;
  scene.add(turned(box({-1, -1, -1}, {1, 1, 1})), lambert({0.7, 0.6, 0.5}));
  scene.add(box({-0.6, -1, -0.7}, {0, -0.2, -0.1}), metal({0.9, 0.7, 0.4}, 0.6));
  scene.add({quad({-0.4, 0.97, -0.4}, {0.8, 0, 0}, {0, 0, 0.8})}, emitter(glm::dvec3(radiance)));
  scene.set_perspective(look_at({0, 0, 0.9}, {0, 0.2, 0}), 1.4);
  return prepare(scene);
}

TEST_F(FilmRange, RoomsOfAnyBrightnessAreTheSameRoom) {
  render::RenderSettings settings = box_filtered(SIZE, SIZE, 3, 5);
  settings.techniques = is_slow_device() ? TECHNIQUE_HIT | TECHNIQUE_NEE
                                         : TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT |
                                               TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
  settings.merge_radius = 0.05f;
  settings.aovs = render::AOV_VARIANCE;
  const PreparedScene ordinary = room(1);
  EXPECT_EQ(ordinary.scene.film_exponents.radiance, 0);
  const Rendered wanted = render(ordinary, settings);
  const image::Image wanted_variance = resolve_variance(wanted.film);
  for (const int exponent : {-80, -43, 54, 90}) {
    const PreparedScene prepared = room(std::ldexp(1.0, exponent));
    EXPECT_NE(prepared.scene.film_exponents.radiance, 0);
    const Rendered found = render(prepared, settings);
    const image::Image variance = resolve_variance(found.film);
    // A unit of the film for each of some hundred contributions (of a merge's rounded sums), in the picture's
    // scale.
    const double unit = std::ldexp(1.0, prepared.scene.film_exponents.radiance - exponent - 40) + 0x1p-40;
    double worst = 0, worst_variance = 0;
    for (size_t i = 0; i < wanted.image.rgb.size(); ++i) {
      const double value = std::ldexp(double{found.image.rgb[i]}, -exponent);
      worst = std::max(worst, std::abs(value - wanted.image.rgb[i]));
      const double spread = std::ldexp(double{variance.rgb[i]}, -2 * exponent);
      worst_variance = std::max(worst_variance, std::abs(spread - wanted_variance.rgb[i]));
    }
    std::printf("2^%d, film in 2^%d and 2^%d: differs by %.3g (unit %.3g), variance by %.3g\n", exponent,
                prepared.scene.film_exponents.radiance, prepared.scene.film_exponents.squares, worst, unit,
                worst_variance);
    EXPECT_LE(worst, 300 * unit + 0x1p-23);
    // Beyond, variances are not floats any more.
    if (std::abs(exponent) <= 54) {
      EXPECT_LE(worst_variance, 1e-5);
    }
    for (const auto& [name, words] : render::sums_of(found.film))
      EXPECT_EQ(render::count_saturated(*words), 0u) << name;
  }
}

// What is seen is the lamp alone, in every sample.
TEST_F(FilmRange, LampsShowTheirRadiance) {
  for (const double radiance : {1e-30, 1e-13, 1e-7, 1e9, 2e16, 1e25, 1e31}) {
    GltfScene scene;
    scene.add({quad({-3, -3, 0}, {6, 0, 0}, {0, 6, 0})}, emitter(glm::dvec3(radiance)));
    scene.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.6);
    render::RenderSettings settings = box_filtered(4, 4, 5, 2);
    settings.aovs = render::AOV_VARIANCE;
    const Rendered found = render(prepare(scene), settings);
    const image::Image variance = resolve_variance(found.film);
    for (size_t i = 0; i < found.image.rgb.size(); ++i) {
      EXPECT_NEAR(found.image.rgb[i] / radiance, 1, 2e-7) << radiance;
      if (radiance < 1e18) {
        EXPECT_LT(variance.rgb[i] / (radiance * radiance), 1e-6) << radiance;
      }
    }
  }
}

// More light than the scene's lamps let expect, by exponents that are wrong: a sum that is too large says so,
// the rest of the picture is right.
TEST_F(FilmRange, SumsThatAreTooLargeAreCountedAndSoAreTheirSquares) {
  PreparedScene prepared = room(0x1p54);
  render::RenderSettings settings = box_filtered(SIZE, SIZE, 5, 2);
  settings.aovs = render::AOV_VARIANCE;
  const Rendered right = render(prepared, settings);
  prepared.scene.film_exponents = prepared.features.film_exponents = {};
  const Rendered found = render(prepared, settings);
  size_t saturated = 0, exactly_full = 0;  // the latter saturate by a rounding or not
  for (size_t i = 0; i < right.image.rgb.size(); ++i) {
    const double sum = 5 * double{right.image.rgb[i]};
    if (std::abs(sum / 0x1p55 - 1) < 1e-6) {
      ++exactly_full;
      continue;
    }
    const double seen = 5 * double{found.image.rgb[i]};
    EXPECT_NEAR(seen, std::min(sum, 0x1p55), 1e-6 * std::min(sum, 0x1p55)) << i;
    saturated += sum > 0x1p55 ? 1 : 0;
  }
  EXPECT_GT(saturated, 0u);
  EXPECT_GE(render::count_saturated(found.film.words), saturated);
  EXPECT_LE(render::count_saturated(found.film.words), saturated + exactly_full);
  EXPECT_GE(render::count_saturated(found.film.square_words), saturated);
  EXPECT_TRUE(std::ranges::any_of(resolve_variance(found.film).rgb, [](float v) { return std::isinf(v); }));
}

}  // namespace
}  // namespace regulus::test
