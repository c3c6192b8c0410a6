// What lobes have in common: directions that meet at a facet, value and pdfs.
#ifndef REGULUS_LIB_LOBES_SCATTERING_GLSL
#define REGULUS_LIB_LOBES_SCATTERING_GLSL

#include "lib/numerics.glsl"

// What is transported along the walk: it decides about the eta^2 of refraction.
const uint TRANSPORT_RADIANCE = 0u;    // walks from the camera
const uint TRANSPORT_IMPORTANCE = 1u;  // walks from lights

// Non-delta lobes at a pair of directions. Densities per solid angle. Of a delta event its factor and discrete probabilities.
struct BsdfEval {
  vec3 value;         // 1/sr, without a cosine
  float pdf_forward;  // of wi given wo
  float pdf_reverse;  // of wo given wi
};

const BsdfEval NO_SCATTERING = BsdfEval(vec3(0.0), 0.0, 0.0);

// Lobes whose alpha is below this are sharp: a vertex with nothing else does not diffuse (lib/regularization.glsl).
const float SHARP_ALPHA = 0.05;

// Where wo and wi meet the microsurface.
struct Encounter {
  vec3 h;               // unit, h.z > 0
  float o_dot_h;        // absolute cosines with h
  float i_dot_h;
  bool is_transmitted;  // wi is below the surface
  bool is_refracted;    // and was bent (not thin-walled)
  bool is_valid;        // false: no facet turns wo into wi
};

const Encounter NO_ENCOUNTER = Encounter(vec3(0.0, 0.0, 1.0), 1.0, 1.0, false, false, false);

// The facet that reflects wo into wi (on the same side, wi.z > 0). |wo + wi| = 2 wo.h.
Encounter reflection_encounter(vec3 wo, vec3 wi) {
  vec3 sum = wo + wi;
  float sum_length = sqrt(max(dot(sum, sum), 1e-30));
  Encounter facet;
  facet.h = sum / sum_length;
  facet.o_dot_h = 0.5 * sum_length;
  facet.i_dot_h = facet.o_dot_h;
  facet.is_transmitted = false;
  facet.is_refracted = false;
  facet.is_valid = true;
  return facet;
}

#endif
