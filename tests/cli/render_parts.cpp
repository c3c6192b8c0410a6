// Parts of a render from the outside: --samples, --crop, merge, --checkpoint and --resume.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <thread>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

class RenderParts : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    GltfScene scene;
    scene.add({quad({-1, 0, 1}, {2, 0, 0}, {0, 0, -2})}, lambert({0.5, 0.5, 0.5}));
    scene.add({quad({-0.5, 1.5, -0.5}, {1, 0, 0}, {0, 0, 1})}, emitter({10, 10, 10}));
    scene.set_perspective(look_at({0, 1, 0}, {0, 0, 0.001}), 1.0);
    scene.write(file("scene.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Arguments command(const std::string& output, const Arguments& more) const {
    Arguments arguments = {"render", file("scene.gltf"), "-o", file(output), "--size", "24x16", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  void render(const std::string& output, const Arguments& more) const {
    const Finished finished = run(command(output, more));
    ASSERT_EQ(finished.status, 0) << finished.err;
  }
  image::ExrContents contents(const std::string& name) const { return image::read_exr_contents(file(name)); }

  TemporaryFolder folder_;
};

TEST_F(RenderParts, MergedRangesAreTheirUnionBitByBit) {
  const std::vector<const char*> integrators =
      is_slow_device() ? std::vector{"pt"} : std::vector{"pt", "vcm"};
  for (const char* integrator : integrators) {
    const Arguments own = {"-i", integrator, "--aov", "variance,samples,Z"};
    const auto part = [&](const std::string& output, const std::string& range) {
      Arguments arguments = own;
      arguments.insert(arguments.end(), {"--samples", range});
      render(output, arguments);
    };
    part("all.exr", "0:7");
    part("a.exr", "0:2");
    part("b.exr", "2:4");
    part("c.exr", "6:1");
    ASSERT_EQ(run({"merge", file("bc.exr"), file("c.exr"), file("b.exr")}).status,
              0);  // merged parts are parts
    const Finished merged = run({"merge", file("merged.exr"), file("bc.exr"), file("a.exr")});
    ASSERT_EQ(merged.status, 0) << merged.err;
    const image::ExrContents all = contents("all.exr"), sum = contents("merged.exr");
    EXPECT_TRUE(all.channels == sum.channels) << integrator;
    EXPECT_EQ(sum.attributes.at("regulus:sample_ranges"), "0:7");
    EXPECT_EQ(sum.attributes.at("regulus:samples_done"), "7");
    // And the picture is that of a plain render.
    Arguments plain = own;
    plain.insert(plain.end(), {"--spp", "7"});
    render("plain.exr", plain);
    for (const char* name : {"R", "G", "B", "variance.G", "samples", "Z"})
      EXPECT_TRUE(contents("plain.exr").channels.at(name) == sum.channels.at(name)) << name;
    EXPECT_FALSE(contents("plain.exr").channels.contains("film.sum.R0")) << "sums are for parts alone";
  }
}

TEST_F(RenderParts, WhatDoesNotBelongTogetherIsRefused) {
  render("a.exr", {"--samples", "0:2"});
  render("overlapping.exr", {"--samples", "1:2"});
  render("seed.exr", {"--samples", "2:2", "--seed", "3"});
  render("plain.exr", {"-s", "2"});
  const auto merge = [&](const std::string& other) {
    return run({"merge", file("out.exr"), file("a.exr"), file(other)});
  };
  expect_error(merge("overlapping.exr"), 3, {"a.exr", "overlapping.exr", "sample 1"});
  expect_error(merge("seed.exr"), 3, {"a.exr", "seed.exr", "seed"});
  expect_error(merge("plain.exr"), 3, {"plain.exr", "--samples"});
  expect_error(merge("none.exr"), 3, {"none.exr"});
  expect_error(run(command("x.exr", {"--samples", "0:2", "-s", "2"})), 2, {"--samples"});
  expect_error(run(command("x.exr", {"--samples", "2"})), 2, {"--samples 2"});
  expect_error(run(command("x.exr", {"--crop", "0,0,25,16"})), 2, {"--crop 0,0,25,16"});
  expect_error(run(command("x.exr", {"--aov", "albedo,beauty"})), 2, {"beauty"});
  expect_error(run(command("x.exr", {"--resume"})), 2, {"--checkpoint"});
  expect_error(run(command("x.exr", {"-s", "2", "--checkpoint", file("a.exr")})), 2, {"--resume"});
  const auto resume = [&](const std::string& from, const Arguments& more) {
    Arguments arguments = {"--checkpoint", file(from), "--resume"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(command("x.exr", arguments));
  };
  expect_error(resume("a.exr", {"-s", "4", "--seed", "3"}), 3, {"a.exr", "seed"});
  expect_error(resume("a.exr", {"-s", "1"}), 2, {"a.exr", "2 samples"});
  expect_error(resume("overlapping.exr", {"-s", "4"}), 3, {"overlapping.exr"});
  expect_error(resume("plain.exr", {"-s", "4"}), 3, {"plain.exr"});
  expect_error(resume("scene.gltf", {"-s", "4"}), 3, {"scene.gltf"});
  EXPECT_FALSE(fs::exists(file("out.exr")));
  EXPECT_FALSE(fs::exists(file("x.exr")));
}

TEST_F(RenderParts, ACropIsPlacedOnTheFilm) {
  render("all.exr", {"-s", "2"});
  render("crop.exr", {"-s", "2", "--crop", "5,3,17,14"});
  const image::ExrContents all = contents("all.exr"), crop = contents("crop.exr");
  EXPECT_EQ(all.placement.x + all.placement.y, 0u);
  EXPECT_EQ(crop.width, 12u);
  EXPECT_EQ(crop.height, 11u);
  EXPECT_EQ(crop.placement.x, 5u);
  EXPECT_EQ(crop.placement.y, 3u);
  EXPECT_EQ(crop.placement.film_width, 24u);
  EXPECT_EQ(crop.placement.film_height, 16u);
  const auto& whole = std::get<std::vector<float>>(all.channels.at("G"));
  const auto& part = std::get<std::vector<float>>(crop.channels.at("G"));
  for (size_t i = 0; i < part.size(); ++i) EXPECT_EQ(part[i], whole[(i / 12 + 3) * 24 + i % 12 + 5]);
}

// Killed without warning, then resumed: what comes out is what an undisturbed render gives, bit by bit.
TEST_F(RenderParts, AKilledRenderIsResumed) {
  const Arguments endless = {"-s", "16000000", "--checkpoint", file("state.exr"), "--checkpoint-seconds",
                             "0"};
  {
    Process process(command("out.exr", endless));
    ASSERT_TRUE(process.wait_for_handler(SIGINT)) << process.wait().err;
    for (int i = 0; i < 600 && !fs::exists(file("state.exr")); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    process.send(SIGKILL);
    EXPECT_EQ(process.wait().signal, SIGKILL);
  }
  ASSERT_TRUE(fs::exists(file("state.exr")));
  EXPECT_FALSE(fs::exists(file("out.exr")));
  const uint64_t paths = std::stoull(contents("state.exr").attributes.at("regulus:paths"));
  const std::string samples = std::to_string(paths / (24 * 16) + 3);
  std::printf("killed; the checkpoint holds %llu paths\n", static_cast<unsigned long long>(paths));
  render("resumed.exr", {"-s", samples, "--checkpoint", file("state.exr"), "--resume"});
  render("undisturbed.exr", {"-s", samples});
  EXPECT_TRUE(contents("resumed.exr").channels == contents("undisturbed.exr").channels);
  // Once more there is nothing left to do, and a missing checkpoint is a beginning.
  render("again.exr", {"-s", samples, "--checkpoint", file("state.exr"), "--resume"});
  EXPECT_TRUE(contents("again.exr").channels == contents("undisturbed.exr").channels);
  render("fresh.exr", {"-s", "2", "--checkpoint", file("fresh-state.exr"), "--resume"});
  EXPECT_TRUE(fs::exists(file("fresh-state.exr")));
}

}  // namespace
}  // namespace regulus::test
