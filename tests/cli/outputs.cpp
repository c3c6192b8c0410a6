// What a command writes replaces nothing that it reads, that its scene refers to, or that it writes
// elsewhere; formats follow names; what cannot be written is told early or put elsewhere. Rendered by the
// reference: nothing here needs a Vulkan device.
#include <gtest/gtest.h>
#include <linux/capability.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <fstream>

#include "cli/process.hpp"
#include "image/image.hpp"
#include "images/support/gltf_scene.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// A scene with a buffer, an image and a sky in files of their own, some of which nothing uses.
class Outputs : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "scene");
    GltfScene scene;
    scene.add({quad({-1, -1, 0}, {2, 0, 0}, {0, 2, 0})}, lambert({0.5, 0.5, 0.5}));
    scene.set_perspective(look_at({0, 0, 2}, {0, 0, 0}), 0.8);
    scene.add_point_light({0, 0, 1}, {1, 1, 1});
    scene.write(gltf());
    json document = json::parse(read_file(gltf()));
    document["buffers"].push_back({{"byteLength", 4}, {"uri", "unused%20data.bin"}});
    document["images"] = json::array({{{"uri", "textures\\unused.png"}}, {{"uri", "textures/other.png"}}});
    document["scenes"][0]["extras"]["regulus"]["environment"] = {{"file", "sky.exr"}};
    std::ofstream(gltf()) << document.dump();
    std::ofstream(folder_ / "scene/unused data.bin") << "four";
    fs::create_directory(folder_ / "scene/textures");
    std::ofstream(folder_ / "scene/textures/unused.png") << "not even a picture";
    image::write_exr(folder_ / "scene/sky.exr", {2, 1, {1, 1, 1, 1, 1, 1}});
  }
  std::string gltf() const { return (folder_ / "scene/scene.gltf").string(); }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }

  Arguments command(const Arguments& more) const {
    Arguments arguments = {"render", gltf(), "--size", "8x8", "-s", "1", "--backend", "reference", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  // The bytes of every file below the folder.
  std::map<std::string, std::string> contents() const {
    std::map<std::string, std::string> all;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder_.path()))
      if (entry.is_regular_file()) all[entry.path().string()] = read_file(entry.path());
    return all;
  }
  void expect_refused(const Arguments& more, const std::vector<std::string>& mentions) const {
    const auto before = contents();
    expect_error(run(command(more)), 2, mentions);
    EXPECT_TRUE(contents() == before) << "a file was changed, made or removed";
  }

  TemporaryFolder folder_;
};

TEST_F(Outputs, NothingTheSceneRefersToIsReplaced) {
  for (const char* option : {"--output", "--png", "--stats", "--report", "--checkpoint"}) {
    const auto refused = [&](const std::string& name, const std::string& what) {
      Arguments more = {option, file(name)};
      if (std::string(option) != "--output") more.insert(more.end(), {"-o", file("out.exr")});
      // --stats alone takes any name; for the others the extension may be the first thing that is wrong.
      expect_refused(more, {option, name, std::string(option) == "--stats" ? what : ""});
    };
    refused("scene/scene.gltf", "is the scene");
    refused("scene/sky.exr", "scene.gltf refers to");
    refused("scene/unused data.bin", "scene.gltf refers to");
    refused("scene/textures/unused.png", "scene.gltf refers to");
    refused("scene/textures/../sky.exr", "scene.gltf refers to");
  }
  expect_refused({"-o", file("scene/sky.exr")}, {"--output", "scene.gltf refers to"});
  expect_refused({"--checkpoint", file("scene/sky.exr"), "-o", file("out.exr"), "--resume"},
                 {"--checkpoint", "scene.gltf refers to"});
  // It does not exist, but a scene refers to it.
  expect_refused({"-o", file("scene/textures/other.png")}, {"--output", "refers to"});
  // An environment that only this command line names, and the scene's own, which it overrides.
  image::write_exr(folder_ / "other sky.exr", {2, 1, {1, 1, 1, 1, 1, 1}});
  expect_refused({"--env", file("other sky.exr"), "-o", file("other sky.exr")},
                 {"--output", "the environment"});
  expect_refused({"--env", file("other sky.exr"), "-o", file("scene/sky.exr")}, {"--output", "refers to"});
}

