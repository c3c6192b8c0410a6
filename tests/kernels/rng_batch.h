// What rng_bits.comp computes, by its `parameter`.
#ifndef REGULUS_RNG_BATCH_H
#define REGULUS_RNG_BATCH_H

#include "interface/types.h"

REGULUS_INTERFACE_BEGIN

REGULUS_CONSTANT RNG_POINT = 0u;  // Sobol point
REGULUS_CONSTANT RNG_SOBOL = 1u;  // block of the sampler `sobol`
REGULUS_CONSTANT RNG_HASH = 2u;   // block of the sampler `hash`

REGULUS_INTERFACE_END

#endif
