#include "cli/render_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>
#include <sstream>

#include "base/error.hpp"
#include "base/near_names.hpp"
#include "base/printable.hpp"
#include "cli/strategy_images.hpp"
#include "cli/validators.hpp"
#include "render/aov.hpp"

namespace regulus::cli {

namespace {

using namespace interface;
namespace names = render::names;

// Film sizes beyond this are refused: 2^31 pixels would overflow path indices.
constexpr uint32_t MAX_SIDE = 32768;

// Options that say where things go or come from: not a scene's business.
const std::set<std::string> COMMAND_LINE_ONLY = {"output",
                                                 "png",
                                                 "stats",
                                                 "strategy-images",
                                                 "device",
                                                 "scene",
                                                 "allow-external",
                                                 "strict",
                                                 "memory",
                                                 "quiet",
                                                 "verbose",
                                                 "help",
                                                 "wave",
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

glm::uvec2 parse_size(const std::string& text) {
  glm::uvec2 size{0};
  const size_t x = text.find('x');
  const auto parse = [](std::string_view part, uint32_t& value) {
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    return error == std::errc{} && end == part.data() + part.size() && value >= 1 && value <= MAX_SIDE;
  };
  if (x == std::string::npos || !parse(std::string_view(text).substr(0, x), size.x) ||
      !parse(std::string_view(text).substr(x + 1), size.y))
    throw Error(ExitStatus::BadUsage,
                fmt::format("--size {}: expected WIDTHxHEIGHT with sides from 1 to {}, such as 1280x720",
                            text, MAX_SIDE));
  return size;
}

/// `count` whole numbers with `separator` between them; none if the text is anything else.
std::vector<uint32_t> parse_numbers(const std::string& text, char separator, size_t count) {
  std::vector<uint32_t> numbers;
  const char* at = text.data();
  const char* const end = at + text.size();
  while (numbers.size() < count) {
    uint32_t number = 0;
    const auto [after, error] = std::from_chars(at, end, number);
    numbers.push_back(number);
    const bool is_last = numbers.size() == count;
    if (error != std::errc{} || (is_last ? after != end : after == end || *after != separator)) return {};
    at = after + 1;
  }
  return numbers;
}

void parse_sample_range(const std::string& text, render::RenderSettings& settings) {
  const std::vector<uint32_t> range = parse_numbers(text, ':', 2);
  if (range.empty() || range[1] == 0 || uint64_t{range[0]} + range[1] > MAX_SAMPLES)
    throw Error(ExitStatus::BadUsage,
                fmt::format("--samples {}: expected FIRST:COUNT, such as 64:32, of samples below {}", text,
                            MAX_SAMPLES));
  settings.first_sample = range[0];
  settings.samples = range[1];
}

uint32_t find_camera(const std::string& wanted, const scene::Scene& scene) {
  constexpr size_t MOST_LISTED = 20;
  std::string list;
  std::vector<std::string> names;
  for (uint32_t i = 0; i < scene.cameras.size(); ++i) {
    if (wanted == scene.cameras[i].name || wanted == std::to_string(i)) return i;
    names.push_back(scene.cameras[i].name);
    if (i < MOST_LISTED) list += fmt::format("{}{} \"{}\"", i == 0 ? "" : ", ", i, names.back());
  }
  if (names.size() > MOST_LISTED) list += fmt::format(" and {} more", names.size() - MOST_LISTED);
  throw Error(ExitStatus::BadUsage, fmt::format("--camera {}: {} has {}{}", wanted, scene.path.string(), list,
                                                suggest(wanted, names)));
}

uint32_t parse_techniques(const std::string& list) {
  uint32_t techniques = 0;
  std::istringstream stream(list);
  for (std::string name; std::getline(stream, name, ',');) {
    const render::Name* found = find_name(names::TECHNIQUES, name);
    if (found == nullptr)
      throw Error(ExitStatus::BadUsage,
                  fmt::format("--techniques {}: {}", list, unknown_name(name, names_of(names::TECHNIQUES))));
    techniques |= found->value;
  }
  if (techniques == 0) throw Error(ExitStatus::BadUsage, "--techniques: the list is empty");
  return techniques;
}

uint32_t parse_connections(const std::string& text) {
  constexpr std::string_view CACHE = "cache:";
  if (text == "paired") return 0;
  uint32_t count = 0;
  if (text.starts_with(CACHE)) {
    const auto [end, error] = std::from_chars(text.data() + CACHE.size(), text.data() + text.size(), count);
    if (error == std::errc{} && end == text.data() + text.size() && count >= 1 && count <= 1024) return count;
  }
  throw Error(ExitStatus::BadUsage,
              fmt::format("--connections {}: expected paired or cache:M with M from 1 to 1024", text));
}

void parse_merge_radius(const std::string& text, render::RenderSettings& settings) {
  float value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const std::string_view unit(end, static_cast<size_t>(text.data() + text.size() - end));
  if (error != std::errc{} || !(unit.empty() || unit == "%") || !std::isfinite(value) || !(value > 0))
    throw Error(ExitStatus::BadUsage,
                fmt::format("--merge-radius {}: expected metres, such as 0.01, or percent of the extent "
                            "seen, such as 0.3%",
                            text));
  if (unit == "%")
    settings.merge_radius_share = 0.01f * value;
  else
    settings.merge_radius = value;
}

}  // namespace

render::Window parse_window(const char* option, const std::string& text, const glm::uvec2& size) {
  const std::vector<uint32_t> edges = parse_numbers(text, ',', 4);
  if (edges.empty() || edges[0] >= edges[2] || edges[1] >= edges[3] || edges[2] > size.x || edges[3] > size.y)
    throw Error(ExitStatus::BadUsage,
                fmt::format("{} {}: expected x0,y0,x1,y1 with 0 <= x0 < x1 <= {} and 0 <= y0 < y1 <= {}, in "
                            "pixels from the top left, x1 and y1 excluded",
                            option, text, size.x, size.y));
  return {edges[0], edges[1], edges[2] - edges[0], edges[3] - edges[1]};
}

scene::LoadOptions load_options(const RenderOptions& options) {
  return {.scene = options.scene_index,
          .allow_external = options.allow_external,
          .is_strict = options.is_strict,
          .environment = {options.environment, options.environment_rotation, options.environment_scale},
          .variant = options.variant,
          .memory_bytes = options.memory_bytes,
          .animation = options.animation,
          .time = options.time};
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
        throw Error(ExitStatus::BadFile,
                    fmt::format("{}: extras.regulus.{}: {}", scene.path.string(), name, error.what()));
      }
    }
  }
  return warnings;
}

