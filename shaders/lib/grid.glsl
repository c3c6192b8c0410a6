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
  return min(LOAD(WordBuffer, frame.light_vertex_count, LIGHT_COUNT_VERTICES), frame.light_vertex_capacity);
}

// The grid entries of the cells near a point: ranges without duplicates (cells may share a hash).
struct Neighbourhood {
  uint first[8];
  uint count[8];
  uint ranges;
  uint total;
};

Neighbourhood neighbourhood(Frame frame, float merge_radius, vec3 position) {
  ivec3 base = ivec3(floor(grid_position(frame, merge_radius, position) - 0.5));
  Neighbourhood near;
  near.ranges = 0u;
  near.total = 0u;
  for (uint corner = 0u; corner < 8u; ++corner) {
    uint cell = grid_cell(frame, base + ivec3(corner & 1u, corner >> 1u & 1u, corner >> 2u));
    uint first = LOAD(WordBuffer, frame.grid_cells, cell);
    uint count = LOAD(WordBuffer, frame.grid_cells, cell + 1u) - first;
    bool is_new = count > 0u;
    for (uint i = 0u; i < near.ranges; ++i) is_new = is_new && near.first[i] != first;
    if (is_new) {
      near.first[near.ranges] = first;
      near.count[near.ranges] = count;
      near.ranges += 1u;
      near.total += count;
    }
  }
  return near;
}

// Number of units that a vertex with this many light vertices in reach takes.
uint merge_units(uint in_reach) { return (in_reach + MERGE_UNIT - 1u) / MERGE_UNIT; }

#endif
