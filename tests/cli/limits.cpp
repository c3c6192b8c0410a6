// Renders on a device that claims the least of what devices may have (tests/support/limits_layer): the
// picture is the same, and nothing more than that is used.
#include <gtest/gtest.h>
#include <signal.h>

#include <cstdlib>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

class Limits : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  static std::string scene(const std::string& name) {
    std::string path = REGULUS_SOURCE_DIR "/scenes/";
    path.append(name).append("/").append(name).append(".gltf");
    return path;
  }
  static Environment layer(const Environment& claims = {}) {
    Environment environment = {{"VK_LAYER_PATH", LIMITS_LAYER},
                               {"VK_INSTANCE_LAYERS", "VK_LAYER_REGULUS_limits"}};
    environment.insert(claims.begin(), claims.end());
    return environment;
  }
  Finished render(const std::string& output, const Arguments& what, const Environment& environment) const {
    Arguments arguments = {"render", "-o", file(output), "--quiet"};
    arguments.insert(arguments.end(), what.begin(), what.end());
    return run(arguments, environment);
  }
  /// The same picture with the layer and without.
  void expect_same(const Arguments& what, const Environment& claims) const {
    const Finished free = render("free.exr", what, {}), held = render("held.exr", what, layer(claims));
    ASSERT_EQ(free.status, 0) << free.err;
    ASSERT_EQ(held.status, 0) << held.err;
    EXPECT_EQ(held.err, "") << "what the layer says";
    const image::Channels expected = image::read_exr_contents(file("free.exr")).channels,
                          found = image::read_exr_contents(file("held.exr")).channels;
    EXPECT_TRUE(found == expected);
  }

  TemporaryFolder folder_;
};

TEST_F(Limits, AreWhatTheProgramSees) {
  const Finished doctor = run({"doctor"}, layer());
  EXPECT_NE(doctor.out.find("subgroups of 4,"), std::string::npos) << doctor.out << doctor.err;
  EXPECT_NE(doctor.out.find("at most 1.0 GiB at once, 64-bit integers: no"), std::string::npos) << doctor.out;
  const Finished less = run({"devices"}, layer({{"REGULUS_LIMITS_SHARED", "8192"}}));
  EXPECT_NE(less.out.find("cannot be used: limit maxComputeSharedMemorySize is 8192, needs 16384"),
            std::string::npos)
      << less.out;
}

TEST_F(Limits, LeaveThePictureAsItIs) {
  for (const char* subgroup : {"4", "64"}) {
    const Environment claims = {{"REGULUS_LIMITS_SUBGROUP", subgroup}};
    expect_same({scene("cornell"), "-i", "vcm", "--size", "24x24", "-s", "2", "--rays", "software", "--aov",
                 "albedo,N,sigma,direct,lights"},
                claims);
  }
  expect_same({scene("watch"), "-i", "pt", "--size", "24x24", "-s", "2", "--rays", "software"}, {});
}

// Kernels for the device's own ray queries do without 64-bit integers as well.
TEST_F(Limits, HoldForRayQueries) {
  if (!device()->info().has_ray_query) GTEST_SKIP() << "no ray queries";
  expect_same({scene("cornell"), "-i", "bpm", "--size", "24x24", "-s", "2", "--rays", "hardware"}, {});
}

// Candidates of 65,536 paths with a light sample and 120 connections take 333 MiB at once (44 bytes each). On
// a device that claims 256, the least that Regulus takes, the wave is cut. A device that then gives less than
// it has claimed stops the process, which says that the layer sees the allocations.
TEST_F(Limits, WavesKeepToTheAllocation) {
  const Arguments what = {scene("cornell"), "-i",    "bpt",           "--size",    "256x256",     "-s", "1",
                          "--wave",         "65536", "--connections", "cache:120", "--max-depth", "2"};
  expect_same(what, {{"REGULUS_LIMITS_ALLOCATION", "256"}});
  const Finished lied =
      render("lied.exr", what,
             layer({{"REGULUS_LIMITS_ALLOCATION", "256"}, {"REGULUS_LIMITS_HELD_ALLOCATION", "64"}}));
  EXPECT_EQ(lied.signal, SIGABRT);
  EXPECT_NE(lied.err.find("limits layer: bytes of a"), std::string::npos) << lied.err;
}

}  // namespace
}  // namespace regulus::test
