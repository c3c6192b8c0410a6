// Roulette of shadow rays (docs/mathematics.md 17): a segment that would carry little if it were free is traced with a
// probability in proportion to that, and counts accordingly more.
#ifndef REGULUS_LIB_SHADOW_ROULETTE_GLSL
#define REGULUS_LIB_SHADOW_ROULETTE_GLSL

#include "lib/buffers.glsl"
#include "lib/rng.glsl"

// The probability with which the segment that would add `contribution` is traced, or 0 if it is not.
// stream, iteration: of the walk that makes the segment, pixel and sample or light path and iteration
// place: which of the walk's segments it is, by edges from the camera, edges from the light and last bits of the light
// path's number, 0 where a segment does not depend on it
float traced_share(Frame frame, vec3 contribution, uint stream, uint iteration, uvec3 place) {
  if (spec_shadow_roulette == 0u) return 1.0;
  float share = max(contribution.r, max(contribution.g, contribution.b)) / frame.shadow_roulette;
  if (!(share < 1.0)) return 1.0;
  // Random numbers have as many digits, so that this is exactly how often one of them is below.
  float steps = max(ceil(share * float(SHADOW_ROULETTE_STEPS)), float(SHADOW_ROULETTE_LEAST));
  share = steps * (1.0 / float(SHADOW_ROULETTE_STEPS));
  uvec4 bits = pcg4d(hash_bits(frame.seed, stream, iteration, DIMENSION_BLOCK_SHADOW_ROULETTE) + uvec4(place, 0u));
  return unit_interval(bits).x < share ? share : 0.0;
}

#endif
