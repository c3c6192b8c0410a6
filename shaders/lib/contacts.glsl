// Rays among surfaces that touch (FEATURE_CONTACTS). Which of two surfaces in one place comes first is lost in rounding;
// three rules decide it, the same whichever way a path is walked:
// - A closed solid is entered only from outside and left only from inside; hits of its boundary that contradict this do not
//   count. So nothing is met twice or left out, however near two faces are to each other.
// - What comes within a few roundings is met in this order: what emits towards the ray, then other fronts, then other backs
//   of surfaces that are no boundary of a solid, what enters a solid, what leaves one. So a lamp in the plane of a ceiling
//   shines, a leaf of two faces has both, and two blocks that share a face have no air between them.
// - Of surfaces of the same kind that are no boundaries, the one with the least number is met. Of boundaries that are entered,
//   that of the deciding solid comes first; of boundaries that are left, it comes last: so it hides the others.
// Rays leave the boundary of a closed solid from where it is; the first rule is all they need. All others start off their
// surface (offset_origin) and do not meet their own triangle.
// Include this before lib/traversal.glsl.
#ifndef REGULUS_LIB_CONTACTS_GLSL
#define REGULUS_LIB_CONTACTS_GLSL

#include "lib/alpha.glsl"
#include "lib/media.glsl"

// State of the ray that is being traced, lengths in units of its t.
struct ContactRay {
  MediaSet around;
  float from;         // surfaces before this t have been dealt with
  uint crossed;       // the solid whose boundary lies there, or INVALID_INDEX
  uint left;          // the solid whose boundary the ray starts on
  uint triangle;      // the triangle that it starts on
  float coordinates;  // largest coordinate of the origin
  float t_max;
  bool is_blind;      // meets boundaries of closed solids only, to find what holds its start: `around` is what it has entered
  MediaSet holding;   // with is_blind: what it has left without having entered it
  DeviceAddress solids;
};
ContactRay contact;

const float CONTACT_ERROR = float(CONTACT_ROUNDINGS) * FLOAT_EPSILON;
// Distances along a surface's normal become distances along the ray by the cosine between them, but at least this.
const float CONTACT_MIN_COS = 1.0 / 16.0;
// The second rule takes surfaces for nearer by this many errors.
const float CONTACT_EMITTER = 2.0, CONTACT_FRONT = 1.5, CONTACT_BACK = 1.0, CONTACT_ENTRY = 0.5;
// Surfaces of the same kind whose values differ by less than this, in errors, are in one place.
const float CONTACT_TIE = 0.2;
// How far before the last surface another may lie that is still to be met, in errors.
const float CONTACT_BEHIND = 1.0;
// How many errors behind another a surface may lie that is met before it: the greatest rank and the tie.
const float CONTACT_REACH = CONTACT_EMITTER + CONTACT_TIE;

// The error of a distance along the normal at a hit.
float contact_error(float t) { return CONTACT_ERROR * (contact.coordinates + abs(t)); }

// How much larger than that of another the t of a hit may be that is met first; also how far behind its origin a ray looks.
float contact_reach(float t) { return CONTACT_REACH / CONTACT_MIN_COS * contact_error(t); }

// The third rule: the lower number is met first.
uint contact_order(uint tag, uint number, float cosine) {
  uint solid = solid_of_tag(tag);
  if (solid == INVALID_INDEX || (tag & TRIANGLE_TAG_CLOSED) == 0u) return number;
  return cosine < 0.0 ? solid : ~solid;
}

