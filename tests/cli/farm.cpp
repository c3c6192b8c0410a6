// Scripts for farms: what they render is what one process does, whatever is killed and whatever files are
// called.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include "base/shell_words.hpp"
#include "cli/process.hpp"
#include "cli/small_scenes.hpp"
#include "image/image.hpp"
#include "images/support/render_scene.hpp"
#include "support/device.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

/// Exit status of a shell that runs the command; -1 if a signal ended it.
int shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

class Farm : public testing::Test {
 protected:
  void SetUp() override {
    old_ = fs::current_path();
    fs::create_directory(work_);
    fs::current_path(work_);  // names are relative, so that they may begin with a dash
    write_lit_floor(SCENE);
  }
  void TearDown() override { fs::current_path(old_); }

  static Finished farm(const std::string& output, const Arguments& more) {
    Arguments arguments = {"farm", SCENE_ARGUMENT, "--output=" + output};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  }
  static image::ExrContents contents(const std::string& name) { return image::read_exr_contents(name); }

  // What a shell, fmt, sed, GNU parallel and an option parser could take for something else.
  static constexpr const char SCENE[] = "-it's $(touch oops) `id` \"{}\" {#} %d\\n.gltf";
  static constexpr const char SCENE_ARGUMENT[] = "./-it's $(touch oops) `id` \"{}\" {#} %d\\n.gltf";
  TemporaryFolder folder_;
  fs::path work_ = folder_.path() / "a farm's $HOME & more;", old_;
};

// A word is one word, and the same, to a shell.
TEST(ShellWord, ArrivesAsItIs) {
  for (const std::string text :
       {"", "plain", "it's", "''", "$HOME `id` $(id) \\ \" * ? ~ ! # ; & | < >", "a\nb", "\xff -x"}) {
    const TemporaryFolder folder;
    const std::string file = (folder.path() / "out").string();
    ASSERT_EQ(shell("printf %s. " + shell_word(text) + " >" + shell_word(file)), 0);
    EXPECT_EQ(text_of(file), text + ".");
  }
}

TEST_F(Farm, WhatCannotBeDividedIsRefused) {
  expect_error(farm("a.exr", {"--parts", "5", "--for", "shell", "-s", "4"}), 2, {"--parts 5", "4 samples"});
  expect_error(farm("a.exr", {"--parts", "3", "--for", "shell", "--frames", "3:4"}), 2,
               {"--parts 3", "2 frames"});
  expect_error(farm("a.exr", {"--parts", "2", "--for", "shelf"}), 2, {"shelf", "did you mean shell"});
  expect_error(farm("a.png", {"--parts", "2", "--for", "shell"}), 2, {"a.png", ".exr"});
  for (const char* option :
       {"--time=3", "--noise=0.1", "--samples=0:4", "--checkpoint=a", "--png=a.png", "--stats=a.json"})
    expect_error(farm("a.exr", {"--parts", "2", "--for", "shell", option}), 2,
                 {std::string(option).substr(0, std::string(option).find('=')), "not for a farm"});
  expect_error(farm("a.exr", {"--parts", "2", "--for", "shell", "--size", "0x0"}), 2, {"--size 0x0"});
  EXPECT_FALSE(fs::exists("a.farm.sh"));
}

// Every sample is in one part, however unevenly they divide.
TEST_F(Farm, PartsCoverTheSamplesOnce) {
  ASSERT_EQ(farm("a.exr", {"--parts", "7", "--for", "shell", "-s", "24"}).status, 0);
  std::ofstream("echo.sh")
      << "#!/bin/sh\nfor word; do case $word in --samples=*) echo \"${word#*=}\" ;; esac; done >>ranges\n"
         "for word; do case $word in --output=*) : >\"${word#*=}\" ;; esac; done\n";
  ASSERT_EQ(shell("chmod +x echo.sh; for k in 0 1 2 3 4 5 6; do REGULUS=./echo.sh sh ./a.farm.sh task $k || "
                  "exit; done"),
            0);
  std::ifstream ranges("ranges");
  uint64_t next = 0, first = 0, count = 0, parts = 0;
  for (char colon; ranges >> first >> colon >> count; ++parts) {
    EXPECT_EQ(first, next);
    EXPECT_TRUE(count == 3 || count == 4) << count;
    next = first + count;
  }
  EXPECT_EQ(parts, 7u);
  EXPECT_EQ(next, 24u);
  // All of them are done now.
  ASSERT_EQ(shell("REGULUS=false sh ./a.farm.sh task 3"), 0);
}

// The first attempt at the middle part gets as far as a checkpoint of half of its samples, then is killed.
TEST_F(Farm, AKilledTaskGoesOnAndThePictureIsThatOfOneProcess) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  const std::string name = "-o {} u't $(touch oops)";
  std::ofstream("regulus.sh") << R"sh(#!/bin/sh
for word; do case $word in --checkpoint=*) state=${word#*=} ;; esac; done
[ -e log ] || case " $* " in
  *" --samples=2:2 "*)
    for word; do
      shift
      [ "$word" != --samples=2:2 ] || word=--samples=2:1
      set -- "$@" "$word"
    done
    "$REAL" "$@" && echo killed >log
    kill -KILL $$ ;;
esac
[ ! -e "$state" ] || echo resumed >>log
exec "$REAL" "$@"
)sh";
  ASSERT_EQ(shell("chmod +x regulus.sh"), 0);
  const Arguments settings = {"-s", "6", "--size", "16x12", "-i", "pt", "--aov", "variance,samples"};
  Arguments one = {"render", SCENE_ARGUMENT, "-o", "one.exr", "--quiet"};
  one.insert(one.end(), settings.begin(), settings.end());
  ASSERT_EQ(run(one).status, 0);
  Arguments parts = settings;
  parts.insert(parts.end(), {"--parts", "3", "--quiet", "--for"});
  for (const char* scheduler : {"shell", "parallel"}) {
    if (std::string(scheduler) == "parallel" && shell("command -v parallel >/dev/null") != 0)
      GTEST_SKIP() << "GNU parallel is not installed";
    Arguments arguments = parts;
    arguments.emplace_back(scheduler);
    const Finished written = farm(name + ".exr", arguments);
    ASSERT_EQ(written.status, 0) << written.err;
    const std::string script = shell_word("./" + name + ".farm.sh");
    ASSERT_EQ(shell("REAL=" + shell_word(REGULUS_BINARY) + " REGULUS=./regulus.sh sh " + script + " 2>err"),
              0)
        << text_of("err");
    EXPECT_EQ(text_of("log"), "killed\nresumed\n");
    const image::ExrContents whole = contents("one.exr"), merged = contents("./" + name + ".exr");
    for (const auto& [channel, values] : whole.channels)
      EXPECT_TRUE(values == merged.channels.at(channel)) << scheduler << " " << channel;
    EXPECT_EQ(merged.attributes.at("regulus:sample_ranges"), "0:6");
    EXPECT_EQ(shell("ls " + shell_word("./" + name + ".parts") + " | grep -c state"), 1)
        << "checkpoints are left";
    fs::remove_all("./" + name + ".parts");
    fs::remove("log");
  }
  EXPECT_FALSE(fs::exists("oops")) << "a file's name was executed";
}

}  // namespace
}  // namespace regulus::test
