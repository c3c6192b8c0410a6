#include "session/several_devices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <new>

#include "base/atomic_file.hpp"
#include "base/error.hpp"
#include "render/aov.hpp"
#include "render/film_file.hpp"
#include "render/names.hpp"
#include "render/rays_choice.hpp"
#include "session/checkpoint.hpp"
#include "session/device_crew.hpp"
#include "session/film_memory.hpp"
#include "session/record.hpp"
#include "session/sample_split.hpp"

namespace regulus::session {

namespace {

using Clock = std::chrono::steady_clock;

void require_plain(const render::Plan& plan, const Job& job) {
  if (job.noise_target || plan.has_strategy_images)
    throw Error(
        ErrorCode::BadUsage,
        "--device: a noise target and strategy images need one device; give several a number of samples "
        "or a time limit");
}

// Who traces rays decides ties, so all devices do it alike.
uint32_t common_rays(const PreparedScene& prepared, const render::Plan& plan,
                     std::span<gpu::Device* const> devices) {
  const uint32_t first = render::resolve_rays(devices.front()->info(), prepared, plan);
  for (const gpu::Device* device : devices)
    if (render::resolve_rays(device->info(), prepared, plan) != first) return interface::RAYS_SOFTWARE;
  return first;
}

/// Values of all devices by name, in their order, each once.
std::string joined(std::span<gpu::Device* const> devices, std::string gpu::DeviceInfo::*member) {
  std::vector<std::string> names;
  for (const gpu::Device* device : devices) {
    const std::string& name = device->info().*member;
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, "; "));
}

// Who did what a checkpoint holds: by its own record, or the one device of these that its name says.
std::vector<Share> shares_of(const Earlier& earlier, const Job& job, const render::Plan& plan,
                             std::span<gpu::Device* const> devices) {
  const auto fail = [&](const std::string& problem) {
    throw Error(ErrorCode::BadUsage, fmt::format("{}: {}", job.checkpoint.string(), problem));
  };
  const uint64_t pixels = plan.window().pixels(), samples = earlier.film.paths / pixels;
  if (earlier.film.paths % pixels != 0)
    fail(fmt::format("ends within a sample; go on with one device ({})", earlier.devices));
  if (samples == 0) return {};
  if (!earlier.split.empty()) {
    if (earlier.devices != joined(devices, &gpu::DeviceInfo::name))
      fail(fmt::format("was rendered by {}; go on with the same --device", earlier.devices));
    return parse_split(earlier.split);
  }
  const auto own =
      std::ranges::find(devices, earlier.devices, [](const auto* one) { return one->info().name; });
  if (own == devices.end()) fail(fmt::format("was rendered by {}; name it among --device", earlier.devices));
  return {{static_cast<size_t>(own - devices.begin()), {plan.first_sample, samples}}};
}

// As `split_text` says, or by speed what an earlier render has left.
SampleSplit split_of(const render::Plan& plan, const Job& job, std::span<gpu::Device* const> devices,
                     const std::string& split_text) {
  const SampleRange all{plan.first_sample, plan.samples};
  std::vector<Share> earlier;
  if (job.earlier) earlier = shares_of(*job.earlier, job, plan, devices);
  if (split_text.empty()) return {all, devices.size(), std::move(earlier)};
  if (job.time_limit || !earlier.empty())
    throw Error(ErrorCode::BadUsage,
                "--split: repeats a render as a whole; leave out --time, and --resume from a state");
  std::vector<Share> shares = parse_split(split_text);
  require_whole(shares, all, devices.size());
  return {std::move(shares), devices.size()};
}

image::Attributes attributes_of_all(const PreparedScene& prepared, const render::Plan& plan,
                                    std::span<gpu::Device* const> devices, const std::vector<Share>& shares,
                                    Clock::time_point start) {
  uint64_t samples = 0;
  for (const Share& share : shares) samples += share.range.count;
  image::Attributes attributes = scene_attributes(prepared.scene, plan);
  attributes["regulus:device"] = joined(devices, &gpu::DeviceInfo::name);
  attributes["regulus:driver"] = joined(devices, &gpu::DeviceInfo::driver);
  attributes["regulus:rays"] = name_of(render::names::RAYS, plan.rays);
  attributes["regulus:split"] = format_split(shares);
  attributes["regulus:samples_done"] = std::to_string(samples);
  attributes["regulus:render_seconds"] =
      fmt::format("{:.3f}", std::chrono::duration<double>(Clock::now() - start).count());
  return attributes;
}

// `shares` are those of the state that the checkpoint writes.
void keep_if_due(const Crew& crew, uint64_t paths, Checkpoint& checkpoint, std::vector<Share>& shares) {
  if (paths == 0 || !checkpoint.is_due(paths)) return;
  try {
    Done done = crew.done();
    shares = std::move(done.shares);
    checkpoint.update(done.film);
  } catch (const std::bad_alloc&) {
    return;  // there was no room for a second film; it stays due
  }
}

/// Surfaces are those that the first device meets which is left.
void take_channels(const PreparedScene& prepared, const render::Plan& plan, const Crew& crew,
                   Result& result) {
  for (const auto& worker : crew.workers()) {
    if (worker->failure || !worker->renderer) continue;
    if ((plan.aovs & render::SURFACE_AOVS) != 0)
      render::add_surface_channels(worker->renderer->surface_aovs(), plan.aovs, prepared.scene.origin,
                                   result.channels);
    if ((plan.aovs & render::CRYPTO_AOVS) != 0)
      render::add_cryptomattes(prepared.scene, worker->renderer->ray_ids(), plan.aovs, result.channels);
    if ((plan.aovs & render::AOV_SIGMA) != 0)
      render::add_sigma_channels(worker->renderer->surface_footprints(), result.channels);
    break;
  }
  render::add_film_channels(*result.film, plan.aovs, result.channels);
}

void tell_failures(const Crew& crew, Result& result) {
  for (const auto& worker : crew.workers()) {
    if (!worker->failure) continue;
    result.failure = worker->failure;
    if (crew.done_samples() != 0)
      result.warnings.push_back(fmt::format("{}; the other devices go on", worker->failure->what()));
  }
}

}  // namespace

