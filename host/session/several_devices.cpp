#include "session/several_devices.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <new>
#include <thread>

#include "base/error.hpp"
#include "render/aov.hpp"
#include "render/film_file.hpp"
#include "render/names.hpp"
#include "render/rays_choice.hpp"
#include "session/film_memory.hpp"
#include "session/record.hpp"
#include "session/sample_split.hpp"

namespace regulus::session {

namespace {

using Clock = std::chrono::steady_clock;

void require_plain(const render::Plan& plan, const Job& job) {
  if (job.time_limit || job.noise_target || !job.checkpoint.empty() || job.earlier ||
      plan.has_strategy_images)
    throw Error(
        ErrorCode::BadUsage,
        "--device: a time limit, a noise target, checkpoints and strategy images need one device; give "
        "several a number of samples");
}

// Who traces rays decides ties, so all devices do it alike.
uint32_t common_rays(const PreparedScene& prepared, const render::Plan& plan,
                     std::span<gpu::Device* const> devices) {
  const uint32_t first = render::resolve_rays(devices.front()->info(), prepared, plan);
  for (const gpu::Device* device : devices)
    if (render::resolve_rays(device->info(), prepared, plan) != first) return interface::RAYS_SOFTWARE;
  return first;
}

/// A device and what it has done. One thread at a time uses it.
struct Worker {
  gpu::Device* device;
  size_t place;
  std::unique_ptr<render::Renderer> renderer{};
  render::Film film{};  ///< of whole ranges
  std::atomic<uint64_t> paths{0};
  std::optional<Error> failure{};

  Worker(gpu::Device* device_in, size_t place_in) : device(device_in), place(place_in) {}
};

/// The render of all devices.
class Crew {
 public:
  Crew(const PreparedScene& prepared, const render::Plan& plan, std::span<gpu::Device* const> devices,
       SampleSplit& split, Watcher& watcher)
      : prepared_(prepared), plan_(plan), split_(split), watcher_(watcher) {
    for (gpu::Device* device : devices) workers_.push_back(std::make_unique<Worker>(device, workers_.size()));
  }

  /// Until all samples are done, all devices are lost or the watcher has cancelled.
  void run() {
    while (!is_cancelled_ && done_samples() < plan_.samples && has_workers()) {
      std::vector<std::jthread> threads;
      running_ = 0;
      for (const auto& worker : workers_) {
        if (worker->failure) continue;
        ++running_;
        threads.emplace_back([this, &worker = *worker] { work(worker); });
      }
      watch();
    }
  }

  uint64_t done_samples() const {
    uint64_t samples = 0;
    for (const Share& share : split_.finished()) samples += share.range.count;
    return samples;
  }
  const std::vector<std::unique_ptr<Worker>>& workers() const { return workers_; }

 private:
  bool has_workers() const {
    return std::ranges::any_of(workers_, [](const auto& worker) { return !worker->failure; });
  }

  void work(Worker& worker) {
    std::optional<SampleRange> range;
    try {
      if (!worker.renderer)
        worker.renderer = std::make_unique<render::Renderer>(*worker.device, prepared_, plan_);
      while (!is_cancelled_ && (range = split_.take(worker.place))) render_range(worker, *range);
    } catch (const Error& error) {
      fail(worker, range, error);
    } catch (const std::bad_alloc&) {
      fail(worker, range, Error(ErrorCode::Failed, "out of memory"));
    }
    const std::lock_guard lock(mutex_);
    --running_;
    ended_.notify_all();
  }

  void render_range(Worker& worker, const SampleRange& range) {
    const auto begin = Clock::now();
    worker.renderer->continue_with(static_cast<uint32_t>(range.first), static_cast<uint32_t>(range.count));
    worker.renderer->render(
        [&](uint64_t done, uint64_t) {
          worker.paths = done;
          return !is_cancelled_;
        },
        [&] { return is_cancelled_.load(); });
    if (is_cancelled_) return;  // half a range is none
    worker.film = worker.renderer->film();
    worker.paths = worker.film.paths;
    split_.finish(worker.place, range, std::chrono::duration<double>(Clock::now() - begin).count());
  }

