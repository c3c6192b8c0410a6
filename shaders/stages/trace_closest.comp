// trace_closest: finds what each queued ray hits first and hands the path to the queue of that material class, or, if a
// camera ray meets nothing but the environment, to the queue of those.
// reads  ray queue, paths          writes  hits, bounce queues, escaped paths
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera.glsl"
#include "lib/contacts.glsl"
#include "lib/stage.glsl"

bool meets_environment() {
  // One by one: glslang 12.0 writes invalid SPIR-V for the conjunction of three such constants.
  if ((spec_features & FEATURE_ENVIRONMENT) == 0u) return false;
  if ((spec_techniques & TECHNIQUE_HIT) == 0u) return false;
  return spec_walk == WALK_CAMERA;
}

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_RAYS)) return;
  uint slot = LOAD(WordBuffer, FRAME.ray_queues, ray_queue_base(stage.bounce) + i);
  Path path = LOAD(PathBuffer, FRAME.paths, slot);
  uint tag;
  vec2 range = vec2(0.0, 3.4e38);
  if (spec_walk == WALK_CAMERA && stage.bounce == 0u) range = clipped_range(FRAME.camera, path.direction);
  if (has_clipping()) path.origin += range.x * path.direction;
  Hit hit;
  if (has_contacts()) {
    PathMedia media = LOAD(PathMediaBuffer, FRAME.path_media, slot);
    hit = trace_through(FRAME, path.origin, path.direction, range.y - range.x, media, tag);
    hit.t = max(hit.t, 0.0);
    STORE(PathMediaBuffer, FRAME.path_media, slot, media);
  } else {
    hit = trace_closest(FRAME.bvh_nodes, FRAME.bvh_triangles, path.origin, path.direction, range.y - range.x, tag);
  }
  if (has_clipping()) hit.t += range.x;
  if (traversal_overrun != 0u) count_events(COUNTER_TRAVERSAL_OVERRUN, 1u);
  if (hit.triangle == INVALID_INDEX) {
    if (meets_environment()) {
      uint escaped = queue_reserve(queue_head(QUEUE_ESCAPED));
      STORE(WordBuffer, FRAME.escaped, escaped, slot);
    }
    return;
  }
  STORE(HitBuffer, FRAME.hits, slot, hit);
  uint material_class = tag & 0xFFu;
  uint index = queue_reserve(queue_head(QUEUE_BOUNCE + material_class));
  STORE(WordBuffer, FRAME.bounce_queues, material_class * FRAME.wave_capacity + index, slot);
}
