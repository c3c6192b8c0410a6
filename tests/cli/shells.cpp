// Completion, manual pages, and `doctor`: what the program tells of itself.
#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <fstream>
#include <set>
#include <sstream>

#include "base/shell_words.hpp"
#include "cli/process.hpp"
#include "images/support/render_scene.hpp"

namespace regulus::test {
namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}

int shell(const std::string& command) {
  const int status = std::system(command.c_str());
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

/// As manual pages write it.
std::string with_escaped_hyphens(const std::string& text) {
  std::string escaped;
  for (const char c : text) escaped += c == '-' ? std::string("\\-") : std::string(1, c);
  return escaped;
}

/// The commands, as the help of `path` lists them.
std::vector<std::string> commands_below(Arguments path) {
  path.emplace_back("--help");
  std::istringstream help(run(path).out);
  std::vector<std::string> commands;
  bool is_list = false;
  for (std::string line; std::getline(help, line);) {
    if (line.starts_with("Subcommands:"))
      is_list = true;
    else if (is_list && line.size() > 2 && line.starts_with("  ") && line[2] != ' ')
      commands.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return commands;
}

/// The long options that the help of a command shows.
std::set<std::string> options_of(Arguments command) {
  command.emplace_back("--help");
  std::istringstream help(run(command).out);
  std::set<std::string> options;
  for (std::string line; std::getline(help, line);) {
    // "  --size WxH ..." or "  -o,--output FILE ..."
    const size_t name = line.size() > 4 && line[2] == '-' && line[4] == ',' ? 5 : 2;
    if (!line.starts_with("  -") || line.compare(name, 2, "--") != 0) continue;
    const size_t end = line.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-", name + 2);
    options.insert(line.substr(name + 2, end == std::string::npos ? end : end - name - 2));
  }
  return options;
}

/// Every command with its options, from the help alone.
std::vector<std::pair<Arguments, std::set<std::string>>> everything(const Arguments& path = {}) {
  std::vector<std::pair<Arguments, std::set<std::string>>> all = {{path, options_of(path)}};
  for (const std::string& command : commands_below(path)) {
    Arguments below = path;
    below.push_back(command);
    for (auto& entry : everything(below)) all.push_back(std::move(entry));
  }
  return all;
}

class Shells : public testing::Test {
 protected:
  std::string file(const std::string& name) const { return (folder_.path() / name).string(); }
  void write_completion(const std::string& shell) const {
    const Finished finished = run({"completion", shell});
    ASSERT_EQ(finished.status, 0) << finished.err;
    std::ofstream(file(shell)) << finished.out;
  }
  /// What bash offers after these words, of which the last is being typed.
  std::string offered(const std::vector<std::string>& words) const {
    std::string list;
    for (const std::string& word : words) list += " " + shell_word(word);
    const std::string command =
        "cd " + shell_word(folder_.path().string()) + " && bash -c " +
        shell_word(". ./bash && COMP_WORDS=(regulus" + list + ") COMP_CWORD=" + std::to_string(words.size()) +
                   " && _regulus && printf '%s\n' \"${COMPREPLY[@]}\" >offered");
    EXPECT_EQ(shell(command), 0);
    return text_of(file("offered"));
  }
  TemporaryFolder folder_;
};

TEST_F(Shells, KnowEveryOptionOfTheHelp) {
  const auto all = everything();
  ASSERT_GE(all.size(), 12u);
  ASSERT_EQ(run({"man", file("man")}).status, 0);
  for (const char* shell : {"bash", "zsh", "fish"}) write_completion(shell);
  const std::string zsh = text_of(file("zsh")), fish = text_of(file("fish"));
  size_t count = 0;
  for (const auto& [command, options] : all) {
    std::string page = "regulus", words;
    for (const std::string& word : command) {
      page += "-" + word;
      words += (words.empty() ? "" : " ") + word;
    }
    const std::string manual = text_of(file("man/" + page + ".1"));
    EXPECT_NE(manual, "") << page;
    std::vector<std::string> typed = command;
    typed.emplace_back("--");
    const std::string bash = "\n" + offered(typed);
    EXPECT_GE(options.size(), 1u) << words;
    for (const std::string& option : options) {
      std::string name = "\\-\\-" + with_escaped_hyphens(option);
      EXPECT_NE(manual.find("\\fB" + name + "\\fR"), std::string::npos) << words << " --" << option;
      EXPECT_NE(bash.find("\n--" + option + "\n"), std::string::npos) << words << " --" << option;
      EXPECT_TRUE(zsh.find("--" + option + "[") != std::string::npos ||
                  zsh.find("--" + option + "=[") != std::string::npos)
          << words << " --" << option;
      EXPECT_NE(fish.find(" -l " + option + " "), std::string::npos) << words << " --" << option;
      ++count;
    }
  }
  std::printf("%zu options of %zu commands\n", count, all.size());
}

TEST_F(Shells, TakeTheirFiles) {
  for (const char* name : {"bash", "zsh", "fish"}) {
    write_completion(name);
    if (shell(std::string("command -v ") + name + " >/dev/null") != 0) {
      std::printf("no %s here\n", name);
      continue;
    }
    EXPECT_EQ(shell(std::string(name) + " -n " + shell_word(file(name)) + " 2>" + shell_word(file("err"))),
              0);
    EXPECT_EQ(text_of(file("err")), "") << name;
  }
}

TEST_F(Shells, OfferWhatFits) {
  write_completion("bash");
  std::ofstream(file("a scene.gltf"));
  EXPECT_EQ(offered({"rend"}), "render\n");
  EXPECT_EQ(offered({"render", "--rays", "ho"}), "host\n");
  EXPECT_EQ(offered({"render", "--rays", "=", "h"}), "hardware\nhost\n");
  EXPECT_EQ(offered({"render", "--rays", "="}), "auto\nhardware\nsoftware\nhost\n");
  EXPECT_EQ(offered({"render", "a"}), "a scene.gltf\n");
  EXPECT_EQ(offered({"render", "x.gltf", "--output", "a"}), "a scene.gltf\n");
  EXPECT_EQ(offered({"render", "--spp", ""}), "\n");
  EXPECT_EQ(offered({"bench", "ker"}), "kernels\n");
  EXPECT_EQ(offered({"merge", "--fo"}), "--force\n");
  EXPECT_EQ(offered({"devices", "--fo"}), "\n");
}

TEST_F(Shells, WhatNoShellIsCalledIsRefused) {
  expect_error(run({"completion", "bsh"}), 2, {"bsh", "did you mean bash"});
  expect_error(run({"completion"}), 2, {"SHELL"});
}

class Doctor : public Shells {
 protected:
  Finished doctor(const Environment& more) const {
    Environment environment = {{"XDG_CACHE_HOME", file("cache")}};
    for (const auto& [name, value] : more) environment[name] = value;
    return run({"doctor"}, environment);
  }
  /// A driver's manifest whose library is not there.
  std::string missing_driver() const {
    std::ofstream(file("lost.json"))
        << R"({"file_format_version": "1.0.0", "ICD": {"library_path": "./nowhere.so", "api_version": "1.3.0"}})";
    return file("lost.json");
  }
};

TEST_F(Doctor, SaysWhatWouldMendAMissingDriver) {
  const Finished lost = doctor({{"VK_DRIVER_FILES", missing_driver()}});
  EXPECT_EQ(lost.status, 4) << lost.err;
  EXPECT_EQ(count_lines(lost.err), 1u) << lost.err;
  for (const char* part :
       {"nowhere.so, which is not there", "mesa-vulkan-drivers", "mend: ", "VK_DRIVER_FILES="})
    EXPECT_NE(lost.out.find(part), std::string::npos) << part << " in\n" << lost.out;
  std::ofstream(file("text.json")) << "[1, 2";
  EXPECT_NE(doctor({{"VK_DRIVER_FILES", file("text.json")}}).out.find("is no manifest"), std::string::npos);
  const Finished none = doctor({{"VK_DRIVER_FILES", file("none.json")}});
  EXPECT_EQ(none.status, 4);
  EXPECT_NE(none.out.find("unset VK_DRIVER_FILES"), std::string::npos) << none.out;
}

TEST_F(Doctor, SaysWhatIsWrongWithTheCache) {
  std::ofstream(file("plain")) << "a file where a folder should be";
  const Finished blocked = doctor({{"XDG_CACHE_HOME", file("plain")}});
  EXPECT_NE(blocked.status, 0);
  EXPECT_NE(blocked.out.find("cannot be written"), std::string::npos) << blocked.out;
  const Finished nowhere = doctor({{"XDG_CACHE_HOME", ""}, {"HOME", ""}});
  EXPECT_NE(nowhere.out.find("set HOME or XDG_CACHE_HOME"), std::string::npos) << nowhere.out;
  EXPECT_NE(doctor({{"XDG_CACHE_HOME", "relative"}}).out.find("give the whole path"), std::string::npos);
  EXPECT_FALSE(fs::exists(file("cache"))) << "looking makes no folder";
}

// Whatever a variable holds is shown so that no terminal obeys it, and ends nothing.
TEST_F(Doctor, SurvivesHostileVariables) {
  const std::string hostile = "\x1b]0;owned\x07\n\xff" + std::string(100'000, 'x') + ":::%s%n";
  const Finished finished = doctor({{"VK_DRIVER_FILES", hostile},
                                    {"VK_ADD_DRIVER_FILES", hostile},
                                    {"XDG_CACHE_HOME", "/dev/null/" + hostile},
                                    {"XDG_DATA_DIRS", hostile},
                                    {"TMPDIR", hostile},
                                    {"LP_DEBUG", hostile}});
  EXPECT_EQ(finished.signal, 0);
  EXPECT_EQ(finished.status, 4) << finished.err;
  EXPECT_EQ((finished.out + finished.err).find('\x1b'), std::string::npos);
  EXPECT_EQ((finished.out + finished.err).find('\xff'), std::string::npos);
  EXPECT_LT(finished.out.size(), 20'000u);
  EXPECT_NE(finished.out.find("TMPDIR="), std::string::npos);
}

}  // namespace
}  // namespace regulus::test
