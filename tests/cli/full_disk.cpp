// regulus on a disk that runs full while it writes: nothing that was there is lost, nothing half written
// stays, and what was made is put elsewhere.
//
// The program is regulus with tests/cli/full_disk_write.cpp.
#include <gtest/gtest.h>
#include <signal.h>

#include <chrono>
#include <fstream>
#include <set>
#include <thread>

#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

std::string read_file(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class FullDisk : public testing::Test {
 protected:
  void SetUp() override {
    write_lit_square(gltf());
    fs::create_directory(disk());
    fs::create_directory(elsewhere());
    std::ofstream(disk() / "full");
  }
  std::string gltf() const { return (folder_ / "scene.gltf").string(); }
  fs::path disk() const { return folder_ / "disk"; }
  fs::path elsewhere() const { return folder_ / "elsewhere"; }
  std::string on_disk(const std::string& name) const { return (disk() / name).string(); }

  Environment room(size_t bytes, const fs::path& temporary) const {
    return {{"REGULUS_TEST_DISK", disk().string()},
            {"REGULUS_TEST_DISK_ROOM", std::to_string(bytes)},
            {"TMPDIR", temporary.string()}};
  }
  Arguments command(const Arguments& more) const {
    Arguments arguments = {"render", gltf(), "--size", "8x8", "--quiet"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  }
  static std::set<std::string> names_in(const fs::path& folder) {
    std::set<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      names.insert(entry.path().filename().string());
    return names;
  }

  TemporaryFolder folder_;
};

TEST_F(FullDisk, AtAnyByteLosesNeitherTheOldFilesNorTheNew) {
  const Arguments outputs = {"-s",        "1",
                             "--backend", "reference",
                             "-o",        on_disk("a.exr"),
                             "--png",     on_disk("a.png"),
                             "--stats",   on_disk("a.json")};
  fs::remove(disk() / "full");
  ASSERT_EQ(run(command(outputs), room(0, elsewhere())).status, 0) << "there is room";
  const std::vector<float> pixels = image::read_exr(on_disk("a.exr")).rgb;
  const std::string preview = read_file(on_disk("a.png"));
  const size_t whole = fs::file_size(on_disk("a.exr"));
  std::ofstream(disk() / "full");
  const std::vector<std::string> names = {"a.exr", "a.png", "a.json"};
  for (const std::string& name : names) std::ofstream(on_disk(name)) << "old";
  for (const size_t bytes : {size_t{0}, size_t{1}, preview.size() / 2, preview.size(), whole - 100}) {
    SCOPED_TRACE(std::to_string(bytes) + " bytes of room");
    const Finished finished = run(command(outputs), room(bytes, elsewhere()));
    expect_error(finished, 1, {"a.exr", "No space left", "elsewhere/regulus-"});
    EXPECT_EQ(names_in(disk()), (std::set<std::string>{"a.exr", "a.json", "a.png", "full"}));
    size_t rescued = 0;
    for (const fs::directory_entry& entry : fs::directory_iterator(elsewhere())) {
      ++rescued;
      EXPECT_NE(finished.err.find(entry.path().string()), std::string::npos) << finished.err;
      if (entry.path().extension() == ".exr") {
        EXPECT_EQ(image::read_exr(entry.path()).rgb, pixels);
      }
      if (entry.path().extension() == ".png") {
        EXPECT_EQ(read_file(entry.path()), preview);
      }
      fs::remove(entry.path());
    }
    // Each is in its place or elsewhere, and whole in either.
    for (const std::string& name : names) rescued += read_file(on_disk(name)) != "old" ? 1 : 0;
    EXPECT_EQ(rescued, names.size());
    EXPECT_EQ(read_file(on_disk("a.exr")), "old");
    if (bytes >= preview.size()) {
      EXPECT_EQ(read_file(on_disk("a.png")), preview);
    }
    for (const std::string& name : names) std::ofstream(on_disk(name)) << "old";
  }
}

TEST_F(FullDisk, WithoutRoomElsewhereIsAnErrorThatLeavesNothing) {
  const Finished finished =
      run(command({"-s", "1", "--backend", "reference", "-o", on_disk("a.exr")}), room(64, disk()));
  expect_error(finished, 1, {"a.exr", "No space left"});
  EXPECT_EQ(finished.err.find("instead"), std::string::npos) << finished.err;
  EXPECT_EQ(names_in(disk()), std::set<std::string>{"full"});
}

TEST_F(FullDisk, LosesNoMergedParts) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::string a = (folder_ / "a.exr").string(), b = (folder_ / "b.exr").string();
  ASSERT_EQ(run(command({"-o", a, "--samples", "0:1"})).status, 0);
  ASSERT_EQ(run(command({"-o", b, "--samples", "1:1"})).status, 0);
  expect_error(run({"merge", on_disk("all.exr"), a, b}, room(1000, elsewhere())), 1,
               {"all.exr", "No space left", "elsewhere/regulus-"});
  EXPECT_EQ(names_in(disk()), std::set<std::string>{"full"});
  ASSERT_EQ(run({"merge", (folder_ / "all.exr").string(), a, b}).status, 0);
  const fs::path rescued = fs::directory_iterator(elsewhere())->path();
  EXPECT_TRUE(image::read_exr_contents(rescued).channels ==
              image::read_exr_contents(folder_ / "all.exr").channels);
}

// The checkpoint before stays whole; when there is room again, the next one is written.
TEST_F(FullDisk, KeepsTheCheckpointBeforeAndTriesAgain) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::string state = on_disk("state.exr");
  fs::remove(disk() / "full");
  ASSERT_EQ(run(command({"-s", "1", "-o", on_disk("a.exr"), "--checkpoint", state})).status, 0);
  std::ofstream(disk() / "full");
  const std::string before = read_file(state);
  Arguments arguments =
      command({"-o", on_disk("a.exr"), "--checkpoint", state, "--resume", "--checkpoint-seconds", "0"});
  arguments.insert(arguments.end(), {"-s", "16000000"});
  std::erase(arguments, "--quiet");
  Process process(arguments, room(before.size() / 2, elsewhere()));
  ASSERT_TRUE(process.wait_for_handler(SIGTERM)) << process.wait().err;
  std::this_thread::sleep_for(std::chrono::seconds(2));
  EXPECT_EQ(read_file(state), before);
  fs::remove(disk() / "full");
  for (int i = 0; i < 300 && read_file(state) == before; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_NE(read_file(state), before);
  process.send(SIGTERM);
  const Finished finished = process.wait();
  EXPECT_EQ(finished.status, 130) << finished.err;
  EXPECT_NE(finished.err.find("state.exr"), std::string::npos) << finished.err;
  EXPECT_NE(finished.err.find("No space left"), std::string::npos) << finished.err;
  EXPECT_NE(finished.err.find("tries again"), std::string::npos) << finished.err;
  EXPECT_EQ(names_in(disk()), (std::set<std::string>{"a.exr", "state.exr"}));
  EXPECT_EQ(names_in(elsewhere()), std::set<std::string>{});
}

}  // namespace
}  // namespace regulus::test
