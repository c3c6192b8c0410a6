// What traversal needs to know of a scene besides its tree: where its instances are, and which surfaces are only partly
// there. Include this before lib/traversal.glsl. Whether a ray meets a surface that is partly there is decided by a hash
// of the ray (as in pbrt-v4), so that closest-hit and shadow rays agree and a picture does not depend on how the work is
// cut.
#ifndef REGULUS_LIB_ALPHA_GLSL
#define REGULUS_LIB_ALPHA_GLSL

#include "lib/coverage.glsl"
#include "lib/rng.glsl"
#include "lib/stage.glsl"

// Whether a ray that meets a triangle at these barycentrics meets its surface, or passes through a hole.
bool is_covered(uint tag, uint triangle_number, vec2 barycentrics, vec3 origin, vec3 direction) {
  if ((spec_features & FEATURE_ALPHA) == 0u || (tag & TRIANGLE_TAG_ALPHA) == 0u) return true;
  float coverage = coverage_at(FRAME, placed_triangle(FRAME, triangle_number).triangle, barycentrics);
  if (coverage >= 1.0) return true;
  uvec4 bits = pcg4d(uvec4(floatBitsToUint(origin), floatBitsToUint(direction.x)));
  bits = pcg4d(bits ^ uvec4(floatBitsToUint(direction.yz), triangle_number, 0u));
  return unit_interval(bits).x < coverage;
}

// Index of a stored triangle that stands for itself, by its place in the device's own structure.
uint placed_triangle_index(uint geometry, uint primitive) {
  if ((spec_features & FEATURE_ALPHA) == 0u) return FRAME.first_placed_triangle + primitive;
  return LOAD(WordBuffer, FRAME.placed_triangles, (geometry == 0u ? 0u : FRAME.whole_placed_triangles) + primitive);
}

#define TRAVERSAL_IS_COVERED is_covered
#define TRAVERSAL_PLACED_TRIANGLE placed_triangle_index
#define TRAVERSAL_HAS_INSTANCES has_instances()
#define TRAVERSAL_INSTANCE(index) LOAD(InstanceBuffer, FRAME.instances, index)

#endif
