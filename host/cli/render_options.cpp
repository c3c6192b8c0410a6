#include "cli/render_options.hpp"

#include <fmt/format.h>

#include <map>
#include <set>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "base/printable.hpp"

namespace regulus::cli {

namespace {

// Options that say where things go or come from: not a scene's business.
const std::set<std::string> COMMAND_LINE_ONLY = {"output",
                                                 "png",
                                                 "stats",
                                                 "report",
                                                 "display-server",
                                                 "strategy-images",
                                                 "denoise",
                                                 "denoiser",
                                                 "oidn",
                                                 "ocio",
                                                 "ocio-display",
                                                 "ocio-view",
                                                 "half",
                                                 "dwaa",
                                                 "define",
                                                 "device",
                                                 "split",
                                                 "scene",
                                                 "allow-external",
                                                 "strict",
                                                 "memory",
                                                 "quiet",
                                                 "progress",
                                                 "verbose",
                                                 "help",
                                                 "wave",
                                                 "rays",
                                                 "backend",
                                                 "env",
                                                 "variant",
                                                 "animation",
                                                 "at",
                                                 "env-rotation",
                                                 "env-scale",
                                                 "samples",
                                                 "checkpoint",
                                                 "checkpoint-seconds",
                                                 "resume"};

std::vector<std::string> scene_setting_names(const CLI::App& command) {
  std::vector<std::string> names = {"environment", "variant", "animation", "at"};
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames())
      if (!COMMAND_LINE_ONLY.contains(name)) names.push_back(name);
  return names;
}

}  // namespace

scene::LoadOptions load_options(const RenderOptions& options) {
  return {.scene = options.scene_index,
          .allow_external = options.allow_external,
          .is_strict = options.is_strict,
          .environment = {options.environment, options.environment_rotation, options.environment_scale},
          .variant = options.variant,
          .memory_bytes = options.memory_bytes,
          .animation = options.animation,
          .time = options.time,
          .edits = options.edits};
}

image::Encoding encoding(const RenderOptions& options) {
  image::Encoding encoding(options.exposure_ev);
  encoding.view = image::view_of(options.view);
  encoding.transform = options.color_transform;
  encoding.storage = options.storage;
  return encoding;
}

std::vector<std::string> apply_scene_settings(CLI::App& command, const scene::Scene& scene) {
  std::vector<std::string> warnings;
  for (const auto& [name, value] : scene.settings) {
    CLI::Option* option = command.get_option_no_throw("--" + name);
    if (option == nullptr || COMMAND_LINE_ONLY.contains(name)) {
      warnings.push_back(
          printable(fmt::format("extras.regulus: \"{}\" is not a setting of a scene; ignored{}", name,
                                suggest(name, scene_setting_names(command)))));
    } else if (option->count() == 0) {
      try {
        option->add_result(value);
        option->run_callback();
      } catch (const CLI::ParseError& error) {
        throw Error(ErrorCode::BadFile,
                    fmt::format("{}: extras.regulus.{}: {}", scene.path.string(), name, error.what()));
      }
    }
  }
  return warnings;
}

void require_no_outputs(const RenderOptions& options, const std::string& who) {
  const std::pair<const char*, const std::string&> outputs[] = {
      {"--output", options.output},         {"--png", options.png},
      {"--stats", options.stats},           {"--report", options.report},
      {"--checkpoint", options.checkpoint}, {"--strategy-images", options.strategy_images}};
  for (const auto& [option, file] : outputs)
    if (!file.empty())
      throw Error(ErrorCode::BadUsage, fmt::format("{} writes no files; leave out {}", who, option));
  if (options.is_denoised)
    throw Error(ErrorCode::BadUsage, fmt::format("{} writes no picture; leave out --denoise", who));
  if (!options.split.empty())
    throw Error(ErrorCode::BadUsage, fmt::format("{} uses one device; leave out --split", who));
}

void lift_sample_limit(const CLI::App& command, RenderOptions& options) {
  if ((options.time_limit || options.noise_target) && command.get_option("--spp")->count() == 0 &&
      options.sample_range.empty())
    options.has_no_sample_limit = true;
}

}  // namespace regulus::cli
