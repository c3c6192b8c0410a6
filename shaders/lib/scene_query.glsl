// What rays meet in the scene, the one way to ask for light transport: `closest` and `is_open`. Surfaces with holes, meshes
// stored once for several copies, solids that touch, clipping planes, and who traces the rays (kernels, or the host before
// the stage: host/rays/scene_query.hpp) are behind it; lib/traversal.glsl cannot be included without.
#ifndef REGULUS_LIB_SCENE_QUERY_GLSL
#define REGULUS_LIB_SCENE_QUERY_GLSL

#include "lib/camera.glsl"
// Passes that look at surfaces alone carry no solids; which of two surfaces in one place they meet does not matter to them.
#ifdef SCENE_QUERY_WITHOUT_MEDIA
#include "lib/alpha.glsl"
#include "lib/traversal.glsl"
#else
#include "lib/contacts.glsl"
#endif

// All of a ray but one from a lens, which sees what its clipping planes leave.
const vec2 WHOLE_RAY = vec2(0.0, 3.4e38);
vec2 seen_range(vec3 direction) { return clipped_range(FRAME.camera, direction); }

// What a ray meets with t in (range.x, range.y], and its tag; of number INVALID_INDEX if nothing.
Hit closest(vec3 origin, vec3 direction, vec2 range, out uint tag) {
  if (has_clipping()) origin += range.x * direction;
  Hit hit = trace_closest(FRAME.bvh_nodes, FRAME.bvh_triangles, origin, direction, range.y - range.x, tag);
  if (has_clipping()) hit.t += range.x;
  return hit;
}

#ifndef SCENE_QUERY_WITHOUT_MEDIA

// The same for a ray in media, with FEATURE_CONTACTS: `media` becomes that on arrival.
Hit closest_through(vec3 origin, vec3 direction, vec2 range, inout PathMedia media, out uint tag) {
  if (has_clipping()) origin += range.x * direction;
  Hit hit = trace_through(FRAME, origin, direction, range.y - range.x, media, tag);
  hit.t = max(hit.t, 0.0);
  if (has_clipping()) hit.t += range.x;
  return hit;
}

// Whether nothing lies between the ends of a segment, number `index` of its queue; `media`: the array of what its segments
// start in, with FEATURE_CONTACTS.
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
