#include "session/render_job.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <new>

#include "base/atomic_file.hpp"
#include "check/reference_render.hpp"
#include "render/aov.hpp"
#include "render/names.hpp"
#include "render/rays_choice.hpp"
#include "session/checkpoint.hpp"
#include "session/film_memory.hpp"
#include "session/part.hpp"
#include "session/stop_rule.hpp"
#include "session/tiled_render.hpp"

namespace regulus::session {

namespace {

/// Between begin() and end() of a watcher, whatever ends the render.
class Watched {
 public:
  explicit Watched(Watcher& watcher) : watcher_(watcher) { watcher_.begin(); }
  ~Watched() { watcher_.end(); }
  Watched(const Watched&) = delete;
  Watched& operator=(const Watched&) = delete;

 private:
  Watcher& watcher_;
};

/// Tells the watcher of kernels that the device compiles.
class WatchedKernels {
 public:
  WatchedKernels(gpu::Device& device, Watcher& watcher) : device_(device) {
    device_.watch_kernels([&watcher](size_t done, size_t total) { watcher.kernels(done, total); });
  }
  ~WatchedKernels() { device_.watch_kernels({}); }
  WatchedKernels(const WatchedKernels&) = delete;
  WatchedKernels& operator=(const WatchedKernels&) = delete;