// As `regulus render kitchen.gltf` beside kitchen.exr.
TEST_F(Outputs, TheDefaultNameIsNoException) {
  fs::rename(folder_ / "scene/sky.exr", folder_ / "scene/scene.exr");
  json document = json::parse(read_file(gltf()));
  document["scenes"][0]["extras"]["regulus"]["environment"]["file"] = "scene.exr";
  std::ofstream(gltf()) << document.dump();
  const auto before = contents();
  const fs::path here = fs::current_path();
  fs::current_path(folder_ / "scene");
  const Finished finished =
      run({"render", "scene.gltf", "--size", "8x8", "-s", "1", "--backend", "reference"});
  fs::current_path(here);
  expect_error(finished, 2, {"--output scene.exr", "scene.gltf refers to"});
  EXPECT_TRUE(contents() == before);
}

TEST_F(Outputs, LinksLeadToTheSameFile) {
  fs::create_symlink("scene/sky.exr", folder_ / "link.exr");
  fs::create_symlink("link.exr", folder_ / "link to link.exr");
  fs::create_hard_link(folder_ / "scene/sky.exr", folder_ / "hard.exr");
  fs::create_symlink("scene/textures", folder_ / "way");
  for (const char* name : {"link.exr", "link to link.exr", "hard.exr", "way/../sky.exr"})
    expect_refused({"-o", file(name)}, {"--output", name, "refers to"});
  expect_refused({"-o", file("way/other.png")}, {"refers to"});  // does not exist
  fs::create_symlink("scene/textures/other.png", folder_ / "to nothing.png");
  expect_refused({"-o", file("to nothing.png")}, {"refers to"});
  // The other way round: the scene refers to a link.
  fs::rename(folder_ / "scene/sky.exr", folder_ / "scene/real sky.exr");
  fs::create_symlink("real sky.exr", folder_ / "scene/sky.exr");
  expect_refused({"-o", file("scene/real sky.exr")}, {"refers to"});
}

TEST_F(Outputs, OutputsAreDifferentFiles) {
  const std::vector<const char*> options = {"--output", "--png", "--stats", "--report", "--checkpoint"};
  for (const char* a : options)
    for (const char* b : options) {
      if (a == b) continue;
      expect_refused({a, file("x.exr"), b, file("./x.exr")}, {a, b, "x.exr"});
    }
  expect_refused({"-o", file("x.exr"), "--checkpoint", file("x.exr"), "--resume"},
                 {"--checkpoint", "--output"});
  fs::create_symlink("scene", folder_ / "way");
  expect_refused({"-o", file("scene/new.png"), "--png", file("way/new.png")}, {"--png", "--output"});
  // Devices are no files that could be lost.
  EXPECT_EQ(run(command({"-o", "/dev/null", "--stats", "/dev/null", "--png", "/dev/null"})).status, 0);
}

TEST_F(Outputs, StrategyImagesReplaceNothing) {
  json document = json::parse(read_file(gltf()));
  const std::string plain = document.dump();
  Arguments more = {"--strategy-images", file("scene/textures"), "-o", file("x.exr")};
  for (const char* name : {"textures/sheet.png", "textures/nee-s1-t2-weighted.exr"}) {
    document = json::parse(plain);
    document["images"].push_back({{"uri", name}});
    std::ofstream(gltf()) << document.dump();
    expect_refused(more, {"--strategy-images", name, "refers to"});
  }
  more = {"--strategy-images", file("scene/textures"), "-o", file("scene/textures/hit-s0-t2-weighted.exr")};
  expect_refused(more, {"--strategy-images", "hit-s0-t2-weighted.exr", "--output"});
}

