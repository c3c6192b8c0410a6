// regulus render from the outside: files, metadata, statistics, interruption.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/stat.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <set>
#include <thread>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

class Render : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    scene_.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
    scene_.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.8);
    lit_ = scene_;
    lit_.add_point_light({0, 0, 1}, {1, 1, 1});
    lit_.write(gltf());
  }
  std::string gltf() const { return (folder_ / "scene.gltf").string(); }
  std::string exr() const { return (folder_ / "out.exr").string(); }
  std::string stats() const { return (folder_ / "stats.json").string(); }
  json read_stats() const {
    std::ifstream file(stats());
    return json::parse(file);
  }
  // Everything in the folder but the scene.
  std::set<std::string> written() const {
    std::set<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_.path()))
      if (entry.path() != gltf()) names.insert(entry.path().filename().string());
    return names;
  }

  TemporaryFolder folder_;
  GltfScene scene_, lit_;
};

TEST_F(Render, WritesPictureMetadataAndPreview) {
  const std::string png = (folder_ / "out.png").string();
  const Finished finished = run(
      {"render", gltf(), "-o", exr(), "--size", "12x8", "-s", "3", "--seed", "5", "--png", png, "--quiet"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(finished.out, "");
  EXPECT_EQ(finished.err, "");
  EXPECT_EQ(written(), (std::set<std::string>{"out.exr", "out.png"}));

  image::Attributes attributes;
  const image::Image image = image::read_exr(exr(), &attributes);
  EXPECT_EQ(image.width, 12u);
  EXPECT_EQ(image.height, 8u);
  for (const float value : image.rgb) EXPECT_TRUE(value >= 0 && std::isfinite(value));
  // The quad fills the frame's middle: I / d^2 * albedo / pi = 0.159 right under the light.
  EXPECT_NEAR(image.rgb[3 * (4 * 12 + 6)], 0.5 / M_PI, 0.03);
  EXPECT_EQ(attributes["regulus:samples_done"], "3");
  EXPECT_EQ(attributes["regulus:samples"], "3");
  EXPECT_EQ(attributes["regulus:seed"], "5");
  for (const char* name : {"regulus:width", "regulus:height", "regulus:max_depth", "regulus:techniques",
                           "regulus:device", "regulus:driver", "regulus:version", "regulus:scene",
                           "regulus:scene_hash", "regulus:render_seconds", "regulus:first_sample"})
    EXPECT_TRUE(attributes.contains(name)) << name;

  std::ifstream file(png, std::ios::binary);
  const std::string start{std::istreambuf_iterator<char>(file), {}};
  EXPECT_EQ(start.substr(0, 8), "\x89PNG\r\n\x1a\n");
}

// A diffuse quad under a point light: no ray can meet the light, and nothing is there to be regularized.
// Header and statistics of both backends say what was done, what was asked for, and why the rest was not
// done.
TEST_F(Render, RecordsWhatWasDoneAndWhatWasDropped) {
  for (const char* backend : {"vulkan", "reference"}) {
    const Finished finished = run({"render", gltf(), "-o", exr(), "-i", "pt", "--size", "4x4", "-s", "1",
                                   "--backend", backend, "--stats", stats()});
    ASSERT_EQ(finished.status, 0) << finished.err;
    image::Attributes attributes;
    image::read_exr(exr(), &attributes);
    EXPECT_EQ(attributes["regulus:techniques"], "[\"nee\"]") << backend;
    EXPECT_EQ(attributes["regulus:asked_techniques"], "[\"hit\",\"nee\"]");
    EXPECT_EQ(attributes["regulus:regularization"], "none");
    EXPECT_EQ(attributes["regulus:asked_regularization"], "null") << "left to the plan";
    EXPECT_EQ(attributes["regulus:light_sampling"], "power");
    EXPECT_EQ(attributes["regulus:asked_light_sampling"], "auto");
    EXPECT_EQ(
        attributes["regulus:dropped"],
        "regularization: no surface has a microfacet lobe; technique hit: the scene has no emitter that "
        "a ray can meet");
  }
  const Arguments small = {"render", gltf(), "-o", exr(), "--size", "4x4", "-s", "1", "--stats", stats()};
  Arguments given = small;
  given.insert(given.end(), {"-i", "pt"});
  ASSERT_EQ(run(given).status, 0);
  const json s = read_stats();
  EXPECT_EQ(s.at("settings").at("regularization"), "none");
  EXPECT_EQ(s.at("settings").at("techniques_rule"), "given");
  EXPECT_EQ(s.at("asked").at("techniques"), json({"hit", "nee"}));
  EXPECT_TRUE(s.at("asked").at("regularization").is_null());
  EXPECT_EQ(s.at("dropped").size(), 2u);
  ASSERT_EQ(run(small).status, 0);
  const json chosen = read_stats();
  EXPECT_EQ(chosen.at("settings").at("techniques"), json({"nee"})) << "a point's light on a diffuse surface";
  EXPECT_TRUE(chosen.at("asked").at("techniques").is_null());
  EXPECT_NE(chosen.at("settings").at("techniques_rule"), "given");
}

// The choice of one picture for another: its techniques and regularization, unless they are given.
TEST_F(Render, RepeatsWhatAPictureSays) {
  ASSERT_EQ(run({"render", gltf(), "-o", exr(), "--size", "4x4", "-s", "1", "-i", "bpt"}).status, 0);
  const std::string again = (folder_ / "again.exr").string();
  ASSERT_EQ(run({"render", gltf(), "-o", again, "--size", "4x4", "-s", "2", "--settings-from", exr()}).status,
            0);
  image::Attributes first, second;
  image::read_exr(exr(), &first);
  image::read_exr(again, &second);
  EXPECT_EQ(first["regulus:techniques"], "[\"nee\",\"splat\",\"connect\"]");
  EXPECT_EQ(second["regulus:techniques"], first["regulus:techniques"]);
  EXPECT_EQ(second["regulus:regularization"], first["regulus:regularization"]);
  expect_error(run({"render", gltf(), "-o", again, "--settings-from", gltf()}), 3, {"scene.gltf"});
}

TEST_F(Render, PlanShowsAmongWhatIsChosen) {
  const std::string file = (folder_ / "plan.json").string();
  const Finished finished = run({"plan", gltf(), "--size", "8x8", "--json", file});
  ASSERT_EQ(finished.status, 0) << finished.err;
  EXPECT_NE(finished.out.find("chosen: nee"), std::string::npos) << finished.out;
  std::ifstream stream(file);
  const json plan = json::parse(stream);
  EXPECT_EQ(plan.at("techniques"), "nee");
  EXPECT_EQ(plan.at("candidates").size(), 8u) << "with and without splats, connections and merges";
}

TEST_F(Render, SameCommandTwiceGivesTheSamePixels) {
  const std::string again = (folder_ / "again.exr").string();
  ASSERT_EQ(run({"render", gltf(), "-o", exr(), "--size", "12x8", "-s", "3"}).status, 0);
  ASSERT_EQ(run({"render", gltf(), "-o", again, "--size", "12x8", "-s", "3", "--wave", "64"}).status, 0);
  EXPECT_EQ(image::read_exr(exr()).rgb, image::read_exr(again).rgb);
}

// What a render records.
TEST_F(Render, StatisticsHaveTheirKeys) {
  const Finished finished = run(
      {"render", gltf(), "-o", exr(), "--size", "12x8", "-s", "4", "--max-depth", "3", "--stats", stats()});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const json s = read_stats();
  EXPECT_TRUE(s.at("device").at("name").is_string());
  EXPECT_TRUE(s.at("device").at("driver").is_string());
  EXPECT_TRUE(s.at("scene").at("features").is_array());
  EXPECT_EQ(s.at("scene").at("triangles"), 2);
  EXPECT_EQ(s.at("scene").at("lights"), 1);
  EXPECT_EQ(s.at("settings").at("samples"), 4);
  EXPECT_EQ(s.at("settings").at("max_depth"), 3);
  for (const char* name : {"load", "bvh", "pipelines", "render", "device"})
    EXPECT_GE(s.at("seconds").at(name).get<double>(), 0) << name;
  EXPECT_GT(s.at("seconds").at("render").get<double>(), 0);
  EXPECT_EQ(s.at("spp_done"), 4);
  const json& submissions = s.at("submissions");
  EXPECT_GT(submissions.at("count").get<uint64_t>(), 0u);
  EXPECT_GT(submissions.at("most_items").get<uint64_t>(), 0u);
  EXPECT_LE(submissions.at("most_items").get<uint64_t>(), submissions.at("bound_items").get<uint64_t>());
  const auto longest_ms = submissions.at("longest_device_ms").get<double>();
  EXPECT_GT(longest_ms, 0);
  EXPECT_LE(longest_ms, 1.001e3 * s.at("seconds").at("device").get<double>());
  EXPECT_EQ(s.at("non_finite"), 0);
  EXPECT_GT(s.at("device_peak_bytes").get<uint64_t>(), 0u);
  EXPECT_GT(s.at("host_peak_bytes").get<uint64_t>(), 0u);

  // Camera rays, and one more per camera ray that hit at most; one light connection per hit at most.
  constexpr uint64_t PATHS = 12 * 8 * 4;
  const auto closest = s.at("rays").at("closest").get<uint64_t>(),
             visibility = s.at("rays").at("visibility").get<uint64_t>();
  EXPECT_GT(closest, PATHS);
  EXPECT_LE(closest, 2 * PATHS);  // the walk leaves the single plane
  EXPECT_GT(visibility, 0u);
  EXPECT_LE(visibility, PATHS);

  std::set<std::string> names;
  for (const json& stage : s.at("stages")) {
    names.insert(stage.at("name").get<std::string>());
    EXPECT_GE(stage.at("device_ms").get<double>(), 0);
    if (stage.at("skipped").get<bool>()) {
      EXPECT_EQ(stage.at("dispatches"), 0) << stage;
      EXPECT_EQ(stage.at("items"), 0) << stage;
    } else {
      EXPECT_GT(stage.at("dispatches").get<uint64_t>(), 0u) << stage;
    }
    if (stage.at("name") == "camera_bounce.transmissive") {
      EXPECT_TRUE(stage.at("skipped").get<bool>());
    }
    if (stage.at("name") == "trace_closest") {
      EXPECT_EQ(stage.at("items"), closest);
    }
  }
  for (const char* name : {"camera_generate", "trace_closest", "trace_visibility", "accumulate"})
    EXPECT_TRUE(names.contains(name)) << name;
}

TEST_F(Render, FullDiskEndsWithOne) {
  struct stat before {};
  ASSERT_EQ(stat("/dev/full", &before), 0);
  for (const char* option : {"--output", "--stats", "--png"}) {
    Arguments arguments = {"render", gltf(), "--size", "4x4", "-s", "1", option, "/dev/full"};
    if (std::string(option) != "--output") arguments.insert(arguments.end(), {"-o", exr()});
    expect_error(run(arguments, {{"TMPDIR", folder_.path().string()}}), 1, {"/dev/full", "regulus-"});
  }
  struct stat after {};
  ASSERT_EQ(stat("/dev/full", &after), 0);
  EXPECT_TRUE(S_ISCHR(after.st_mode));
  EXPECT_EQ(after.st_ino, before.st_ino);
}

TEST_F(Render, SceneWithoutLightIsLitDimlyAndSaysSo) {
  scene_.write(gltf());
  const Finished finished = run({"render", gltf(), "-o", exr(), "--size", "8x8", "-s", "2"});
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(count_lines(finished.err), 1u) << finished.err;
  EXPECT_NE(finished.err.find("light"), std::string::npos) << finished.err;
  // White from everywhere at 0.5, reflected by half: 0.25, with a standard error below 0.02.
  const image::Image image = image::read_exr(exr());
  double mean = 0;
  for (const float value : image.rgb) {
    EXPECT_GT(value, 0);
    mean += value / static_cast<double>(image.rgb.size());
  }
  EXPECT_NEAR(mean, 0.25, 0.1);
}

TEST_F(Render, EmptySceneIsAnError) {
  std::ofstream(gltf()) << R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{}]})";
  expect_error(run({"render", gltf(), "-o", exr(), "--size", "8x8", "-s", "2"}), 3, {"scene.gltf"});
  EXPECT_EQ(written(), std::set<std::string>{});
}

