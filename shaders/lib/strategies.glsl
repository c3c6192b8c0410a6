// Images of single strategies (render/strategies.hpp): beside the film, what each strategy (technique, s, t) adds, with
// its weight and without. s and t are the vertices of the light and of the camera subpath, lens included; a merge counts
// the merged vertex in both. Without STATE_STRATEGIES all of this compiles to nothing.
#ifndef REGULUS_LIB_STRATEGIES_GLSL
#define REGULUS_LIB_STRATEGIES_GLSL

#include "lib/film.glsl"

#define has_strategies() has_state(STATE_STRATEGIES)

// The value that a technique measures, with its weight and without.
struct Weighted {
  vec3 value;
  vec3 unweighted;
};

// A strategy's number, or INVALID_INDEX if it has no image.
uint strategy_layer(Frame frame, uint s, uint t, bool is_merge) {
  uint edges = s + t - (is_merge ? 2u : 1u);
  return LOAD(WordBuffer, frame.strategy_layers, 2u * (edges * (frame.max_depth + 2u) + s) + uint(is_merge));
}

// pixel: its index on the film. value, unweighted: as they go to the film, with every factor except the number of samples.
void add_to_strategy(Frame frame, uint layer, uint pixel, vec3 value, vec3 unweighted) {
  if (layer == INVALID_INDEX) return;
  uint pixels = frame.crop.z * frame.crop.w;
  if (is_valid_sample(value)) film_add(frame.strategy_film, 2u * layer * pixels + pixel, value);
  if (is_valid_sample(unweighted)) film_add(frame.strategy_film, (2u * layer + 1u) * pixels + pixel, unweighted);
}

#endif