void require_no_outputs(const RenderOptions& options, const std::string& who) {
  const std::pair<const char*, const std::string&> outputs[] = {
      {"--output", options.output},
      {"--png", options.png},
      {"--stats", options.stats},
      {"--checkpoint", options.checkpoint},
      {"--strategy-images", options.strategy_images}};
  for (const auto& [option, file] : outputs)
    if (!file.empty())
      throw Error(ExitStatus::BadUsage, fmt::format("{} writes no files; leave out {}", who, option));
}

void lift_sample_limit(const CLI::App& command, RenderOptions& options) {
  if ((options.time_limit || options.noise_target) && command.get_option("--spp")->count() == 0 &&
      options.sample_range.empty())
    options.has_no_sample_limit = true;
}

uint32_t parse_technique_set(const std::string& text) {
  const render::Name* integrator = find_name(names::INTEGRATORS, text);
  return integrator != nullptr ? integrator->value : parse_techniques(text);
}

render::RenderSettings resolve_settings(const RenderOptions& options, const scene::Scene& scene) {
  render::RenderSettings settings = options.settings;
  if (options.has_no_sample_limit) settings.samples = MAX_SAMPLES;
  settings.has_strategy_images = !options.strategy_images.empty();
  settings.keeps_doublings = options.noise_target.has_value();
  settings.camera = options.camera.empty() ? 0 : find_camera(options.camera, scene);
  const glm::uvec2 size =
      options.size.empty() ? scene::default_film_size(scene, settings.camera) : parse_size(options.size);
  settings.width = size.x;
  settings.height = size.y;
  if (!options.crop.empty()) settings.crop = parse_window("--crop", options.crop, size);
  if (!options.sample_range.empty()) parse_sample_range(options.sample_range, settings);
  settings.aovs = render::parse_aovs(options.aovs);
  settings.techniques = options.techniques.empty() ? find_name(names::INTEGRATORS, options.integrator)->value
                                                   : parse_techniques(options.techniques);
  settings.regularization = options.regularization;
  settings.regularization_modes = options.tau_schedule | options.diffusion;
  settings.cache_connections = parse_connections(options.connections);
  if (!options.merge_radius.empty()) parse_merge_radius(options.merge_radius, settings);
  settings.filter_radius = options.filter_radius.value_or(settings.filter == FILTER_BOX ? 0.5f : 1.5f);
  settings.filter_sigma = settings.filter_radius / 3;
  return settings;
}

}  // namespace regulus::cli
