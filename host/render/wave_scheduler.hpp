// Hands out waves of paths until a range of them is done, or the render is to stop.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "render/wavefront.hpp"

namespace regulus::render {

/// Paths of a wave, or of waves.
struct WavePaths {
  uint64_t camera = 0, light = 0;
};

class WaveScheduler {
 public:
  /// `wavefront` must outlive the object. `goes_on` is asked after each wave; once it says no, no more waves
  /// begin.
  WaveScheduler(Wavefront& wavefront, std::function<bool()> goes_on)
      : wavefront_(wavefront), goes_on_(std::move(goes_on)) {}

  /// Runs waves over the paths [begin, end). `run` takes the wave [first, first + paths) through its passes
  /// and returns how many paths of each kind it holds, or nothing if it was given up. At most two submissions
  /// are under way, so that the device never waits. `reach`: light vertices in reach of a merge, at most.
  using RunWave = std::function<std::optional<WavePaths>(uint64_t first, uint32_t paths)>;
  void run(uint64_t begin, uint64_t end, uint64_t reach, const RunWave& run_wave);

  bool is_running() const { return is_running_; }
  void set_running(bool is_running) { is_running_ = is_running; }

  /// False if the device's film holds parts of a wave that was given up.
  bool is_film_whole() const { return is_film_whole_; }

  /// Paths whose waves have run.
  const WavePaths& finished() const { return finished_; }
  void set_finished(const WavePaths& finished) { finished_ = finished; }

 private:
  uint64_t next_wave_paths(uint64_t reach) const;
  void give_up_wave();

  Wavefront& wavefront_;
  std::function<bool()> goes_on_;
  WavePaths finished_;
  bool is_first_wave_ = true, is_running_ = true, is_film_whole_ = true;
};

}  // namespace regulus::render
