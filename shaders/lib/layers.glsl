// Layers of the film: beside the picture, the light of single kinds and of single groups of lights (interface/path.h). What a
// path contributes is added to them as to the film, in the same units, so that the sums of all kinds, or of all groups, are
// those of the film word by word. Without STATE_LAYERS all of this compiles to nothing.
#ifndef REGULUS_LIB_LAYERS_GLSL
#define REGULUS_LIB_LAYERS_GLSL

#include "lib/film.glsl"
#include "lib/regularization.glsl"

#define has_layers() has_state(STATE_LAYERS)

// Of a vertex where a path scatters. is_first: it is the one next to the lens.
uint vertex_trail(Bsdf bsdf, bool is_first) {
  if (!diffuses(bsdf)) return TRAIL_SHARP;
  return is_first ? TRAIL_DIFFUSED_FIRST : TRAIL_DIFFUSED_BEYOND;
}

// The group of a light, as it stands in trails.
uint group_trail(Frame frame, uint light) { return LOAD(WordBuffer, frame.light_groups, light) << TRAIL_GROUP_SHIFT; }

uint kind_of_light(uint trail) {
  trail &= TRAIL_BITS;
  if ((trail & (TRAIL_DIFFUSED_FIRST | TRAIL_DIFFUSED_BEYOND)) == 0u) return LIGHT_EMISSION;
  if (trail == TRAIL_DIFFUSED_FIRST) return LIGHT_DIRECT;
  return trail == (TRAIL_DIFFUSED_FIRST | TRAIL_SHARP) ? LIGHT_CAUSTICS : LIGHT_INDIRECT;
}

// trail: of the whole path, with its group. pixel: its index on the film. first: 0, or for splats Frame.layer_count.
void add_to_layers(Frame frame, uint first, uint trail, uint pixel, vec3 value) {
  uint pixels = frame.crop.z * frame.crop.w;
  uint layer = frame.kind_layers[kind_of_light(trail)];
  if (layer != INVALID_INDEX) film_add(frame.layer_film, (first + layer) * pixels + pixel, value);
  if (frame.first_group_layer == INVALID_INDEX) return;
  layer = frame.first_group_layer + (trail >> TRAIL_GROUP_SHIFT);
  film_add(frame.layer_film, (first + layer) * pixels + pixel, value);
}

// What a camera path contributes. False if it is not finite: it is added to nothing then.
bool add_to_film(Frame frame, uint trail, uint pixel, vec3 value) {
  if (!is_valid_sample(value)) return false;
  film_add(frame.film, pixel, value);
  add_to_layers(frame, 0u, trail, pixel, value);
  return true;
}

#endif
