// A render whose device runs out of memory at each allocation in turn, or is lost at each submission in turn:
// one line of error, nothing leaked, and the device or the next one renders as if nothing had been.
#include <gtest/gtest.h>

#include <cstdio>

#include "base/error.hpp"
#include "gpu/faults.hpp"
#include "images/support/gltf_scene.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class DeviceFaults : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    GltfScene scene;
    scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
    scene.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.8);
    scene.add_point_light({0, 0, 1}, {1, 1, 1});
    scene.write(folder_ / "scene.gltf");
    prepared_ = prepare(folder_ / "scene.gltf");
    settings_ = box_filtered(8, 8, 2, 3);
    settings_.techniques = interface::TECHNIQUE_HIT | interface::TECHNIQUE_NEE | interface::TECHNIQUE_SPLAT |
                           interface::TECHNIQUE_CONNECT | interface::TECHNIQUE_MERGE;
    settings_.merge_radius = 0.1F;
  }
  void TearDown() override { gpu::faults() = {}; }

  std::vector<float> render_on(gpu::Device& device) const {
    render::Renderer renderer(device, prepared_, make_plan(prepared_, settings_));
    renderer.render([](uint64_t, uint64_t) { return true; });
    return resolve(renderer.film()).rgb;
  }

  /// The error of a render with a fault; empty if it was not met.
  std::string error_on(gpu::Device& device, ErrorCode code) const {
    try {
      render_on(device);
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), code) << error.what();
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
      return error.what();
    }
    return {};
  }

  TemporaryFolder folder_;
  PreparedScene prepared_;
  render::RenderSettings settings_;
};

TEST_F(DeviceFaults, EveryAllocationMayFail) {
  const std::vector<float> expected = render_on(*device());
  const uint64_t held = device()->allocated_bytes();
  uint32_t failures = 0;
  for (;; ++failures) {
    gpu::faults().allocations_before_failure = failures;
    const std::string error = error_on(*device(), ErrorCode::Failed);
    gpu::faults() = {};
    ASSERT_EQ(device()->allocated_bytes(), held) << "after allocation " << failures;
    if (error.empty()) break;
    EXPECT_NE(error.find("has no memory for buffer"), std::string::npos) << error;
    ASSERT_LT(failures, 1000u);
  }
  std::printf("%u allocations failed in turn\n", failures);
  EXPECT_GT(failures, 20u);
  EXPECT_EQ(render_on(*device()), expected);
}

// Every submission is one of a stage or a copy. A device that is lost stays so: each try opens it anew.
TEST_F(DeviceFaults, TheDeviceMayBeLostAtEverySubmission) {
  const std::vector<float> expected = render_on(*device());
  gpu::faults().submissions_before_loss = 1u << 30;
  render_on(*device());
  const uint32_t submissions = (1u << 30) - *gpu::faults().submissions_before_loss;
  const uint32_t tries = std::min(submissions, is_slow_device() ? 6u : 12u);
  for (uint32_t i = 0; i < tries; ++i) {
    gpu::Device own({.select = std::to_string(device()->info().index)});
    gpu::faults().submissions_before_loss =
        i < tries / 2 ? submissions * i / tries : submissions - (tries - i);
    const std::string error = error_on(own, ErrorCode::NoDevice);
    gpu::faults() = {};
    EXPECT_NE(error.find("lost"), std::string::npos) << "submission " << i << ": " << error;
  }
  std::printf("lost at %u of %u submissions\n", tries, submissions);
  EXPECT_EQ(render_on(*device()), expected);
}

}  // namespace
}  // namespace regulus::test
