// What regulus render says while it works and when it is done: to people, and in JSON to programs.
#include "cli/progress.hpp"

#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <regex>
#include <sstream>
#include <thread>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;
using cli::Limits;
using nlohmann::json;

class Progress : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    write_lit_floor(file("scene.gltf"));
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Finished render(const Arguments& more) const {
    Arguments arguments = {"render", file("scene.gltf"), "--size", "32x32", "--sampler",
                           "hash",   "--filter",         "box"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }

  TemporaryFolder folder_;
};

std::vector<json> json_lines(const std::string& text) {
  std::vector<json> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(json::parse(line));
  return lines;
}

// The estimate and the error are means of 3072 values, of which those of a pixel hang together: 1024 with a
// relative error of about sqrt(2) each, 5 standard errors are 22 percent of the square for each of the two;
// the reference's own error takes 3 percent off or on.
TEST_F(Progress, TheMessageSaysWhatWasWrittenAndHowGoodItIs) {
  const Finished finished = render({"-o", file("a.exr"), "--png", file("a.png"), "-s", "64"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(finished.err, "");
  ASSERT_EQ(count_lines(finished.out), 1u) << finished.out;
  EXPECT_EQ(
      finished.out.rfind("wrote " + file("a.exr") + ", " + file("a.png") + ": 32x32, 64 samples per", 0), 0u)
      << finished.out;
  std::smatch found;
  ASSERT_TRUE(std::regex_search(finished.out, found,
                                std::regex("in ([0-9.]+) s .*, ([0-9.]+) s in all; estimated relative error "
                                           "([0-9.e-]+)\n$")))
      << finished.out;
  EXPECT_LE(std::stod(found[1]), std::stod(found[2]));
  ASSERT_EQ(render({"-o", file("reference.exr"), "-s", "1024", "--seed", "9", "--quiet"}).status, 0);
  ASSERT_EQ(run({"diff", file("a.exr"), file("reference.exr"), "--json", file("diff.json")}).status, 0);
  std::ifstream stream(file("diff.json"));
  const double error = std::sqrt(json::parse(stream)["relmse"].get<double>());
  std::printf("estimated %s, true %.4f\n", found[3].str().c_str(), error);
  EXPECT_NEAR(std::stod(found[3]) / error, 1, 0.25);
}

TEST_F(Progress, TheMessageAdmitsWhatItDoesNotKnow) {
  const Finished one = render({"-o", file("a.exr"), "-s", "1"});
  EXPECT_NE(one.out.find("error unknown: more samples"), std::string::npos) << one.out;
  const Finished reference = render({"-o", file("a.exr"), "-s", "2", "--backend", "reference"});
  EXPECT_NE(reference.out.find("wrote"), std::string::npos) << reference.out;
  EXPECT_EQ(reference.out.find("error"), std::string::npos) << reference.out;
}

TEST_F(Progress, QuietIsQuiet) {
  for (const char* style : {"auto", "lines", "none"}) {
    const Finished finished = render({"-o", file("a.exr"), "-s", "2", "--quiet", "--progress", style});
    EXPECT_EQ(finished.status, 0);
    EXPECT_EQ(finished.out + finished.err, "") << style;
  }
  expect_error(render({"--progress", "jsonn"}), 2, {"--progress", "jsonn", "json"});
}

// A picture that goes into a pipe is not mixed with words.
TEST_F(Progress, APictureOnStdoutIsAlone) {
  const std::string command = std::string(REGULUS_BINARY) + " render " + file("scene.gltf") +
                              " --size 8x8 -s 1 -o /dev/stdout | cat >" + file("piped.exr");
  ASSERT_EQ(std::system(command.c_str()), 0);
  ASSERT_EQ(run({"render", file("scene.gltf"), "--size", "8x8", "-s", "1", "-o", file("a.exr")}).status, 0);
  EXPECT_EQ(image::read_exr(file("piped.exr")).rgb, image::read_exr(file("a.exr")).rgb);
  std::ifstream stream(file("piped.exr"), std::ios::binary);
  const std::string bytes(std::istreambuf_iterator<char>(stream), {});
  EXPECT_EQ(bytes.find("wrote /dev/stdout"), std::string::npos);
}

TEST_F(Progress, JsonIsAnObjectALine) {
  const Finished finished =
      render({"-o", file("a.exr"), "--time", "2.5", "-s", "1000000", "--progress", "json", "--quiet"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(finished.err, "");
  std::vector<std::string> phases;
  double seconds = 0, samples = 0, kernels = 0;
  size_t renders = 0;
  for (const json& line : json_lines(finished.out)) {
    const auto phase = line.at("phase").get<std::string>();
    if (phases.empty() || phases.back() != phase) phases.push_back(phase);
    EXPECT_GE(line.at("seconds").get<double>(), seconds) << line;
    seconds = line.at("seconds").get<double>();
    if (phase == "kernels") {
      if (line.at("kernels_done") == 0) kernels = 0;  // they are compiled in several groups
      EXPECT_GE(line.at("kernels_done"), kernels);
      kernels = line.at("kernels_done").get<double>();
      EXPECT_LE(kernels, line.at("kernels_total").get<double>());
    }
    if (phase != "render" || !line.contains("samples_done")) continue;
    ++renders;
    EXPECT_GE(line.at("samples_done").get<double>(), samples);
    samples = line.at("samples_done").get<double>();
    EXPECT_EQ(line.at("samples_total"), 1000000);
    if (samples > 0) EXPECT_GT(line.at("samples_per_second"), 0) << line;
    EXPECT_LE(line.at("seconds_left"), 2.5);
    EXPECT_TRUE(line.at("estimated_error").is_number() || line.at("estimated_error").is_null());
  }
  // The device opens before its kernels are compiled; those that are known take no phase.
  std::erase(phases, "kernels");
  EXPECT_EQ(phases, (std::vector<std::string>{"load", "prepare", "device", "render", "write", "done"}));
  EXPECT_GE(renders, 1u);  // one of those each second may come before the first path
  const json done = json_lines(finished.out).back();
  EXPECT_EQ(done.at("files"), json::array({file("a.exr")}));
  EXPECT_GE(done.at("samples"), samples);
  EXPECT_GE(done.at("render_seconds"), 1.25);  // the limit of 2.5 s begins a little earlier
  EXPECT_GT(done.at("estimated_error"), 0);
}

// Stopped for ten seconds, which cost nothing: then the line is due.
TEST_F(Progress, OffATerminalALineEveryTenSeconds) {
  Process process({"render", file("scene.gltf"), "-o", file("a.exr"), "--size", "16x16", "-s", "16000000"});
  ASSERT_TRUE(process.wait_for_handler(SIGINT));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  process.send(SIGSTOP);
  std::this_thread::sleep_for(std::chrono::seconds(10));
  process.send(SIGCONT);
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  process.send(SIGINT);
  const Finished finished = process.wait();
  EXPECT_EQ(finished.status, 130);
  EXPECT_EQ(finished.out, "");
  EXPECT_TRUE(std::regex_search(
      finished.err,
      std::regex("regulus: progress: [0-9.]+ %  [0-9.e+]+ of 16000000 samples  [0-9.e-]+ million samples/s"
                 "  (error [0-9.e-]+  )?[0-9]+ (s|min|h [0-9]+ min) left\nregulus: error: interrupted")))
      << finished.err;
}

TEST(ProgressTime, TheFirstLimitThatIsReachedEndsTheRender) {
  const session::Progress quarter{.paths_done = 25, .paths_total = 100};
  EXPECT_DOUBLE_EQ(*cli::seconds_left(quarter, {}, 10), 30);  // 75 more at 2.5 a second
  EXPECT_DOUBLE_EQ(*cli::seconds_left(quarter, {.seconds = 25.0}, 10), 15);
  EXPECT_DOUBLE_EQ(*cli::seconds_left(quarter, {.seconds = 5.0}, 10), 0);
  const session::Progress resumed{.paths_done = 25, .paths_total = 100, .earlier_paths = 20};
  EXPECT_DOUBLE_EQ(*cli::seconds_left(resumed, {}, 10), 150);  // 75 more at 0.5 a second
  // Half of the error takes four times the samples.
  const session::Progress noisy{.paths_done = 25, .paths_total = 1000, .noise = 0.2};
  EXPECT_DOUBLE_EQ(*cli::seconds_left(noisy, {.has_samples = false, .noise = 0.1}, 10), 30);
  EXPECT_DOUBLE_EQ(*cli::seconds_left(noisy, {.has_samples = false, .noise = 0.3}, 10), 0);
  EXPECT_FALSE(cli::seconds_left(quarter, {.has_samples = false, .noise = 0.1}, 10));  // not known yet
  EXPECT_FALSE(cli::seconds_left(noisy, {.has_samples = false, .noise = 0.0}, 10));    // never
  EXPECT_FALSE(cli::seconds_left({.paths_done = 0, .paths_total = 100}, {}, 10));
}

}  // namespace
}  // namespace regulus::test
