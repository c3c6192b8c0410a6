// regulus bench error and bench reference: their statistics, and the page in a browser.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

using nlohmann::json;

class Bench : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    write_lit_floor(file("floor.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Finished make_reference() const {
    return run({"bench", "reference", file("floor.gltf"), "--size", "32x32", "--spp", "256", "--seeds", "4",
                "--options", "-i pt --filter box"});
  }

  TemporaryFolder folder_;
};

// Independent numbers: four times the samples make a quarter of the variance. The mean over 3072 values,
// those of a pixel hanging together, of a variance from 4 seeds has a standard error of about sqrt(2 / (3 *
// 1024)) * 1.5 = 4 percent; 5 of them on each side of the ratio are 28 percent. The reference is 64 times
// finer than the coarser run and 16 times than the finer one.
TEST_F(Bench, VarianceFallsWithTheSamplesAndBiasIsNone) {
  const Finished made = make_reference();
  ASSERT_EQ(made.status, 0) << made.err;
  double variance[2];
  for (const int finer : {0, 1}) {
    const Finished finished =
        run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", finer == 1 ? "16" : "4", "--seeds",
             "4", "--json", file("error.json"), "--configs", "pt=-i pt --sampler hash --filter box"});
    ASSERT_EQ(finished.status, 0) << finished.err;
    std::ifstream stream(file("error.json"));
    const json run = json::parse(stream)["sections"][0]["runs"][0];
    variance[finer] = run["variance"].get<double>();
    EXPECT_EQ(run["points"].back()["samples"], finer == 1 ? 16 : 4);
    EXPECT_NEAR(run["relmse"].get<double>() / variance[finer], 1, 0.28);
    EXPECT_LT(std::abs(run["squared_bias"].get<double>()), 0.15 * variance[finer]);
    EXPECT_NEAR(run["mean_ratio"].get<double>(), 1, 0.02);
  }
  EXPECT_NEAR(variance[0] / variance[1], 4, 4 * 0.28);
}

std::string run_shell(const std::string& command) {
  FILE* pipe = popen(command.c_str(), "r");
  std::string output;
  char buffer[4096];
  for (size_t n; pipe != nullptr && (n = fread(buffer, 1, sizeof buffer, pipe)) > 0;)
    output.append(buffer, n);
  if (pipe != nullptr) pclose(pipe);
  return output;
}

size_t count(const std::string& text, const std::string& wanted) {
  size_t found = 0;
  for (size_t at = 0; (at = text.find(wanted, at)) != std::string::npos; at += wanted.size()) ++found;
  return found;
}

// What a browser makes of a page.
struct LoadedPage {
  std::string document, console;
};

LoadedPage load_in_browser(const std::string& page, const std::string& folder) {
  const std::string console_file = folder + "/console.txt";
  LoadedPage loaded;
  loaded.document = run_shell(
      "timeout 120 chromium --headless --no-sandbox --disable-gpu --enable-logging=stderr --user-data-dir=" +
      folder + "/profile --dump-dom 'file://" + page + "' 2>" + console_file);
  std::ifstream stream(console_file);
  loaded.console.assign(std::istreambuf_iterator<char>(stream), {});
  return loaded;
}

TEST_F(Bench, PageShowsACurveForEachConfiguration) {
  if (run_shell("command -v chromium").empty()) GTEST_SKIP() << "no chromium on this machine";
  ASSERT_EQ(make_reference().status, 0);
  const Finished finished =
      run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", "4", "--seeds", "2", "--html",
           file("page.html"), "--configs",
           "a </script> name=-i pt --filter box;second=-i pt --filter box --max-depth 2"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const auto [document, console] = load_in_browser(file("page.html"), folder_.path().string());
  EXPECT_EQ(count(console, "CONSOLE"), 0u) << console;
  EXPECT_EQ(count(document, "class=\"curve\""), 2u);
  EXPECT_EQ(count(document, "<h2>floor</h2>"), 1u);
  EXPECT_EQ(count(document, "alt=\"relative error of "), 2u) << "heat maps";
  EXPECT_EQ(count(document, "alt=\"picture by "), 2u);
}

