// Tables of what rough interfaces reflect and transmit by single scattering: for energy compensation
// (lib/energy.glsl), for what rough dielectrics leave to their diffuse base (lib/cover.glsl), and for what
// raised lobes keep (lib/raised_light.glsl).
#ifndef REGULUS_INTERFACE_ENERGY_H
#define REGULUS_INTERFACE_ENERGY_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// A plane has ENERGY_NODES times ENERGY_NODES nodes: direction, then perceptual roughness from 0 to 1.
REGULUS_CONSTANT ENERGY_NODES = 64u;
REGULUS_CONSTANT ENERGY_PLANE_WORDS = ENERGY_NODES * ENERGY_NODES;

// The covers of diffuse bases: pairs of words (R, S) at ENERGY_NODES directions times COVER_ROWS roughnesses.
// R is what a perfectly reflecting surface sends back, S the same weighed by the Fresnel position of the
// facets: of F = F_0 + s (F_90 - F_0) an interface reflects F_0 R + (F_90 - F_0) S. From outside directions
// go by sqrt(cos), roughnesses from COVER_BEGIN to 1. From inside roughnesses go by their square roots, from
// 0 on, and one node is the direction at which total reflection begins: what passes grows there as the square
// root of the distance in cosine, or where facets blur it within a distance of alpha.
REGULUS_CONSTANT COVER_ROWS = 32u;
REGULUS_CONSTANT COVER_NODES = ENERGY_NODES * COVER_ROWS;
REGULUS_CONSTANT COVER_CRITICAL_NODE =
    32u;  // from inside; those below it are reflected totally where the interface is smooth
// Roughness, in hundredths, up to which from outside the smooth interface's reflectance stands for R and S,
// and from which they count fully; between them by smoothstep.
REGULUS_CONSTANT COVER_BEGIN_HUNDREDTHS = 10u;
REGULUS_CONSTANT COVER_FULL_HUNDREDTHS = 20u;
// Words of one side of an interface: the nodes, then their means 2 int f(cos) cos dcos by roughness.
REGULUS_CONSTANT COVER_SIDE_WORDS = 2u * (COVER_NODES + COVER_ROWS);

// What a clear interface refracts: words at the directions of a cover of that side and the roughnesses of one
// from inside, on both sides.
REGULUS_CONSTANT REFRACTED_SIDE_WORDS = COVER_NODES;

// The buffer: how many indices of refraction have tables, those indices, the plane ENERGY_REFLECTED and its
// means over directions by roughness, then for each index the other planes, the means of ENERGY_FRESNEL, and
// the covers and what is refracted, both from outside and from inside. Pairs begin at even words.
REGULUS_CONSTANT ENERGY_MAX_INDICES = 32u;  // further ones use the nearest
REGULUS_CONSTANT ENERGY_INDICES = 2u;       // word at which the indices begin
REGULUS_CONSTANT ENERGY_COMMON = ENERGY_INDICES + ENERGY_MAX_INDICES;
REGULUS_CONSTANT ENERGY_PER_INDEX = ENERGY_COMMON + ENERGY_PLANE_WORDS + ENERGY_NODES;
REGULUS_CONSTANT ENERGY_COVERS =
    3u * ENERGY_PLANE_WORDS + ENERGY_NODES;  // first word of the covers of an index
REGULUS_CONSTANT ENERGY_REFRACTED = ENERGY_COVERS + 2u * COVER_SIDE_WORDS;
REGULUS_CONSTANT ENERGY_INDEX_WORDS = ENERGY_REFRACTED + 2u * REFRACTED_SIDE_WORDS;

// Quantities. Directions of the first and the last two go by x = cos / (cos + alpha sin), which spreads out
// what happens at grazing angles whatever the roughness is; those of the second by cos.
REGULUS_CONSTANT ENERGY_REFLECTED =
    0u;  // share of light that a perfectly reflecting surface sends back at once
REGULUS_CONSTANT ENERGY_FRESNEL = 1u;  // mean Fresnel position of that light, minus the smooth surface's
REGULUS_CONSTANT ENERGY_SCATTERED_OUT =
    2u;  // share that a clear refracting surface sends anywhere, from outside
REGULUS_CONSTANT ENERGY_SCATTERED_IN = 3u;   // and from inside
REGULUS_CONSTANT ENERGY_COVER_OUT = 4u;      // the cover of a base, from outside
REGULUS_CONSTANT ENERGY_COVER_IN = 5u;       // and from inside
REGULUS_CONSTANT ENERGY_REFRACTED_OUT = 6u;  // share that a clear interface refracts, from outside
REGULUS_CONSTANT ENERGY_REFRACTED_IN = 7u;   // and from inside

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