 private:
  gpu::Device& device_;
};

/// What needs the whole film at a time.
bool needs_whole_film(const render::Plan& plan, const Job& job) {
  return job.time_limit || job.noise_target || job.holds_sums || !job.checkpoint.empty() || job.earlier ||
         plan.has_strategy_images;
}

constexpr const char* WHOLE_FILM =
    "a time limit, a noise target, a range of samples, checkpoints and strategy images need";

Result render_by_reference(const PreparedScene& prepared, const render::Plan& plan, const Job& job,
                           Watcher& watcher) {
  if (needs_whole_film(plan, job))
    throw Error(ErrorCode::BadUsage,
                fmt::format("{} a device; give the reference a number of samples", WHOLE_FILM));
  const auto start = std::chrono::steady_clock::now();
  check::ReferenceRender rendered;
  {
    const Watched watched(watcher);
    rendered = check::render_with_reference(prepared, plan, [&](uint64_t done, uint64_t total) {
      watcher.progress({done, total});
      return !watcher.is_cancelled();
    });
  }
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  Result result;
  result.placement = placement_of(plan);
  result.attributes = scene_attributes(prepared.scene, plan);
  result.attributes["regulus:device"] = "scalar reference";
  result.attributes["regulus:samples_done"] = std::to_string(rendered.samples);
  result.attributes["regulus:render_seconds"] = fmt::format("{:.3f}", seconds);
  result.statistics = nlohmann::json(result.attributes);
  result.paths = rendered.samples * plan.window().pixels();
  result.seconds = seconds;
  result.is_complete = rendered.samples == plan.samples;
  result.summary = fmt::format("{}x{}, {} samples per pixel in {:.2f} s by the reference",
                               rendered.image.width, rendered.image.height, rendered.samples, seconds);
  result.image = std::move(rendered.image);
  result.channels = std::move(rendered.channels);
  return result;
}

void report_bugs(uint64_t non_finite, uint64_t overruns, Result& result) {
  if (non_finite > 0)
    result.bugs.push_back(fmt::format("{} samples were not finite and were dropped", non_finite));
  if (overruns > 0) result.bugs.push_back(fmt::format("{} rays hit the traversal's step bound", overruns));
}

/// A film larger than a buffer.
Result render_by_bands(const PreparedScene& prepared, const render::Plan& plan, const Job& job,
                       gpu::Device& device, const std::vector<render::Window>& bands, Watcher& watcher) {
  if (needs_whole_film(plan, job))
    throw Error(ErrorCode::BadUsage, fmt::format("{} the whole film in a buffer of the device, which holds "
                                                 "{} of {} rows; render crops of it",
                                                 WHOLE_FILM, bands.front().height, plan.window().height));
  TiledRender rendered;
  {
    const Watched watched(watcher);
    rendered = render_in_bands(device, prepared, plan, bands, [&](uint64_t done, uint64_t total) {
      watcher.progress({done, total});
      return !watcher.is_cancelled();
    });
  }
  const uint64_t pixels = plan.window().pixels();
  Result result;
  result.placement = placement_of(plan);
  result.attributes = scene_attributes(prepared.scene, plan);
  result.attributes["regulus:device"] = device.info().name;
  result.attributes["regulus:driver"] = device.info().driver;
  result.attributes["regulus:rays"] =
      name_of(render::names::RAYS, render::resolve_rays(device.info(), prepared, plan));
  result.attributes["regulus:samples_done"] = std::to_string(rendered.paths / pixels);
  result.attributes["regulus:render_seconds"] = fmt::format("{:.3f}", rendered.render_seconds);
  result.attributes["regulus:non_finite"] = std::to_string(rendered.non_finite);
  result.statistics = nlohmann::json(result.attributes);
  result.paths = rendered.paths;
  result.seconds = rendered.render_seconds;
  result.is_complete = rendered.paths == pixels * plan.samples;
  result.summary = fmt::format("{}x{} in {} bands, {:.2f} s", rendered.image.width, rendered.image.height,
                               bands.size(), rendered.render_seconds);
  result.warnings = std::move(rendered.warnings);
  report_bugs(rendered.non_finite, rendered.overruns, result);
  result.image = std::move(rendered.image);
  result.channels = std::move(rendered.channels);
  return result;
}

/// The picture with its AOVs. A device that is lost makes no AOVs of surfaces any more.
void take_picture(const PreparedScene& prepared, const render::Plan& plan, Result& result) {
  render::Renderer& renderer = *result.renderer;
  if ((plan.aovs & render::SURFACE_AOVS) != 0 && !result.failure)
    render::add_surface_channels(renderer.surface_aovs(), plan.aovs, prepared.scene.origin, result.channels);
  if ((plan.aovs & render::CRYPTO_AOVS) != 0 && !result.failure)
    render::add_cryptomattes(prepared.scene, renderer.ray_ids(), plan.aovs, result.channels);
  if ((plan.aovs & render::AOV_SIGMA) != 0 && !result.failure)
    render::add_sigma_channels(renderer.surface_footprints(), result.channels);
  render::add_film_channels(renderer.film(), plan.aovs, result.channels);
  result.image = resolve(renderer.film());
}

void report(const render::Plan& plan, Result& result) {
  const render::RenderStatistics& statistics = result.renderer->statistics();
  report_bugs(statistics.non_finite, statistics.traversal_overruns, result);
  result.warnings = saturation_warnings(result.renderer->film());
  if (statistics.forgotten_media > 0)
    result.warnings.push_back(fmt::format(
        "paths were inside of more than {} solids at once: {} times the one that decides least was forgotten",
        interface::MEDIA_SET_SIZE, statistics.forgotten_media));
  const render::Window window = plan.window();
  const auto paths = static_cast<double>(statistics.paths - statistics.resumed_paths);
  result.seconds = statistics.render_seconds;
  result.summary =
      fmt::format("{}x{}, {} samples per pixel in {:.2f} s ({:.3f} million samples/s)", window.width,
                  window.height, statistics.paths / window.pixels(), statistics.render_seconds,
                  1e-6 * paths / std::max(statistics.render_seconds, 1e-9));
}

Result render_whole_film(const PreparedScene& prepared, const render::Plan& plan, const Job& job,
                         gpu::Device& device, Watcher& watcher) {
  require_film_memory(plan.asked, job.holds_sums || !job.checkpoint.empty(), false, job.memory_bytes);
  Result result;
  render::Plan own = plan;
  if (job.earlier) {
    require_samples_in_order(*job.earlier, job.checkpoint, plan);
    own.rays = job.earlier->rays;
  }
  result.renderer = std::make_unique<render::Renderer>(device, prepared, own);
  render::Renderer& renderer = *result.renderer;
  LoadTimes times = job.times;
  times.pipeline_seconds = device.pipeline_seconds();
  if (job.earlier) resume(renderer, job.checkpoint, job.earlier->film);
  const auto attributes = [&] { return image_attributes(device, prepared.scene, plan, renderer); };
  Checkpoint checkpoint(
      job.checkpoint, job.checkpoint_seconds,
      [&](const render::Film& film) {
        write_file_atomically(job.checkpoint,
                              encode_part(job.checkpoint, film, {{plan.first_sample, plan.samples}},
                                          attributes(), {}, placement_of(plan)));
      },
      [&](const std::string& text) { watcher.warn(text); });
  const uint64_t pixels = plan.window().pixels();
  const uint64_t earlier_paths = renderer.film().paths;
  StopRule stop(job.time_limit, job.noise_target, pixels);
  try {
    const Watched watched(watcher);
    renderer.render(
        [&](uint64_t done, uint64_t total) {
          const bool is_enough = stop.is_reached(renderer.film(), done);
          watcher.progress({done, total, earlier_paths, stop.noise()});
          watcher.state(renderer.film());
          checkpoint.update(renderer.film());
          return !is_enough;
        },
        [&] { return watcher.is_cancelled(); });
  } catch (const Error& error) {
    result.failure = error;
    if (renderer.film().paths == 0) throw;
  } catch (const std::bad_alloc&) {
    result.failure = Error(ErrorCode::Failed, "out of memory");
    if (renderer.film().paths == 0) throw;
  }
  checkpoint.finish(renderer.film());
  result.paths = renderer.film().paths;
  result.is_complete = stop.was_reached() || result.paths >= pixels * plan.samples;
  result.noise = stop.final_noise(renderer.film());
  result.statistics = render_statistics(device, prepared, plan, renderer, times);
  result.statistics["noise"] = result.noise;
  result.attributes = attributes();
  result.placement = placement_of(plan);
  take_picture(prepared, plan, result);
  report(plan, result);
  return result;
}

}  // namespace

image::Placement placement_of(const render::Plan& plan) {
  const render::Window window = plan.window();
  return {window.x, window.y, plan.width, plan.height};
}

Result render(const PreparedScene& prepared, const render::Plan& plan, const Job& job, gpu::Device* device,
              Watcher& watcher) {
  if (device == nullptr) return render_by_reference(prepared, plan, job, watcher);
  const WatchedKernels watched(*device, watcher);
  const std::vector<render::Window> bands = film_bands(*device, plan, job.band_pixels);
  if (bands.size() > 1) return render_by_bands(prepared, plan, job, *device, bands, watcher);
  return render_whole_film(prepared, plan, job, *device, watcher);
}

std::string encode(const Result& result, const render::Plan& plan, const Job& job, image::Format format,
                   const image::Encoding& encoding, const std::filesystem::path& path) {
  if (job.holds_sums)
    return encode_part(
        path, result.film ? *result.film : result.renderer->film(),
        result.film ? result.ranges : std::vector{SampleRange{plan.first_sample, plan.samples}},
        result.attributes, result.channels, result.placement);
  return image::encode_picture(format, result.image, encoding, result.attributes, result.channels,
                               result.placement, path.string());
}

}  // namespace regulus::session
