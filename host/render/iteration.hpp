// An iteration: all its light paths, the sorting of their vertices, then one sample of every pixel.
#pragma once

#include <cstdint>

#include "render/wave_scheduler.hpp"
#include "render/wavefront.hpp"

namespace regulus::render {

class Iteration {
 public:
  /// Both must outlive the object.
  Iteration(Wavefront& wavefront, WaveScheduler& scheduler) : wavefront_(wavefront), scheduler_(scheduler) {}

  /// Counts the light vertices of the very first iteration, with which connections to the cache reckon in
  /// every iteration and range of samples, and returns their number. Precondition: nothing is in flight.
  uint32_t expect_light_vertices();

  /// The light pass of an iteration: walks its light paths, of which the first `repeated` are on the film
  /// already and only leave vertices, and makes the vertices findable. Returns how many there are.
  uint32_t run_light_pass(uint64_t sample, uint64_t repeated);

  /// The camera pass, from pixel `first` (its place among those rendered) on.
  void run_camera_pass(uint64_t sample, uint64_t first);

  /// Largest number of light vertices that a merge of this iteration can have in reach.
  uint64_t reach() const { return reach_; }

 private:
  void walk_light_paths(uint64_t sample, uint64_t repeated);
  void sort_light_vertices(uint64_t sample);
  uint32_t read_counts();

  Wavefront& wavefront_;
  WaveScheduler& scheduler_;
  uint64_t reach_ = 0;
};

}  // namespace regulus::render
