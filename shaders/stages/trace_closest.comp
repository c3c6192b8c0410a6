// trace_closest: finds what each queued ray hits first and hands the path to the queue of that material class.
// reads  ray queue, paths          writes  hits, bounce queues
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/stage.glsl"
#include "lib/traversal.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_RAYS)) return;
  uint slot = LOAD(WordBuffer, FRAME.ray_queues, ray_queue_base(stage.bounce) + i);
  Path path = LOAD(PathBuffer, FRAME.paths, slot);
  uint tag;
  Hit hit = trace_closest(FRAME.bvh_nodes, FRAME.bvh_triangles, path.origin, path.direction, 3.4e38, tag);
  if (traversal_overrun != 0u) count_events(COUNTER_TRAVERSAL_OVERRUN, 1u);
  if (hit.triangle == INVALID_INDEX) return;
  STORE(HitBuffer, FRAME.hits, slot, hit);
  uint material_class = tag & 0xFFu;
  uint index = queue_reserve(queue_head(QUEUE_BOUNCE + material_class));
  STORE(WordBuffer, FRAME.bounce_queues, material_class * FRAME.wave_capacity + index, slot);
}
