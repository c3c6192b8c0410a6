// Any-hit query of one ray per invocation.
// reads  rays          writes  one word per ray: 1 if it hits
#version 460
#extension GL_GOOGLE_include_directive : require
#include "bench/bench.glsl"

void main() {
  uint i = gl_GlobalInvocationID.x;
  // No early return: see lib/traversal.glsl.
  BenchRay ray = BenchRays(bench.rays).rays[min(i, bench.ray_count - 1u)];
  bool is_hit = trace_any(bench.nodes, bench.triangles, ray.origin, ray.direction, ray.t_max);
  if (i >= bench.ray_count) return;
  BenchWords(bench.results).words[i] = is_hit ? 1u : 0u;
  if (traversal_overrun != 0u) atomicAdd(BenchWords(bench.overruns).words[0], 1u);
}
