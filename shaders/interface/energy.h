// Tables of what rough interfaces reflect and transmit by single scattering, for energy compensation (lib/energy.glsl).
#ifndef REGULUS_INTERFACE_ENERGY_H
#define REGULUS_INTERFACE_ENERGY_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// A plane has ENERGY_NODES times ENERGY_NODES nodes: direction, then perceptual roughness from 0 to 1.
REGULUS_CONSTANT ENERGY_NODES = 64u;
REGULUS_CONSTANT ENERGY_PLANE_WORDS = ENERGY_NODES * ENERGY_NODES;

// The buffer: how many indices of refraction have tables, those indices, the plane ENERGY_REFLECTED and its means over
// directions by roughness, then for each index the other planes and the means of ENERGY_FRESNEL.
REGULUS_CONSTANT ENERGY_MAX_INDICES = 32u;  // further ones use the nearest
REGULUS_CONSTANT ENERGY_INDICES = 1u;       // word at which the indices begin
REGULUS_CONSTANT ENERGY_COMMON = ENERGY_INDICES + ENERGY_MAX_INDICES;
REGULUS_CONSTANT ENERGY_PER_INDEX = ENERGY_COMMON + ENERGY_PLANE_WORDS + ENERGY_NODES;
REGULUS_CONSTANT ENERGY_INDEX_WORDS = 3u * ENERGY_PLANE_WORDS + ENERGY_NODES;

// Quantities. Directions of the first and the last two go by x = cos / (cos + alpha sin), which spreads out what happens
// at grazing angles whatever the roughness is; those of the second by cos.
REGULUS_CONSTANT ENERGY_REFLECTED = 0u;       // share of light that a perfectly reflecting surface sends back at once
REGULUS_CONSTANT ENERGY_FRESNEL = 1u;         // mean Fresnel position of that light, minus the smooth surface's
REGULUS_CONSTANT ENERGY_SCATTERED_OUT = 2u;   // share that a clear refracting surface sends anywhere, from outside
REGULUS_CONSTANT ENERGY_SCATTERED_IN = 3u;    // and from inside

// Push constants of the kernel that fills a plane.
struct EnergyArguments {
  DeviceAddress tables;
  uint plane;     // first word
  uint quantity;  // ENERGY_*
  float ior;
};
REGULUS_LAYOUT(EnergyArguments, 20);

REGULUS_INTERFACE_END

#endif
