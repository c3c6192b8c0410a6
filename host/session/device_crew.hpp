// Several devices that render ranges of samples of one picture, each in a thread of its own.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "base/error.hpp"
#include "gpu/gpu.hpp"
#include "render/renderer.hpp"
#include "session/render_job.hpp"
#include "session/sample_split.hpp"

namespace regulus::session {

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

/// What a crew has done: sums, and the samples that are in them.
struct Done {
  render::Film film;  ///< without paths if there are no whole samples
  std::vector<Share> shares;
};

/// The render of all devices. What it is made of must outlive it.
class Crew {
 public:
  /// @param time_limit seconds from when the first device is ready; every pixel gets one sample all the same
  /// @param earlier done before, which `split` leaves out; null: nothing
  Crew(const PreparedScene& prepared, const render::Plan& plan, std::span<gpu::Device* const> devices,
       SampleSplit& split, Watcher& watcher, std::optional<double> time_limit, const render::Film* earlier);

  /// Renders until all samples are done, the time is up, all devices are lost or the watcher has cancelled.
  /// Calls `look` now and then, from the thread that called this, with how many samples are done by then.
  void run(const std::function<void(uint64_t samples)>& look);

  uint64_t done_samples() const;
  /// The time is up, and every pixel has a sample.
  bool is_over() const { return is_over_; }
  Done done() const;
  const std::vector<std::unique_ptr<Worker>>& workers() const { return workers_; }

 private:
  using Clock = std::chrono::steady_clock;

  size_t workers_left() const;
  void start_clock();
  double seconds_left() const;
  void work(Worker& worker);
  void render_range(Worker& worker, const SampleRange& range);
  void fail(Worker& worker, const std::optional<SampleRange>& range, const Error& error);
  void watch(const std::function<void(uint64_t samples)>& look);

  const PreparedScene& prepared_;
  const render::Plan& plan_;
  SampleSplit& split_;
  Watcher& watcher_;
  const render::Film* earlier_;
  std::optional<double> time_limit_;
  std::optional<Clock::time_point> end_;  // under mutex_
  bool is_over_ = false;
  std::vector<std::unique_ptr<Worker>> workers_;
  mutable std::mutex done_mutex_;  // films of workers and what the split says of them belong together
  std::atomic<bool> is_cancelled_ = false;
  mutable std::mutex mutex_;
  std::condition_variable ended_;
  size_t running_ = 0;
};

}  // namespace regulus::session
