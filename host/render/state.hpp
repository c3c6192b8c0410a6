// The arrays of the wavefront (shaders/interface/state_table.h) as the host counts them: which of them a plan
// keeps, how large they are, what a path in flight costs, and hence how many paths may be in flight.
#pragma once

#include <array>
#include <cstdint>

#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "render/plan.hpp"

namespace regulus::render {

/// A row of the table.
struct StateArray {
  const char* name;
  uint64_t bytes;  ///< for each of `per`
  uint32_t per;    ///< PER_*
  uint32_t when;   ///< STATE_*
};

inline constexpr std::array STATE_ARRAYS = [] {
  using namespace interface;
  return std::to_array<StateArray>({
#define STATE(name, element, times, per, when) {#name, (times) * sizeof(element), per, when},
#include "interface/state_table.h"
#undef STATE
  });
}();

/// What a wavefront has room for.
struct StateSizes {
  uint64_t paths = 0;           ///< path slots
  uint64_t light_vertices = 0;  ///< of the wave or iteration
  uint64_t pairs = 0;           ///< of camera and light vertices, at one bounce
  uint64_t grid_cells = 0;
};

/// The STATE_* bits that the plan's other choices need.
uint32_t choose_state(const Plan& plan);

/// Largest number of light vertices of one light path.
uint64_t vertices_per_path(const Plan& plan);

/// Whether no two camera paths of a wave connect to the same light path. Their pairs are then no more than
/// the light vertices, which are far fewer than the longest paths could leave.
bool connects_own_paths(const Plan& plan);

/// What arrays are made for: so many path slots, and so many light vertices.
StateSizes sizes_of(const Plan& plan, uint64_t paths, uint64_t light_vertices);

/// Of so many light paths, before any was walked.
uint64_t expected_light_vertices(const Plan& plan, uint64_t light_paths);

/// Bytes of an array; 0 if the plan does not keep it.
uint64_t bytes_of_array(const StateArray& array, const Plan& plan, const StateSizes& sizes);

/// Device bytes of one path slot, over all arrays that grow with the slots; of a wave's own light vertices as
/// many as are expected.
uint64_t bytes_per_path(const Plan& plan);

/// The same of arrays of these sizes, rounded up.
uint64_t bytes_per_path(const Plan& plan, const StateSizes& sizes);

/// Device bytes of a light vertex, with what a path's own pairs take.
uint64_t bytes_per_light_vertex(const Plan& plan);

/// Device bytes of a pixel: over all arrays, and of the largest.
struct PixelBytes {
  uint64_t all, largest;
};
PixelBytes bytes_per_pixel(const Plan& plan);

/// Largest number of path slots on a device with these limits of a dispatch and of an allocation: no queue
/// may hold more items than one dispatch runs, and no array may be larger than one allocation.
uint64_t most_paths(const Plan& plan, uint64_t most_groups, uint64_t most_bytes);

/// Largest number of light vertices of a wave of so many path slots, by the same limits.
uint64_t most_light_vertices(const Plan& plan, uint64_t paths, uint64_t most_groups, uint64_t most_bytes);

/// Number of path slots of a render of `total_paths`, a whole number of groups: as many as the plan or the
/// kind of device asks for, as far as the device's limits and its free memory allow.
/// @throws regulus::Error (Failed) if not even one group of paths is possible
uint32_t choose_capacity(const gpu::DeviceInfo& device, uint64_t free_bytes, const Plan& plan,
                         uint64_t total_paths);

}  // namespace regulus::render
