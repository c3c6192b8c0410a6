// Faults that a test can ask the device layer to pretend, because no test can cause them for real. All off in
// normal use. Internal to host/gpu and its tests.
#pragma once

#include <cstdint>
#include <optional>

namespace regulus::gpu {

/// Each fault stays on until it is switched off.
struct Faults {
  bool lost_at_submit = false;  ///< submitting finds the device lost; nothing is handed to it
  bool lost_at_wait = false;    ///< waiting finds the device lost, after the work has really ended
  bool out_of_memory = false;   ///< the driver has no memory for a buffer
  /// Once this many downloads have ended, waiting finds the device lost. Unset: never.
  std::optional<uint32_t> downloads_before_loss;

  /// Once this many more allocations or submissions were made, the next ones fail as above. Unset: never.
  std::optional<uint32_t> allocations_before_failure, submissions_before_loss;

  /// The only device that submissions_before_loss counts and loses. Null: each.
  const class Device* only_device = nullptr;

  /// Devices that are opened claim to run no more groups in a dispatch. Unset: what they do run.
  std::optional<uint32_t> most_groups;

  /// True if the next wait is to find the device lost.
  bool loses_device_at_wait() const { return lost_at_wait || downloads_before_loss == 0u; }

  /// Counts an event down. @return whether it is to fail
  static bool is_due(std::optional<uint32_t>& events_before) {
    if (!events_before) return false;
    if (*events_before == 0) return true;
    --*events_before;
    return false;
  }
};

/// The faults of this process.
Faults& faults();

}  // namespace regulus::gpu
