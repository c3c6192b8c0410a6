// regulus check: the device against the scalar reference on a scene.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include "base/error.hpp"
#include "check/check.hpp"
#include "check/reference_render.hpp"
#include "cli/commands.hpp"
#include "cli/render_options.hpp"
#include "cli/standard_streams.hpp"
#include "cli/validators.hpp"
#include "reference/merge_radius.hpp"

namespace regulus::cli {

namespace {

using namespace interface;
using render::WALK_TECHNIQUES;

// Without --size: as many paths as a stage needs for its 99.9th percentile to mean something.
constexpr const char* DEFAULT_SIZE = "96x64";
constexpr uint32_t CHECKED_ITERATIONS[] = {0, 1, 1000};
constexpr uint32_t MOST_ITERATIONS = 10'000;  // of a scene where little can be weighed

constexpr const char* BLENDED =
    "whole paths, connections and images are not compared: what a ray does at a blended surface hangs on its "
    "bits";

struct CheckOptions {
  RenderOptions render;
  std::string path;         ///< x,y,sample; empty: check everything
  uint64_t weights = 0;     ///< how many to compare; 0: check everything
  uint32_t statistics = 0;  ///< batches of images to compare; 0: check everything
  std::string against;      ///< with statistics: a technique set; empty: the reference
  double tolerance = 1e-5;  ///< with statistics, relative
};

struct PathName {
  uint32_t x, y, sample;
};

PathName parse_path(const std::string& text, const render::RenderSettings& settings) {
  PathName name{};
  const char* at = text.data();
  const char* end = text.data() + text.size();
  for (uint32_t* number : {&name.x, &name.y, &name.sample}) {
    const auto [after, error] = std::from_chars(at, end, *number);
    const bool is_last = number == &name.sample;
    if (error != std::errc{} || (is_last ? after != end : after == end || *after != ','))
      throw Error(ExitStatus::BadUsage, fmt::format("--path {}: expected x,y,sample, such as 10,20,0", text));
    at = is_last ? after : after + 1;
  }
  if (name.x >= settings.width || name.y >= settings.height)
    throw Error(ExitStatus::BadUsage,
                fmt::format("--path {}: the film has {}x{} pixels", text, settings.width, settings.height));
  return name;
}

/// Prints a line and returns whether it passed.
bool report(const check::Tally& tally) {
  say("{}\n", tally.line());
  flush_stdout();
  return tally.is_passed();
}

/// Iterations with connections to the cache, merges and splats, until `weights` weights have been compared;
/// 0: the first two and a late one, where radius and roughness have shrunk.
bool check_sorted_and_connected(gpu::Device& device, const check::Subject& subject, uint64_t weights) {
  constexpr uint32_t BOTH = TECHNIQUE_CONNECT | TECHNIQUE_MERGE;
  render::RenderSettings asked = subject.plan.asked;
  asked.techniques = WALK_TECHNIQUES | BOTH;
  if (asked.cache_connections == 0) asked.cache_connections = 3;
  // So wide that every vertex has some light paths to merge with, few as they are.
  const double extent = render::seen_by_camera(subject.prepared, asked.camera).extent;
  asked.merge_radius = std::max(render::choose_merge_radius(subject.prepared, asked).metres,
                                static_cast<float>(0.05 * extent));
  asked.keeps_merge_radius = true;
  const render::Plan plan = plan_recording(subject.prepared, asked, asked.techniques);
  if ((plan.techniques & BOTH) != BOTH) return true;  // nothing in the scene can be connected
  render::StageRecorder recorder(device, subject.prepared, plan, plan.width * plan.height);
  const reference::Settings wanted = check::reference_settings(plan);
  const check::Subject same{subject.prepared, subject.world, subject.camera, plan, wanted};
  std::vector<check::Tally> sorting, connections;
  const auto add = [](std::vector<check::Tally>& all, const std::vector<check::Tally>& more) {
    for (size_t i = 0; i < more.size(); ++i) i < all.size() ? all[i].add(more[i]) : all.push_back(more[i]);
  };
  const auto compared = [&] {
    const auto line = std::find_if(connections.begin(), connections.end(),
                                   [](const check::Tally& tally) { return tally.name() == check::WEIGHTS; });
    return line == connections.end() ? 0 : line->items();
  };
  const uint32_t first = subject.plan.first_sample;
  const auto is_enough = [&](uint32_t done) {
    return weights == 0 ? done == std::size(CHECKED_ITERATIONS) : done > 0 && compared() >= weights;
  };
  for (uint32_t i = 0; i < MOST_ITERATIONS && !is_enough(i); ++i) {
    const uint32_t sample = first + (weights == 0 ? CHECKED_ITERATIONS[i] : i);
    render::ConnectionRecording recording = recorder.record_light_vertices(sample);
    add(sorting, check_sorting(same, recording));
    // Lists that are broken lead the other stages astray.
    if (!std::all_of(sorting.begin(), sorting.end(), [](const auto& tally) { return tally.is_passed(); }))
      break;
    recorder.record_connections(sample, recording);
    add(connections, check_connections(same, sample, recording));
  }
  bool is_passed = true;
  for (const std::vector<check::Tally>* tallies : {&sorting, &connections})
    for (const check::Tally& tally : *tallies) is_passed = report(tally) && is_passed;
  return is_passed;
}

bool check_everything(gpu::Device& device, const check::Subject& subject) {
  const uint32_t pixels = subject.plan.width * subject.plan.height;
  say("{}\n", check::Tally::header());
  bool is_passed = true;
  const bool is_blended = has_blended_surfaces(subject.prepared.scene);
  {
    render::RenderSettings asked = subject.plan.asked;
    asked.techniques = WALK_TECHNIQUES;
    const render::Plan plan = plan_recording(subject.prepared, asked);
    render::StageRecorder recorder(device, subject.prepared, plan, pixels);
    const reference::Settings walking = check::reference_settings(plan);
    const check::Subject same{subject.prepared, subject.world, subject.camera, plan, walking};
    const render::Recording camera = recorder.record(render::Pass::Camera, 0, subject.plan.first_sample);
    for (const check::Tally& tally : check_stages(same, render::Pass::Camera, camera))
      is_passed = report(tally) && is_passed;
    if (!is_blended)
      for (const check::Tally& tally : check_paths(same, camera)) is_passed = report(tally) && is_passed;
    if ((walking.techniques & TECHNIQUE_SPLAT) != 0) {
      const render::Recording light = recorder.record(render::Pass::Light, 0, subject.plan.first_sample);
      for (const check::Tally& tally : check_stages(same, render::Pass::Light, light))
        is_passed = report(tally) && is_passed;
    }
  }
  if (is_blended) {
    say("{}\n", BLENDED);
    return is_passed;
  }
  // Images would repeat it at best; lists that are broken may crash the driver.
  if (!check_sorted_and_connected(device, subject, 0)) return false;
  for (const auto& [name, techniques] :
       {std::pair<const char*, uint32_t>{"pt", TECHNIQUE_HIT | TECHNIQUE_NEE},
        {"lt", TECHNIQUE_SPLAT},
        {"bpt", WALK_TECHNIQUES | TECHNIQUE_CONNECT},
        {"bpm", TECHNIQUE_HIT | TECHNIQUE_NEE | TECHNIQUE_MERGE},
        {"vcm", WALK_TECHNIQUES | TECHNIQUE_CONNECT | TECHNIQUE_MERGE}})
    is_passed = report(check_image(device, subject, name, techniques)) && is_passed;
  return is_passed;
}

bool check_images(gpu::Device& device, const check::Subject& subject, const CheckOptions& options) {
  std::optional<uint32_t> other;
  if (!options.against.empty()) other = parse_technique_set(options.against);
  say("{} seeds of {} samples, {}x{} pixels, the device against {}\n", options.statistics,
      subject.plan.samples, subject.plan.width, subject.plan.height,
      other ? options.against : "the reference");
  bool is_passed = true;
  for (const check::ImageTest& test :
       check_statistics(device, subject, options.statistics, other, options.tolerance)) {
    say("{}\n", test.line);
    is_passed = test.is_passed && is_passed;
  }
  return is_passed;
}

void run_check(CLI::App& command, CheckOptions& options) {
  require_no_outputs(options.render, "check");
  if (options.render.size.empty() && options.path.empty()) options.render.size = DEFAULT_SIZE;
  // Sets of techniques have the same mean only where nothing is raised: each has a bias of its own.
  if (!options.against.empty() && command.count("--regularization") == 0)
    options.render.regularization = REGULARIZATION_NONE;
  scene::Scene loaded = scene::load(options.render.scene_file, load_options(options.render));
  apply_scene_settings(command, loaded);
  render::RenderSettings settings = resolve_settings(options.render, loaded);
  if (options.statistics == 0 &&
      (settings.crop.pixels() != 0 || std::isfinite(settings.largest_contribution)))
    throw Error(ExitStatus::BadUsage, "check has --crop and --clamp only with --statistics");
  if (!options.render.frames.empty())
    throw Error(ExitStatus::BadUsage, "check has no --frames; give the time of one with --at");
  const PreparedScene prepared = prepare(std::move(loaded));
  const scene::Scene& scene = prepared.scene;
  // One choice for all sets of techniques: what a render by these settings would do.
  if (!settings.regularization) settings.regularization = make_plan(prepared, settings).regularization;
  const render::Plan plan = make_plan(prepared, settings);
  for (const std::string& warning : plan.warnings) spdlog::warn("{}: {}", scene.path.string(), warning);
  gpu::Device device({.select = options.render.device,
                      .software_stage_times = false,
                      .memory_bytes = options.render.memory_bytes});
  say("{} on {} ({})\n", scene.path.string(), device.info().name, device.info().driver);

  const reference::World world(prepared, settings.ndf, settings.shadowing, settings.light_sampling,
                               settings.has_energy_compensation);
  const reference::Camera camera(
      scene::make_camera(scene.cameras.at(settings.camera), settings.width, settings.height), settings.width,
      settings.height);
  const reference::Settings wanted = check::reference_settings(plan);
  const check::Subject subject{prepared, world, camera, plan, wanted};
  if (options.weights > 0 && has_blended_surfaces(scene))
    throw Error(ExitStatus::BadUsage, fmt::format("{}: {}", scene.path.string(), BLENDED));
  if (options.path.empty()) {
    if (options.weights > 0) say("{}\n", check::Tally::header());
    const bool is_passed = options.statistics > 0 ? check_images(device, subject, options)
                           : options.weights > 0
                               ? check_sorted_and_connected(device, subject, options.weights)
                               : check_everything(device, subject);
    if (!is_passed)
      throw Error(ExitStatus::Failed,
                  fmt::format("{}: device and reference differ, see above", scene.path.string()));
    return;
  }
  const PathName path = parse_path(options.path, settings);
  const uint32_t pixel = path.y * settings.width + path.x;
  render::StageRecorder recorder(device, prepared, plan_recording(prepared, settings), 1);
  const render::Recording recording = recorder.record(render::Pass::Camera, pixel, path.sample);
  say("{}", describe_path(subject, pixel, path.sample, recording));
}

}  // namespace

void add_check_command(CLI::App& app) {
  const auto options = std::make_shared<CheckOptions>();
  CLI::App* command = app.add_subcommand(
      "check", "Hold every stage of the device against the scalar reference, on data of a scene");
  declare_render_options(*command, options->render);
  command->option_defaults()->group("Check");
  command->add_option("--path", options->path, "Print one camera path from both in full")
      ->type_name("x,y,sample");
  command
      ->add_option("--weights", options->weights,
                   "Only connections, merges and splats, until so many weights have been compared")
      ->type_name("N");
  command
      ->add_option("--statistics", options->statistics,
                   "Only images: test by pixels, over so many independent seeds, that device and reference "
                   "have the same mean")
      ->type_name("SEEDS")
      ->check(whole_number_in(2, 1000));
  command
      ->add_option("--against", options->against,
                   "With --statistics: not the reference, but the device with another integrator or list "
                   "of techniques")
      ->type_name("TECHNIQUES");
  command
      ->add_option("--tolerance", options->tolerance,
                   "With --statistics: relative difference that is not counted, such as the blur of merges")
      ->type_name("DIFFERENCE")
      ->check(not_negative());
  command->callback([command, options] { run_check(*command, *options); });
}

}  // namespace regulus::cli
