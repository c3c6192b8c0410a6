// trace_closest: finds what each queued ray hits first and hands the path to the queue of that material class, or, if a
// camera ray meets nothing but the environment, to the queue of those.
// reads  ray queue, paths          writes  hits, bounce queues, escaped paths
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/queue.glsl"
#include "lib/scene_query.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_RAYS)) return;
  uint slot = queued_ray(i);
  Path path = LOAD(PathBuffer, FRAME.paths, slot);
  uint tag;
  vec2 range = WHOLE_RAY;
  if (spec_walk == WALK_CAMERA && stage.bounce == 0u) range = seen_range(path.direction);
  Hit hit;
  if (has_contacts()) {
    PathMedia media = LOAD(PathMediaBuffer, FRAME.path_media, slot);
    hit = closest_through(path.origin, path.direction, range, media, tag);
    STORE(PathMediaBuffer, FRAME.path_media, slot, media);
  } else {
    hit = closest(path.origin, path.direction, range, tag);
  }
  count_overrun();
  if (hit.triangle == INVALID_INDEX) {
    if (has_state(STATE_ESCAPES) && spec_walk == WALK_CAMERA) append_escape(slot);
    return;
  }
  STORE(HitBuffer, FRAME.hits, slot, hit);
  append_arrival(tag & 0xFFu, slot);
}
