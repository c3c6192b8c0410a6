// What a raised lobe keeps of its light. A wider lobe loses more between facets, which single scattering leaves out, and of a
// wider refraction more is reflected: a lobe raised from alpha to alpha^ is scaled by
//   E(alpha, w) / E(alpha^, w)     reflection, clearcoat and thin-walled transmission: E of a perfect reflector
//   T(alpha, w) / T(alpha^, w)     refraction: what a clear interface refracts, from the side of w
// with w the direction towards the camera, whichever way a path is walked: a function of the path. So the lobe gives an eye
// as much of even light as before. What Fresnel makes of wider reflection is not undone: at grazing angles that factor would
// raise the lobe far above its bound, while this one is at most 1 / E(alpha^).
#ifndef REGULUS_LIB_RAISED_LIGHT_GLSL
#define REGULUS_LIB_RAISED_LIGHT_GLSL

#include "lib/cover.glsl"

// T
float refracted_share(EnergyTables tables, float cosine, bool is_inside) {
  float place = cover_column(cosine, tables.critical, is_inside);
  uint node = min(uint(place), ENERGY_NODES - 2u);
  float row = cover_row(tables, true);
  uint below = min(uint(row), COVER_ROWS - 2u);
  uint corner = tables.first + ENERGY_REFRACTED + (is_inside ? REFRACTED_SIDE_WORDS : 0u) + below * ENERGY_NODES + node;
  float low = mix(energy_word(tables, corner), energy_word(tables, corner + 1u), place - float(node));
  float high = mix(energy_word(tables, corner + ENERGY_NODES), energy_word(tables, corner + ENERGY_NODES + 1u),
                   place - float(node));
  return mix(low, high, row - float(below));
}

EnergyTables with_alpha(EnergyTables tables, vec2 alpha) {
  tables.roughness = sqrt(sqrt(alpha.x * alpha.y));
  return tables;
}

// The factor on a reflection lobe. cosine: of the camera's direction.
float reflection_kept(EnergyTables tables, vec2 alpha, vec2 raised_alpha, float cosine) {
  if (raised_alpha == alpha) return 1.0;
  return energy_reflected(with_alpha(tables, alpha), cosine) / energy_reflected(with_alpha(tables, raised_alpha), cosine);
}

// The factor on a refraction lobe. is_inside: the camera's direction is on the denser side.
float refraction_kept(EnergyTables tables, vec2 alpha, vec2 raised_alpha, float cosine, bool is_inside) {
  if (raised_alpha == alpha) return 1.0;
  float raised = refracted_share(with_alpha(tables, raised_alpha), cosine, is_inside);
  return raised > 0.0 ? refracted_share(with_alpha(tables, alpha), cosine, is_inside) / raised : 0.0;
}

#endif