  void fail(Worker& worker, const std::optional<SampleRange>& range, const Error& error) {
    worker.failure = error;
    worker.paths = worker.film.paths;
    split_.lose(worker.place, range);
  }

  // Tells the watcher how far all are, in its own thread, until the devices have nothing left to do.
  void watch() {
    constexpr auto INTERVAL = std::chrono::milliseconds(50);
    const uint64_t total = plan_.window().pixels() * plan_.samples;
    std::unique_lock lock(mutex_);
    while (!ended_.wait_for(lock, INTERVAL, [this] { return running_ == 0; })) {
      lock.unlock();
      uint64_t paths = 0;
      for (const auto& worker : workers_) paths += worker->paths;
      watcher_.progress({std::min(paths, total), total});
      if (watcher_.is_cancelled()) is_cancelled_ = true;
      lock.lock();
    }
  }

  const PreparedScene& prepared_;
  const render::Plan& plan_;
  SampleSplit& split_;
  Watcher& watcher_;
  std::vector<std::unique_ptr<Worker>> workers_;
  std::atomic<bool> is_cancelled_ = false;
  std::mutex mutex_;
  std::condition_variable ended_;
  size_t running_ = 0;
};

// Of all devices; without paths if there are no whole samples.
render::Film sum_of(const Crew& crew) {
  render::Film sum;
  for (const auto& worker : crew.workers()) {
    if (worker->film.paths == 0) continue;
    if (sum.paths == 0)
      sum = worker->film;
    else
      render::add(sum, worker->film);
  }
  return sum;
}

/// Values of all devices by name, in their order, each once.
std::string joined(const Crew& crew, std::string gpu::DeviceInfo::*member) {
  std::vector<std::string> names;
  for (const auto& worker : crew.workers()) {
    const std::string& name = worker->device->info().*member;
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, "; "));
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
  require_film_memory(plan.asked, job.holds_sums, false, job.memory_bytes);
  const SampleRange all{plan.first_sample, plan.samples};
  std::vector<Share> shares;
  if (!split_text.empty()) {
    shares = parse_split(split_text);
    require_whole(shares, all, devices.size());
  }
  SampleSplit split = shares.empty() ? SampleSplit(all, devices.size()) : SampleSplit(shares, devices.size());
  render::Plan own = plan;
  own.rays = common_rays(prepared, plan, devices);
  const auto start = Clock::now();
  Crew crew(prepared, own, devices, split, watcher);
  watcher.begin();
  crew.run();
  watcher.end();

  Result result;
  tell_failures(crew, result);
  result.film = sum_of(crew);
  if (result.film->paths == 0)
    throw result.failure ? *result.failure
                         : Error(ErrorCode::Interrupted, "interrupted before any samples were done");
  const uint64_t samples = crew.done_samples();
  if (samples == plan.samples) result.failure.reset();
  result.seconds = std::chrono::duration<double>(Clock::now() - start).count();
  result.paths = result.film->paths;
  result.is_complete = samples == plan.samples;
  result.placement = placement_of(plan);
  result.attributes = scene_attributes(prepared.scene, own);
  result.attributes["regulus:device"] = joined(crew, &gpu::DeviceInfo::name);
  result.attributes["regulus:driver"] = joined(crew, &gpu::DeviceInfo::driver);
  result.attributes["regulus:rays"] = name_of(render::names::RAYS, own.rays);
  result.attributes["regulus:split"] = format_split(split.finished());
  result.attributes["regulus:samples_done"] = std::to_string(samples);
  result.attributes["regulus:render_seconds"] = fmt::format("{:.3f}", result.seconds);
  result.statistics = nlohmann::json(result.attributes);
  result.summary = fmt::format("{}x{}, {} samples per pixel in {:.2f} s on {} devices", plan.window().width,
                               plan.window().height, samples, result.seconds, devices.size());
  take_channels(prepared, plan, crew, result);
  result.image = resolve(*result.film);
  return result;
}

}  // namespace regulus::session
