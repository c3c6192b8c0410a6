// Work on its way to the device, cut into submissions that hold a bounded amount of counted work.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "gpu/gpu.hpp"
#include "render/statistics.hpp"

namespace regulus::render {

/// Records commands and hands them to the device. Work is counted in items: a ray, the shading of a surface,
/// a connection, 32 steps of a merge. Two submissions are in flight at most, so that the device never waits
/// for the host, and a render that is cancelled ends with the second of them.
///
/// Software devices have a fixed bound: nothing there depends on the clock. On others it follows the time
/// that full submissions take, between FIRST_ITEMS at the start and MOST_ITEMS.
class WorkQueue {
 public:
  /// `least_bound`: the bound never falls below it. `statistics` (which outlives the object) gets the times.
  WorkQueue(gpu::Device& device, uint64_t least_bound, RenderStatistics& statistics);

  /// Most items of a submission.
  uint64_t bound() const { return bound_; }

  /// The list on which to record a step of at most `items` items (at most what bound() was when the wave
  /// began). What was recorded before is handed over first if both do not fit into one submission.
  gpu::CommandList& room_for(uint64_t items);

  /// Calls `then` once all that is recorded so far has run.
  void when_done(std::function<void()> then);

  /// Hands over what is recorded.
  void flush();
  /// Hands over what is recorded and waits for everything.
  void finish();
  /// Forgets what is recorded and not handed over, and waits for the rest.
  void drop();

  /// `wants_to_stop` is asked after every submission; once it has said yes, is_cancelled() is true.
  void set_cancellation(std::function<bool()> wants_to_stop) { wants_to_stop_ = std::move(wants_to_stop); }
  bool is_cancelled() const { return is_cancelled_; }

 private:
  struct InFlight {
    gpu::Submission submission;
    uint64_t items;
    std::vector<std::function<void()>> then;
  };
  void wait_for_oldest();
  void adapt(uint64_t items, double milliseconds);

  gpu::Device& device_;
  RenderStatistics& statistics_;
  bool is_software_;
  uint64_t least_bound_, most_bound_, bound_;
  std::optional<gpu::CommandList> recorded_;
  uint64_t recorded_items_ = 0;
  std::vector<std::function<void()>> then_;
  std::deque<InFlight> in_flight_;
  double last_end_ = 0;  // s, of the steady clock
  std::function<bool()> wants_to_stop_;
  bool is_cancelled_ = false;
};

}  // namespace regulus::render
