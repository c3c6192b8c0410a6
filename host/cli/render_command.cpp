// regulus render: scene in, picture out.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "cli/commands.hpp"
#include "cli/frames.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress.hpp"
#include "cli/render_options.hpp"
#include "cli/render_outputs.hpp"
#include "cli/standard_streams.hpp"
#include "cli/strategy_images.hpp"
#include "image/atomic_file.hpp"
#include "image/formats.hpp"
#include "scene/placement.hpp"
#include "session/checkpoint.hpp"
#include "session/film_memory.hpp"
#include "session/render_job.hpp"

namespace regulus::cli {

namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

// Seconds since the last call.
class Stopwatch {
 public:
  double lap() {
    const auto now = Clock::now();
    const double seconds = std::chrono::duration<double>(now - last_).count();
    last_ = now;
    return seconds;
  }

 private:
  Clock::time_point last_ = Clock::now();
};

// Messages go to stderr, as one line each: stdout is for results.
void set_up_log(const RenderOptions& options) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("regulus", std::make_shared<spdlog::sinks::stderr_sink_st>()));
  spdlog::set_pattern("regulus: %l: %v");
  spdlog::set_level(options.is_quiet     ? spdlog::level::err
                    : options.is_verbose ? spdlog::level::info
                                         : spdlog::level::warn);
}

// Preview and statistics.
void write_others(OutputWriter& writer, const RenderOutputs& outputs, const RenderOptions& options,
                  const image::Image& image, const nlohmann::json& statistics) {
  if (!outputs.png.empty())
    writer.write(outputs.png, [&] {
      return image::encode_tone_mapped(image::Format::Png, image, options.exposure_ev, outputs.png.string());
    });
  if (!outputs.stats.empty()) writer.write(outputs.stats, [&] { return statistics.dump(2) + "\n"; });
}

void report(const session::Result& result, const RenderOutputs& outputs) {
  const std::string picture = outputs.picture.string();
  for (const std::string& warning : result.warnings) spdlog::warn("{}: {}", picture, warning);
  for (const std::string& bug : result.bugs) spdlog::error("{}: a bug, please report the scene", bug);
  spdlog::info("{}: {}", picture, result.summary);
}

// A word more than what was asked for, which is the picture.
void print_noise(double noise, double target) {
  forgive_stdout();
  if (std::isnan(noise))
    say("relative error unknown: more samples are needed to estimate it\n");
  else
    say("estimated relative error {:.4g}{}\n", noise,
        noise <= target ? "" : fmt::format(", not the {:.4g} asked for", target));
}

// Whether there is a checkpoint, or a device in its place is none.
bool has_checkpoint(const RenderOptions& options) {
  std::error_code error;
  return fs::exists(options.checkpoint, error) && !image::is_device_or_pipe(options.checkpoint);
}

// Without --resume a checkpoint is not overwritten: it may be hours of work.
void require_new_checkpoint(const RenderOptions& options) {
  if (!has_checkpoint(options) || options.is_resumed) return;
  throw Error(
      ErrorCode::BadUsage,
      fmt::format("--checkpoint {}: exists; go on from it with --resume, or remove it", options.checkpoint));
}

// What is done while the render runs.
class TerminalWatcher : public session::Watcher {
 public:
  explicit TerminalWatcher(bool shows_progress) : shows_progress_(shows_progress) {}
  void begin() override {
    catch_interrupts();
    line_.emplace(shows_progress_);
  }
  void progress(uint64_t done, uint64_t total) override { line_->update(done, total); }
  bool is_cancelled() override { return is_interrupted(); }
  void end() override { line_.reset(); }
  void warn(const std::string& text) override { spdlog::warn("{}", text); }

 private:
  bool shows_progress_;
  std::optional<ProgressLine> line_;
};

// What outlives a picture of a sequence.
struct Session {
  OutputGuard guard;
  std::unique_ptr<gpu::Device> device;  // opened when it is first needed
  std::set<std::string> said;           // warnings
  Stopwatch stopwatch;
};

void say_warning(const scene::Scene& scene, const std::string& warning, Session& session) {
  if (session.said.insert(warning).second) spdlog::warn("{}: {}", scene.path.string(), warning);
}

gpu::Device& open_device(const RenderOptions& options, Session& session) {
  if (session.device) return *session.device;
  session.device =
      std::make_unique<gpu::Device>(gpu::DeviceOptions{.select = options.device,
                                                       .software_stage_times = !options.stats.empty(),
                                                       .kernel_statistics = !options.stats.empty(),
                                                       .memory_bytes = options.memory_bytes});
  const gpu::DeviceInfo& info = session.device->info();
  if (info.kind == gpu::DeviceKind::Software)
    spdlog::info("device {}: software, rendering on the CPU", info.name);
  else
    spdlog::info("device {}", info.name);
  return *session.device;
}

// Writes everything that is asked for, and throws what there is to complain of.
void write_result(const session::Result& result, const render::Plan& plan, const session::Job& job,
                  const RenderOptions& options, const RenderOutputs& outputs) {
  OutputWriter writer;
  writer.write(outputs.picture, [&] {
    return encode(result, plan, job, outputs.format, options.exposure_ev, outputs.picture);
  });
  write_others(writer, outputs, options, result.image, result.statistics);
  if (!options.strategy_images.empty() && !result.failure)
    write_strategy_images(writer, options.strategy_images, *result.renderer, plan.max_depth,
                          result.attributes, options.exposure_ev);
  report(result, outputs);
  if (options.noise_target && !options.is_quiet) print_noise(result.noise, *options.noise_target);
  const std::string picture = outputs.picture.string();
  if (result.failure && writer.has_failed())
    spdlog::error("{}", result.failure->what());
  else if (result.failure)
    throw Error(result.failure->code(),
                fmt::format("{}; {} holds what was rendered before", result.failure->what(), picture));
  writer.throw_failures();
  if (!result.is_complete)
    throw Error(ErrorCode::Interrupted, fmt::format("interrupted; {} holds what was rendered", picture));
}

