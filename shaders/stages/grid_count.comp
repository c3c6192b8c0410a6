// grid_count: counts the light vertices of each cell; each takes the next place in its cell. (The places depend on
// timing; sums over a cell do not, see film.glsl.)
// reads  light vertices          writes  grid cells, grid ranks, the size of the most crowded cell
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/grid.glsl"
#include "lib/stage.glsl"

void main() {
  uint i = stage.first_pixel + item_index();
  Frame frame = FRAME;
  if (i >= light_vertex_count(frame)) return;
  vec3 position = LOAD(LightVertexBuffer, frame.light_vertices, i).position;
  uint cell = grid_cell(frame, ivec3(floor(grid_position(frame, stage.merge_radius, position))));
  uint rank = ATOMIC_ADD(frame.grid_cells, cell, 1u);
  STORE(WordBuffer, frame.grid_ranks, i, rank);
  if (rank >= CROWDED_CELL) atomicMax(WordBuffer(frame.light_vertex_count).items[LIGHT_COUNT_CROWD], rank + 1u);
}