TEST_F(Outputs, OtherCommandsReplaceNothingEither) {
  fs::create_directory(folder_ / "references");
  fs::copy_file(gltf(), folder_ / "other.gltf");
  for (const char* name : {"references/scene.exr", "references/other.exr"})
    image::write_exr(folder_ / name, {2, 1, {1, 1, 1, 1, 1, 1}});
  const auto before = contents();
  expect_error(run({"inspect", gltf(), "--json", gltf()}), 2, {"--json", "is the scene"});
  expect_error(run({"inspect", gltf(), "--json", file("scene/sky.exr")}), 2, {"--json", "refers to"});
  const std::string sky = file("scene/sky.exr");
  for (const char* option : {"--json", "--heat-map", "--flip-map"})
    expect_error(run({"diff", sky, sky, option, sky}), 2, {option, "sky.exr"});
  expect_error(run({"diff", sky, sky, "--heat-map", file("x.png"), "--flip-map", file("x.png")}), 2,
               {"--flip-map", "--heat-map"});
  expect_error(run({"bench", "reference", gltf(), "-o", sky}), 2, {"--output", "refers to"});
  for (const std::string& output : {gltf(), sky}) {
    const char* why = output == sky ? "refers to" : "is the scene";
    expect_error(run({"bench", "kernels", gltf(), "--json", output}), 2, {"--json", why});
    expect_error(run({"bench", "skip", gltf(), "--json", output}), 2, {"--json", why});
    // Of several scenes it may be another's file. Their references need only exist.
    for (const char* option : {"--json", "--html"})
      expect_error(run({"bench", "error", "--scenes", file("other.gltf"), gltf(), "--references",
                        file("references"), option, output}),
                   2, {option, why});
  }
  const std::string reference = file("references/scene.exr");
  expect_error(
      run({"bench", "error", "--scenes", gltf(), "--references", file("references"), "--json", reference}), 2,
      {"--json", "is a reference"});
  expect_error(run({"bench", "error", "--scenes", gltf(), "--references", file("references"), "--json",
                    file("x"), "--html", file("x")}),
               2, {"--html", "--json"});
  // Known before minutes of measuring.
  expect_error(run({"bench", "kernels", "--json", file("absent/x.json")}), 1, {"--json", "absent"});
  expect_error(run({"bench", "skip", gltf(), "--json", file("absent/x.json")}), 1, {"--json", "absent"});
  expect_error(run({"bench", "error", "--scenes", gltf(), "--references", file("references"), "--html",
                    file("absent/x.html")}),
               1, {"--html", "absent"});
  // What would be ignored is not accepted.
  for (const char* option : {"--output", "--png", "--stats", "--checkpoint", "--strategy-images"})
    expect_error(run({"check", gltf(), option, sky}), 2, {"check writes no files", option});
  expect_error(run({"bench", "reference", gltf(), "-o", file("new.exr"), "--options", "-i pt -o " + sky}), 2,
               {"--output", "writes no files"});
  EXPECT_TRUE(contents() == before);
}

// Whatever a scene says: it chooses no file on the machine that renders it.
TEST_F(Outputs, ScenesNameNoOutputs) {
  json document = json::parse(read_file(gltf()));
  json& settings = document["scenes"][0]["extras"]["regulus"];
  const std::vector<const char*> names = {"output",     "o",      "png",     "stats", "strategy-images",
                                          "checkpoint", "resume", "samples", "env"};
  for (const char* name : names)
    settings[name] = std::string(name) == "resume" ? json(true) : json("stolen.exr");
  std::ofstream(gltf()) << document.dump();
  const fs::path here = fs::current_path();
  fs::current_path(folder_.path());
  Arguments arguments = command({"-o", file("out.exr")});
  std::erase(arguments, "--quiet");
  const Finished finished = run(arguments);
  fs::current_path(here);
  EXPECT_EQ(finished.status, 0) << finished.err;
  for (const char* name : names)
    EXPECT_NE(finished.err.find("\"" + std::string(name) + "\" is not a setting"), std::string::npos) << name;
  EXPECT_FALSE(fs::exists(folder_ / "stolen.exr"));
  EXPECT_TRUE(fs::exists(folder_ / "out.exr"));
}

