// Media that nest, overlap and touch: the reference against the closed forms of tests/images/media.cpp.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/media_cases.hpp"
#include "reference/support/reference_images.hpp"
#include "reference/world.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

void expect_radiance(const MediaCase& c) {
  constexpr uint32_t SIZE = 8, SAMPLES = 16, DEPTH = 32;
  reference::Settings settings = reference_settings(SIZE, SIZE, SAMPLES, DEPTH);
  settings.techniques = PT;
  const std::array<double, 3> mean = mean_of(render_reference(prepare(c.scene), settings));
  const double bound = c.bound(SIZE * SIZE * SAMPLES);
  std::printf("%s: %.6f, known %.6f, bound %.1e\n", c.name.c_str(), mean[0], c.radiance, bound);
  EXPECT_NEAR(mean[0], c.radiance, bound) << c.name;
}

TEST(ReferenceMedia, NestOverlapAndTouch) {
  for (const MediaCase& c : media_cases()) expect_radiance(c);
}

TEST(ReferenceMedia, SlabsAbsorbAsThickAsTheyAre) {
  for (const MediaCase& c : thin_slabs()) expect_radiance(c);
}

TEST(ReferenceMedia, ALampInABlockIsDimmedOnce) {
  const PreparedScene scene = prepare(lamp_in_block());
  reference::Settings settings = reference_settings(4, 4, 1, 4);
  settings.techniques = interface::TECHNIQUE_SPLAT;
  settings.light_paths = 4000;
  image::Image known{4, 4, {}};
  constexpr int CELLS = 16;
  for (uint32_t y = 0; y < 4; ++y)
    for (uint32_t x = 0; x < 4; ++x) {
      double sum = 0;
      for (int i = 0; i < CELLS * CELLS; ++i)
        sum += floor_below_lamp({0.9 * (2 * (x + (i % CELLS + 0.5) / CELLS) / 4 - 1), 0,
                                 0.9 * (2 * (y + (i / CELLS + 0.5) / CELLS) / 4 - 1)});
      known.rgb.insert(known.rgb.end(), 3, static_cast<float>(sum / (CELLS * CELLS)));
    }
  ComparisonOptions options;
  options.relative_tolerance = 1e-3;
  expect_known("lamp in a block by splats", reference_batches(scene, settings, 17, 31), known, options);
}

TEST(ReferenceMedia, LampsThatOverlapShineOnce) {
  using namespace interface;
  const PreparedScene scene = prepare(overlapping_lamps());
  const double known = floor_below_lamps();
  constexpr uint32_t SIZE = 8, SAMPLES = 256;
  for (const uint32_t techniques : {TECHNIQUE_HIT, TECHNIQUE_NEE, TECHNIQUE_SPLAT}) {
    reference::Settings settings = reference_settings(SIZE, SIZE, SAMPLES, 2);
    settings.techniques = techniques;
    const double found = mean_of(render_reference(scene, settings))[0];
    const double most = (techniques & TECHNIQUE_SPLAT) != 0 ? 0.5 * (10 + 0.75 * 30) : 0.5 * 30;
    EXPECT_NEAR(found, known, 1e-4 * known + 5 * std::sqrt(known * most / (SIZE * SIZE * SAMPLES)))
        << techniques;
  }
}

/// What a straight line passes from one point to another: substances (INVALID_INDEX: air), and how far in
/// each.
struct Passed {
  std::vector<uint32_t> media;
  std::vector<double> lengths;
};

Passed passed_between(const reference::World& world, const glm::dvec3& from, const glm::dvec3& to) {
  Passed passed;
  const glm::dvec3 w = normalize(to - from);
  reference::Place place{world.media_at(from)};
  reference::Ray ray{from, w};
  double gone = 0;
  const double whole = length(to - from);
  constexpr int MOST = 100;
  for (int i = 0; i < MOST && gone < whole; ++i) {
    const uint32_t solid = place.around.first();
    const uint32_t medium =
        solid == interface::INVALID_INDEX ? solid : world.scene().solids.records[solid].substance;
    const auto hit = world.meet(ray, place);
    reference::Surface surface;
    double here = whole;
    if (hit) {
      surface = world.surface_at(hit->triangle, hit->barycentrics);
      here = std::min(dot(surface.position - from, w), whole);
    }
    // Shorter ones lie between faces that touch.
    if (here - gone > 1e-6) {
      passed.media.push_back(medium);
      passed.lengths.push_back(here - gone);
    }
    gone = here;
    if (!hit) break;
    place = world.place_towards(surface, place.around, -w, w);
    ray = world.ray_from(surface, w);
  }
  return passed;
}

// Lines through all cases, forwards and backwards: the order of media is a function of the place.
TEST(ReferenceMedia, LinesPassTheSameMediaBothWays) {
  Random random(51);
  size_t lines = 0, media = 0;
  for (const MediaCase& c : media_cases()) {
    const PreparedScene prepared = prepare(c.scene);
    const reference::World world(prepared);
    if (!world.has_contacts()) continue;
    for (int i = 0; i < 40; ++i) {
      const glm::dvec3 from = 5.0 * random.cube() - 2.5, to = 5.0 * random.cube() - 2.5;
      const Passed there = passed_between(world, from, to);
      Passed back = passed_between(world, to, from);
      std::reverse(back.media.begin(), back.media.end());
      std::reverse(back.lengths.begin(), back.lengths.end());
      ASSERT_EQ(there.media, back.media) << c.name << ", line " << i;
      for (size_t k = 0; k < there.lengths.size(); ++k)
        EXPECT_NEAR(there.lengths[k], back.lengths[k], 1e-5) << c.name << ", line " << i;
      ++lines;
      media += there.media.size();
    }
  }
  std::printf("%zu lines through %zu media\n", lines, media);
  EXPECT_GT(2 * media, 3 * lines);
}

}  // namespace
}  // namespace regulus::test
