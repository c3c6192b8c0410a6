// Which light vertices a camera vertex connects to: all of its own light path, or some drawn from all paths.
#ifndef REGULUS_LIB_PAIRS_GLSL
#define REGULUS_LIB_PAIRS_GLSL

#include "lib/rng.glsl"
#include "lib/queue.glsl"

void append_pair(Frame frame, uint slot, uint index, uint edges_and_class) {
  uint light_class = edges_and_class >> LIGHT_VERTEX_CLASS_SHIFT & LIGHT_VERTEX_CLASS_MASK;
  append_connection(max(spec_material_class, light_class), ConnectionPair(slot, index));
}

// The vertices of the path's own light path.
void append_own_pairs(Frame frame, Path path, uint slot) {
  uint head = frame.light_head_modulus == 0u ? slot : (path.number & PATH_NUMBER) % frame.light_head_modulus;
  uint index = LOAD(LightHeadBuffer, frame.light_heads, head).last;
  // A list is no longer than the longest path.
  for (uint i = 0u; i < frame.max_depth && index != INVALID_INDEX; ++i) {
    uint edges = LOAD(LightVertexBuffer, frame.light_vertices, index).edges;
    // The camera's edges, the connection, and the light's edges together.
    if (path.bounce + 2u + (edges & PATH_VERTEX_EDGES) <= frame.max_depth) append_pair(frame, slot, index, edges);
    index = LOAD(LightVertexBuffer, frame.light_vertices, index).previous;
  }
}

// The light path that holds vertex `number` when the vertices are counted path by path: the first whose running
// total exceeds it.
uint light_path_of(Frame frame, uint number) {
  uint low = 0u, high = frame.light_path_count - 1u;
  for (uint i = 0u; i < 32u && low < high; ++i) {
    uint middle = (low + high + 1u) >> 1u;
    if (LOAD(WordBuffer, frame.light_path_ends, middle) <= number)
      low = middle;
    else
      high = middle - 1u;
  }
  return low;
}

// Vertices drawn uniformly from all light paths of the iteration, by their number and not by where they were
// stored: that depends on timing.
void append_cache_pairs(Frame frame, Path path, uint slot) {
  uint cached = LOAD(WordBuffer, frame.light_vertex_count, LIGHT_COUNT_VERTICES);
  if (cached == 0u) return;
  for (uint k = 0u; k < frame.cache_connections; ++k) {
    vec4 u = random_block(frame.seed, path.number & PATH_NUMBER, path.sample_index, DIMENSION_BLOCK_CACHE + path.bounce * 256u + k / 4u);
    uint number = min(uint(u[k % 4u] * float(cached)), cached - 1u);
    uint light_path = light_path_of(frame, number);
    LightPathHead list = LOAD(LightHeadBuffer, frame.light_heads, light_path);
    uint steps = number - LOAD(WordBuffer, frame.light_path_ends, light_path);
    uint index = list.last;
    for (uint i = 0u; i < steps && i < list.count; ++i) index = LOAD(LightVertexBuffer, frame.light_vertices, index).previous;
    uint edges = LOAD(LightVertexBuffer, frame.light_vertices, index).edges;
    if (path.bounce + 2u + (edges & PATH_VERTEX_EDGES) <= frame.max_depth) append_pair(frame, slot, index, edges);
  }
}

void append_pairs(Frame frame, Path path, uint slot) {
  if (frame.cache_connections == 0u)
    append_own_pairs(frame, path, slot);
  else
    append_cache_pairs(frame, path, slot);
}

#endif