TEST_F(Outputs, TheFormatFollowsTheExtension) {
  const std::map<std::string, std::string> starts = {
      {"a.exr", "\x76\x2f\x31\x01"}, {"a.EXR", "\x76\x2f\x31\x01"}, {"a.png", "\x89PNG"},
      {"a.jpg", "\xff\xd8\xff"},     {"a.jpeg", "\xff\xd8\xff"},    {"a.hdr", "#?RADIANCE"}};
  for (const auto& [name, start] : starts) {
    const Finished finished = run(command({"-o", file(name)}));
    EXPECT_EQ(finished.status, 0) << finished.err;
    EXPECT_TRUE(read_file(file(name)).starts_with(start)) << name;
  }
  for (const char* name : {"a", "a.tif", "a.exr.bak", ".exr", "a.pfm"})
    expect_refused({"-o", file(name)}, {"--output", name, ".exr, .hdr, .jpeg, .jpg, .png"});
  for (const char* name : {"b.jpg", "b.exr", "b"})
    expect_refused({"-o", file("a.exr"), "--png", file(name)}, {"--png", name, ".png"});
  expect_refused({"-o", file("a.exr"), "--checkpoint", file("b.png")}, {"--checkpoint", ".exr"});
  for (const char* option : {"-o", "--png", "--stats", "--checkpoint", "--strategy-images"})
    expect_refused({option, ""}, {"empty"});
  // What only OpenEXR holds is not dropped silently.
  expect_refused({"-o", file("a.png"), "--aov", "Z"}, {"--aov", "a.png"});
  const std::string sky = file("scene/sky.exr");
  EXPECT_EQ(run({"diff", sky, sky, "--heat-map", file("h.jpg"), "--flip-map", file("f.png")}).status, 0);
  EXPECT_TRUE(read_file(file("h.jpg")).starts_with("\xff\xd8\xff"));
  for (const char* name : {"h.exr", "h.hdr", "h"})
    expect_error(run({"diff", sky, sky, "--heat-map", file(name)}), 2, {"--heat-map", name, ".png"});
}

// -o x.png is the picture that --png makes.
TEST_F(Outputs, APngIsThePreview) {
  ASSERT_EQ(run(command({"-o", file("a.png"), "--exposure", "1"})).status, 0);
  ASSERT_EQ(run(command({"-o", file("a.exr"), "--png", file("b.png"), "--exposure", "1"})).status, 0);
  EXPECT_TRUE(read_file(file("a.png")) == read_file(file("b.png")));
}

TEST_F(Outputs, PlacesThatCannotBeWrittenAreKnownBeforeTheSceneIsRead) {
  std::ofstream(file("broken.gltf")) << "no scene";
  const auto before = contents();
  for (const char* option : {"--output", "--png", "--stats", "--report", "--checkpoint"}) {
    const std::string name = std::string(option) == "--png" ? "x.png" : "x.exr";
    for (const std::string& place : {file("absent/" + name), file("broken.gltf/" + name), file("scene")})
      expect_error(run({"render", file("broken.gltf"), option, place}), 1, {option, place});
  }
  // No permissions are needed to be refused there, not even by root.
  for (const char* place : {"/proc/x.exr", "/proc/self/x.exr"})
    expect_error(run({"render", file("broken.gltf"), "-o", place}), 1, {"--output", place});
  EXPECT_TRUE(contents() == before);
}

/// Root writes everywhere; the new process does not any more.
void give_up_override() {
  for (const int capability : {CAP_DAC_OVERRIDE, CAP_DAC_READ_SEARCH, CAP_FOWNER})
    prctl(PR_CAPBSET_DROP, capability);
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[2] = {};
  if (syscall(SYS_capget, &header, data) != 0) return;
  for (__user_cap_data_struct& word : data) word.inheritable = 0;
  syscall(SYS_capset, &header, data);
}

TEST_F(Outputs, WriteProtectedFilesAndFoldersAreLeftAlone) {
  if (geteuid() == 0 && prctl(PR_CAPBSET_READ, CAP_SETPCAP) != 1)
    GTEST_SKIP() << "root that cannot give up its right to write everywhere";
  std::ofstream(file("protected.exr")) << "finished";
  fs::permissions(file("protected.exr"), fs::perms::owner_read);
  fs::create_directory(folder_ / "protected");
  fs::permissions(folder_ / "protected", fs::perms::owner_read | fs::perms::owner_exec);
  fs::create_symlink("protected.exr", folder_ / "link.exr");
  for (const char* name : {"protected.exr", "link.exr", "protected/new.exr"})
    expect_error(run(command({"-o", file(name)}), {}, give_up_override), 1,
                 {"--output", name, "Permission denied"});
  EXPECT_EQ(read_file(file("protected.exr")), "finished");
  EXPECT_TRUE(fs::is_empty(folder_ / "protected"));
  // The same places are fine once they may be written.
  fs::permissions(file("protected.exr"), fs::perms::owner_all);
  fs::permissions(folder_ / "protected", fs::perms::owner_all);
  for (const char* name : {"protected.exr", "protected/new.exr"})
    EXPECT_EQ(run(command({"-o", file(name)}), {}, give_up_override).status, 0) << name;
}