TEST_F(Render, SettingsOfTheSceneApplyAndTheCommandLineWins) {
  lit_.set_setting("spp", 3);
  lit_.set_setting("max-depth", 5);
  lit_.set_setting("size", "10x6");
  lit_.set_setting("ndf", "beckmann");
  lit_.set_setting("output", "/nonexistent/stolen.exr");
  lit_.set_setting("colour-of-the-bike-shed", "green");
  lit_.write(gltf());
  const Finished finished = run({"render", gltf(), "-o", exr(), "--max-depth", "2", "--stats", stats()});
  ASSERT_EQ(finished.status, 0) << finished.err;
  const json settings = read_stats().at("settings");
  EXPECT_EQ(settings.at("samples"), 3);
  EXPECT_EQ(settings.at("width"), 10);
  EXPECT_EQ(settings.at("height"), 6);
  EXPECT_EQ(settings.at("ndf"), "beckmann");
  EXPECT_EQ(settings.at("max_depth"), 2);
  EXPECT_TRUE(fs::exists(exr()));
  EXPECT_NE(finished.err.find("output"), std::string::npos) << finished.err;
  EXPECT_NE(finished.err.find("colour-of-the-bike-shed"), std::string::npos) << finished.err;
}

// A render that would take days.
Arguments endless(const std::string& scene, const std::string& output) {
  return {"render", scene, "-o", output, "--size", "16x16", "-s", "16000000"};
}

