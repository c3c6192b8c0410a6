// Media that nest, overlap and touch: the reference against the closed forms of tests/images/media.cpp.
#include <gtest/gtest.h>

#include <cmath>

#include "images/support/comparison.hpp"
#include "images/support/media_cases.hpp"
#include "reference/support/reference_images.hpp"

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

}  // namespace
}  // namespace regulus::test