// Twice the samples take about twice the time: the exponent over 4, 16 and 64 of them lies between those of a
// render that costs nothing beside its samples, and of one whose start costs as much as 16.
TEST_F(Bench, GrowthWithSamplesIsLinear) {
  const Finished finished = run({"bench", "growth", "--sweeps", "samples", "--repeats", "2", "--json",
                                 file("growth.json"), "--html", file("growth.html")});
  ASSERT_EQ(finished.status, 0) << finished.err;
  std::ifstream stream(file("growth.json"));
  const json sweep = json::parse(stream)["sweeps"][0];
  EXPECT_EQ(sweep["name"], "samples");
  ASSERT_EQ(sweep["points"].size(), 3u);
  const double exponent = sweep["render"]["exponent"].get<double>();
  std::printf("exponent of time over samples %.3f\n", exponent);
  EXPECT_GT(exponent, std::log(80.0 / 20.0) / std::log(16.0));
  EXPECT_LT(exponent, 1.25);
  expect_error(run({"bench", "growth", "--sweeps", "sample"}), 2, {"sample", "did you mean samples?"});
  if (run_shell("command -v chromium").empty()) GTEST_SKIP() << "no chromium on this machine";
  const auto [document, console] = load_in_browser(file("growth.html"), folder_.path().string());
  EXPECT_EQ(count(console, "CONSOLE"), 0u) << console;
  EXPECT_EQ(count(document, "class=\"curve\""), 3u);
  EXPECT_EQ(count(document, "class=\"exponent\""), 3u);
}

// The comparisons (a) to (g) of the talk; what they show is a matter of the scenes, which the floor stands
// for here.
TEST_F(Bench, TalkShowsEachComparison) {
  if (run_shell("command -v chromium").empty()) GTEST_SKIP() << "no chromium on this machine";
  ASSERT_EQ(make_reference().status, 0);
  for (const std::string name : {"watch", "mirrors", "cornell", "pool"}) {
    std::filesystem::create_directory(file(name));
    write_lit_floor(file(name + "/" + name + ".gltf"));
    std::filesystem::copy_file(file("reference/floor.exr"), file("reference/" + name + ".exr"));
  }
  const Finished finished =
      run({"bench", "talk", "--folder", folder_.path().string(), "--references", file("reference"), "--spp",
           "2", "--seeds", "2", "--html", file("talk.html")});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const auto [document, console] = load_in_browser(file("talk.html"), folder_.path().string());
  EXPECT_EQ(count(console, "CONSOLE"), 0u) << console;
  EXPECT_EQ(count(document, "<h2>"), 7u);
  EXPECT_EQ(count(document, "class=\"curve\""), 2u + 4u + 3u + 2u + 5u + 6u + 4u);
}

// The right half of the floor by itself: as many values as there are, and the whole film's error in the mean
// of both.
TEST_F(Bench, MeasuresARegion) {
  ASSERT_EQ(make_reference().status, 0);
  double relmse[3];
  const char* regions[3] = {"0,0,32,32", "0,0,16,32", "16,0,32,32"};
  for (int i = 0; i < 3; ++i) {
    const Finished finished =
        run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", "1", "--seeds", "2", "--json",
             file("error.json"), "--region", regions[i], "--configs", "pt=-i pt"});
    ASSERT_EQ(finished.status, 0) << finished.err;
    std::ifstream stream(file("error.json"));
    relmse[i] = json::parse(stream)["sections"][0]["runs"][0]["relmse"].get<double>();
  }
  EXPECT_NE(relmse[1], relmse[2]);
  EXPECT_NEAR((relmse[1] + relmse[2]) / 2, relmse[0], 1e-9);
  const Finished outside = run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", "1", "--region",
                                "0,0,33,32", "--configs", "pt=-i pt"});
  EXPECT_EQ(outside.status, 2);
  EXPECT_NE(outside.err.find("--region 0,0,33,32"), std::string::npos) << outside.err;
}

TEST_F(Bench, NamesWhatIsMissing) {
  expect_error(run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", "1"}), 3,
               {"floor.exr", "bench reference"});
  ASSERT_EQ(make_reference().status, 0);
  expect_error(run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", "1", "--configs",
                    "x=--no-such-option 3"}),
               2, {"no-such-option"});
}

}  // namespace
}  // namespace regulus::test
