// regulus check: the device against the scalar reference on a scene.

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include "base/error.hpp"
#include "base/standard_streams.hpp"
#include "check/check.hpp"
#include "cli/commands.hpp"
#include "cli/render_options.hpp"
#include "cli/validators.hpp"
#include "session/check_run.hpp"

namespace regulus::cli {

namespace {

using namespace interface;

// Without --size: as many paths as a stage needs for its 99.9th percentile to mean something.
constexpr const char* DEFAULT_SIZE = "96x64";
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
      throw Error(ErrorCode::BadUsage, fmt::format("--path {}: expected x,y,sample, such as 10,20,0", text));
    at = is_last ? after : after + 1;
  }
  if (name.x >= settings.width || name.y >= settings.height)
    throw Error(ErrorCode::BadUsage,
                fmt::format("--path {}: the film has {}x{} pixels", text, settings.width, settings.height));
  return name;
}

void print_tally(const check::Tally& tally) {
  say("{}\n", tally.line());
  flush_stdout();
}

check::Agreement check_images(gpu::Device& device, const check::Subject& subject,
                              const CheckOptions& options) {
  std::optional<uint32_t> other;
  if (!options.against.empty()) other = session::parse_technique_set(options.against);
  if (other == 0u)
    throw Error(ErrorCode::BadUsage, "--against auto: name the set of techniques to compare with");
  say("{} seeds of {} samples, {}x{} pixels, the device against {}\n", options.statistics,
      subject.plan.samples, subject.plan.width, subject.plan.height,
      other ? options.against : "the reference");
  check::Agreement all = check::Agreement::Agree;
  for (const check::ImageTest& test :
       check_statistics(device, subject, options.statistics, other, options.tolerance)) {
    say("{}\n", test.line);
    all = std::max(all, test.agreement);
  }
  say("verdict: {}\n", all == check::Agreement::Agree       ? "agree"
                       : all == check::Agreement::Undecided ? "undecided"
                                                            : "DIFFER");
  return all;
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
  if (command.count("--rays") == 0) settings.rays = RAYS_SOFTWARE;  // it is the kernels that are checked
  if (options.statistics == 0 &&
      (settings.crop.pixels() != 0 || std::isfinite(settings.largest_contribution)))
    throw Error(ErrorCode::BadUsage, "check has --crop and --clamp only with --statistics");
  if (!options.render.frames.empty())
    throw Error(ErrorCode::BadUsage, "check has no --frames; give the time of one with --at");
  const PreparedScene prepared = prepare(std::move(loaded));
  const scene::Scene& scene = prepared.scene;
  settings = session::one_choice(prepared, settings);
  const render::Plan plan = make_plan(prepared, settings);
  for (const std::string& warning : plan.warnings) spdlog::warn("{}: {}", scene.path.string(), warning);
  if (options.statistics > 0 && options.statistics < check::fewest_batches(plan))
    throw Error(
        ErrorCode::BadUsage,
        fmt::format(
            "--statistics {}: of so few seeds no pixel's difference can be told from noise; give {} or more",
            options.statistics, check::fewest_batches(plan)));
  gpu::Device device({.select = options.render.device,
                      .software_stage_times = false,
                      .memory_bytes = options.render.memory_bytes});
  say("{} on {} ({})\n", scene.path.string(), device.info().name, device.info().driver);

  const session::CheckedPlan checked(prepared, plan);
  const check::Subject& subject = checked.subject();
  if (options.weights > 0 && has_blended_surfaces(scene))
    throw Error(ErrorCode::BadUsage, fmt::format("{}: {}", scene.path.string(), BLENDED));
  if (options.path.empty()) {
    if (options.statistics == 0) say("{}\n", check::Tally::header());
    const check::Agreement images =
        options.statistics > 0 ? check_images(device, subject, options) : check::Agreement::Agree;
    if (images == check::Agreement::Undecided)
      throw Error(
          ErrorCode::Failed,
          fmt::format("{}: so many samples neither confirm nor withdraw a difference, see above; take more",
                      scene.path.string()));
    const bool is_passed = options.statistics > 0 ? images == check::Agreement::Agree
                           : options.weights > 0  ? session::check_sorted_and_connected(
                                                        device, subject, options.weights, print_tally)
                                                 : session::check_everything(device, subject, print_tally);
    if (options.statistics == 0 && options.weights == 0 && has_blended_surfaces(scene)) say("{}\n", BLENDED);
    if (!is_passed)
      throw Error(ErrorCode::Failed,
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
  CLI::App* command =
      app.add_subcommand("check", "Compare every stage of the device with the scalar reference, on a scene");
  declare_render_options(*command, options->render);
  command->option_defaults()->group("Check");
  command->add_option("--path", options->path, "Print one camera path in full, from device and reference")
      ->type_name("x,y,sample");
  command
      ->add_option("--weights", options->weights,
                   "Compare only connections, merges and splats, until this many weights have been compared")
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