// The value by which hits are ordered (t, less what the rank takes off), and how near two such values must be for the third
// rule to decide. TRAVERSAL_NEVER: the hit does not count. cosine: of the direction with the front's normal.
vec2 contact_key(uint tag, uint number, float t, float cosine) {
  const vec2 NEVER = vec2(3.4e38, 0.0);  // TRAVERSAL_NEVER
  float along = contact_error(t) / max(abs(cosine), CONTACT_MIN_COS);
  uint solid = solid_of_tag(tag);
  if (solid == INVALID_INDEX || (tag & TRIANGLE_TAG_CLOSED) == 0u) {
    bool is_met = !contact.is_blind && number != contact.triangle && t > 0.0 && t > contact.from - CONTACT_BEHIND * along &&
                  t <= contact.t_max;
    if (solid != INVALID_INDEX) is_met = is_met && t > contact.from;
    bool emits = (tag & (cosine < 0.0 ? TRIANGLE_TAG_EMITS : TRIANGLE_TAG_EMITS_BACK)) != 0u;
    float rank = emits ? CONTACT_EMITTER : cosine < 0.0 ? CONTACT_FRONT : CONTACT_BACK;
    return is_met ? vec2(t - rank * along, CONTACT_TIE * along) : NEVER;
  }
  bool is_entry = cosine < 0.0;
  bool is_inside = media_contain(contact.around, solid);
  float before = -CONTACT_BEHIND * along;
  if (contact.is_blind) {
    bool counts = is_entry ? !is_inside : is_inside || !media_contain(contact.holding, solid);
    if (solid == contact.crossed && t < contact.from - before) return NEVER;
    // Boundaries are taken one after the other: one that was left must not count again as left without having been entered.
    uint last = media_contain(contact.around, contact.crossed) ? contact.crossed : ~contact.crossed;
    bool is_ahead = t > contact.from || (t == contact.from && (is_entry ? solid : ~solid) > last);
    return counts && is_ahead && t > 0.0 ? vec2(t, 0.0) : NEVER;
  }
  if (is_inside == is_entry) return NEVER;
  // What has just been left is not entered again at once.
  if (is_entry && solid == contact.left && t < -before) return NEVER;
  if (is_entry && solid == contact.crossed && t < contact.from - before) return NEVER;
  // The surface at a segment's end may count as nearer by its rank.
  if (!(t > contact.from + before && t <= contact.t_max - CONTACT_FRONT * along)) return NEVER;
  return vec2(is_entry ? t - CONTACT_ENTRY * along : t, CONTACT_TIE * along);
}

// Whether the ray goes on behind what it has met first: behind an interface that is none, or, if blind, behind anything.
bool contact_goes_on(Hit hit, uint tag) {
  uint solid = solid_of_tag(tag);
  if (hit.triangle == INVALID_INDEX || solid == INVALID_INDEX) return false;
  if (!contact.is_blind && !is_passed(contact.solids, contact.around, solid)) return false;
  bool is_front = (tag & TRIANGLE_TAG_FRONT) != 0u;
  bool held_the_start = contact.is_blind && !is_front && !media_contain(contact.around, solid);
  MediaSet changed = media_behind(held_the_start ? contact.holding : contact.around, solid, is_front || held_the_start);
  if (held_the_start)
    contact.holding = changed;
  else
    contact.around = changed;
  contact.from = hit.t;
  contact.crossed = solid;
  return true;
}

#define TRAVERSAL_HAS_CONTACTS has_contacts()
#define TRAVERSAL_CONTACT_KEY contact_key
#define TRAVERSAL_CONTACT_ORDER contact_order
#define TRAVERSAL_CONTACT_REACH contact_reach
#define TRAVERSAL_CONTACT_GOES_ON contact_goes_on
#include "lib/traversal.glsl"

void start_contact(Frame frame, vec3 origin, float t_max, PathMedia media, bool is_blind) {
  contact.around = media.around;
  contact.from = 0.0;
  contact.crossed = INVALID_INDEX;
  contact.left = media.solid;
  contact.triangle = media.triangle;
  contact.coordinates = max(abs(origin.x), max(abs(origin.y), abs(origin.z)));
  contact.t_max = t_max;
  contact.is_blind = is_blind;
  contact.holding = NO_MEDIA;
  contact.solids = frame.solids;
}

// What the ray meets with t up to t_max, its tag and, in `media.around`, the solids there. Interfaces that are none are
// passed. To be called like trace_closest.
Hit trace_through(Frame frame, vec3 origin, vec3 direction, float t_max, inout PathMedia media, out uint tag) {
  start_contact(frame, origin, t_max, media, false);
  Hit hit = trace_closest(frame.bvh_nodes, frame.bvh_triangles, origin, direction, t_max, tag);
  media.around = contact.around;
  return hit;
}

// The solids that hold a point: those that a ray from there leaves without having entered them.
MediaSet media_at(Frame frame, vec3 point) {
  const vec3 AWAY = vec3(0.5377, 0.7339, 0.4151);  // along no axis of anything; unit
  start_contact(frame, point, 3.4e38, start_media(NO_MEDIA), true);
  uint tag;
  trace_closest(frame.bvh_nodes, frame.bvh_triangles, point, AWAY, 3.4e38, tag);
  return contact.holding;
}

// Whether something lies between the ends of a segment. Media between them do not change: what does not stop it has the same
// on both sides.
bool is_segment_occluded(Frame frame, VisibilityCandidate segment, PathMedia media) {
  uint tag;
  return trace_through(frame, segment.origin, segment.direction, segment.t_max, media, tag).triangle != INVALID_INDEX;
}

#endif