TEST_F(Render, InterruptWritesWhatWasRendered) {
  for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGXCPU}) {
    Process process(endless(gltf(), exr()));
    ASSERT_TRUE(process.wait_for_handler(signal)) << process.wait().err;
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    const auto sent = std::chrono::steady_clock::now();
    process.send(signal);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    process.send(signal);  // as timeout(1) does, to the child and to its group
    const Finished finished = process.wait();
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - sent).count();
    expect_error(finished, 130, {"out.exr"});
    EXPECT_LT(seconds, 10);  // two waves in flight, under 200 ms each on any device that is not overcommitted
    image::Attributes attributes;
    const image::Image image = image::read_exr(exr(), &attributes);
    const unsigned long long samples = std::stoull(attributes.at("regulus:samples_done"));
    std::printf("signal %d: %llu samples per pixel, written %.2f s after it\n", signal, samples, seconds);
    EXPECT_GE(samples, 1u);
    EXPECT_LT(samples, 16000000u);
    // Many samples of the middle: I / d^2 * albedo / pi within what the pixel's width lets vary.
    EXPECT_NEAR(image.rgb[3 * (8 * 16 + 8)], 0.5 / M_PI, 0.01);
    EXPECT_EQ(written(), std::set<std::string>{"out.exr"});
    fs::remove(exr());
  }
}

