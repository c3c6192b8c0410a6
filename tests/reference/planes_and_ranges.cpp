// Clipping planes of cameras and ranges of lights: closed forms on device and reference, and techniques that
// agree.
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "check/reference_render.hpp"
#include "images/support/comparison.hpp"
#include "images/support/render_scene.hpp"
#include "images/support/room.hpp"
#include "render/aov.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;

/// Pictures by both backends.
std::vector<image::Image> by_both(const PreparedScene& prepared, const render::RenderSettings& settings) {
  return {render(prepared, settings).image,
          check::render_with_reference(prepared, make_plan(prepared, settings), [](uint64_t, uint64_t) {
            return true;
          }).image};
}

class PlanesAndRanges : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

/// Three emitters at depths 1, 2 and 3 that fill the view, each brighter than the one before it.
PreparedScene three_emitters(bool is_orthographic, float nearest, float farthest) {
  GltfScene scene;
  for (int i = 1; i <= 3; ++i)
    scene.add({quad({-9, -9, 3.0 - i}, {18, 0, 0}, {0, 18, 0})}, emitter(glm::dvec3(i == 3 ? 4 : i)));
  const glm::dmat4 view = look_at({0, 0, 3}, {0, 0, 0});
  if (is_orthographic)
    scene.set_orthographic(view, 1, 1);
  else
    scene.set_perspective(view, 1.5);
  PreparedScene prepared = prepare(scene);
  prepared.scene.cameras[0].z_near = nearest;
  prepared.scene.cameras[0].z_far = farthest;
  prepared.features = find_features(prepared.scene);
  return prepared;
}

// At grazing pixels the ray to the plane is longer than its depth: planes are planes, not spheres.
TEST_F(PlanesAndRanges, OnlyWhatIsBetweenThePlanesIsSeen) {
  for (const bool is_orthographic : {true, false})
    for (const auto& [nearest, farthest, seen] : {std::tuple(0.5F, 100.F, 1.F),
                                                  {1.01F, 100.F, 2.F},
                                                  {1.99F, 2.01F, 2.F},
                                                  {2.01F, 1e9F, 4.F},
                                                  {1.1F, 1.9F, 0.F},
                                                  {0.F, 0.99F, 0.F},
                                                  {0.F, 1.01F, 1.F},
                                                  {3.01F, scene::NO_FAR_PLANE, 0.F}}) {
      const PreparedScene prepared = three_emitters(is_orthographic, nearest, farthest);
      render::RenderSettings settings = point_sampled(8, 8, 2);
      for (const image::Image& picture : by_both(prepared, settings))
        for (const float value : picture.rgb) ASSERT_EQ(value, seen) << nearest << " to " << farthest;
    }
}

TEST_F(PlanesAndRanges, LightPathsSeeTheSame) {
  // The view through the hidden emitter: a plane at 1.5 shows the second, which light tracing connects to the
  // lens.
  const PreparedScene prepared = three_emitters(true, 1.5F, 2.5F);
  render::RenderSettings settings = box_filtered(8, 8, is_slow_device() ? 32 : 128, 2);
  settings.techniques = TECHNIQUE_SPLAT;
  // Of 64 pixels' light paths every 7th starts at the second light (power 2 of 1 + 2 + 4), at a point in view
  // with probability 4 / 324: the relative deviation of the mean is 1 / sqrt(4 / 324 * 2 / 7 * paths), .14 at
  // 128.
  const double deviation = 1 / std::sqrt(4.0 / 324 * 2 / 7 * 64 * settings.samples);
  for (const image::Image& picture : by_both(prepared, settings))
    EXPECT_NEAR(mean_of(picture)[0], 2, 2 * 4.5 * deviation);
}

/// The room seen from outside, through its front wall and past a box that the near plane hides.
PreparedScene cut_room() {
  GltfScene scene = room(WHITE, plastic({0.4, 0.4, 0.6}, 0.5), WHITE);
  scene.add({ceiling_light()}, emitter({2, 1.5, 1}));
  scene.add(box({-0.3, -0.3, 1.5}, {0.3, 0.3, 1.7}), lambert({0.9, 0, 0}));
  scene.set_perspective(look_at({0, 0, 3.5}, {0, -0.2, 0}), 0.6);
  PreparedScene prepared = prepare(scene);
  prepared.scene.cameras = {prepared.scene.cameras.back()};  // not the room's own
  prepared.scene.cameras[0].z_near = 2.6F;                   // the front wall is at depth 2.5
  prepared.features = find_features(prepared.scene);
  return prepared;
}

