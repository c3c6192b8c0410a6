// Device memory of the wavefront: the arrays of the state table, and the frame that names the address of
// everything.
#pragma once

#include <cstdint>

#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "render/device_scene.hpp"
#include "render/plan.hpp"
#include "render/state.hpp"

namespace regulus::render {

class WavefrontBuffers {
 public:
  /// Allocates for `capacity` path slots. `plan` must outlive the object.
  /// @throws std::logic_error if there are more than most_paths() on this device: then a queue could hold
  /// more than a dispatch runs
  WavefrontBuffers(gpu::Device& device, const DeviceScene& scene, const interface::Camera& camera,
                   const Plan& plan, uint32_t capacity);

  /// Makes room for at least `vertices` light vertices and the pairs of them; what was stored is lost. No
  /// submission may be in flight.
  void grow_light_vertices(gpu::Device& device, uint64_t vertices);

  /// Sets the number of light vertices that connections to the cache expect. No submission may be in flight.
  void expect_light_vertices(gpu::Device& device, uint64_t vertices);

  /// Sets how many light vertices of the cache a camera vertex connects to; 0: those of its own path.
  /// Preconditions: at most the plan's number; no submission is in flight.
  void connect_to_cache(gpu::Device& device, uint32_t connections);

  /// What there is room for.
  const StateSizes& sizes() const { return sizes_; }

  const interface::Frame& frame() const { return frame_; }
  uint32_t grid_cell_count() const { return frame_.grid_cell_mask + 1; }
  interface::DeviceAddress frame_address() const {
    return interface::device_address(frame_buffer_.address());
  }

  // Every array by its name in the table; empty if the plan does not keep it.
#define STATE(name, element, times, per, when) gpu::Buffer name;
#include "interface/state_table.h"
#undef STATE
  gpu::Buffer empty_heads;  ///< what queue_heads hold at the start of a wave

 private:
  template <typename Visit>
  void for_each_array(const Visit& visit);
  void allocate(gpu::Device& device, bool is_by_light_vertex);

  const Plan& plan_;
  StateSizes sizes_;
  interface::Frame frame_ {};
  gpu::Buffer frame_buffer_;
};

}  // namespace regulus::render
