// Rays at surfaces that are only partly there: they decide by a hash of themselves whether they meet one (as in
// pbrt-v4), so that closest-hit and shadow rays agree and a picture does not depend on how the work is cut. Include this
// before lib/traversal.glsl.
#ifndef REGULUS_LIB_ALPHA_GLSL
#define REGULUS_LIB_ALPHA_GLSL

#include "lib/coverage.glsl"
#include "lib/rng.glsl"
#include "lib/stage.glsl"

// Whether a ray meets the surface of a triangle there, or passes.
bool is_covered(uint tag, uint triangle_index, vec2 barycentrics, vec3 origin, vec3 direction) {
  if ((spec_features & FEATURE_ALPHA) == 0u || (tag & TRIANGLE_TAG_ALPHA) == 0u) return true;
  float coverage = coverage_at(FRAME, LOAD(TriangleBuffer, FRAME.triangles, triangle_index), barycentrics);
  if (coverage >= 1.0) return true;
  uvec4 bits = pcg4d(uvec4(floatBitsToUint(origin), floatBitsToUint(direction.x)));
  bits = pcg4d(bits ^ uvec4(floatBitsToUint(direction.yz), triangle_index, 0u));
  return unit_interval(bits).x < coverage;
}

#define TRAVERSAL_IS_COVERED is_covered

#endif
