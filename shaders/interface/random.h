// Where the random numbers of a path come from: a function of (seed, pixel, sample, dimension), never of its place in
// a queue.
#ifndef REGULUS_INTERFACE_RANDOM_H
#define REGULUS_INTERFACE_RANDOM_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// Dimensions of the random sequence. One block is four numbers; a path uses block CAMERA once and the
// others once per bounce: block index = DIMENSION_BLOCKS_FIRST + bounce * DIMENSION_BLOCKS_PER_BOUNCE + k.
REGULUS_CONSTANT DIMENSION_BLOCK_CAMERA = 0u;         // film x, film y, lens u, lens v
REGULUS_CONSTANT DIMENSION_BLOCKS_FIRST = 1u;
// light, alias (light tree: more digits of the light), position u, position v (environment: direction)
REGULUS_CONSTANT DIMENSION_BLOCK_LIGHT = 0u;
REGULUS_CONSTANT DIMENSION_BLOCK_BSDF = 1u;           // lobe, direction u, direction v, roulette
REGULUS_CONSTANT DIMENSION_BLOCKS_PER_BOUNCE = 2u;
// Light path k of iteration i draws random_block(seed, k, i, block): blocks of its own, beyond every bounce's.
REGULUS_CONSTANT DIMENSION_BLOCK_EMISSION = 1u << 16;  // light, alias, position u, position v
// direction u, v (environment: place on the scene's disk), lens u, v
REGULUS_CONSTANT DIMENSION_BLOCK_EMISSION_DIRECTION = DIMENSION_BLOCK_EMISSION + 1u;
REGULUS_CONSTANT DIMENSION_BLOCK_LIGHT_BSDF = DIMENSION_BLOCK_EMISSION + 2u;  // + bounce: as DIMENSION_BLOCK_BSDF
REGULUS_CONSTANT DIMENSION_BLOCK_SPLAT = DIMENSION_BLOCK_EMISSION + 4096u;  // + edges: lens u, lens v, unused
// Connections to the cache draw one number each: block + bounce * 256 + k / 4.
REGULUS_CONSTANT DIMENSION_BLOCK_CACHE = 1u << 20;
// Virtual merges draw independent numbers, whatever the sampler (see virtual_merge_seed): block + VIRTUAL_MERGE_*.
REGULUS_CONSTANT DIMENSION_BLOCK_VIRTUAL_MERGE = 1u << 24;
REGULUS_CONSTANT VIRTUAL_MERGE_AT_CAMERA = 0u;  // the camera vertex of a connection or light sample
REGULUS_CONSTANT VIRTUAL_MERGE_AT_LIGHT = 1u;   // the light vertex of a connection or splat
REGULUS_CONSTANT VIRTUAL_MERGE_AT_MERGE = 2u;
REGULUS_CONSTANT VIRTUAL_MERGE_TRIES = 4u;      // stratified in the choice of the event
// Roulette of shadow rays draws independent numbers likewise (lib/shadow_roulette.glsl). A ray that is worth tracing less
// often than this is traced this often.
REGULUS_CONSTANT DIMENSION_BLOCK_SHADOW_ROULETTE = 1u << 25;
REGULUS_CONSTANT SHADOW_ROULETTE_STEPS = 1u << 24;  // probabilities are multiples of one over this
REGULUS_CONSTANT SHADOW_ROULETTE_LEAST = 1u << 14;  // of these

REGULUS_INTERFACE_END

#endif
