// Energy compensation (Turquin, "Practical multiple scattering compensation for microfacet models", 2019): light that
// single scattering at a rough interface loses, because facets shadow each other, is given back by scaling what it keeps.
//   metal              1 + (1 - E) / E  F E_avg / (1 - F (1 - E_avg))   per channel; F: mean of Schlick's reflectance.
//                      The series of Kulla and Conty (2017): the light of later bounces has the metal's colour
//   dielectric, thin   1 / E
//   refracting solid   1 / E', reflection and transmission alike
//   diffuse            its interface lets 1 - F pass, F being the mean over the rough surface's facets: together with the
//                      reflection this adds up to 1 for a white base
// E(w), E'(w): shares that a perfectly reflecting and a clear surface keep, from tables. w is the direction towards the
// camera, whichever way a path is walked: the bsdf is not reciprocal, but all techniques measure the same one. Pdfs do not
// change. Clearcoats are left as they are; anisotropic lobes take the tables of their mean roughness.
#ifndef REGULUS_LIB_ENERGY_GLSL
#define REGULUS_LIB_ENERGY_GLSL

#include "interface/energy.h"
#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#include "lib/specialization.glsl"

// What is needed to look up a surface in the tables.
struct EnergyTables {
  DeviceAddress words;
  uint first;       // of the interface's own planes
  float roughness;  // perceptual
  float critical;   // cosine at which total reflection begins on the dense side of their interface
};

float energy_word(const EnergyTables tables, uint word) { return LOAD(FloatBuffer, tables.words, word); }

// Cosine at which total reflection begins on the dense side of an interface of index `ior`.
float critical_cosine(float ior) { return safe_sqrt((ior - 1.0) * (ior + 1.0)) / ior; }

// The tables for an index of refraction, or for the nearest one that has tables.
EnergyTables find_energy_tables(DeviceAddress words, float ior, vec2 alpha) {
  EnergyTables tables = EnergyTables(words, 0u, sqrt(sqrt(alpha.x * alpha.y)), 0.0);
  uint count = min(LOAD(WordBuffer, words, 0u), ENERGY_MAX_INDICES), nearest = 0u;
  float distance = 3.4e38;
  for (uint i = 0u; i < count; ++i) {
    float away = abs(energy_word(tables, ENERGY_INDICES + i) - ior);
    if (away < distance) nearest = i;
    distance = min(distance, away);
  }
  tables.first = ENERGY_PER_INDEX + nearest * ENERGY_INDEX_WORDS;
  float found = energy_word(tables, ENERGY_INDICES + nearest);
  tables.critical = critical_cosine(found);
  return tables;
}

float energy_mean(const EnergyTables tables, uint first) {
  float place = clamp(tables.roughness, 0.0, 1.0) * float(ENERGY_NODES - 1u);
  uint node = min(uint(place), ENERGY_NODES - 2u);
  return mix(energy_word(tables, first + node), energy_word(tables, first + node + 1u), place - float(node));
}

// Linear between the four words around, of which `corner` is the first. rest: where between columns and between rows.
float energy_between(const EnergyTables tables, uint corner, vec2 rest) {
  float low = mix(energy_word(tables, corner), energy_word(tables, corner + 1u), rest.x);
  float high = mix(energy_word(tables, corner + ENERGY_NODES), energy_word(tables, corner + ENERGY_NODES + 1u), rest.x);
  return mix(low, high, rest.y);
}

float energy_plane(const EnergyTables tables, uint first, float x) {
  vec2 place = clamp(vec2(x, tables.roughness), 0.0, 1.0) * float(ENERGY_NODES - 1u);
  uvec2 node = min(uvec2(place), uvec2(ENERGY_NODES - 2u));
  return energy_between(tables, first + node.y * ENERGY_NODES + node.x, place - vec2(node));
}

// Where a direction with this cosine lies in the planes of energy.
float energy_position(const EnergyTables tables, float cosine) {
  float sine = safe_sqrt((1.0 - cosine) * (1.0 + cosine));
  return cosine / max(cosine + square(tables.roughness) * sine, 1e-20);
}

// E
float energy_reflected(const EnergyTables tables, float cosine) {
  return energy_plane(tables, ENERGY_COMMON, energy_position(tables, cosine));
}

// E'
float energy_scattered(const EnergyTables tables, float cosine, bool is_inside) {
  uint plane = (is_inside ? ENERGY_SCATTERED_IN : ENERGY_SCATTERED_OUT) - 1u;
  return energy_plane(tables, tables.first + plane * ENERGY_PLANE_WORDS, energy_position(tables, cosine));
}

// How much further the mean Fresnel position lies than at a smooth surface: for a direction from outside, and over all.
float energy_fresnel(const EnergyTables tables, float cosine) { return energy_plane(tables, tables.first, cosine); }
float energy_fresnel_mean(const EnergyTables tables) {
  return energy_mean(tables, tables.first + 3u * ENERGY_PLANE_WORDS);
}

// Factor on a metal of this colour at normal incidence.
vec3 metal_compensation(const EnergyTables tables, float cosine, vec3 color) {
  float kept = energy_reflected(tables, cosine);
  float mean = energy_mean(tables, ENERGY_COMMON + ENERGY_PLANE_WORDS);
  vec3 fresnel = color + (1.0 - color) * (1.0 / 21.0);
  return 1.0 + ((1.0 - kept) / kept) * fresnel * mean / (1.0 - fresnel * (1.0 - mean));
}

#endif
