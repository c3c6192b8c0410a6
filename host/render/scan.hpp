// Exclusive prefix sums on the device.
#pragma once

#include <cstdint>

#include "gpu/gpu.hpp"

namespace regulus::render {

/// Replaces words by the sum of the words before them, in levels of SCAN_FAN.
class Scan {
 public:
  explicit Scan(gpu::Device& device);

  /// Words a buffer needs for a scan of `count` words: the sums of the levels stand behind them.
  static uint64_t words_needed(uint64_t count);

  /// Records the scan of the first `count` words (below 2^31) of a buffer of words_needed(count) words.
  void record(gpu::CommandList& commands, const gpu::Buffer& words, uint32_t count) const;

 private:
  gpu::Kernel sums_, spread_;
  uint64_t most_groups_;  // of a dispatch
};

}  // namespace regulus::render
