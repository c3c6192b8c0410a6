// The reference's environment light against closed forms.
#include "reference/environment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "images/support/bright_texel.hpp"
#include "images/support/comparison.hpp"
#include "reference/support/reference_images.hpp"
#include "support/random.hpp"

namespace regulus::test {
namespace {

using std::numbers::pi;

constexpr int BATCHES = 11;

TEST(ReferenceEnvironment, SolidsThatAbsorbNothingCannotBeSeen) {
  uint32_t stream = 700;
  for (const auto& [name, material, depth] :
       {std::tuple("white", lambert({1, 1, 1}), 3u), std::tuple("mirror", metal({1, 1, 1}, 0), 3u),
        std::tuple("glass", glass(1.5), 32u)}) {
    GltfScene scene;
    scene.add(box({-0.5, -0.5, -0.5}, {0.5, 0.5, 0.5}), material);
    scene.set_perspective(look_at({1.6, 1.5, 1.7}, {0, 0, 0}), 0.5);
    scene.set_setting("environment", {{"color", {0.5, 1, 2}}});
    const PreparedScene prepared = prepare(scene);
    for (const NamedTechniques set : {NamedTechniques{"pt", PT}, {"bpt", BPT}}) {
      reference::Settings settings = reference_settings(8, 8, 16, depth);
      settings.techniques = set.bits;
      ComparisonOptions options;
      options.relative_tolerance = 1e-4;  // paths longer than `depth` are lost
      expect_known((std::string(name) + " cube, " + set.name).c_str(),
                   reference_batches(prepared, settings, BATCHES, stream++), uniform_image(8, 8, {0.5, 1, 2}),
                   options);
    }
  }
}

TEST(ReferenceEnvironment, OneBrightTexelIsALampInItsDirection) {
  const BrightTexel texel{20, 13};
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, -0.2, 0.1));
  const PreparedScene prepared = prepare(white_square(normal), texel.map(), -50);
  const glm::dvec3 radiance = texel.radiance * (texel.irradiance(normal, -50) / pi);
  uint32_t stream = 720;
  for (const NamedTechniques set :
       {NamedTechniques{"pt", PT}, {"lt", interface::TECHNIQUE_SPLAT}, {"bpt", BPT}}) {
    reference::Settings settings = reference_settings(8, 8, 32, 2);
    settings.techniques = set.bits;
    ComparisonOptions options;
    options.tile = 8;
    options.relative_tolerance = 3e-5;
    expect_known((std::string("bright texel, ") + set.name).c_str(),
                 reference_batches(prepared, settings, BATCHES, stream++),
                 uniform_image(8, 8, {radiance.x, radiance.y, radiance.z}), options);
  }
}

// The density integrates to 1, is positive wherever light comes from, and each direction drawn has the
// density of its own cell.
TEST(ReferenceEnvironment, DensityIsOne) {
  const BrightTexel texel{0, 1};
  const PreparedScene prepared = prepare(white_square({0, 1, 0}), texel.map(), 30);
  const scene::Environment& environment = *prepared.scene.environment;
  // Midpoints of 8 x 8 parts of each cell; within one the density goes with 1 / sin(theta), which the sine of
  // the solid angle undoes exactly.
  constexpr int PARTS = 8;
  double sum = 0;
  for (uint32_t y = 0; y < PARTS * BrightTexel::HEIGHT; ++y)
    for (uint32_t x = 0; x < PARTS * BrightTexel::WIDTH; ++x) {
      const double theta = pi * (y + 0.5) / (PARTS * BrightTexel::HEIGHT);
      const double phi = 2 * pi * (x + 0.5) / (PARTS * BrightTexel::WIDTH);
      const glm::dvec3 w = BrightTexel::direction(theta, phi, 30);
      const double density = reference::environment_pdf(environment, w);
      EXPECT_TRUE(density > 0 || reference::environment_radiance(environment, w) == glm::dvec3(0));
      sum += density * std::sin(theta);
    }
  const double cell = pi / (PARTS * BrightTexel::HEIGHT) * 2 * pi / (PARTS * BrightTexel::WIDTH);
  EXPECT_NEAR(sum * cell, 1, 1e-6) << "single-precision shares";
}

}  // namespace
}  // namespace regulus::test
