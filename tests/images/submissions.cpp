// What is handed to the device at once is bounded by counted work, whatever the scene and the settings, and a
// cancelled render begins nothing more.
#include <gtest/gtest.h>

#include "gpu/faults.hpp"
#include "images/support/render_scene.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;
using render::RenderSettings;

using namespace technique_sets;

class Submissions : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    if (is_slow_device()) GTEST_SKIP() << "slow device";
  }
};

RenderSettings settings_of(uint32_t size, uint32_t techniques, uint32_t max_depth) {
  RenderSettings settings = box_filtered(size, size, 1, max_depth);
  settings.techniques = techniques;
  settings.merge_radius = 10;
  return settings;
}

void expect_bounded(const render::RenderStatistics& statistics) {
  const render::SubmissionStatistics& submissions = statistics.submissions;
  std::printf("%llu submissions of at most %llu items, %llu allowed\n",
              static_cast<unsigned long long>(submissions.count),
              static_cast<unsigned long long>(submissions.most_items),
              static_cast<unsigned long long>(submissions.bound_items));
  EXPECT_GT(submissions.most_items, 0u);
  EXPECT_LE(submissions.most_items, submissions.bound_items);
}

/// A white box full of sheets that are half there: walks of a hundred edges, and shadow rays through all
/// sheets.
PreparedScene overdraw() {
  GltfScene scene;
  scene.add(turned(box({-1, -1, -1}, {1, 1, 1})), lambert({0.98, 0.98, 0.98}));
  nlohmann::json sheet = lambert({1, 1, 1});
  sheet["alphaMode"] = "BLEND";
  sheet["doubleSided"] = true;
  sheet["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.2};
  for (int i = 0; i < 40; ++i) scene.add({quad({-1, -1, -0.9 + 0.04 * i}, {2, 0, 0}, {0, 2, 0})}, sheet);
  scene.add({quad({-0.5, 0.99, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({1, 1, 1}));
  scene.set_perspective(look_at({0, 0, 0.95}, {0, 0, 0}), 1.2);
  return prepare(scene);
}

// 127 connections of each of 4,096 paths are half a million in one bounce, of 127.
TEST_F(Submissions, OfDeepPathsAreBoundedAndEndWhenCancelled) {
  const PreparedScene scene = overdraw();
  const RenderSettings settings = settings_of(64, BPT, 128);
  render::Renderer renderer(*device(), scene, make_plan(scene, settings));
  uint64_t asked = 0, begun = 0;
  renderer.render([](uint64_t, uint64_t) { return true; },
                  [&] {
                    begun = renderer.statistics().submissions.count;
                    return ++asked >= 8;
                  });
  expect_bounded(renderer.statistics());
  EXPECT_LE(renderer.statistics().submissions.count, begun + 1) << "one may be on its way";
  EXPECT_EQ(renderer.film().paths, 0u) << "no wave has ended";
}

/// All light ends on one floor, and every light vertex is within reach of every camera vertex.
PreparedScene floor_under_lamp() {
  GltfScene scene;
  scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
  scene.add({quad({-0.5, 0.3, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}, true));
  scene.set_perspective(look_at({0, 2, 0}, {0, 0, 0.001}), 0.6);
  return prepare(scene);
}

// With 60,000 light paths more light vertices are in reach than an invocation may look at. Waves of 64 are
// cut in other places, and 30,000 in reach of so few need no counting.
TEST_F(Submissions, OfHugeMergesAreBoundedAndAddUp) {
  const PreparedScene scene = floor_under_lamp();
  for (const uint32_t light_paths : {60000u, 120000u}) {
    RenderSettings settings = settings_of(24, BPM, 2);
    settings.light_paths = light_paths;
    const Rendered whole = render(scene, settings);
    expect_bounded(whole.statistics);
    settings.wave_paths = 64;
    const Rendered pieces = render(scene, settings);
    expect_bounded(pieces.statistics);
    EXPECT_TRUE(whole.film.words == pieces.film.words) << light_paths << " light paths";
  }
}

// On a device whose dispatches run few groups everything is cut to fit: waves, the sorting of light vertices,
// scans. The picture is the same. (A dispatch of more groups is a logic error, and a queue cannot hold more
// than one runs.)
TEST_F(Submissions, FitDispatchesOfFewGroups) {
  const PreparedScene scene = floor_under_lamp();
  struct Case {
    uint32_t most_groups, techniques, cache_connections;
  };
  for (const Case& few : {Case{1, BPM | TECHNIQUE_SPLAT, 0}, Case{4, BPT | TECHNIQUE_MERGE, 1}}) {
    RenderSettings settings = settings_of(24, few.techniques, 3);
    settings.merge_radius = 0.2F;
    settings.cache_connections = few.cache_connections;
    const Rendered whole = render(scene, settings);
    gpu::faults().most_groups = few.most_groups;
    gpu::DeviceOptions options;
    options.select = device()->info().name;
    gpu::Device small(options);
    gpu::faults() = {};
    ASSERT_EQ(small.info().max_groups, few.most_groups);
    render::Renderer renderer(small, scene, make_plan(scene, settings));
    renderer.render([](uint64_t, uint64_t) { return true; });
    EXPECT_LE(renderer.statistics().wave_capacity, 64 * few.most_groups);
    EXPECT_TRUE(renderer.film().words == whole.film.words) << few.most_groups;
    EXPECT_TRUE(renderer.film().splat_words == whole.film.splat_words) << few.most_groups;
  }
}

// Light paths of some thirty vertices each, where a device has room for two of each path in flight: waves are
// cut until theirs fit. The picture is the same.
TEST_F(Submissions, AreCutWhereLightPathsLeaveMuch) {
  const PreparedScene scene = overdraw();
  const RenderSettings settings = settings_of(40, BPT, 36);
  const Rendered whole = render(scene, settings);
  EXPECT_GT(whole.statistics.bytes_per_path, 2000u) << "room was made where there was memory";
  gpu::faults().most_groups = 36;
  gpu::DeviceOptions options;
  options.select = device()->info().name;
  gpu::Device small(options);
  gpu::faults() = {};
  render::Renderer renderer(small, scene, make_plan(scene, settings));
  renderer.render([](uint64_t, uint64_t) { return true; });
  EXPECT_GT(renderer.statistics().wave_capacity, 64u);
  EXPECT_LT(renderer.statistics().bytes_per_path, 1000u);
  EXPECT_EQ(renderer.statistics().light_paths, 1600u);
  EXPECT_TRUE(renderer.film().words == whole.film.words);
  EXPECT_TRUE(renderer.film().splat_words == whole.film.splat_words);
}

// Nothing of a wave that was given up is in the film: what is left to do gives the picture of a render in one
// go.
TEST_F(Submissions, OfACancelledRenderLeaveWholeWaves) {
  const PreparedScene scene = floor_under_lamp();
  RenderSettings settings = settings_of(40, BPM | TECHNIQUE_SPLAT | TECHNIQUE_CONNECT, 4);
  settings.merge_radius = 0.1F;
  settings.samples = 6;
  settings.wave_paths = 256;
  settings.keeps_doublings = true;  // the film's last state is then at most half as far
  const Rendered whole = render(scene, settings);
  render::Renderer first(*device(), scene, make_plan(scene, settings));
  uint64_t asked = 0;
  const uint64_t half = whole.statistics.submissions.count / 2;
  first.render([](uint64_t, uint64_t) { return true; }, [&] { return ++asked >= half; });
  std::printf("cancelled after %llu of %llu submissions: %llu camera paths\n",
              static_cast<unsigned long long>(first.statistics().submissions.count),
              static_cast<unsigned long long>(whole.statistics.submissions.count),
              static_cast<unsigned long long>(first.film().paths));
  EXPECT_GT(first.film().paths, 0u);
  EXPECT_LT(first.film().paths, whole.film.paths);
  render::Renderer second(*device(), scene, make_plan(scene, settings));
  second.resume(first.film());
  second.render([](uint64_t, uint64_t) { return true; });
  EXPECT_TRUE(second.film().words == whole.film.words);
  EXPECT_TRUE(second.film().splat_words == whole.film.splat_words);
}

}  // namespace
}  // namespace regulus::test
