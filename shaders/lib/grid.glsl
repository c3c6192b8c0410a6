// The merge grid: light vertices sorted by the hash of their cell, whose side is twice the merge radius. All that
// lies within the radius of a point is then in the 2 x 2 x 2 cells nearest to it.
#ifndef REGULUS_LIB_GRID_GLSL
#define REGULUS_LIB_GRID_GLSL

#include "lib/buffers.glsl"

uint grid_cell(Frame frame, ivec3 cell) {
  uvec3 c = uvec3(cell);
  uint hash = (c.x * 73856093u) ^ (c.y * 19349663u) ^ (c.z * 83492791u);
  hash = (hash ^ (hash >> 16u)) * 2246822519u;
  return (hash ^ (hash >> 13u)) & frame.grid_cell_mask;
}

// Position in units of cells.
vec3 grid_position(Frame frame, float merge_radius, vec3 position) {
  return (position - frame.scene_center) / (2.0 * merge_radius);
}

// Light vertices stored.
uint light_vertex_count(Frame frame) {
  return min(LOAD(WordBuffer, frame.light_vertex_count, 0u), frame.light_vertex_capacity);
}

// A cell with more light vertices than this is reported, so that the host may dispatch further merge rounds.
const uint CROWDED_CELL = MERGE_ROUND_LENGTH / 16u;

#endif
