#include "cli/bench_options.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <sstream>
#include <vector>

#include "base/error.hpp"
#include "cli/render_options.hpp"
#include "render/plan.hpp"

namespace regulus::cli {
namespace {

// Reads the options of `render` from a string, as if given on the command line of `command`.
void parse_render_options(const std::string& text, const std::string& scene_file, CLI::App& command,
                          RenderOptions& options) {
  declare_render_options(command, options);
  std::vector<std::string> words{scene_file};
  std::istringstream stream(text);
  for (std::string word; stream >> word;) words.push_back(word);
  std::reverse(words.begin(), words.end());
  try {
    command.parse(words);
  } catch (const CLI::ParseError& error) {
    throw Error(ErrorCode::BadUsage, fmt::format("options \"{}\": {}", text, error.what()));
  }
  require_no_outputs(options, fmt::format("options \"{}\": a benchmark", text));
}

}  // namespace

ResolvedOptions resolve_render_options(const std::string& text, const std::string& size,
                                       const PreparedScene& prepared) {
  const scene::Scene& scene = prepared.scene;
  RenderOptions options;
  CLI::App command;
  parse_render_options(text, scene.path.string(), command, options);
  apply_scene_settings(command, scene);
  options.size = size;
  render::RenderSettings settings = resolve_settings(options, scene);
  for (const std::string& warning : make_plan(prepared, settings).warnings)
    spdlog::warn("{}: {}", scene.path.string(), warning);
  return {std::move(settings), options.exposure_ev};
}

void require_render_options(const std::string& text, const std::string& scene_file) {
  RenderOptions ignored;
  CLI::App command;
  parse_render_options(text, scene_file, command, ignored);
}

}  // namespace regulus::cli
