// The options of `render` and the settings of the library are the same, and take the same values.

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <set>

#include "cli/render_options.hpp"

namespace regulus::cli {
namespace {

// What is no setting of a render: where it reads and writes, where it runs, what it prints.
const std::set<std::string> NO_SETTINGS = {"scene-file",
                                           "help",
                                           "output",
                                           "png",
                                           "exposure",
                                           "strategy-images",
                                           "stats",
                                           "report",
                                           "display-server",
                                           "checkpoint",
                                           "resume",
                                           "scene",
                                           "allow-external",
                                           "checkpoint-seconds",
                                           "strict",
                                           "memory",
                                           "quiet",
                                           "progress",
                                           "verbose",
                                           "define",
                                           "denoise",
                                           "denoiser",
                                           "oidn",
                                           "view",
                                           "ocio",
                                           "ocio-display",
                                           "ocio-view",
                                           "half",
                                           "dwaa",
                                           "device",
                                           "split",
                                           "backend",
                                           "variant",
                                           "animation",
                                           "at",
                                           "frames",
                                           "fps",
                                           "env",
                                           "env-rotation",
                                           "env-scale"};

constexpr const char* VALUES[] = {
    "-1",      "0",     "0.25", "1",   "0.5001", "3",      "17",   "1024", "1025",     "1e30",       "nan",
    "inf",     "none",  "on",   "off", "smooth", "both",   "peak", "ggx",  "sobol",    "box",        "smith",
    "uniform", "fixed", "vcm",  "abc", "3x",     "1000.5", "16.5", "",     "16777217", "4294967296", "1e-50"};

std::vector<std::string> setting_options() {
  CLI::App command;
  RenderOptions options;
  declare_render_options(command, options);
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames())
      if (!NO_SETTINGS.contains(name)) names.push_back(name);
  std::ranges::sort(names);
  return names;
}

TEST(Settings, AreTheOptionsOfRender) {
  std::vector<std::string> known;
  for (const session::Setting& setting : session::known_settings()) known.emplace_back(setting.name);
  std::ranges::sort(known);
  EXPECT_EQ(known, setting_options());
}

bool option_takes(const std::string& name, const std::string& value) {
  CLI::App command;
  RenderOptions options;
  declare_render_options(command, options);
  try {
    std::vector<std::string> words = {"--" + name + "=" + value, "scene.gltf"};
    command.parse(words);
    return !value.empty();  // cli/arguments.hpp refuses empty values of all options
  } catch (const CLI::ParseError&) {
    return false;
  }
}

bool setting_takes(const std::string& name, const std::string& value) {
  session::Request request;
  return !session::find_setting(name).take(request, value);
}

TEST(Settings, TakeTheValuesThatTheOptionsTake) {
  for (const std::string& name : setting_options()) {
    if (name == "energy-compensation") continue;  // a flag
    for (const char* value : VALUES)
      EXPECT_EQ(setting_takes(name, value), option_takes(name, value)) << name << " " << value;
  }
}

}  // namespace
}  // namespace regulus::cli
