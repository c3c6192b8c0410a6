// Device memory of the wavefront: path slots and queues, the film, light vertices and their grid, and the
// frame that names the address of everything.
#pragma once

#include <cstdint>

#include "gpu/gpu.hpp"
#include "interface/wavefront.h"
#include "render/device_scene.hpp"
#include "render/plan.hpp"

namespace regulus::render {

/// Most connections of one path in a bounce.
uint64_t pairs_per_path(const Plan& plan);

/// Most path slots on a device whose dispatches run so many groups and whose allocations hold so many bytes:
/// no queue holds more items than one dispatch may run, no array is larger than one allocation.
uint64_t most_paths(const Plan& plan, uint64_t most_groups, uint64_t most_bytes);

/// Device bytes of one path slot, over all queues.
uint64_t bytes_per_path(const Plan& plan);

class WavefrontBuffers {
 public:
  /// Allocates for `capacity` path slots.
  WavefrontBuffers(gpu::Device& device, const DeviceScene& scene, const interface::Camera& camera,
                   const Plan& plan, uint32_t capacity);

  /// Makes room for at least `vertices` light vertices; what was stored is lost. No submission may be in
  /// flight.
  void grow_light_vertices(gpu::Device& device, uint64_t vertices);

  /// Sets the number of light vertices that connections to the cache expect. No submission may be in flight.
  void expect_light_vertices(gpu::Device& device, uint64_t vertices);

  uint64_t light_vertex_capacity() const { return frame_.light_vertex_capacity; }
  uint32_t grid_cell_count() const { return frame_.grid_cell_mask + 1; }
  interface::DeviceAddress frame_address() const {
    return interface::device_address(frame_buffer_.address());
  }

  gpu::Buffer queue_heads, empty_heads, film, splat_film, film_earlier, film_squares, aovs, counters;
  gpu::Buffer light_vertex_count;  ///< LIGHT_COUNT_* words
  gpu::Buffer light_path_ends, grid_cells;
  gpu::Buffer path_footprints;
  gpu::Buffer strategy_film;  ///< per strategy a weighted and an unweighted film

 private:
  friend class StageRecorder;  // reads the queues between stages
  friend class HostRays;       // a stage itself
  void create_path_buffers(gpu::Device& device, const Plan& plan);
  void create_media_buffers(gpu::Device& device, const Plan& plan);
  void create_strategy_buffers(gpu::Device& device, const Plan& plan);
  void create_light_buffers(gpu::Device& device, const Plan& plan);

  LightVertexPlan vertex_plan_;
  interface::Frame frame_ {};
  gpu::Buffer frame_buffer_;
  gpu::Buffer paths_, hits_, radiance_, ray_queues_, bounce_queues_, candidates_, splats_, camera_vertices_,
      pairs_, merge_starts_, escaped_;
  gpu::Buffer light_vertices_, light_heads_, grid_ranks_, grid_entries_, light_path_sharp_, strategy_layers_,
      candidate_strategies_, splat_strategies_, light_vertex_sharp_, light_receivers_, path_histories_,
      camera_vertex_histories_, light_vertex_histories_, path_media_, camera_vertex_media_,
      light_vertex_media_, candidate_media_, splat_media_;
};

}  // namespace regulus::render
