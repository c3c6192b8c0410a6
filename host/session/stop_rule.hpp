// When a render stops before all its samples are done, and how noisy it is by then.
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
  /// @param noise_target relative error; none: as noisy as it is, which is followed all the same
  /// @param pixels of the film
  StopRule(std::optional<double> time_limit, std::optional<double> noise_target, uint64_t pixels)
      : time_limit_(time_limit), noise_target_(noise_target), pixels_(pixels) {}

  /// True if `film`, the last state of the film while `paths` are done, is good enough or the time is up.
  bool is_reached(const render::Film& film, uint64_t paths) {
    // Without a target states that follow each other closely would cost more than they tell.
    if (noise_target_ || film.paths >= next_observed_) observe(film);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    is_reached_ =
        is_reached_ || (paths >= pixels_ && time_limit_ && seconds >= *time_limit_) ||
        (noise_target_ && film.paths >= LEAST_SAMPLES * pixels_ && noise_.relative_error() <= *noise_target_);
    return is_reached_;
  }

  bool was_reached() const { return is_reached_; }
  /// Of the film as it is when all is rendered.
  double final_noise(const render::Film& film) {
    observe(film);
    return noise();
  }
  /// Relative error of the last film observed (render::NoiseEstimate); NaN if it cannot be told yet.
  double noise() const { return noise_.relative_error(); }

 private:
  // Fewer samples have not met yet what is rare, and do not miss it.
  static constexpr uint64_t LEAST_SAMPLES = 16;

  void observe(const render::Film& film) {
    noise_.observe(film);
    next_observed_ = film.paths + film.paths / 4;
  }

  std::optional<double> time_limit_, noise_target_;
  uint64_t pixels_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
  render::NoiseEstimate noise_;
  uint64_t next_observed_ = 0;
  bool is_reached_ = false;
};

}  // namespace regulus::session