void render_prepared(const RenderOptions& options, const RenderOutputs& outputs,
                     const PreparedScene& prepared, const render::RenderSettings& settings,
                     session::LoadTimes times, Session& session) {
  const scene::Scene& scene = prepared.scene;
  const render::Plan plan = make_plan(prepared, settings);
  session::Job job{.time_limit = options.time_limit,
                   .noise_target = options.noise_target,
                   .band_pixels = options.band_pixels,
                   .memory_bytes = options.memory_bytes,
                   .holds_sums = !options.sample_range.empty(),
                   .checkpoint = options.checkpoint,
                   .checkpoint_seconds = options.checkpoint_seconds,
                   .earlier = {},
                   .times = {}};
  if (has_checkpoint(options)) job.earlier = session::read_checkpoint(options.checkpoint, scene, plan);
  for (const std::string& warning : scene.warnings) say_warning(scene, warning, session);
  for (const std::string& warning : plan.warnings) say_warning(scene, warning, session);
  if (!settings.techniques)
    spdlog::info("techniques {}{}: {}", render::technique_set_name(plan.techniques),
                 plan.regularization != 0 ? " with regularization" : "", plan.techniques_rule);
  for (const render::Dropped& dropped : plan.dropped)
    spdlog::info("without {}: {}", dropped.what, dropped.why);
  times.bvh_seconds = session.stopwatch.lap();
  job.times = times;
  spdlog::info("{} triangles, {} lights: loaded in {:.2f} s, acceleration structure in {:.2f} s",
               scene::placed_triangle_count(scene), scene.lights.size(), times.load_seconds,
               times.bvh_seconds);
  gpu::Device* device = options.backend == "reference" ? nullptr : &open_device(options, session);
  TerminalWatcher watcher(!options.is_quiet);
  const session::Result result = session::render(prepared, plan, job, device, watcher);
  write_result(result, plan, job, options, outputs);
}

// Renders a scene that has just been loaded or posed; afterwards it can be posed again.
void render_picture(const RenderOptions& options, const RenderOutputs& outputs, scene::Scene& scene,
                    Session& session) {
  const render::RenderSettings settings = resolve_settings(options, scene);
  check_outputs(outputs, options, settings, session.guard);
  const bool holds_sums = !options.sample_range.empty() || !options.checkpoint.empty();
  session::require_film_memory(settings, holds_sums, options.backend != "reference", options.memory_bytes);
  session::LoadTimes times;
  times.load_seconds = session.stopwatch.lap();
  PreparedScene prepared = prepare(std::move(scene));
  render_prepared(options, outputs, prepared, settings, times, session);
  scene = std::move(prepared.scene);
}

// A picture to render: its frame, and the options and outputs under its names.
struct Picture {
  std::optional<Frame> frame;
  RenderOptions options;
  RenderOutputs outputs;
};

// All pictures that the options ask for, one if there are no frames. Whatever is wrong with any of their
// names is better known before the first.
std::vector<Picture> plan_pictures(const RenderOptions& options, const std::vector<Frame>& frames,
                                   OutputGuard& guard) {
  std::vector<Picture> pictures;
  if (frames.empty()) {
    pictures.push_back({std::nullopt, options, resolve_outputs(options, guard)});
    require_new_checkpoint(options);
  }
  for (const Frame& frame : frames) {
    const RenderOptions named = for_frame(options, frame.number);
    pictures.push_back({frame, named, resolve_outputs(named, guard)});
    require_new_checkpoint(named);
  }
  return pictures;
}

void render_scene(CLI::App& command, RenderOptions& options) {
  set_up_log(options);
  lift_sample_limit(command, options);
  options.has_strategy_images = !options.strategy_images.empty();
  Session session;
  std::vector<Frame> frames = parse_frames(options);
  std::vector<Picture> pictures = plan_pictures(options, frames, session.guard);
  if (!frames.empty()) options.time = frames.front().seconds;
  const bool has_own_time = options.time.has_value();
  scene::SceneFile file(options.scene_file, load_options(options));
  scene::Scene scene = file.load();
  std::ranges::move(apply_scene_settings(command, scene), std::back_inserter(scene.warnings));
  if (!has_own_time) frames = parse_frames(options);  // those of the scene
  if (!has_own_time && !frames.empty()) file.pose(scene, frames.front().seconds);
  // Once more: with the scene's settings, and its frames.
  session.guard = OutputGuard();
  pictures = plan_pictures(options, frames, session.guard);
  for (const Picture& picture : pictures) {
    if (picture.frame && &picture != &pictures.front()) {
      if (is_interrupted())
        throw Error(ErrorCode::Interrupted,
                    fmt::format("interrupted before frame {}", picture.frame->number));
      session.stopwatch.lap();
      file.pose(scene, picture.frame->seconds);
    }
    render_picture(picture.options, picture.outputs, scene, session);
  }
}

}  // namespace

void add_render_command(CLI::App& app) {
  const auto options = std::make_shared<RenderOptions>();
  CLI::App* command = app.add_subcommand("render", "Render a glTF scene to a picture");
  declare_render_options(*command, *options);
  command->callback([command, options] { render_scene(*command, *options); });
}

}  // namespace regulus::cli