// The picture cannot be written where it should be: it is somewhere, and the other outputs are where they
// should.
TEST_F(Outputs, AFullDiskLosesNothing) {
  fs::create_directory(folder_ / "elsewhere");
  const Finished finished =
      run(command({"-o", "/dev/full", "--png", file("a.png"), "--stats", file("a.json")}),
          {{"TMPDIR", file("elsewhere")}});
  expect_error(finished, 1, {"/dev/full", "No space left", "elsewhere/regulus-"});
  ASSERT_EQ(std::distance(fs::directory_iterator(folder_ / "elsewhere"), {}), 1);
  const fs::path rescued = fs::directory_iterator(folder_ / "elsewhere")->path();
  EXPECT_NE(finished.err.find(rescued.string()), std::string::npos) << finished.err;
  ASSERT_EQ(run(command({"-o", file("a.exr")})).status, 0);
  EXPECT_TRUE(image::read_exr(rescued).rgb == image::read_exr(file("a.exr")).rgb);
  EXPECT_TRUE(fs::exists(file("a.png")));
  EXPECT_TRUE(fs::exists(file("a.json")));
}

// The folder goes away while the picture is rendered.
TEST_F(Outputs, ARemovedFolderLosesNothing) {
  fs::create_directory(folder_ / "elsewhere");
  fs::create_directory(folder_ / "going");
  Arguments arguments = command({"-o", file("going/a.exr")});
  std::ranges::replace(arguments, std::string("1"), std::string("16000000"));
  Process process(arguments, {{"TMPDIR", file("elsewhere")}});
  ASSERT_TRUE(process.wait_for_handler(SIGTERM));
  fs::remove_all(folder_ / "going");
  usleep(200'000);
  process.send(SIGTERM);
  const Finished finished = process.wait();
  expect_error(finished, 1, {"going/a.exr", "No such file", "elsewhere/regulus-"});
  EXPECT_EQ(image::read_exr(fs::directory_iterator(folder_ / "elsewhere")->path()).width, 8u);
}

// Known before anything is rendered: at least the three words of each sum, for three channels, twice.
TEST_F(Outputs, FilmsAreCountedBeforeTheyAreMade) {
  Arguments arguments = command({"-o", file("a.exr"), "--memory", "16M"});
  std::ranges::replace(arguments, std::string("8x8"), std::string("512x512"));
  const Finished finished = run(arguments);
  expect_error(finished, 1, {"512 x 512", "but 16.0 MiB are allowed", "crops"});
  const std::string before = "needs ";
  EXPECT_GE(std::stod(finished.err.substr(finished.err.find(before) + before.size())), 18) << finished.err;
  arguments.insert(arguments.end(), {"--crop", "0,0,8,8"});
  EXPECT_EQ(run(arguments).status, 0);
}

TEST_F(Outputs, WhatAKilledRunLeftIsRemovedByTheNext) {
  std::ofstream(file(".a.exr.4711-0.tmp")) << "half a picture";
  std::ofstream(file(".a.png.4711-0.tmp")) << "half a preview";
  std::ofstream(file(".b.exr.4711-0.tmp")) << "another's";
  ASSERT_EQ(run(command({"-o", file("a.exr"), "--png", file("a.png")})).status, 0);
  EXPECT_FALSE(fs::exists(file(".a.exr.4711-0.tmp")));
  EXPECT_FALSE(fs::exists(file(".a.png.4711-0.tmp")));
  EXPECT_TRUE(fs::exists(file(".b.exr.4711-0.tmp")));
}

}  // namespace
}  // namespace regulus::test
