// A wave that is complete in itself: light paths, if any, then as many camera paths, each of which connects
// to the vertices of its own light path.
#pragma once

#include <cstdint>

#include "render/wavefront.hpp"

namespace regulus::render {

class PairedWave {
 public:
  /// `wavefront` must outlive the object.
  explicit PairedWave(Wavefront& wavefront) : wavefront_(wavefront) {}

  /// Runs `paths` paths of either kind from pixel `first` of a sample on. Where their light paths leave more
  /// vertices than there is room for, room is made, or else, at the device's limits, the wave is cut in two.
  /// Returns false if it was given up.
  bool run(uint64_t first, uint64_t sample, uint32_t paths);

 private:
  bool run(uint64_t first, uint64_t sample, uint32_t paths, bool is_repeated);
  bool walk_light_paths(uint64_t first, uint64_t sample, uint32_t paths, bool is_repeated);
  void make_room(uint64_t vertices);
  uint64_t most_vertices() const;
  uint32_t stored_vertices() const;

  Wavefront& wavefront_;
  uint64_t vertices_ = 0, paths_ = 0;  // of all waves so far
};

}  // namespace regulus::render
