// The radius of merges where none is given: closed forms of the footprint, and that nothing changes it which
// is not seen. With it merging agrees with connecting where scenes are far larger than what is seen.
#include "reference/merge_radius.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "images/support/comparison.hpp"
#include "reference/support/reference_images.hpp"
#include "support/sanitizers.hpp"

namespace regulus::test {
namespace {

using reference::default_merge_radius;
using reference::given_merge_radius;
using reference::radius_of_share;
using reference::SeenSurfaces;

SeenSurfaces seen_in(const GltfScene& gltf, uint32_t width = 64, uint32_t height = 64) {
  const PreparedScene prepared = prepare(gltf);
  return see_surfaces(reference::World(prepared), prepared.scene.cameras.front(), width, height);
}

/// A wall of 20 m in the plane z = 0, seen from +z.
GltfScene wall() {
  GltfScene scene;
  scene.add({quad({-10, -10, 0}, {20, 0, 0}, {0, 20, 0})}, lambert({0.5, 0.5, 0.5}));
  scene.add_point_light({0, 0, 5}, {1, 1, 1});
  return scene;
}

TEST(MergeRadius, IsAThousandthOfThePicturesHeight) {
  constexpr double FIELD = 0.9;  // radians
  GltfScene perspective = wall();
  perspective.set_perspective(look_at({0, 0, 3}, {0, 0, 0}), FIELD);
  // Matrices and angles are single precision.
  const SeenSurfaces seen = seen_in(perspective);
  EXPECT_NEAR(seen.footprint, 1e-3 * 2 * std::tan(FIELD / 2) * 3, 1e-8);
  EXPECT_NEAR(seen_in(perspective, 1920, 1920).footprint, seen.footprint, 1e-15)
      << "the size does not matter";
  EXPECT_FLOAT_EQ(default_merge_radius(seen, 1).metres, 0.0029F) << "three digits of 0.0028983";
  GltfScene orthographic = wall();
  orthographic.set_orthographic(look_at({0, 0, 3}, {0, 0, 0}), 2, 1.5);
  EXPECT_NEAR(seen_in(orthographic, 80, 60).footprint, 1e-3 * 3, 1e-9);
}

// Half of the points of a square lie within half its area around the middle: a disk of radius side / sqrt(2
// pi). The grid of 32 x 32 points knows that to less than its spacing.
TEST(MergeRadius, ExtentIsTheMedianDistanceFromTheMiddle) {
  GltfScene scene = wall();
  scene.set_orthographic(look_at({2, 1, 3}, {2, 1, 0}), 1.5, 1.5);
  EXPECT_NEAR(seen_in(scene).extent, 3 / std::sqrt(2 * M_PI), 3.0 / 32);
}

TEST(MergeRadius, DoesNotKnowWhatIsNotSeen) {
  GltfScene plain = wall();
  plain.set_perspective(look_at({0, 0, 3}, {0, 0, 0}), 0.9);
  GltfScene vast = plain;
  vast.add(turned(sphere({0, 0, 0}, 5000, 8)), emitter({1, 1, 1}));
  vast.add({quad({-1e5, -20, -1e5}, {2e5, 0, 0}, {0, 0, 2e5})}, lambert({0.5, 0.5, 0.5}));
  const SeenSurfaces few = seen_in(plain), all = seen_in(vast);
  EXPECT_EQ(few.footprint, all.footprint);
  EXPECT_EQ(few.extent, all.extent);
}

// An emitter before two thirds of the wall; the rays past it count alone.
TEST(MergeRadius, RaysThatMeetALightDoNotCount) {
  GltfScene scene = wall();
  scene.add({quad({-10, -10, 2}, {10.3, 0, 0}, {0, 20, 0})}, emitter({1, 1, 1}));
  scene.set_perspective(look_at({0, 0, 3}, {0, 0, 0}), 0.9);
  EXPECT_NEAR(seen_in(scene).footprint, 1e-3 * 2 * std::tan(0.45) * 3, 1e-8);
  GltfScene lights;
  lights.add({quad({-10, -10, 2}, {20, 0, 0}, {0, 20, 0})}, emitter({1, 1, 1}));
  lights.set_perspective(look_at({0, 0, 3}, {0, 0, 0}), 0.9);
  EXPECT_NEAR(seen_in(lights).footprint, 1e-3 * 2 * std::tan(0.45) * 1, 1e-8)
      << "nothing but lights: they do";
}

// By a mirror at 45 degrees, 1 m before the camera, to a wall 4 m beside it; through a pane of glass of index
// 1, which bends nothing.
TEST(MergeRadius, FollowsMirrorsAndGlass) {
  GltfScene mirrored;
  mirrored.add({quad({-4, -4, 4}, {8, 0, -8}, {0, 8, 0})}, metal({1, 1, 1}, 0));
  mirrored.add({quad({4, -20, -20}, {0, 0, 40}, {0, 40, 0})}, lambert({0.5, 0.5, 0.5}));
  mirrored.add({quad({-4, -20, 20}, {0, 0, -40}, {0, 40, 0})}, lambert({0.5, 0.5, 0.5}));
  mirrored.add_point_light({0, 0, 1}, {1, 1, 1});
  mirrored.set_perspective(look_at({0, 0, 1}, {0, 0, 0}), 0.4);
  EXPECT_NEAR(seen_in(mirrored).footprint, 1e-3 * 2 * std::tan(0.2) * 5, 1e-8);
  GltfScene behind_glass = wall();
  behind_glass.add(box({-5, -5, 1}, {5, 5, 1.5}), glass(1));
  behind_glass.set_perspective(look_at({0, 0, 3}, {0, 0, 0}), 0.9);
  EXPECT_NEAR(seen_in(behind_glass).footprint, 1e-3 * 2 * std::tan(0.45) * 3, 1e-8);
}

TEST(MergeRadius, IsBoundedByWhatIsSeen) {
  EXPECT_FLOAT_EQ(default_merge_radius({0.004, 1}, 1000).metres, 0.004F);
  EXPECT_FLOAT_EQ(default_merge_radius({0.4, 1}, 1000).metres, 0.01F) << "a small thing in a large picture";
  EXPECT_FLOAT_EQ(default_merge_radius({}, 10).metres, 0.03F) << "nothing is seen";
  EXPECT_FLOAT_EQ(given_merge_radius(0.05F, {0.004, 1}, 1000).metres, 0.05F);
  EXPECT_FLOAT_EQ(given_merge_radius(1e3F, {0.004, 1}, 1000).metres, 0.1F);
  EXPECT_FLOAT_EQ(given_merge_radius(1e-30F, {0.004, 1}, 1000).metres, 1e-6F);
  EXPECT_FLOAT_EQ(radius_of_share(0.003F, {0.004, 2}, 1000), 0.006F) << "percent are of what is seen";
  EXPECT_FLOAT_EQ(radius_of_share(0.003F, {}, 10), 0.03F);
}

// Means of the picture over independent renders of a fixed seed: 2 percent or, if that is more, two standard
// errors of the difference.
void expect_merging_agrees(const char* name, uint32_t stream, uint32_t samples) {
  const PreparedScene prepared = prepare(own_scenes() / "outdoors" / name);
  const reference::World world(prepared);
  const SeenSurfaces seen = see_surfaces(world, prepared.scene.cameras.front(), 384, 256);
  const auto measure = [&](uint32_t techniques, double radius, uint32_t number) {
    constexpr int BATCHES = 8;
    reference::Settings settings = reference_settings(12, 8, samples, 8);
    settings.techniques = techniques;
    settings.merge_radius = radius;
    double sum = 0, squares = 0;
    for (const image::Image& image : reference_batches(prepared, settings, BATCHES, stream + number)) {
      double mean = 0;
      for (const float value : image.rgb) mean += double{value} / static_cast<double>(image.rgb.size());
      sum += mean / BATCHES;
      squares += mean * mean / BATCHES;
    }
    return std::pair(sum, std::sqrt(std::max(squares - sum * sum, 0.0) / (BATCHES - 1)));
  };
  const double radius = double{default_merge_radius(seen, 0).metres};
  const auto [wanted, wanted_error] = measure(BPT, radius, 0);
  const auto difference = [&](const char* set, uint32_t techniques, double used, uint32_t number) {
    const auto [mean, error] = measure(techniques, used, number);
    const double tolerance = std::max(0.02 * wanted, 2 * std::hypot(error, wanted_error));
    std::printf("%s %s: %.5f +- %.5f against %.5f +- %.5f, radius %.4g m\n", name, set, mean, error, wanted,
                wanted_error, used);
    return std::abs(mean - wanted) / tolerance;
  };
  EXPECT_LE(difference("bpm", BPM, radius, 1), 1);
  EXPECT_LE(difference("vcm", VCM, radius, 2), 1);
}

// A hut of 4 m without an opening on a ground of a kilometre in the sun (tests/cases): no light gets in, but
// through its walls where merges reach so far.
TEST(MergeRadius, SealedHutsStayDark) {
  const PreparedScene prepared =
      prepare(own_scenes().parent_path() / "tests" / "cases" / "sealed-hut-large-ground" / "c32b.gltf");
  const reference::World world(prepared);
  reference::Settings settings = reference_settings(12, 12, 8, 8);
  settings.techniques = VCM;
  settings.merge_radius =
      double{default_merge_radius(see_surfaces(world, prepared.scene.cameras.front(), 24, 24), 0).metres};
  EXPECT_LT(mean_of(render_reference(prepared, settings))[0], 0.005);
  settings.merge_radius = 0.003 * world.radius();
  EXPECT_GT(mean_of(render_reference(prepared, settings))[0], 0.1) << "as it was by the scene's bounds";
}

TEST(MergeRadius, SuitsARoomUnderASkyDome) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  expect_merging_agrees("room-under-dome.gltf", 50, 96);
}

TEST(MergeRadius, SuitsAStillLifeOnAPlain) {
  REGULUS_SKIP_UNDER_SANITIZERS();
  expect_merging_agrees("still-life-on-plain.gltf", 60, 96);
}

}  // namespace
}  // namespace regulus::test
