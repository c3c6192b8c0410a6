// How a raised lobe keeps its light. A wider lobe loses more light between facets, because single scattering leaves out
// further bounces, and a wider refraction loses more to reflection. So a lobe raised from alpha to alpha^ is scaled by
//   E(alpha, w) / E(alpha^, w)     reflection, clearcoat and thin-walled transmission: E of a perfect reflector
//   T(alpha, w) / T(alpha^, w)     refraction: what a clear interface refracts, from the side of w
// with w the direction towards the camera, whichever way a path is walked: a function of the path. So the lobe gives an eye
// as much of even light as before. How the Fresnel factor changes with a wider lobe is not undone: at grazing angles that
// would raise the lobe far above its bound, while this factor is at most 1 / E(alpha^).
#ifndef REGULUS_LIB_RAISED_LIGHT_GLSL
#define REGULUS_LIB_RAISED_LIGHT_GLSL

#include "lib/cover.glsl"

// T
float refracted_share(const EnergyTables tables, float cosine, bool is_inside) {
  vec2 place = vec2(cover_column(cosine, tables.critical, is_inside), cover_row(tables, true));
  uvec2 node = min(uvec2(place), uvec2(ENERGY_NODES - 2u, COVER_ROWS - 2u));
  uint first = tables.first + ENERGY_REFRACTED + (is_inside ? REFRACTED_SIDE_WORDS : 0u);
  return energy_between(tables, first + node.y * ENERGY_NODES + node.x, place - vec2(node));
}

EnergyTables with_alpha(EnergyTables tables, vec2 alpha) {
  tables.roughness = sqrt(sqrt(alpha.x * alpha.y));
  return tables;
}

// The factor on a reflection lobe. cosine: of the camera's direction.
float reflection_kept(const EnergyTables tables, vec2 alpha, vec2 raised_alpha, float cosine) {
  if (raised_alpha == alpha) return 1.0;
  return energy_reflected(with_alpha(tables, alpha), cosine) / energy_reflected(with_alpha(tables, raised_alpha), cosine);
}

// The factor on a refraction lobe. is_inside: the camera's direction is on the denser side.
float refraction_kept(const EnergyTables tables, vec2 alpha, vec2 raised_alpha, float cosine, bool is_inside) {
  if (raised_alpha == alpha) return 1.0;
  float raised = refracted_share(with_alpha(tables, raised_alpha), cosine, is_inside);
  return raised > 0.0 ? refracted_share(with_alpha(tables, alpha), cosine, is_inside) / raised : 0.0;
}

#endif
