// What rays meet in the scene: `closest` and `is_open` are the only ways in which light transport asks. Behind them are
// surfaces with holes, meshes stored once for several copies, solids that touch, clipping planes, and who traces the rays
// (kernels; with REGULUS_RAY_QUERY the device's own queries: lib/hardware_query.glsl; or the host before the stage:
// host/rays/scene_query.hpp). lib/traversal.glsl cannot be included without this.
#ifndef REGULUS_LIB_SCENE_QUERY_GLSL
#define REGULUS_LIB_SCENE_QUERY_GLSL

#include "lib/camera.glsl"
// Passes that only look at surfaces carry no solids, and do not care which of two surfaces in one place they meet.
#ifdef SCENE_QUERY_WITHOUT_MEDIA
#include "lib/alpha.glsl"
#include "lib/traversal.glsl"
#else
#include "lib/contacts.glsl"
#endif

// The range of every ray except those from a lens, which see what lies between the clipping planes.
const vec2 WHOLE_RAY = vec2(0.0, 3.4e38);
vec2 seen_range(vec3 direction) { return clipped_range(FRAME.camera, direction); }

// What a ray meets first with t in (range.x, range.y], and its tag; the triangle is INVALID_INDEX if it meets nothing.
Hit closest(vec3 origin, vec3 direction, vec2 range, out uint tag) {
  if (has_clipping()) origin += range.x * direction;
  Hit hit = trace_closest(FRAME.bvh_nodes, FRAME.bvh_triangles, origin, direction, range.y - range.x, tag);
  if (has_clipping()) hit.t += range.x;
  return hit;
}

#ifndef SCENE_QUERY_WITHOUT_MEDIA

// The same for a ray in media (FEATURE_CONTACTS): `media` becomes what surrounds the ray on arrival.
Hit closest_through(vec3 origin, vec3 direction, vec2 range, inout PathMedia media, out uint tag) {
  if (has_clipping()) origin += range.x * direction;
  Hit hit = trace_through(FRAME, origin, direction, range.y - range.x, media, tag);
  hit.t = max(hit.t, 0.0);
  if (has_clipping()) hit.t += range.x;
  return hit;
}

// True if nothing lies between the ends of a segment, which is item `index` of its queue. `media`: with FEATURE_CONTACTS, the
// array of what that queue's segments start in.
bool is_open(VisibilityCandidate segment, DeviceAddress media, uint index) {
  if (spec_rays == RAYS_HOST) return !(segment.t_max < 0.0);
  if (has_contacts()) return !is_segment_occluded(FRAME, segment, LOAD(PathMediaBuffer, media, index));
  return !trace_any(FRAME.bvh_nodes, FRAME.bvh_triangles, segment.origin, segment.direction, segment.t_max);
}

#endif

// Counts a ray whose traversal was given up.
void count_overrun() {
  if (traversal_overrun != 0u) count_events(COUNTER_TRAVERSAL_OVERRUN, 1u);
}

#endif
