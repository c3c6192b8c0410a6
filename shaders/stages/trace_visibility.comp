// trace_visibility: adds the contribution of each candidate whose segment is free to its path.
// reads  candidates          writes  radiance
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/stage.glsl"
#include "lib/traversal.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_VISIBILITY)) return;
  VisibilityCandidate candidate = LOAD(CandidateBuffer, FRAME.candidates, i);
  bool occluded = trace_any(FRAME.bvh_nodes, FRAME.bvh_triangles, candidate.origin, candidate.direction, candidate.t_max);
  if (traversal_overrun != 0u) count_events(COUNTER_TRAVERSAL_OVERRUN, 1u);
  if (occluded) return;
  vec3 radiance = LOAD(Vec3Buffer, FRAME.radiance, candidate.path);
  STORE(Vec3Buffer, FRAME.radiance, candidate.path, radiance + candidate.contribution);
}