TEST_F(PlanesAndRanges, TechniquesAgreeOnACutRoom) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  const PreparedScene prepared = cut_room();
  const auto batches = [&](uint32_t techniques, uint32_t stream) {
    render::RenderSettings settings = box_filtered(16, 16, 8, 4);
    settings.techniques = techniques;
    return render_batches(prepared, settings, 11, stream);
  };
  const auto known = batches(TECHNIQUE_HIT | TECHNIQUE_NEE, 1);
  EXPECT_GT(mean_of(known[0])[0], 0.05) << "light from inside";
  expect_equal("cut room, lt", batches(TECHNIQUE_SPLAT, 2), known);
  expect_equal("cut room, bpt",
               batches(TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT, 3), known);
}

TEST_F(PlanesAndRanges, AovsAreCutToo) {
  render::RenderSettings settings = point_sampled(4, 4, 2);
  settings.aovs = render::parse_aovs("Z");
  const PreparedScene prepared = three_emitters(false, 1.5F, 100);
  for (const image::Channels& channels :
       {surface_channels(prepared, settings),
        check::render_with_reference(prepared, make_plan(prepared, settings), [](uint64_t, uint64_t) {
          return true;
        }).channels})
    for (const float depth : std::get<std::vector<float>>(channels.at("Z"))) EXPECT_NEAR(depth, 2, 1e-5);
}

/// A white floor under a light of 9 cd at a height of 1 m whose light ends at `range`, seen from above.
PreparedScene ranged_light(bool is_spot, float range) {
  GltfScene scene;
  scene.add({quad({-4, 0, 4}, {8, 0, 0}, {0, 0, -8})}, lambert({1, 1, 1}));
  if (is_spot)
    scene.add_spot_light({0, 1, 0}, {0, -1, 0}, 9, 1.5, 1.57);
  else
    scene.add_point_light({0, 1, 0}, {9, 9, 9});
  scene.set_orthographic(look_at({0, 3, 0}, {0, 0, 0}, {0, 0, -1}), 2, 2);
  PreparedScene prepared = prepare(scene);
  prepared.scene.lights.at(0).area = range;
  prepared.features = find_features(prepared.scene);
  return prepared;
}

// E = I cos / d^2 (1 - (d / r)^4), 0 from r on; L = E / pi.
TEST_F(PlanesAndRanges, LightEndsAtItsRange) {
  for (const bool is_spot : {false, true})
    for (const float range : {0.F, 2.F, 1.2F, 0.9F}) {
      const PreparedScene prepared = ranged_light(is_spot, range);
      constexpr uint32_t SIZE = 16;
      const render::RenderSettings settings = point_sampled(SIZE, SIZE, 2);
      for (const image::Image& picture : by_both(prepared, settings))
        for (uint32_t i = 0; i < SIZE * SIZE; ++i) {
          const double x = 4 * ((i % SIZE) + 0.5) / SIZE - 2, z = 4 * ((i / SIZE) + 0.5) / SIZE - 2;
          const double squared = 1 + x * x + z * z, cosine = 1 / std::sqrt(squared);
          if (is_spot && cosine < std::cos(1.5)) continue;
          const double share = range == 0 ? 1 : std::max(1 - std::pow(squared / (range * range), 2), 0.0);
          const double expected = 9 * cosine / squared * share / glm::pi<double>();
          // Where share is small it is the difference of numbers near 1.
          ASSERT_NEAR(picture.rgb[3 * i], expected, 1e-5 * 9 / squared)
              << "range " << range << " at " << x << " " << z;
        }
    }
}

TEST_F(PlanesAndRanges, TechniquesAgreeOnALightOfLimitedRange) {
  if (is_slow_device()) GTEST_SKIP() << "slow device";
  GltfScene scene = room(WHITE, plastic({0.4, 0.4, 0.6}, 0.5), WHITE);
  scene.add_point_light({0.1, 0.5, 0.2}, {1, 1, 1});
  scene.add_spot_light({0, 0.8, -0.5}, {0, -1, 0.2}, 1, 0.3, 0.9);
  PreparedScene prepared = prepare(scene);
  for (Light& light : prepared.scene.lights) light.area = 1.4F;
  prepared.features = find_features(prepared.scene);
  const auto batches = [&](uint32_t techniques, uint32_t stream) {
    render::RenderSettings settings = box_filtered(16, 16, 8, 4);
    settings.techniques = techniques;
    if ((techniques & TECHNIQUE_MERGE) != 0) {
      settings.light_paths = 2048;
      settings.merge_radius = 0.02F;
      settings.merge_reduction = 0;
    }
    return render_batches(prepared, settings, 11, stream);
  };
  const auto known = batches(TECHNIQUE_NEE, 11);
  EXPECT_GT(mean_of(known[0])[0], 0.01);
  using namespace technique_sets;
  expect_equal("limited range, lt", batches(TECHNIQUE_SPLAT, 12), known);
  expect_equal("limited range, bpt", batches(BPT, 13), known);
  ComparisonOptions options;
  options.relative_tolerance = 3e-3;
  expect_equal("limited range, vcm", batches(BPT | TECHNIQUE_MERGE, 14), known, options);
}

}  // namespace
}  // namespace regulus::test
