// regulus render: scene in, picture out.

#include <fmt/format.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <memory>
#include <new>
#include <optional>
#include <set>

#include "base/error.hpp"
#include "check/reference_render.hpp"
#include "cli/checkpoint.hpp"
#include "cli/commands.hpp"
#include "cli/film_memory.hpp"
#include "cli/frames.hpp"
#include "cli/interrupt.hpp"
#include "cli/progress.hpp"
#include "cli/render_options.hpp"
#include "cli/render_outputs.hpp"
#include "cli/standard_streams.hpp"
#include "cli/stats.hpp"
#include "cli/stop_rule.hpp"
#include "cli/strategy_images.hpp"
#include "cli/tiled_render.hpp"
#include "image/atomic_file.hpp"
#include "image/formats.hpp"
#include "render/aov.hpp"
#include "render/film_file.hpp"
#include "render/renderer.hpp"
#include "scene/placement.hpp"

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

void report(const render::Renderer& renderer, const render::Plan& plan, const RenderOutputs& outputs) {
  const render::RenderStatistics& statistics = renderer.statistics();
  if (statistics.non_finite > 0)
    spdlog::error("{} samples were not finite and were dropped: a bug, please report the scene",
                  statistics.non_finite);
  if (statistics.traversal_overruns > 0)
    spdlog::error("{} rays hit the traversal's step bound: a bug, please report the scene",
                  statistics.traversal_overruns);
  for (const std::string& warning : saturation_warnings(renderer.film()))
    spdlog::warn("{}: {}", outputs.picture.string(), warning);
  if (statistics.forgotten_media > 0)
    spdlog::warn(
        "paths were inside of more than {} solids at once: {} times the one that decides least was forgotten",
        interface::MEDIA_SET_SIZE, statistics.forgotten_media);
  const render::Window window = plan.window();
  const auto paths = static_cast<double>(statistics.paths - statistics.resumed_paths);
  spdlog::info("{}: {}x{}, {} samples per pixel in {:.2f} s ({:.3f} million samples/s)",
               outputs.picture.string(), window.width, window.height, statistics.paths / window.pixels(),
               statistics.render_seconds, 1e-6 * paths / std::max(statistics.render_seconds, 1e-9));
}

// Throws the error of a render that was stopped; its outputs are written.
void require_complete(bool is_complete, const RenderOutputs& outputs) {
  if (!is_complete)
    throw Error(ExitStatus::Interrupted,
                fmt::format("interrupted; {} holds what was rendered", outputs.picture.string()));
}

image::Placement placement_of(const render::Plan& plan) {
  const render::Window window = plan.window();
  return {window.x, window.y, plan.width, plan.height};
}

// --backend reference. Its statistics are those that need no device.
void render_by_reference(const RenderOptions& options, const RenderOutputs& outputs,
                         const PreparedScene& prepared, const render::Plan& plan) {
  if (options.time_limit || options.noise_target)
    throw Error(ExitStatus::BadUsage,
                "--time and --noise need --backend vulkan; give --spp to the reference");
  if (!options.sample_range.empty() || !options.checkpoint.empty())
    throw Error(ExitStatus::BadUsage, "--samples and --checkpoint need --backend vulkan");
  if (!options.strategy_images.empty())
    throw Error(ExitStatus::BadUsage, "--strategy-images needs --backend vulkan");
  Stopwatch stopwatch;
  catch_interrupts();
  check::ReferenceRender rendered;
  {
    ProgressLine progress(!options.is_quiet);
    rendered = check::render_with_reference(prepared, plan, [&](uint64_t done, uint64_t total) {
      progress.update(done, total);
      return !is_interrupted();
    });
  }
  const double seconds = stopwatch.lap();
  image::Attributes attributes = scene_attributes(prepared.scene, plan);
  attributes["regulus:device"] = "scalar reference";
  attributes["regulus:samples_done"] = std::to_string(rendered.samples);
  attributes["regulus:render_seconds"] = fmt::format("{:.3f}", seconds);
  OutputWriter writer;
  writer.write(outputs.picture, [&] {
    return image::encode_picture(outputs.format, rendered.image, options.exposure_ev, attributes,
                                 rendered.channels, placement_of(plan), outputs.picture.string());
  });
  write_others(writer, outputs, options, rendered.image, nlohmann::json(attributes));
  writer.throw_failures();
  spdlog::info("{}: {}x{}, {} samples per pixel in {:.2f} s by the reference", outputs.picture.string(),
               rendered.image.width, rendered.image.height, rendered.samples, seconds);
  require_complete(rendered.samples == plan.samples, outputs);
}

