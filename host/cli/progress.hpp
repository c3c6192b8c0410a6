// A progress line on a terminal: share done, rate, time left.
#pragma once

#include <chrono>
#include <cstdint>

namespace regulus::cli {

/// Draws on stderr, at most a few times a second, and only if stderr is a terminal.
class ProgressLine {
 public:
  explicit ProgressLine(bool enabled);
  ~ProgressLine();
  void update(uint64_t paths_done, uint64_t paths_total);

 private:
  bool enabled_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_, last_;
};

}  // namespace regulus::cli
