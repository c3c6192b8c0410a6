// What a rough dielectric interface leaves to the diffuse base that it covers. Its facets stand at other angles than the
// surface, so at grazing angles it reflects much less than a smooth one: the base gets what the interface's own albedo leaves,
//   E(w) = F_0 R(w) + (F_90 - F_0) S(w)
// (R, S of interface/energy.h, for single scattering), and the diffuse lobe base / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg) is
// reciprocal and with what the interface reflects sums to E + base (1 - E), never above 1 (Kelemen and Szirmay-Kalos 2001).
// From outside the smooth interface's reflectance stands for E up to a roughness of COVER_BEGIN, where the two hardly differ;
// from inside, where facets blur the onset of total reflection, E counts at every roughness. With energy compensation see
// lib/energy.glsl.
#ifndef REGULUS_LIB_COVER_GLSL
#define REGULUS_LIB_COVER_GLSL

#include "lib/energy.glsl"

const float COVER_BEGIN = 0.01 * float(COVER_BEGIN_HUNDREDTHS);
const float COVER_FULL = 0.01 * float(COVER_FULL_HUNDREDTHS);

// Roughness of a row of the tables.
float cover_roughness(uint row, bool is_inside) {
  float x = float(row) / float(COVER_ROWS - 1u);
  return is_inside ? square(x) : mix(COVER_BEGIN, 1.0, x);
}

// How much E counts against the smooth interface's reflectance, from outside.
float cover_share(float roughness) { return smoothstep(COVER_BEGIN, COVER_FULL, roughness); }

// Cosine of a column of the tables; critical: where total reflection begins. Columns are denser near 0 and near critical.
float cover_cosine(uint column, float critical, bool is_inside) {
  const float LEAST = 1e-3;
  if (!is_inside) return square(max(float(column) / float(ENERGY_NODES - 1u), LEAST));
  if (column >= COVER_CRITICAL_NODE)
    return critical +
           (1.0 - critical) * square(float(column - COVER_CRITICAL_NODE) / float(ENERGY_NODES - 1u - COVER_CRITICAL_NODE));
  float x = float(column) / float(COVER_CRITICAL_NODE);
  return max(critical * (square(x) / (square(x) + square(1.0 - x))), square(LEAST));
}

// Where a direction with this cosine lies between the columns: the inverse of cover_cosine.
float cover_column(float cosine, float critical, bool is_inside) {
  float c = clamp(cosine, 0.0, 1.0);
  if (!is_inside) return sqrt(c) * float(ENERGY_NODES - 1u);
  if (c >= critical)
    return mix(float(COVER_CRITICAL_NODE), float(ENERGY_NODES - 1u), sqrt((c - critical) / (1.0 - critical)));
  float near_zero = sqrt(c), near_critical = sqrt(critical - c);
  return float(COVER_CRITICAL_NODE) * (near_zero / (near_zero + near_critical));
}

// First pair of the tables of a side, and where a roughness lies between its rows.
uint cover_pairs(const EnergyTables tables, bool is_inside) {
  return (tables.first + ENERGY_COVERS + (is_inside ? COVER_SIDE_WORDS : 0u)) / 2u;
}
float cover_row(const EnergyTables tables, bool is_inside) {
  float x = is_inside ? sqrt(tables.roughness) : (tables.roughness - COVER_BEGIN) / (1.0 - COVER_BEGIN);
  return clamp(x, 0.0, 1.0) * float(COVER_ROWS - 1u);
}

vec2 cover_pair(const EnergyTables tables, uint pair) { return LOAD(Vec2Buffer, tables.words, pair); }

// R and S of a direction with this cosine.
vec2 cover_albedo(const EnergyTables tables, float cosine, bool is_inside) {
  float place = cover_column(cosine, tables.critical, is_inside);
  uint node = min(uint(place), ENERGY_NODES - 2u);
  float row = cover_row(tables, is_inside);
  uint below = min(uint(row), COVER_ROWS - 2u);
  uint corner = cover_pairs(tables, is_inside) + below * ENERGY_NODES + node;
  vec2 low = mix(cover_pair(tables, corner), cover_pair(tables, corner + 1u), place - float(node));
  vec2 high = mix(cover_pair(tables, corner + ENERGY_NODES), cover_pair(tables, corner + ENERGY_NODES + 1u),
                  place - float(node));
  return mix(low, high, row - float(below));
}

// Their means over directions.
vec2 cover_mean(const EnergyTables tables, bool is_inside) {
  float row = cover_row(tables, is_inside);
  uint below = min(uint(row), COVER_ROWS - 2u);
  uint first = cover_pairs(tables, is_inside) + COVER_NODES + below;
  return mix(cover_pair(tables, first), cover_pair(tables, first + 1u), row - float(below));
}

#endif
