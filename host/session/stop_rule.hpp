// When a render stops before all its samples are done.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "render/noise.hpp"

namespace regulus::session {

/// A limit of time, and one of noise after 16 samples of every pixel. The time runs from construction.
class StopRule {
 public:
  /// @param time_limit seconds; none: no limit
  /// @param noise_target relative error; none: it is not followed
  /// @param pixels of the film
  StopRule(std::optional<double> time_limit, std::optional<double> noise_target, uint64_t pixels)
      : time_limit_(time_limit), noise_target_(noise_target), pixels_(pixels) {}

  /// True if `film`, the last state of the film while `paths` are done, is good enough or the time is up.
  bool is_reached(const render::Film& film, uint64_t paths) {
    if (noise_target_) noise_.observe(film);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    is_reached_ =
        is_reached_ || (paths >= pixels_ && time_limit_ && seconds >= *time_limit_) ||
        (noise_target_ && film.paths >= LEAST_SAMPLES * pixels_ && noise_.relative_error() <= *noise_target_);
    return is_reached_;
  }

  bool was_reached() const { return is_reached_; }
  /// Of the last film observed; NaN if the noise was not followed or cannot be told yet.
  double noise() const { return noise_.relative_error(); }

 private:
  // Fewer samples have not met yet what is rare, and do not miss it.
  static constexpr uint64_t LEAST_SAMPLES = 16;

  std::optional<double> time_limit_, noise_target_;
  uint64_t pixels_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  render::NoiseEstimate noise_;
  bool is_reached_ = false;
};

}  // namespace regulus::session