TEST_F(Render, KilledRenderLeavesTheOldPicture) {
  std::ofstream(exr()) << "the old picture";
  Process process(endless(gltf(), exr()));
  ASSERT_TRUE(process.wait_for_handler(SIGINT)) << process.wait().err;
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  process.send(SIGKILL);
  EXPECT_EQ(process.wait().signal, SIGKILL);
  std::ifstream file(exr());
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "the old picture");
  EXPECT_EQ(written(), std::set<std::string>{"out.exr"});
}

TEST_F(Render, DefaultOutputsAreTheScenesNameInTheWorkingFolder) {
  const fs::path before = fs::current_path();
  fs::current_path(folder_.path());
  const Finished finished = run({"render", "scene.gltf", "--size", "4x4", "-s", "1"});
  fs::current_path(before);
  EXPECT_EQ(finished.status, 0) << finished.err;
  EXPECT_EQ(written(), (std::set<std::string>{"scene.exr", "scene.png"}));
}

TEST_F(Render, DevicesAreListed) {
  const Finished finished = run({"devices"});
  EXPECT_EQ(finished.status, 0);
  EXPECT_EQ(finished.err, "");
  EXPECT_NE(finished.out.find(device()->info().name), std::string::npos) << finished.out;
  EXPECT_NE(finished.out.find("can be used"), std::string::npos) << finished.out;
}

}  // namespace
}  // namespace regulus::test