// A film larger than a buffer. What needs the whole film at a time is for crops.
void render_by_bands(const RenderOptions& options, const RenderOutputs& outputs, gpu::Device& device,
                     const PreparedScene& prepared, const render::Plan& plan,
                     const std::vector<render::Window>& bands) {
  if (options.time_limit || options.noise_target || !options.sample_range.empty() ||
      !options.checkpoint.empty() || !options.strategy_images.empty())
    throw Error(
        ExitStatus::BadUsage,
        fmt::format("--time, --noise, --samples, --checkpoint and --strategy-images need the whole film in a "
                    "buffer of the device, which holds {} of {} rows; render parts with --crop",
                    bands.front().height, plan.window().height));
  catch_interrupts();
  TiledRender rendered;
  {
    ProgressLine progress(!options.is_quiet);
    rendered = render_in_bands(device, prepared, plan, bands, [&](uint64_t done, uint64_t total) {
      progress.update(done, total);
      return !is_interrupted();
    });
  }
  const uint64_t pixels = plan.window().pixels();
  image::Attributes attributes = scene_attributes(prepared.scene, plan);
  attributes["regulus:device"] = device.info().name;
  attributes["regulus:driver"] = device.info().driver;
  attributes["regulus:samples_done"] = std::to_string(rendered.paths / pixels);
  attributes["regulus:render_seconds"] = fmt::format("{:.3f}", rendered.render_seconds);
  attributes["regulus:non_finite"] = std::to_string(rendered.non_finite);
  OutputWriter writer;
  writer.write(outputs.picture, [&] {
    return image::encode_picture(outputs.format, rendered.image, options.exposure_ev, attributes,
                                 rendered.channels, placement_of(plan), outputs.picture.string());
  });
  write_others(writer, outputs, options, rendered.image, nlohmann::json(attributes));
  writer.throw_failures();
  for (const std::string& warning : rendered.warnings)
    spdlog::warn("{}: {}", outputs.picture.string(), warning);
  if (rendered.non_finite > 0 || rendered.overruns > 0)
    spdlog::error(
        "{} samples were not finite, {} rays hit the traversal's step bound: a bug, please report the scene",
        rendered.non_finite, rendered.overruns);
  spdlog::info("{}: {}x{} in {} bands, {:.2f} s", outputs.picture.string(), rendered.image.width,
               rendered.image.height, bands.size(), rendered.render_seconds);
  require_complete(rendered.paths == pixels * plan.samples, outputs);
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
      ExitStatus::BadUsage,
      fmt::format("--checkpoint {}: exists; go on from it with --resume, or remove it", options.checkpoint));
}

// The film that --resume goes on from; none if there is no checkpoint yet.
std::optional<render::Film> find_checkpoint(const RenderOptions& options, const scene::Scene& scene,
                                            const render::Plan& plan) {
  if (!has_checkpoint(options)) return std::nullopt;
  require_new_checkpoint(options);
  return read_checkpoint(options.checkpoint, scene_attributes(scene, plan), plan);
}

// The picture, with its AOVs, and with its sums if it is a range of samples. A device that is lost makes no
// AOVs of surfaces any more.
image::Image write_image(OutputWriter& writer, const RenderOutputs& outputs, const RenderOptions& options,
                         const scene::Scene& scene, const render::Plan& plan,
                         const image::Attributes& attributes, render::Renderer& renderer,
                         bool is_device_lost) {
  const render::Film& film = renderer.film();
  image::Channels channels;
  if ((plan.aovs & render::SURFACE_AOVS) != 0 && !is_device_lost)
    render::add_surface_channels(renderer.surface_aovs(), plan.aovs, scene.origin, channels);
  if ((plan.aovs & render::AOV_SIGMA) != 0 && !is_device_lost)
    render::add_sigma_channels(renderer.surface_footprints(), channels);
  render::add_film_channels(film, plan.aovs, channels);
  image::Image image = resolve(film);
  writer.write(outputs.picture, [&] {
    if (!options.sample_range.empty())
      return encode_part(outputs.picture, film, {{plan.first_sample, plan.samples}}, attributes, channels,
                         placement_of(plan));
    return image::encode_picture(outputs.format, image, options.exposure_ev, attributes, channels,
                                 placement_of(plan), outputs.picture.string());
  });
  return image;
}

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

// Whether sums are written besides the picture.
bool holds_sums(const RenderOptions& options) {
  return !options.sample_range.empty() || !options.checkpoint.empty();
}

