// regulus render: scene in, picture out.

#include <fmt/format.h>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <set>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "base/interrupt.hpp"
#include "base/standard_streams.hpp"
#include "cli/commands.hpp"
#include "cli/frames.hpp"
#include "cli/progress.hpp"
#include "cli/render_options.hpp"
#include "cli/render_outputs.hpp"
#include "cli/render_result.hpp"
#include "cli/render_watcher.hpp"
#include "image/color_config.hpp"
#include "image/formats.hpp"
#include "scene/placement.hpp"
#include "session/checkpoint.hpp"
#include "session/film_memory.hpp"
#include "session/render_job.hpp"
#include "session/several_devices.hpp"

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

// Messages go to stderr, as one line each, past the line that shows progress: stdout is for results.
class LogSink : public spdlog::sinks::base_sink<std::mutex> {
 public:
  explicit LogSink(ProgressReport& progress) : progress_(progress) {}

 private:
  void sink_it_(const spdlog::details::log_msg& message) override {
    spdlog::memory_buf_t text;
    formatter_->format(message, text);
    progress_.print({text.data(), text.size()});
  }
  void flush_() override {}

  ProgressReport& progress_;
};

void set_up_log(const RenderOptions& options, ProgressReport& progress) {
  spdlog::set_default_logger(
      std::make_shared<spdlog::logger>("regulus", std::make_shared<LogSink>(progress)));
  spdlog::set_pattern("regulus: %l: %v");
  spdlog::set_level(options.is_quiet     ? spdlog::level::err
                    : options.is_verbose ? spdlog::level::info
                                         : spdlog::level::warn);
}

// What outlives a picture of a sequence. Nothing is logged when it is gone.
struct Session {
  ProgressReport progress;
  OutputGuard guard;
  std::vector<std::unique_ptr<gpu::Device>> devices;  // opened when they are first needed
  std::set<std::string> said;                         // warnings
  Stopwatch stopwatch;
  Clock::time_point begin = Clock::now();  // of the picture

  explicit Session(const RenderOptions& options) : progress(options.progress, options.is_quiet) {}
};

// Whether there is a checkpoint, or a device in its place is none.
bool has_checkpoint(const RenderOptions& options) {
  std::error_code error;
  return fs::exists(options.checkpoint, error) && !is_device_or_pipe(options.checkpoint);
}

// Without --resume a checkpoint is not overwritten: it may be hours of work.
void require_new_checkpoint(const RenderOptions& options) {
  if (!has_checkpoint(options) || options.is_resumed) return;
  throw Error(
      ErrorCode::BadUsage,
      fmt::format("--checkpoint {}: exists; go on from it with --resume, or remove it", options.checkpoint));
}

void say_warning(const scene::Scene& scene, const std::string& warning, Session& session) {
  if (session.said.insert(warning).second) spdlog::warn("{}: {}", scene.path.string(), warning);
}

std::unique_ptr<gpu::Device> open_device(const RenderOptions& options, const std::string& select) {
  const bool measures_stages = !options.stats.empty() || !options.report.empty();
  auto device = std::make_unique<gpu::Device>(gpu::DeviceOptions{.select = select,
                                                                 .software_stage_times = measures_stages,
                                                                 .kernel_statistics = !options.stats.empty(),
                                                                 .memory_bytes = options.memory_bytes});
  const gpu::DeviceInfo& info = device->info();
  if (info.kind == gpu::DeviceKind::Software)
    spdlog::info("device {}: software, rendering on the CPU", info.name);
  else
    spdlog::info("device {}", info.name);
  return device;
}

std::vector<gpu::Device*> open_devices(const RenderOptions& options, Session& session) {
  if (session.devices.empty())
    for (const std::string& select : gpu::split_device_list(options.device))
      session.devices.push_back(open_device(options, select));
  std::vector<gpu::Device*> devices;
  for (const auto& device : session.devices) devices.push_back(device.get());
  return devices;
}

// Before hours of work.
void prepare_to_denoise(const CLI::App& command, RenderOptions& options) {
  if (!options.sample_range.empty())
    throw Error(ErrorCode::BadUsage,
                "--denoise: the sum of denoised parts is no denoised sum; denoise what merge has joined "
                "(regulus denoise)");
  require_denoiser(options.denoise);
  // Noise is to be that of one pixel: light paths are splatted onto all pixels whose filter reaches them.
  if (command.get_option("--filter")->count() == 0) options.settings.filter = interface::FILTER_BOX;
}

