// Handing command lists to the device, waiting for them, and what happens if the device is lost.
#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "gpu/faults.hpp"
#include "gpu/limits.hpp"
#include "gpu/state.hpp"

namespace regulus::gpu {
namespace {

[[noreturn]] void throw_failed(const DeviceState& state, const char* doing, const vk::SystemError& error) {
  throw Error(ErrorCode::Failed,
              fmt::format("device {} failed while {} ({}); render a smaller image or scene",
                          state.info().name, doing, error.what()));
}

/// All timestamps of a submission in ticks, each followed by whether it was written.
struct Timestamp {
  uint64_t ticks = 0;
  uint64_t is_written = 0;
};

std::vector<Timestamp> read_timestamps(const Recording& recording, uint32_t count) {
  std::vector<Timestamp> all(count);
  for (uint32_t first = 0; first < count; first += TIMESTAMPS_PER_POOL) {
    const uint32_t here = std::min(TIMESTAMPS_PER_POOL, count - first);
    const vk::raii::QueryPool& pool = recording.timestamps[first / TIMESTAMPS_PER_POOL];
    const auto [status, values] =
        pool.getResults<Timestamp>(0, here, here * sizeof(Timestamp), sizeof(Timestamp),
                                   vk::QueryResultFlagBits::e64 | vk::QueryResultFlagBits::eWithAvailability);
    std::copy(values.begin(), values.end(), all.begin() + first);
  }
  return all;
}

}  // namespace

Submission::Submission() = default;
Submission::~Submission() = default;
Submission::Submission(Submission&&) noexcept = default;
Submission& Submission::operator=(Submission&&) noexcept = default;

Submission::Impl::~Impl() {
  if (!recording) return;
  try {
    if (!state->is_lost) wait();
  } catch (const std::exception&) {
    state->is_lost = true;  // the next use of the device reports it
  }
}

int Submission::Impl::completed_stages() const {
  try {
    const std::vector<Timestamp> written = read_timestamps(*recording, timestamps);
    int completed = 0;
    for (const TimedStage& time : times) completed += written[time.end].is_written != 0;
    return times.empty() ? -1 : completed;
  } catch (const vk::SystemError&) {
    return -1;  // a lost device need not tell
  }
}

void Submission::Impl::wait() {
  try {
    const vk::Result status = state->device.waitForFences(*recording->fence, true, UINT64_MAX);
    if (faults().loses_device_at_wait()) state->device.waitIdle();  // nothing runs on a device that is lost
    if (status != vk::Result::eSuccess || faults().loses_device_at_wait()) throw vk::DeviceLostError("wait");
  } catch (const vk::DeviceLostError&) {
    state->throw_lost(stages, completed_stages());
  } catch (const vk::SystemError& error) {
    throw_failed(*state, "waiting", error);
  }
}

std::vector<StageTime> Submission::Impl::stage_times() const {
  std::vector<StageTime> result(stages.size());
  for (size_t i = 0; i < stages.size(); ++i) result[i].stage = stages[i];
  if (times.empty()) return result;

  const uint32_t bits = state->chosen.timestamp_bits;
  const uint64_t mask = bits >= 64 ? ~uint64_t{0} : (uint64_t{1} << bits) - 1;
  const std::vector<Timestamp> written = read_timestamps(*recording, timestamps);
  for (size_t i = 0; i < times.size(); ++i) {
    const uint64_t ticks = (written[times[i].end].ticks - written[times[i].begin].ticks) & mask;
    result[i].device_ms = static_cast<double>(ticks) * state->info().timestamp_ns * 1e-6;
  }
  return result;
}

Submission Device::submit(CommandList&& commands) {
  CommandList::Impl& list = *commands.impl;
  DeviceState& state = *impl->state;
  if (state.is_lost) state.throw_lost(list.stages, -1);
  try {
    if (info().kind == DeviceKind::Software) list.publish_to_host();
    list.recording->commands.end();
    const bool is_meant = faults().only_device == nullptr || faults().only_device == this;
    if (faults().lost_at_submit || (is_meant && Faults::is_due(faults().submissions_before_loss)))
      throw vk::DeviceLostError("submit");
    state.device.resetFences(*list.recording->fence);
    state.queue.submit(vk::SubmitInfo({}, {}, *list.recording->commands), *list.recording->fence);
  } catch (const vk::DeviceLostError&) {
    state.throw_lost(list.stages, -1);
  } catch (const vk::SystemError& error) {
    throw_failed(state, "submitting", error);
  }
  Submission submission;
  submission.impl.reset(new Submission::Impl{list.state, std::move(list.recording), std::move(list.stages),
                                             std::move(list.times), list.timestamps});
  return submission;
}

std::vector<StageTime> Device::wait(Submission& submission) {
  if (!submission.impl) return {};
  const std::unique_ptr<Submission::Impl> done = std::move(submission.impl);
  done->wait();
  std::vector<StageTime> times = done->stage_times();
  impl->state->idle.push_back(std::move(done->recording));
  return times;
}

}  // namespace regulus::gpu
