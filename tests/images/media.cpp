// Media that nest, overlap and touch, against closed forms.
#include <gtest/gtest.h>

#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/media_cases.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class Media : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

void expect_radiance(const MediaCase& c) {
  constexpr uint32_t SIZE = 16, SAMPLES = 64, DEPTH = 32;
  const Rendered found = render(prepare(c.scene), box_filtered(SIZE, SIZE, SAMPLES, DEPTH));
  const std::array<double, 3> mean = mean_of(found.image);
  const double bound = c.bound(SIZE * SIZE * SAMPLES);
  std::printf("%s: %.6f, known %.6f, bound %.1e\n", c.name.c_str(), mean[0], c.radiance, bound);
  EXPECT_NEAR(mean[0], c.radiance, bound) << c.name;
}

TEST_F(Media, NestOverlapAndTouch) {
  for (const MediaCase& c : media_cases()) expect_radiance(c);
}

TEST_F(Media, SlabsAbsorbAsThickAsTheyAre) {
  for (const MediaCase& c : thin_slabs()) expect_radiance(c);
}

// Light paths start in the block: by splats alone, and by all techniques together.
TEST_F(Media, ALampInABlockIsDimmedOnce) {
  const PreparedScene scene = prepare(lamp_in_block());
  constexpr uint32_t SIZE = 8;
  image::Image known{SIZE, SIZE, {}};
  constexpr int CELLS = 8;
  for (uint32_t y = 0; y < SIZE; ++y)
    for (uint32_t x = 0; x < SIZE; ++x) {
      double sum = 0;
      for (int i = 0; i < CELLS * CELLS; ++i)
        sum += floor_below_lamp({0.9 * (2 * (x + (i % CELLS + 0.5) / CELLS) / SIZE - 1), 0,
                                 0.9 * (2 * (y + (i / CELLS + 0.5) / CELLS) / SIZE - 1)});
      known.rgb.insert(known.rgb.end(), 3, static_cast<float>(sum / (CELLS * CELLS)));
    }
  using namespace interface;
  ComparisonOptions options;
  options.relative_tolerance = 1e-3;  // of the midpoint rule
  for (const uint32_t techniques : {TECHNIQUE_SPLAT, TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT |
                                                         TECHNIQUE_CONNECT | TECHNIQUE_MERGE}) {
    render::RenderSettings settings = box_filtered(SIZE, SIZE, 64, 4);
    settings.techniques = techniques;
    settings.merge_radius = 0.02f;
    settings.regularization = REGULARIZATION_NONE;
    expect_known("lamp in a block", render_batches(scene, settings, 17, techniques), known, options);
  }
}

// Its light paths start in air or in the block, point by point. Without an index paths that hit it need no
// luck.
TEST_F(Media, APanelAcrossABlockIsTheSameFromBothEnds) {
  const PreparedScene scene = prepare(panel_across_block());
  render::RenderSettings settings = box_filtered(8, 8, 64, 6);
  settings.regularization = interface::REGULARIZATION_NONE;
  settings.techniques = interface::TECHNIQUE_HIT;
  const auto by_hits = render_batches(scene, settings, 17, 41);
  settings.techniques = interface::TECHNIQUE_SPLAT;
  expect_equal("panel across a block", by_hits, render_batches(scene, settings, 17, 42));
}

// Techniques without hits connect emitters to the lens: each through what holds its place on the film.
TEST_F(Media, EmittersSeenFromAFilmHalfInFog) {
  const MediaCase c = half_in_a_block();
  constexpr uint32_t SIZE = 16, SAMPLES = 512;
  render::RenderSettings settings = box_filtered(SIZE, SIZE, SAMPLES, 2);
  settings.techniques = interface::TECHNIQUE_SPLAT;
  // The film sees 1 of the emitter's 64 m^2: what a light path brings is 64 or 16 with a probability of 1 /
  // 128 each. Five standard errors.
  const double variance = (64.0 * 64 + 16.0 * 16) / 128 - c.radiance * c.radiance;
  const double bound = 5 * std::sqrt(variance / (SIZE * SIZE * SAMPLES));
  const double found = mean_of(render(prepare(c.scene), settings).image)[0];
  std::printf("%s by splats: %.4f, known %.4f, bound %.1e\n", c.name.c_str(), found, c.radiance, bound);
  EXPECT_NEAR(found, c.radiance, bound);
}

// By rays that meet them, by light sampling and by light paths, each alone and together.
TEST_F(Media, LampsThatOverlapShineOnce) {
  using namespace interface;
  const PreparedScene scene = prepare(overlapping_lamps());
  const double known = floor_below_lamps();
  constexpr uint32_t SIZE = 16, SAMPLES = 1024;
  for (const uint32_t techniques :
       {TECHNIQUE_HIT, TECHNIQUE_NEE, TECHNIQUE_SPLAT, TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT}) {
    render::RenderSettings settings = box_filtered(SIZE, SIZE, SAMPLES, 2);
    settings.techniques = techniques;
    const double found = mean_of(render(scene, settings).image)[0];
    // No path brings more than albedo times radiance, or times the power of all lamps over the film's m^2.
    const double most = (techniques & TECHNIQUE_SPLAT) != 0 ? 0.5 * (10 + 0.75 * 30) : 0.5 * 30;
    const double bound = 1e-4 * known + 5 * std::sqrt(known * most / (SIZE * SIZE * SAMPLES));
    std::printf("techniques %u: %.4f, known %.4f, bound %.1e\n", techniques, found, known, bound);
    EXPECT_NEAR(found, known, bound) << techniques;
  }
}

}  // namespace
}  // namespace regulus::test