// The noisy picture is better than none.
void try_to_denoise(const RenderOptions& options, session::Result& result) {
  try {
    denoise_picture(options.denoise, result.image, result.channels, result.attributes);
  } catch (const Error& error) {
    spdlog::error("{}; the picture is written as it is", error.what());
  }
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
  if (!plan.light_guide_rule.empty() && plan.why_dropped("guided emission") == nullptr)
    spdlog::info("{} guided emission: {}", plan.light_guide ? "with" : "without", plan.light_guide_rule);
  if (!plan.shadow_roulette_rule.empty())
    spdlog::info("shadow rays that would carry less than {:.3g} play roulette: {}", plan.shadow_roulette,
                 plan.shadow_roulette_rule);
  if (!plan.walk_guide_rule.empty() && plan.why_dropped("guided camera walks") == nullptr)
    spdlog::info("{} guided camera walks: {}", plan.walk_guide ? "with" : "without", plan.walk_guide_rule);
  for (const render::Dropped& dropped : plan.dropped)
    spdlog::info("without {}: {}", dropped.what, dropped.why);
  times.bvh_seconds = session.stopwatch.lap();
  job.times = times;
  spdlog::info("{} triangles, {} lights: loaded in {:.2f} s, acceleration structure in {:.2f} s",
               scene::placed_triangle_count(scene), scene.lights.size(), times.load_seconds,
               times.bvh_seconds);
  if (options.backend != "reference") session.progress.begin("device");
  std::vector<gpu::Device*> devices;
  if (options.backend != "reference") devices = open_devices(options, session);
  std::optional<session::DisplayServer> viewer;
  if (!options.display_server.empty())
    viewer.emplace(parse_host_and_port(options.display_server), outputs.picture.string(),
                   session::placement_of(plan));
  const Limits limits{!options.has_no_sample_limit, options.time_limit, options.noise_target};
  RenderWatcher watcher(session.progress, limits, plan.window().pixels(), viewer ? &*viewer : nullptr);
  session::Result result =
      devices.size() > 1 || !options.split.empty()
          ? session::render_on_devices(prepared, plan, job, devices, options.split, watcher)
          : session::render(prepared, plan, job, devices.empty() ? nullptr : devices.front(), watcher);
  if (options.is_denoised) try_to_denoise(options, result);
  if (viewer) viewer->finish(result.image);
  RenderOptions exposed = options;
  if (options.is_exposed_automatically) exposed.exposure_ev = image::automatic_exposure(result.image);
  write_result({result, prepared, plan, job, exposed, outputs, watcher.convergence()}, session.progress,
               session.begin);
  if (!viewer) return;
  viewer->close();
  if (const auto warning = viewer->take_warning()) spdlog::warn("{}", *warning);
}

// Renders a scene that has just been loaded or posed; afterwards it can be posed again.
void render_picture(const RenderOptions& options, const RenderOutputs& outputs, scene::Scene& scene,
                    Session& session) {
  render::RenderSettings settings = resolve_settings(options, scene);
  settings.keeps_doublings |= !options.report.empty();  // for the curve of its error
  check_outputs(outputs, options, settings, session.guard);
  const bool holds_sums = !options.sample_range.empty() || !options.checkpoint.empty();
  if (options.is_denoised) settings.aovs |= aovs_for_denoiser(options.denoise);
  session::require_film_memory(settings, holds_sums, options.backend != "reference", options.memory_bytes);
  session::LoadTimes times;
  times.load_seconds = session.stopwatch.lap();
  session.progress.begin("prepare");
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
  Session session(options);
  set_up_log(options, session.progress);
  lift_sample_limit(command, options);
  if (options.is_denoised) prepare_to_denoise(command, options);
  if (!options.ocio.empty()) {
    options.color_transform =
        std::make_shared<image::ColorTransform>(options.ocio, options.ocio_display, options.ocio_view);
    if (!options.color_transform->warning().empty()) spdlog::warn(options.color_transform->warning());
  }
  options.has_strategy_images = !options.strategy_images.empty();
  std::vector<Frame> frames = parse_frames(options);
  std::vector<Picture> pictures = plan_pictures(options, frames, session.guard);
  if (!frames.empty()) options.time = frames.front().seconds;
  const bool has_own_time = options.time.has_value();
  session.progress.begin("load");
  scene::SceneFile file(options.scene_file, load_options(options));
  scene::Scene scene = file.load();
  std::ranges::move(apply_scene_settings(command, scene), std::back_inserter(scene.warnings));
  if (!has_own_time) frames = parse_frames(options);  // those of the scene
  if (!has_own_time && !frames.empty()) file.pose(scene, frames.front().seconds);
  // Once more: with the scene's settings, and its frames.
  session.guard = OutputGuard();
  pictures = plan_pictures(options, frames, session.guard);
  for (const Picture& picture : pictures) {
    if (picture.frame) session.progress.begin_frame(picture.frame->number);
    if (picture.frame && &picture != &pictures.front()) {
      if (is_interrupted())
        throw Error(ErrorCode::Interrupted,
                    fmt::format("interrupted before frame {}", picture.frame->number));
      session.stopwatch.lap();
      session.begin = Clock::now();
      session.progress.begin("load");
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
