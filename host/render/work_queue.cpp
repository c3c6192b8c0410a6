#include "render/work_queue.hpp"

#include <algorithm>
#include <chrono>

#include "interface/wavefront.h"

namespace regulus::render {

namespace {

constexpr size_t MOST_IN_FLIGHT = 2;
// A software device has no watchdog; four stages of SOFTWARE_WAVE_PATHS take it .1 to .5 s.
constexpr uint64_t SOFTWARE_ITEMS = uint64_t{1} << 18;
constexpr uint64_t FIRST_ITEMS = uint64_t{1} << 18, MOST_ITEMS = uint64_t{1} << 26;
// A full submission that is shorter than the first doubles the bound, one that is longer than the second
// halves it: far from the 200 ms at which watchdogs of interactive systems become a danger.
constexpr double SHORT_MS = 25, LONG_MS = 100;

double now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

WorkQueue::WorkQueue(gpu::Device& device, uint64_t least_bound, RenderStatistics& statistics)
    : device_(device),
      statistics_(statistics),
      is_software_(device.info().kind == gpu::DeviceKind::Software),
      least_bound_(least_bound),
      most_bound_(uint64_t{device.info().max_groups} * interface::WORKGROUP_SIZE),
      bound_(std::clamp(is_software_ ? SOFTWARE_ITEMS : FIRST_ITEMS, least_bound,
                        std::max(least_bound, most_bound_))) {}

gpu::CommandList& WorkQueue::room_for(uint64_t items) {
  if (recorded_items_ + items > bound_) flush();
  if (!recorded_) recorded_.emplace(device_);
  recorded_items_ += items;
  return *recorded_;
}

void WorkQueue::when_done(std::function<void()> then) {
  if (!recorded_) recorded_.emplace(device_);
  then_.push_back(std::move(then));
}

void WorkQueue::flush() {
  if (!recorded_) return;
  SubmissionStatistics& submissions = statistics_.submissions;
  ++submissions.count;
  submissions.bound_items = std::max(submissions.bound_items, bound_);
  submissions.most_items = std::max(submissions.most_items, recorded_items_);
  if (in_flight_.empty()) last_end_ = now();
  in_flight_.push_back({device_.submit(std::move(*recorded_)), recorded_items_, std::move(then_)});
  recorded_.reset();
  recorded_items_ = 0;
  then_.clear();
  while (in_flight_.size() >= MOST_IN_FLIGHT) wait_for_oldest();
}

void WorkQueue::finish() {
  flush();
  while (!in_flight_.empty()) wait_for_oldest();
}

void WorkQueue::drop() {
  recorded_.reset();
  recorded_items_ = 0;
  then_.clear();
  finish();
}

void WorkQueue::wait_for_oldest() {
  InFlight oldest = std::move(in_flight_.front());
  in_flight_.pop_front();
  double device_ms = 0;
  for (const gpu::StageTime& time : device_.wait(oldest.submission)) {
    StageStatistics& stage = statistics_.stages[time.stage];
    ++stage.dispatches;
    stage.device_ms += time.device_ms;
    device_ms += time.device_ms;
  }
  statistics_.device_seconds += 1e-3 * device_ms;
  statistics_.submissions.longest_ms = std::max(statistics_.submissions.longest_ms, device_ms);
  // The device began this submission when the one before it ended.
  const double end = now();
  adapt(oldest.items, 1e3 * (end - last_end_));
  last_end_ = end;
  for (const std::function<void()>& then : oldest.then) then();
  is_cancelled_ = is_cancelled_ || (wants_to_stop_ && wants_to_stop_());
}

void WorkQueue::adapt(uint64_t items, double milliseconds) {
  if (is_software_ || 2 * items < bound_) return;
  if (milliseconds < SHORT_MS) bound_ = std::min({2 * bound_, MOST_ITEMS, most_bound_});
  if (milliseconds > LONG_MS) bound_ = std::max(bound_ / 2, least_bound_);
}

}  // namespace regulus::render
