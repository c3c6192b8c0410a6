// The film of a render: its sums on the device, and the state of them that the host has last seen.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "render/film.hpp"
#include "render/strategies.hpp"
#include "render/wave_scheduler.hpp"
#include "render/wavefront.hpp"

namespace regulus::render {

class FilmStore {
 public:
  /// `wavefront` must outlive the object.
  FilmStore(Wavefront& wavefront, const scene::FilmExponents& exponents);

  /// The film as of the last snapshot.
  const Film& film() const { return film_; }

  /// The age of the last snapshot counts from now.
  void start_clock() { last_snapshot_ = Clock::now(); }
  /// True if the last snapshot is so old, compared with the time it took, that another one costs little.
  bool is_snapshot_due() const;
  /// Copies the film and the counters to the host, so that what is done survives the device. If the device is
  /// lost on the way nothing changes. @param finished what the device has rendered of it
  void take_snapshot(const WavePaths& finished);

  /// Puts a film onto the device to go on with. Precondition: it is of the same size and has the same parts.
  void restore(const Film& film);

  /// Calls `use` with the images of every strategy that has some, one after the other.
  void for_each_strategy(const std::function<void(const StrategyImages&)>& use) const;

 private:
  using Clock = std::chrono::steady_clock;
  void count_work(const WavePaths& finished, const std::vector<uint32_t>& words);
  std::vector<LightLayer> download_layers() const;
  void upload_layers(const Film& film);
  image::Image strategy_image(const Strategy& strategy, uint64_t index) const;

  Wavefront& wavefront_;
  Film film_;
  Clock::time_point last_snapshot_;
  double snapshot_seconds_;  // what the last one took
};

}  // namespace regulus::render
