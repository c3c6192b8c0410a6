// regulus bench error and bench reference: their statistics, and the page in a browser.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "cli/lit_floor.hpp"
#include "cli/process.hpp"
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

TEST_F(Bench, PageShowsACurveForEachConfiguration) {
  if (run_shell("command -v chromium").empty()) GTEST_SKIP() << "no chromium on this machine";
  ASSERT_EQ(make_reference().status, 0);
  const Finished finished =
      run({"bench", "error", "--scenes", file("floor.gltf"), "--spp", "4", "--seeds", "2", "--html",
           file("page.html"), "--configs",
           "a </script> name=-i pt --filter box;second=-i pt --filter box --max-depth 2"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const std::string document = run_shell(
      "timeout 120 chromium --headless --no-sandbox --disable-gpu --enable-logging=stderr --user-data-dir=" +
      file("profile") + " --dump-dom 'file://" + file("page.html") + "' 2>" + file("console.txt"));
  std::ifstream stream(file("console.txt"));
  const std::string console{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(count(console, "CONSOLE"), 0u) << console;
  EXPECT_EQ(count(document, "class=\"curve\""), 2u);
  EXPECT_EQ(count(document, "<h2>floor</h2>"), 1u);
  EXPECT_EQ(count(document, "alt=\"relative error of "), 2u) << "heat maps";
  EXPECT_EQ(count(document, "alt=\"picture by "), 2u);
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
