#include "render/iteration.hpp"

#include <algorithm>

namespace regulus::render {

using namespace interface;

uint32_t Iteration::expect_light_vertices() {
  walk_light_paths(0, wavefront_.plan.light_paths);
  const uint32_t vertices = read_counts();
  wavefront_.buffers.expect_light_vertices(wavefront_.device, vertices);
  return vertices;
}

// Nothing is read back before the whole pass is under way. If not all vertices could be stored, the walk is
// repeated with room for them; it stores and splats the same every time.
uint32_t Iteration::run_light_pass(uint64_t sample, uint64_t repeated) {
  const Plan& plan = wavefront_.plan;
  WavefrontBuffers& buffers = wavefront_.buffers;
  walk_light_paths(sample, repeated);
  if (!scheduler_.is_running() || !plan.keeps(STATE_VERTICES)) return 0;
  sort_light_vertices(sample);
  uint32_t vertices = read_counts();
  if (vertices > buffers.frame().light_vertex_capacity) {
    buffers.grow_light_vertices(wavefront_.device, vertices + uint64_t{vertices} / 4);
    walk_light_paths(sample, plan.light_paths);
    if (!scheduler_.is_running()) return 0;
    sort_light_vertices(sample);
    vertices = read_counts();
  }
  return vertices;
}

void Iteration::walk_light_paths(uint64_t sample, uint64_t repeated) {
  const gpu::Buffer& count = wavefront_.buffers.light_vertex_count;
  wavefront_.work.room_for(1).fill(count, 0, count.size(), 0);
  const auto walk = [&](uint64_t begin, uint64_t end, bool is_repeated) {
    scheduler_.run(begin, end, 0, [&](uint64_t first, uint32_t paths) -> std::optional<WavePaths> {
      StageArguments arguments = wavefront_.arguments_of(first, sample, paths);
      arguments.is_repeated = is_repeated ? 1 : 0;
      if (!wavefront_.core.run(Pass::Light, arguments)) return std::nullopt;
      return WavePaths{0, is_repeated ? 0 : paths};
    });
  };
  walk(0, repeated, true);
  walk(repeated, wavefront_.plan.light_paths, false);
}

// Sorts the light vertices, so that they can be found by place and by number. The device knows how many there
// are; stages are dispatched for as many as there is room for.
void Iteration::sort_light_vertices(uint64_t sample) {
  const Plan& plan = wavefront_.plan;
  const WavefrontBuffers& buffers = wavefront_.buffers;
  const StageArguments arguments = wavefront_.arguments_of(0, sample, 0);
  if (plan.keeps(STATE_CACHE)) {
    wavefront_.run_over(Pass::Cache, Stage::LightPathCounts, arguments, plan.light_paths);
    wavefront_.run_scan(Pass::Cache, arguments, buffers.light_path_ends, plan.light_paths);
  }
  if (!plan.keeps(STATE_MERGES)) return;
  const uint64_t vertices = buffers.frame().light_vertex_capacity;
  wavefront_.work.room_for(1).fill(buffers.grid_cells, 0, buffers.grid_cells.size(), 0);
  wavefront_.run_over(Pass::Grid, Stage::GridCount, arguments, vertices);
  wavefront_.run_scan(Pass::Grid, arguments, buffers.grid_cells, buffers.grid_cell_count() + 1);
  wavefront_.run_over(Pass::Grid, Stage::GridScatter, arguments, vertices);
}

// Reads how many light vertices there are, and how many of them may be in reach of a merge.
uint32_t Iteration::read_counts() {
  wavefront_.work.finish();
  const auto words = gpu::download_all<uint32_t>(wavefront_.device, wavefront_.buffers.light_vertex_count,
                                                 LIGHT_COUNT_WORDS);
  const uint32_t vertices = words[LIGHT_COUNT_VERTICES];
  // A merge looks at eight cells.
  const uint64_t crowd = std::max(words[LIGHT_COUNT_CROWD], CROWDED_CELL);
  reach_ = wavefront_.plan.keeps(STATE_MERGES) ? std::min<uint64_t>(vertices, 8 * crowd) : 0;
  return vertices;
}

void Iteration::run_camera_pass(uint64_t sample, uint64_t first_pixel) {
  scheduler_.run(first_pixel, wavefront_.pixels, reach_,
                 [&](uint64_t first, uint32_t paths) -> std::optional<WavePaths> {
                   const StageArguments arguments = wavefront_.arguments_of(first, sample, paths);
                   if (!wavefront_.core.run(Pass::Camera, arguments, reach_)) return std::nullopt;
                   return WavePaths{paths, 0};
                 });
}

}  // namespace regulus::render
