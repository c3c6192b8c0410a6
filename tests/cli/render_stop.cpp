// regulus render with --time and --noise: when it stops, what it says, and whether the noise it says is true.
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <fstream>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using nlohmann::json;

class RenderStop : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    write_lit_floor(file("scene.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Finished render(const std::string& output, Arguments more) const {
    Arguments arguments = {"render",  file("scene.gltf"), "-o",        file(output), "--size",   "32x32",
                           "--stats", file("stats.json"), "--sampler", "hash",       "--filter", "box"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  json read_json(const std::string& name) const {
    std::ifstream stream(file(name));
    return json::parse(stream);
  }

  TemporaryFolder folder_;
};

TEST_F(RenderStop, TimeIsUsedAndOneSampleIsCertain) {
  // The limit begins a little before what statistics call the render, which may lack a part of it where
  // threads have to wait; the whole process lacks nothing. How many samples a busy machine takes in that time
  // nobody knows, so that it may have more.
  constexpr uint64_t DEFAULT_SAMPLES = 16;
  uint64_t samples = 0;
  for (double limit = 1.5; samples <= DEFAULT_SAMPLES && limit < 100; limit *= 2) {
    const auto start = std::chrono::steady_clock::now();
    const Finished finished = render("time.exr", {"--time", std::to_string(limit), "--quiet"});
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    ASSERT_EQ(finished.status, 0) << finished.err;
    EXPECT_GE(seconds.count(), limit);
    EXPECT_GE(read_json("stats.json")["seconds"]["render"].get<double>(), limit / 2);
    samples = read_json("stats.json")["spp_done"].get<uint64_t>();
  }
  EXPECT_GT(samples, DEFAULT_SAMPLES) << "the default of --spp is no limit";
  ASSERT_EQ(render("none.exr", {"--time", "0", "--quiet"}).status, 0);
  EXPECT_GE(read_json("stats.json")["spp_done"].get<uint64_t>(), 1u);
  ASSERT_EQ(render("both.exr", {"--time", "1000", "--spp", "4", "--quiet"}).status, 0);
  EXPECT_EQ(read_json("stats.json")["spp_done"], 4u);
}

// The reference has 16 times the samples, so it takes at most 6 percent off or on. The estimate and the error
// are means of 3072 values, of which those of a pixel hang together: 1024 with a relative error of about
// sqrt(2) each, 5 standard errors are 22 percent of the square for each of the two.
TEST_F(RenderStop, NoiseIsReachedAndTrue) {
  const Finished finished = render("noisy.exr", {"--noise", "0.02"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const double noise = read_json("stats.json")["noise"].get<double>();
  const auto samples = read_json("stats.json")["spp_done"].get<uint64_t>();
  EXPECT_NE(finished.out.find("estimated relative error"), std::string::npos) << finished.out;
  EXPECT_LE(noise, 0.02);
  ASSERT_EQ(render("reference.exr", {"--spp", std::to_string(16 * samples), "--seed", "9", "--quiet"}).status,
            0);
  ASSERT_EQ(run({"diff", file("noisy.exr"), file("reference.exr"), "--json", file("diff.json")}).status, 0);
  const double error = std::sqrt(read_json("diff.json")["relmse"].get<double>());
  std::printf("%llu samples: estimated %.4f, true %.4f\n", static_cast<unsigned long long>(samples), noise,
              error);
  EXPECT_NEAR(noise / error, 1, 0.25);
}

// The state of the film before the one that is good enough had 1 / 1.5 of its samples at least, and was not.
// Both estimates err by at most 22 percent of the square (see above): the last one is at least
// sqrt(.78 / (1.22 * 1.5)) of the target, however many paths the device takes at once.
TEST_F(RenderStop, NoiseIsNotOvershotWhateverTheWave) {
  constexpr double TARGET = 0.05;
  for (const char* wave : {"0", "64", "2097152"}) {  // 0: the device's own; the last one is 2048 samples
    ASSERT_EQ(render("noisy.exr", {"--noise", std::to_string(TARGET), "--wave", wave, "--quiet"}).status, 0);
    const double noise = read_json("stats.json")["noise"].get<double>();
    const auto samples = read_json("stats.json")["spp_done"].get<uint64_t>();
    std::printf("--wave %s: %llu samples, estimated %.4f\n", wave, static_cast<unsigned long long>(samples),
                noise);
    EXPECT_LE(noise, TARGET);
    EXPECT_GE(noise, TARGET * std::sqrt(0.78 / (1.22 * 1.5)));
  }
}

TEST_F(RenderStop, SaysThatNoiseWasNotReached) {
  const Finished finished = render("few.exr", {"--noise", "1e-6", "--spp", "64"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_TRUE(finished.out.find("asked for") != std::string::npos ||
              finished.out.find("unknown") != std::string::npos)
      << finished.out;
  EXPECT_EQ(read_json("stats.json")["spp_done"], 64u);
  expect_error(render("bad.exr", {"--noise", "-1"}), 2, {"--noise"});
  expect_error(render("bad.exr", {"--time", "soon"}), 2, {"--time"});
}

}  // namespace
}  // namespace regulus::test