Result render_on_devices(const PreparedScene& prepared, const render::Plan& plan, const Job& job,
                         std::span<gpu::Device* const> devices, const std::string& split_text,
                         Watcher& watcher) {
  require_plain(plan, job);
  require_film_memory(plan.asked, job.holds_sums || !job.checkpoint.empty(), false, job.memory_bytes);
  SampleSplit split = split_of(plan, job, devices, split_text);
  render::Plan own = plan;
  own.rays = job.earlier ? job.earlier->rays : common_rays(prepared, plan, devices);
  const auto start = Clock::now();
  Crew crew(prepared, own, devices, split, watcher, job.time_limit,
            job.earlier ? &job.earlier->film : nullptr);
  const auto attributes_of = [&](const std::vector<Share>& shares) {
    return attributes_of_all(prepared, own, devices, shares, start);
  };
  std::vector<Share> kept;
  Checkpoint checkpoint(
      job.checkpoint, job.checkpoint_seconds,
      [&](const render::Film& film) {
        write_file_atomically(job.checkpoint, encode_part(job.checkpoint, film, ranges_of(kept),
                                                          attributes_of(kept), {}, placement_of(plan)));
      },
      [&](const std::string& text) { watcher.warn(text); });
  watcher.begin();
  crew.run([&](uint64_t samples) { keep_if_due(crew, samples * plan.window().pixels(), checkpoint, kept); });
  watcher.end();

  Result result;
  tell_failures(crew, result);
  Done done = crew.done();
  if (done.film.paths == 0)
    throw result.failure ? *result.failure
                         : Error(ErrorCode::Interrupted, "interrupted before any samples were done");
  kept = done.shares;
  checkpoint.finish(done.film);
  const uint64_t samples = crew.done_samples();
  result.is_complete = samples == plan.samples || crew.is_over();
  if (result.is_complete) result.failure.reset();
  result.film = std::move(done.film);
  result.ranges = ranges_of(done.shares);
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  result.paths = result.film->paths;
  result.placement = placement_of(plan);
  result.attributes = attributes_of(done.shares);
  result.statistics = nlohmann::json(result.attributes);
  result.summary = fmt::format("{}x{}, {} samples per pixel in {:.2f} s on {} devices", plan.window().width,
                               plan.window().height, samples, result.seconds, devices.size());
  take_channels(prepared, plan, crew, result);
  result.image = resolve(*result.film);
  return result;
}

}  // namespace regulus::session
