// grid_scatter: writes each light vertex to its place in the grid.
// reads  light vertices, grid cells (scanned), grid ranks          writes  grid entries
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
  uint place = LOAD(WordBuffer, frame.grid_cells, cell) + LOAD(WordBuffer, frame.grid_ranks, i);
  STORE(GridEntryBuffer, frame.grid_entries, place, GridEntry(position, i));
}
