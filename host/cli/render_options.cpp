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
constexpr uint32_t MAX_SAMPLES = 1u << 24;

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

/// From how many lights on --light-sampling auto is the tree.
size_t many_lights() {
  size_t count = 1;
  while (scene::resolve_light_sampling(LIGHT_SAMPLING_AUTO, count) != LIGHT_SAMPLING_BVH) ++count;
  return count;
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

void add_memory_option(CLI::App& command, uint64_t& bytes) {
  command
      .add_option(
          "--memory", bytes,
          "Most that a scene may take of the host's memory, and of the device's: bytes, or as in 4G or 512M "
          "(default: three quarters of the machine's; of the device what is free)")
      ->transform(CLI::AsSizeValue(false))
      ->check(CLI::PositiveNumber);
}

void declare_render_options(CLI::App& command, RenderOptions& options) {
  render::RenderSettings& settings = options.settings;
  command.add_option("scene-file", options.scene_file, "The .gltf or .glb file to render")
      ->required()
      ->type_name("SCENE");
  command.add_option("-o,--output", options.output,
                     "Picture to write, in the format of its extension: .exr, tone-mapped .png or .jpg, .hdr "
                     "(default: the scene's name with .exr)");
  command.add_option("--png", options.png, "Also write a tone-mapped 8-bit PNG");
  command.add_option("--exposure", options.exposure_ev, "Exposure of PNG and JPEG, in stops")
      ->check(number_in(-100.0, 100.0));
  command
      .add_option("-i,--integrator", options.integrator, "A named set of techniques: pt, lt, bpt, bpm, vcm")
      ->check(one_of(names_of(names::INTEGRATORS)));
  command.add_option("--techniques", options.techniques,
                     "The techniques themselves, comma-separated: hit,nee,splat,connect,merge");
  command.add_option("--strategy-images", options.strategy_images, STRATEGY_IMAGES_HELP);
  command
      .add_option("--light-paths", settings.light_paths,
                  "Light paths per iteration, that is, per sample of every pixel (default: one per pixel)")
      ->check(CLI::Range(1u, 1u << 28));
  command
      .add_option("--light-sampling", settings.light_sampling,
                  fmt::format("How surfaces choose the light they sample: bvh (by what it can send there), "
                              "power, uniform, auto (bvh from {} lights on)",
                              many_lights()))
      ->transform(choice(names::LIGHT_SAMPLING))
      ->default_str("auto");
  command.add_option("--connections", options.connections,
                     "Light vertices a camera vertex connects to: paired (those of its own light path) or "
                     "cache:M (M drawn from all of the iteration)");
  command.add_option("--merge-radius", options.merge_radius,
                     "Merge radius of the first iteration in metres, or in percent of the extent seen, as in "
                     "0.3%; at most a tenth of it (default: a thousandth of the picture's height at the "
                     "surfaces seen)");
  command
      .add_option("--merge-reduction", settings.merge_reduction,
                  "The merge radius of iteration i is the first one's times i to minus this power")
      ->check(number_in(0.0, 0.5))
      ->capture_default_str();
  command
      .add_option(
          "--regularization", options.regularization,
          "How connections and merges see glossy and specular surfaces: none (as they are), roughness "
          "(with raised roughness), virtual-merge (by what they send into a small cone), both (with raised "
          "roughness, and as they are)")
      ->transform(choice(names::REGULARIZATION))
      ->default_str(options.regularization ? "none" : "roughness; with technique merge none");
  command
      .add_option(
          "--tau", settings.tau,
          "Largest density of a regularized lobe, in 1/sr: smaller blurs more (inf: no regularization)")
      ->check(positive_or_infinite())
      ->capture_default_str();
  command.add_option("--bound", settings.bound, "How roughness follows from tau: peak, smith, directional")
      ->transform(choice(names::BOUND))
      ->default_str("peak");
  command
      .add_option(
          "--tau-schedule", options.tau_schedule,
          "fixed, or consistent: less roughness with every iteration, so that the image converges to the "
          "truth")
      ->transform(choice(names::TAU_SCHEDULE))
      ->default_str("consistent");
  command
      .add_option("--diffusion", options.diffusion,
                  "on: what the camera sees directly or through sharp surfaces alone is not regularized; off")
      ->transform(choice(names::DIFFUSION))
      ->default_str("on");
  command
      .add_option("--sampler-quality", settings.sampler_quality,
                  "on: paths that some technique samples well are not regularized; smooth: with a soft "
                  "transition; off")
      ->transform(choice(names::SAMPLER_QUALITY))
      ->default_str("off");
  command
      .add_option(
          "--mis", settings.mis,
          "Weights of regularized techniques: blended, corrected (by sample values), unmodified (wrong; for "
          "comparison)")
      ->transform(choice(names::MIS))
      ->default_str("blended");
  command
      .add_option(
          "--clamp", settings.largest_contribution,
          "Largest value that one technique may add to a sample: fewer fireflies, lost light; for comparison")
      ->check(positive_or_infinite());
  command.add_option("-s,--spp", settings.samples, "Samples per pixel")
      ->check(CLI::Range(1u, MAX_SAMPLES))
      ->capture_default_str();
  command
      .add_option("--samples", options.sample_range,
                  "FIRST:COUNT: only these of the samples, with what `regulus merge` needs to join parts")
      ->excludes("--spp");
  command
      .add_option(
          "--time", options.time_limit,
          "Stop after this many seconds of rendering, but not before every pixel has a sample. Without "
          "--spp on the command line as many samples as the time allows")
      ->check(number_in(0.0, 1e9));
  command
      .add_option("--noise", options.noise_target,
                  "Stop when the estimated relative error of the picture (root of relmse) is this small, "
                  "after 16 samples at least. Without "
                  "--spp on the command line as many samples as that takes")
      ->check(number_in(0.0, 1e3));
  command.add_option("--size", options.size, "Film size WIDTHxHEIGHT (default: the scene's)");
  command.add_option("--crop", options.crop,
                     "x0,y0,x1,y1: only these pixels, from the top left, x1 and y1 excluded");
  command.add_option(
      "--aov", options.aovs,
      fmt::format("Extra channels, comma-separated: {}", fmt::join(render::known_aovs(), ", ")));
  command.add_option("--camera", options.camera, "Camera by name or index");
  command.add_option("--scene", options.scene_index, "Scene of the file by index (default: its own default)");
  command.add_option("--variant", options.variant,
                     "Material variant by name (default: the scene's, or none)");
  command.add_option("--animation", options.animation,
                     "Animation that poses the scene, by name or index (default: the scene's, or none)");
  command
      .add_option("--at", options.time,
                  "Time in seconds at which the animation, or else the first one, poses the scene")
      ->check(number_in(-1e9, 1e9));
  command
      .add_option(
          "--frames", options.frames,
          "FIRST:LAST: a picture of each of these frames, number / fps seconds into the animation, in "
          "files of their own: the frame's number, as in name.0007.exr, or in place of #s in the name")
      ->excludes("--at");
  command.add_option("--fps", options.frames_per_second, "Frames per second of --frames")
      ->check(number_in(1e-6, 1e6))
      ->capture_default_str();
  command.add_option(
      "--env", options.environment,
      "Environment light: a latitude-longitude map, OpenEXR or Radiance HDR (default: the scene's)");
  command
      .add_option("--env-rotation", options.environment_rotation,
                  "Turns the environment about +y by this many degrees, counterclockwise seen from above")
      ->check(number_in(-1e6, 1e6));
  command.add_option("--env-scale", options.environment_scale, "Factor on the environment's radiance")
      ->check(number_in(0.0, 1e12));
  command.add_option("--max-depth", settings.max_depth, "Longest path, in edges")
      ->check(CLI::Range(1u, 1024u))
      ->capture_default_str();
  command.add_option("--seed", settings.seed, "Seed of the random numbers")->capture_default_str();
  command
      .add_option("--sampler", settings.sampler,
                  "Random numbers: sobol (scrambled Sobol points), hash (independent)")
      ->transform(choice(names::SAMPLER))
      ->default_str("sobol");
  command.add_option("--ndf", settings.ndf, "Microfacet distribution: ggx, beckmann, cosine")
      ->transform(choice(names::NDF))
      ->default_str("ggx");
  command
      .add_option("--shadowing", settings.shadowing,
                  "Masking-shadowing: smith (height-correlated), smith-uncorrelated, v-cavity")
      ->transform(choice(names::SHADOWING))
      ->default_str("smith");
  command.add_flag("--energy-compensation", settings.has_energy_compensation,
                   "Rough metals, plastics and glass give back what single scattering between facets loses");
  command.add_option("--filter", settings.filter, "Pixel filter: blackman-harris, gaussian, box")
      ->transform(choice(names::FILTER))
      ->default_str("blackman-harris");
  command
      .add_option("--filter-radius", options.filter_radius,
                  "Radius of the filter in pixels (default: box 0.5, others 1.5)")
      ->check(number_in(0.0, 16.0));
  command.add_option("--device", options.device,
                     "Vulkan device by index or part of its name (see regulus devices)");
  command
      .add_option("--backend", options.backend,
                  "vulkan, or reference: the scalar double-precision reference, slow and without a device")
      ->check(one_of({"vulkan", "reference"}))
      ->capture_default_str();
  command.add_option("--wave", settings.wave_paths,
                     "Paths in flight (default: chosen for the device; never changes the image)");
  command.add_option(
      "--band", options.band_pixels,
      "Pixels rendered at once, in bands of rows (default: as the device's buffers hold; never "
      "changes the image)");
  command.add_option("--stats", options.stats, "JSON file with times, rays and memory");
  command.add_option("--checkpoint", options.checkpoint,
                     "File from which --resume can go on; itself an OpenEXR picture and a part for merge");
  command
      .add_option("--checkpoint-seconds", options.checkpoint_seconds,
                  "Seconds between two states of the checkpoint")
      ->check(number_in(0.0, 1e9))
      ->capture_default_str();
  command.add_flag("--resume", options.is_resumed, "Go on from the checkpoint if there is one")
      ->needs("--checkpoint");
  command.add_flag("--allow-external", options.allow_external,
                   "Let the scene refer to files outside its folder");
  command.add_flag("--strict", options.is_strict, STRICT_HELP);
  add_memory_option(command, options.memory_bytes);
  command.add_flag("-q,--quiet", options.is_quiet, "Print errors only");
  command.add_flag("-v,--verbose", options.is_verbose, "Print what is done and how long it takes");
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