void render_prepared(const RenderOptions& options, const RenderOutputs& outputs,
                     const PreparedScene& prepared, const render::RenderSettings& settings, LoadTimes times,
                     Session& session) {
  const scene::Scene& scene = prepared.scene;
  const render::Plan plan = make_plan(prepared, settings);
  const std::optional<render::Film> earlier = find_checkpoint(options, scene, plan);
  for (const std::string& warning : scene.warnings) say_warning(scene, warning, session);
  for (const std::string& warning : plan.warnings) say_warning(scene, warning, session);
  for (const render::Dropped& dropped : plan.dropped)
    spdlog::info("without {}: {}", dropped.what, dropped.why);
  times.bvh_seconds = session.stopwatch.lap();
  spdlog::info("{} triangles, {} lights: loaded in {:.2f} s, acceleration structure in {:.2f} s",
               scene::placed_triangle_count(scene), scene.lights.size(), times.load_seconds,
               times.bvh_seconds);

  if (options.backend == "reference") return render_by_reference(options, outputs, prepared, plan);

  gpu::Device& device = open_device(options, session);
  const std::vector<render::Window> bands = film_bands(device, plan, options.band_pixels);
  if (bands.size() > 1) return render_by_bands(options, outputs, device, prepared, plan, bands);
  require_film_memory(settings, holds_sums(options), false, options.memory_bytes);
  render::Renderer renderer(device, prepared, plan);
  times.pipeline_seconds = device.pipeline_seconds();
  if (earlier) resume(renderer, options.checkpoint, *earlier);
  Checkpoint checkpoint(options.checkpoint, options.checkpoint_seconds, [&](const render::Film& film) {
    const std::string bytes =
        encode_part(options.checkpoint, film, {{plan.first_sample, plan.samples}},
                    image_attributes(device, scene, plan, renderer), {}, placement_of(plan));
    image::write_file_atomically(options.checkpoint, bytes);
  });

  catch_interrupts();
  const uint64_t pixels = plan.window().pixels();
  StopRule stop(options, pixels);
  std::optional<Error> failure;
  try {
    ProgressLine progress(!options.is_quiet);
    renderer.render(
        [&](uint64_t done, uint64_t total) {
          progress.update(done, total);
          checkpoint.update(renderer.film());
          return !stop.is_reached(renderer.film(), done);
        },
        is_interrupted);
  } catch (const Error& error) {
    failure = error;  // a lost device: what was rendered before is still written
    if (renderer.film().paths == 0) throw;
  } catch (const std::bad_alloc&) {
    failure = Error(ExitStatus::Failed, "out of memory");
    if (renderer.film().paths == 0) throw;
  }
  checkpoint.finish(renderer.film());
  const bool is_finished = stop.was_reached() || renderer.film().paths >= pixels * plan.samples;
  stop.is_reached(renderer.film(), renderer.film().paths);  // says the noise of what is written
  nlohmann::json statistics = render_statistics(device, prepared, plan, renderer, times);
  if (options.noise_target) statistics["noise"] = stop.noise();
  OutputWriter writer;
  const image::Image image =
      write_image(writer, outputs, options, scene, plan, image_attributes(device, scene, plan, renderer),
                  renderer, failure.has_value());
  write_others(writer, outputs, options, image, statistics);
  if (!options.strategy_images.empty() && !failure)
    write_strategy_images(writer, options.strategy_images, renderer, plan.max_depth,
                          image_attributes(device, scene, plan, renderer), options.exposure_ev);
  report(renderer, plan, outputs);
  if (options.noise_target && !options.is_quiet) print_noise(stop.noise(), *options.noise_target);
  if (failure && writer.has_failed())
    spdlog::error("{}", failure->what());
  else if (failure)
    throw Error(failure->status(), fmt::format("{}; {} holds what was rendered before", failure->what(),
                                               outputs.picture.string()));
  writer.throw_failures();
  require_complete(is_finished, outputs);
}

// Renders a scene that has just been loaded or posed; afterwards it can be posed again.
void render_picture(const RenderOptions& options, const RenderOutputs& outputs, scene::Scene& scene,
                    Session& session) {
  const render::RenderSettings settings = resolve_settings(options, scene);
  check_outputs(outputs, options, settings, session.guard);
  require_film_memory(settings, holds_sums(options), options.backend != "reference", options.memory_bytes);
  LoadTimes times;
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
        throw Error(ExitStatus::Interrupted,
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
