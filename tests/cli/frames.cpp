// Poses and frames of an animation from the outside: --animation, --at, --frames, --fps.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/prepared_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string base64_of(const std::vector<float>& values) {
  const auto* bytes = reinterpret_cast<const unsigned char*>(values.data());
  const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const size_t size = values.size() * sizeof(float);
  std::string text;
  for (size_t i = 0; i < size; i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < size ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) text += k <= size - i ? digits[(group >> (18 - 6 * k)) & 63] : '=';
  }
  return text;
}

/// A glowing unit square that an animation of two seconds, "slide", moves by 2 along x at constant speed. The
/// camera sees 2 x 2 units around its first place: frames of it are known in closed form.
json sliding_square() {
  json file = {{"asset", {{"version", "2.0"}}}, {"scenes", {{{"nodes", {0, 1}}}}}};
  file["scenes"][0]["extras"]["regulus"] = {{"environment", {{"color", {0, 0, 0}}}}, {"filter", "box"}};
  const auto accessor = [&](const std::vector<float>& values, const char* type, size_t components) {
    file["buffers"].push_back({{"byteLength", 4 * values.size()},
                               {"uri", "data:application/octet-stream;base64," + base64_of(values)}});
    file["bufferViews"].push_back(
        {{"buffer", file["buffers"].size() - 1}, {"byteLength", 4 * values.size()}});
    file["accessors"].push_back({{"bufferView", file["bufferViews"].size() - 1},
                                 {"componentType", 5126},
                                 {"type", type},
                                 {"count", values.size() / components}});
    return file["accessors"].size() - 1;
  };
  const size_t corners =
      accessor({-.5, -.5, 0, .5, -.5, 0, .5, .5, 0, -.5, -.5, 0, .5, .5, 0, -.5, .5, 0}, "VEC3", 3);
  file["meshes"] = {{{"primitives", {{{"attributes", {{"POSITION", corners}}}, {"material", 0}}}}}};
  file["materials"] = {
      {{"emissiveFactor", {1, 1, 1}}, {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}}}}};
  file["cameras"] = {
      {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 10}}}}};
  file["nodes"] = {{{"mesh", 0}}, {{"camera", 0}, {"translation", {0, 0, 5}}}};
  const size_t times = accessor({0, 2}, "SCALAR", 1), places = accessor({0, 0, 0, 2, 0, 0}, "VEC3", 3);
  file["animations"] = {
      {{"name", "slide"},
       {"samplers", {{{"input", times}, {"output", places}}}},
       {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
  return file;
}

class Frames : public testing::Test {
 protected:
  void SetUp() override {
    REGULUS_SKIP_WITHOUT_DEVICE();
    write(sliding_square());
  }
  void write(const json& scene) const { std::ofstream(file("scene.gltf")) << scene.dump(); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Finished render(const Arguments& more) const {
    Arguments arguments = {"render", file("scene.gltf"), "--size",      "8x8", "-s",
                           "1",      "--quiet",          "--max-depth", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  image::ExrContents contents(const std::string& name) const { return image::read_exr_contents(file(name)); }

  /// How many of the eight columns of pixels the square covers, in a picture whose pixels are covered wholly
  /// or not at all, and which column is the first.
  std::pair<int, int> columns(const std::string& name) const {
    const auto& red = contents(name).channels.at("R");
    int first = -1, count = 0;
    for (int x = 0; x < 8; ++x)
      if (std::get<std::vector<float>>(red)[static_cast<size_t>(4 * 8 + x)] > 0.5f) {
        if (first < 0) first = x;
        ++count;
      }
    return {first, count};
  }

  TemporaryFolder folder_;
};

// The families morph-default-weights and skin-at-rest: what glows is there where the default weights and the
// joint put it. (A rest pose that drops them shows the left half instead, and the whole picture.)
TEST_F(Frames, RestPosesAreThoseOfTargetsAndJoints) {
  const std::string cases = std::string(REGULUS_SOURCE_DIR) + "/tests/cases/";
  for (const char* backend : {"vulkan", "reference"}) {
    const auto at_rest = [&](const std::string& scene) {
      EXPECT_EQ(run({"render", cases + scene, "--size", "8x8", "-s", "1", "--quiet", "--filter", "box",
                     "--backend", backend, "-o", file("a.exr")})
                    .status,
                0);
      return columns("a.exr");
    };
    EXPECT_EQ(at_rest("morph-default-weights/c4a.gltf"), (std::pair{4, 4})) << backend;
    EXPECT_EQ(at_rest("skin-at-rest/c5a.gltf"), (std::pair{2, 4})) << backend;
  }
}

// Pixels are a quarter of a unit wide, and the square moves by a unit per second.
TEST_F(Frames, APoseIsWhatTheAnimationHasAtThatTime) {
  for (const char* backend : {"vulkan", "reference"}) {
    const auto at = [&](const Arguments& pose) {
      Arguments arguments = {"-o", file("a.exr"), "--backend", backend};
      arguments.insert(arguments.end(), pose.begin(), pose.end());
      EXPECT_EQ(render(arguments).status, 0);
      return columns("a.exr");
    };
    EXPECT_EQ(at({}), (std::pair{2, 4}));
    EXPECT_EQ(at({"--at", "0.5"}), (std::pair{4, 4}));
    EXPECT_EQ(at({"--animation", "slide", "--at", "1"}), (std::pair{6, 2}));
    EXPECT_EQ(at({"--animation", "0", "--at", "-9"}), (std::pair{2, 4}));
  }
  EXPECT_EQ(contents("a.exr").attributes.at("regulus:animation"), "slide");
  EXPECT_EQ(contents("a.exr").attributes.at("regulus:animation_seconds"), "-9");
}

TEST_F(Frames, EveryFrameIsThePictureOfItsTimeInFilesOfItsOwn) {
  const Finished finished =
      render({"-o", file("f.exr"), "--png", file("p##.png"), "--stats", file("s.json"), "--frames", "1:3",
              "--fps", "4", "--animation", "slide", "--progress", "json"});
  ASSERT_EQ(finished.status, 0) << finished.err;
  std::istringstream progress(finished.out);
  std::vector<json> done;
  for (std::string line; std::getline(progress, line);)
    if (json::parse(line).at("phase") == "done") done.push_back(json::parse(line));
  ASSERT_EQ(done.size(), 3u) << finished.out;
  for (int i = 0; i < 3; ++i) EXPECT_EQ(done[static_cast<size_t>(i)].at("frame"), i + 1);
  EXPECT_FALSE(fs::exists(file("f.exr")));
  EXPECT_FALSE(fs::exists(file("f.0000.exr")));
  EXPECT_FALSE(fs::exists(file("f.0004.exr")));
  for (const char* number : {"1", "2", "3"}) {
    const std::string name = std::string("f.000") + number + ".exr";
    const std::string seconds = fmt::format("{}", std::stoi(number) / 4.0);
    ASSERT_EQ(render({"-o", file("one.exr"), "--at", seconds}).status, 0);
    const image::ExrContents frame = contents(name), one = contents("one.exr");
    EXPECT_TRUE(frame.channels == one.channels) << name;
    EXPECT_EQ(frame.attributes.at("regulus:scene_hash"), one.attributes.at("regulus:scene_hash"));
    EXPECT_EQ(frame.attributes.at("regulus:animation_seconds"), seconds);
    EXPECT_TRUE(fs::exists(file(std::string("p0") + number + ".png")));
    std::ifstream stats(file(std::string("s.000") + number + ".json"));
    EXPECT_EQ(json::parse(stats)["scene"]["animation_seconds"], std::stoi(number) / 4.0);
  }
}

TEST_F(Frames, OfAFarmAreThoseOfOneProcess) {
  const Arguments settings = {"--frames", "1:3", "--fps", "4", "--animation", "slide"};
  Arguments all = {"-o", file("f.exr")},
            tasks = {"farm", file("scene.gltf"), "-o",  file("t.exr"), "--for", "shell",       "--parts",
                     "2",    "--size",           "8x8", "-s",          "1",     "--max-depth", "1"};
  for (Arguments* arguments : {&all, &tasks})
    arguments->insert(arguments->end(), settings.begin(), settings.end());
  ASSERT_EQ(render(all).status, 0);
  ASSERT_EQ(run(tasks).status, 0);
  ASSERT_EQ(std::system(("sh " + file("t.farm.sh")).c_str()), 0);
  for (const char* number : {"0001", "0002", "0003"})
    EXPECT_TRUE(contents(fmt::format("t.{}.exr", number)).channels ==
                contents(fmt::format("f.{}.exr", number)).channels);
  EXPECT_FALSE(fs::exists(file("t.0000.exr")) || fs::exists(file("t.0004.exr")));
}

TEST_F(Frames, PartsOfDifferentPosesDoNotMerge) {
  const auto part = [&](const std::string& name, const std::string& samples, const Arguments& pose) {
    Arguments arguments = {"-o", file(name), "--samples", samples};
    arguments.insert(arguments.end(), pose.begin(), pose.end());
    Arguments all = {"render", file("scene.gltf"), "--size", "8x8", "--quiet"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    ASSERT_EQ(run(all).status, 0);
  };
  part("a.exr", "0:1", {"--at", "0.5"});
  part("b.exr", "1:1", {"--at", "0.25"});
  part("c.exr", "1:1", {});
  part("d.exr", "1:1", {"--frames", "2:2", "--fps", "4"});
  expect_error(run({"merge", file("ab.exr"), file("a.exr"), file("b.exr")}), 3,
               {"not samples of one render"});
  expect_error(run({"merge", file("ac.exr"), file("a.exr"), file("c.exr")}), 3,
               {"not samples of one render"});
  EXPECT_EQ(run({"merge", file("ad.exr"), file("a.exr"), file("d.0002.exr")}).status, 0);
}

TEST_F(Frames, CheckpointsAreOfEachFrame) {
  const Arguments sequence = {"-o",    file("f.exr"), "--frames",     "0:1",
                              "--fps", "2",           "--checkpoint", file("state.exr")};
  ASSERT_EQ(render(sequence).status, 0);
  EXPECT_TRUE(fs::exists(file("state.0000.exr")));
  EXPECT_TRUE(fs::exists(file("state.0001.exr")));
  expect_error(render(sequence), 2, {"state.0000.exr", "--resume"});
  Arguments resumed = sequence;
  resumed.push_back("--resume");
  EXPECT_EQ(render(resumed).status, 0);
}

TEST_F(Frames, SceneMaySayThemToo) {
  json scene = sliding_square();
  scene["scenes"][0]["extras"]["regulus"].update({{"animation", "slide"}, {"frames", "0:1"}, {"fps", 2}});
  write(scene);
  ASSERT_EQ(render({"-o", file("f.exr")}).status, 0);
  EXPECT_EQ(columns("f.0000.exr"), (std::pair{2, 4}));
  EXPECT_EQ(columns("f.0001.exr"), (std::pair{4, 4}));
  scene["scenes"][0]["extras"]["regulus"].erase("frames");
  scene["scenes"][0]["extras"]["regulus"]["at"] = 0.5;
  write(scene);
  ASSERT_EQ(render({"-o", file("a.exr")}).status, 0);
  EXPECT_EQ(columns("a.exr"), (std::pair{4, 4}));
  const Finished inspected = run({"inspect", file("scene.gltf")});
  EXPECT_NE(inspected.out.find("animation        \"slide\", 2 s"), std::string::npos) << inspected.out;
  EXPECT_NE(inspected.out.find("pose             \"slide\" at 0.5 s"), std::string::npos);
}

TEST_F(Frames, WhatMakesNoSenseIsRefused) {
  const std::string out = file("f.exr");
  for (const char* frames : {"", "3", "3:2", "-1:2", "1:2:3", "a:b", "0:9999999"})
    EXPECT_EQ(render({"-o", out, "--frames", frames}).status, 2) << frames;
  EXPECT_EQ(render({"-o", out, "--frames", "0:1", "--at", "1"}).status, 2);
  EXPECT_EQ(render({"-o", out, "--frames", "0:1", "--fps", "0"}).status, 2);
  expect_error(render({"-o", out, "--animation", "run"}), 3, {"no animation \"run\"", "slide"});
  expect_error(render({"-o", file("#.exr"), "--png", file("#.exr"), "--frames", "0:1"}), 2);
}

}  // namespace
}  // namespace regulus::test
