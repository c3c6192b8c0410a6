// Pictures whose rays the host, or the device's own queries, have traced, against those of the kernels.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "base/error.hpp"
#include "images/support/copies.hpp"
#include "images/support/media_cases.hpp"
#include "images/support/render_scene.hpp"
#include "render/technique_sets.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using namespace interface;

using namespace technique_sets;

/// By who traces the rays: RAYS_HOST, RAYS_HARDWARE.
class TracedBy : public testing::TestWithParam<uint32_t> {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    const gpu::DeviceInfo& info = device()->info();
    if (GetParam() == RAYS_HOST && info.kind != gpu::DeviceKind::Software)
      GTEST_SKIP() << "not a software device";
    if (GetParam() == RAYS_HARDWARE && !info.has_ray_query) GTEST_SKIP() << "the device has no ray queries";
  }

  static void expect_kernels_bits(const PreparedScene& scene, uint32_t techniques);
};

GltfScene ball_under_lamp() {
  GltfScene scene;
  scene.add({quad({-3, 0, 3}, {6, 0, 0}, {0, 0, -6})}, lambert({0.7, 0.6, 0.5}));
  scene.add({quad({-1, 3, -1}, {2, 0, 0}, {0, 0, 2})}, emitter({6, 6, 5}));
  scene.add(sphere({0.1, 0.6, 0.2}, 0.6, 10), lambert({0.3, 0.7, 0.5}));
  scene.set_perspective(look_at({0, 1.5, 4.5}, {0, 0.7, 0}), 0.7);
  return scene;
}

/// Pixels whose sums differ in any bit.
size_t differing_pixels(const render::Film& a, const render::Film& b) {
  const auto differ = [](const std::vector<uint32_t>& x, const std::vector<uint32_t>& y, size_t pixel) {
    for (size_t i = pixel * FILM_WORDS_PER_PIXEL; i < (pixel + 1) * FILM_WORDS_PER_PIXEL && i < x.size(); ++i)
      if (x[i] != y[i]) return true;
    return false;
  };
  size_t count = 0;
  for (size_t pixel = 0; pixel < a.pixels(); ++pixel)
    count += differ(a.words, b.words, pixel) || differ(a.splat_words, b.splat_words, pixel) ? 1 : 0;
  return count;
}

// Of some ten thousand rays one or none passes an edge so closely that the two find different triangles.
void TracedBy::expect_kernels_bits(const PreparedScene& scene, uint32_t techniques) {
  render::RenderSettings settings = box_filtered(24, 24, is_slow_device() ? 1 : 2, 5);
  settings.techniques = techniques;
  settings.merge_radius = 0.1f;
  const Rendered expected = render(scene, settings);
  settings.rays = GetParam();
  const Rendered found = render(scene, settings);
  EXPECT_EQ(expected.statistics.rays, RAYS_SOFTWARE);
  EXPECT_EQ(found.statistics.rays, GetParam());
  const uint64_t rays = expected.statistics.closest_rays() + expected.statistics.visibility_rays();
  const size_t different = differing_pixels(expected.film, found.film);
  std::printf("%llu rays, %zu of %zu pixels differ\n", static_cast<unsigned long long>(rays), different,
              static_cast<size_t>(expected.film.pixels()));
  EXPECT_GT(rays, 1000u);
  EXPECT_LE(different, expected.film.pixels() / 100);
  EXPECT_GT(*std::max_element(found.image.rgb.begin(), found.image.rgb.end()), 0.01f);
}

TEST_P(TracedBy, PathTracingHasTheKernelsBits) {
  expect_kernels_bits(prepare(ball_under_lamp()), PT);
}
TEST_P(TracedBy, LightTracingHasTheKernelsBits) {
  expect_kernels_bits(prepare(ball_under_lamp()), LT);
}
TEST_P(TracedBy, BidirectionalPathsHaveTheKernelsBits) {
  expect_kernels_bits(prepare(ball_under_lamp()), BPT);
}
TEST_P(TracedBy, MergingHasTheKernelsBits) {
  expect_kernels_bits(prepare(ball_under_lamp()), VCM);
}

// Meshes stored once, mirrored ones among them, and surfaces with holes.
TEST_P(TracedBy, CopiesAndHolesHaveTheKernelsBits) {
  const PreparedScene scene = shared_copies(copies_scene());
  ASSERT_FALSE(scene.scene.instances.empty());
  ASSERT_NE(scene.features.bits & FEATURE_ALPHA, 0u);
  expect_kernels_bits(scene, PT);
}

// What the sky lights: rays that meet nothing are queued.
TEST_P(TracedBy, EscapedRaysHaveTheKernelsBits) {
  const image::Image sky{2, 1, {0.5f, 0.6f, 0.7f, 0.2f, 0.1f, 0.1f}};
  expect_kernels_bits(prepare(ball_under_lamp(), sky), PT);
}

// Surfaces that touch: the host leaves them to the kernels, auto so, and is refused by name.
TEST_P(TracedBy, ScenesWithContactsHaveTheKernelsBits) {
  const PreparedScene scene = prepare(lamp_in_block());
  ASSERT_NE(scene.features.bits & FEATURE_CONTACTS, 0u);
  if (GetParam() == RAYS_HARDWARE) {
    expect_kernels_bits(scene, LT);
    expect_kernels_bits(prepare(overlapping_lamps()), PT);
    return;
  }
  render::RenderSettings settings = box_filtered(8, 8, 1, 2);
  settings.rays = RAYS_AUTO;
  EXPECT_EQ(render(scene, settings).statistics.rays, RAYS_SOFTWARE);
  settings.rays = GetParam();
  try {
    render(scene, settings);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::BadUsage);
    EXPECT_NE(std::string(error.what()).find("contacts"), std::string::npos) << error.what();
  }
}

// A near plane cuts away what lies before it.
TEST_P(TracedBy, ClippedViewsHaveTheKernelsBits) {
  if (GetParam() == RAYS_HOST) GTEST_SKIP() << "the host leaves them to the kernels";
  PreparedScene scene = prepare(ball_under_lamp());
  scene.scene.cameras[0].z_near = 4.2F;  // through the ball
  scene.features = scene::find_features(scene.scene);
  ASSERT_NE(scene.features.bits & FEATURE_CLIPPING, 0u);
  expect_kernels_bits(scene, PT);
}

INSTANTIATE_TEST_SUITE_P(Tracers, TracedBy, testing::Values(RAYS_HOST, RAYS_HARDWARE),
                         [](const testing::TestParamInfo<uint32_t>& rays) {
                           return std::string(rays.param == RAYS_HOST ? "Host" : "Hardware");
                         });

// What a device lacks is said by its name.
TEST(HardwareRays, AreRefusedWhereThereAreNone) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  if (device()->info().has_ray_query) GTEST_SKIP() << "the device has ray queries";
  render::RenderSettings settings = box_filtered(8, 8, 1, 2);
  settings.rays = RAYS_HARDWARE;
  try {
    render(prepare(ball_under_lamp()), settings);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ErrorCode::BadUsage);
    EXPECT_NE(std::string(error.what()).find("lacks VK_KHR_ray_query"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace regulus::test
