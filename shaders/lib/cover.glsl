// What a rough dielectric interface leaves to the diffuse base that it covers. Its facets stand at other angles than the
// surface, so at grazing angles it reflects much less than a smooth one: the base gets by its own albedo
//   E(w) = F_0 R(w) + (F_90 - F_0) S(w)
// (R, S of interface/energy.h, for single scattering), and the diffuse lobe base / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg) is
// reciprocal and with what the interface reflects sums to E + base (1 - E), never above 1 (Kelemen and Szirmay-Kalos 2001).
// Up to a roughness of COVER_BEGIN the smooth interface's reflectance stands for E, where the two hardly differ. With energy
// compensation see lib/energy.glsl.
#ifndef REGULUS_LIB_COVER_GLSL
#define REGULUS_LIB_COVER_GLSL

#include "lib/energy.glsl"

const float COVER_BEGIN = 0.01 * float(COVER_BEGIN_HUNDREDTHS);
const float COVER_FULL = 0.01 * float(COVER_FULL_HUNDREDTHS);

// Roughness of a row of the tables.
float cover_roughness(uint row) { return mix(COVER_BEGIN, 1.0, float(row) / float(COVER_ROWS - 1u)); }

// How much E counts against the smooth interface's reflectance.
float cover_share(float roughness) { return smoothstep(COVER_BEGIN, COVER_FULL, roughness); }

// First pair of the tables of a side, and where a roughness lies between its rows.
uint cover_pairs(EnergyTables tables, bool is_inside) {
  return (tables.first + ENERGY_COVERS + (is_inside ? COVER_SIDE_WORDS : 0u)) / 2u;
}
float cover_row(EnergyTables tables) {
  return clamp((tables.roughness - COVER_BEGIN) / (1.0 - COVER_BEGIN), 0.0, 1.0) * float(COVER_ROWS - 1u);
}

vec2 cover_pair(EnergyTables tables, uint pair) { return LOAD(Vec2Buffer, tables.words, pair); }

// R and S of a direction with this cosine.
vec2 cover_albedo(EnergyTables tables, float cosine, bool is_inside) {
  float place = sqrt(clamp(cosine, 0.0, 1.0)) * float(ENERGY_NODES - 1u);
  uint node = min(uint(place), ENERGY_NODES - 2u);
  float row = cover_row(tables);
  uint below = min(uint(row), COVER_ROWS - 2u);
  uint corner = cover_pairs(tables, is_inside) + below * ENERGY_NODES + node;
  vec2 low = mix(cover_pair(tables, corner), cover_pair(tables, corner + 1u), place - float(node));
  vec2 high = mix(cover_pair(tables, corner + ENERGY_NODES), cover_pair(tables, corner + ENERGY_NODES + 1u),
                  place - float(node));
  return mix(low, high, row - float(below));
}

// Their means over directions.
vec2 cover_mean(EnergyTables tables, bool is_inside) {
  float row = cover_row(tables);
  uint below = min(uint(row), COVER_ROWS - 2u);
  uint first = cover_pairs(tables, is_inside) + COVER_NODES + below;
  return mix(cover_pair(tables, first), cover_pair(tables, first + 1u), row - float(below));
}

#endif
