// Closest-hit query of one ray per invocation.
// reads  rays          writes  hits
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench/bench.glsl"

void main() {
  uint i = gl_GlobalInvocationID.x;
  // No early return: see lib/traversal.glsl.
  BenchRay ray = BenchRays(bench.rays).rays[min(i, bench.ray_count - 1u)];
  uint tag;
  Hit hit = trace_closest(bench.nodes, bench.triangles, ray.origin, ray.direction, ray.t_max, tag);
  if (i >= bench.ray_count) return;
  BenchHits(bench.results).hits[i] = hit;
  if (traversal_overrun != 0u) atomicAdd(BenchWords(bench.overruns).words[0], 1u);
}
