// The solids that a path is inside. Where several overlap, the medium is that of the one with the least number: a function
// of the place (host/scene/solids.hpp). Their sets have no order; what does not fit is counted, and the path forgets the
// solids of greatest number, which matter least.
#ifndef REGULUS_LIB_MEDIA_GLSL
#define REGULUS_LIB_MEDIA_GLSL

#include "lib/instances.glsl"
#include "lib/stage.glsl"

// A macro, as those of lib/bsdf_parameters.glsl.
#define has_contacts() ((spec_features & FEATURE_CONTACTS) != 0u)

const MediaSet NO_MEDIA = MediaSet(uvec4(INVALID_INDEX), uvec4(INVALID_INDEX));

bool media_contain(MediaSet set, uint solid) {
  return any(equal(set.a, uvec4(solid))) || any(equal(set.b, uvec4(solid)));
}

MediaSet media_without(MediaSet set, uint solid) {
  return MediaSet(mix(set.a, uvec4(INVALID_INDEX), equal(set.a, uvec4(solid))),
                  mix(set.b, uvec4(INVALID_INDEX), equal(set.b, uvec4(solid))));
}

// Replaces the first of the numbers that equals `number` by `other`. Without a loop, which SwiftShader takes long to compile.
uvec4 replace_first(uvec4 numbers, uint number, uint other) {
  uvec4 same = uvec4(equal(numbers, uvec4(number)));
  uvec4 before = uvec4(0u, same.x, same.x | same.y, same.x | same.y | same.z);
  return mix(numbers, uvec4(other), greaterThan(same, before));
}

void media_replace(inout MediaSet set, uint solid, uint other) {
  bool is_in_a = any(equal(set.a, uvec4(solid)));
  set.a = replace_first(set.a, solid, other);
  set.b = is_in_a ? set.b : replace_first(set.b, solid, other);
}

MediaSet media_with(MediaSet set, uint solid) {
  if (media_contain(set, solid)) return set;
  uvec4 larger = max(set.a, set.b);
  uint greatest = max(max(larger.x, larger.y), max(larger.z, larger.w));  // INVALID_INDEX: there is room
  if (greatest != INVALID_INDEX) count_events(COUNTER_MEDIA_OVERFLOW, 1u);
  if (greatest > solid) media_replace(set, greatest, solid);
  return set;
}

// The solid that decides; INVALID_INDEX: none.
uint media_first(MediaSet set) {
  uvec4 least = min(set.a, set.b);
  return min(min(least.x, least.y), min(least.z, least.w));
}

// Material of the medium; INVALID_INDEX: none.
uint medium_of(Frame frame, MediaSet set) {
  uint first = media_first(set);
  return first == INVALID_INDEX ? INVALID_INDEX : LOAD(SolidBuffer, frame.solids, first).material;
}

// The solid whose boundary a triangle is, or INVALID_INDEX: by the triangle's tag, and by its number.
uint solid_of_tag(uint tag) { return ((tag >> TRIANGLE_TAG_SOLID_SHIFT) & TRIANGLE_TAG_SOLID_MASK) - 1u; }
uint triangle_tag(Frame frame, uint number) {
  if (has_instances() && number >= frame.stored_triangles) return 0u;  // copies bound no solid
  return LOAD(BvhTriangleBuffer, frame.bvh_triangles, number).tag;
}

// True if a path inside of `set` meets no interface at the boundary of `solid`: it is hidden in a medium that decides, or
// both sides are the same.
bool is_passed(DeviceAddress solids, MediaSet set, uint solid) {
  uint other = media_first(media_without(set, solid));
  if (other == INVALID_INDEX) return false;
  return other < solid ||
         LOAD(SolidBuffer, solids, other).substance == LOAD(SolidBuffer, solids, solid).substance;
}

// The set behind the boundary of `solid`.
MediaSet media_behind(MediaSet set, uint solid, bool is_front) {
  return is_front ? media_with(set, solid) : media_without(set, solid);
}

PathMedia start_media(MediaSet set) { return PathMedia(set, vec2(0.0), INVALID_INDEX, INVALID_INDEX); }

// Starts a path in the set of this index, or (MEDIA_VARY) in one that stage start_media finds. `triangle`, unless it is
// INVALID_INDEX, and `barycentrics` say which surface point the path starts at.
void start_in_media(Frame frame, uint set, uint triangle, vec2 barycentrics, uint slot, inout Path path) {
  PathMedia media = start_media(NO_MEDIA);
  path.medium = MEDIA_VARY;
  if (set != MEDIA_VARY) {
    media.around = LOAD(MediaSetBuffer, frame.media_sets, set);
    path.medium = medium_of(frame, media.around);
  }
  media.triangle = triangle;
  media.barycentrics = barycentrics;
  if (triangle != INVALID_INDEX) media.solid = solid_of_tag(triangle_tag(frame, triangle));
  STORE(PathMediaBuffer, frame.path_media, slot, media);
}

#endif
