// The table of what sheen reflects: see shaders/lib/lobes/sheen.glsl.
#ifndef REGULUS_INTERFACE_SHEEN_H
#define REGULUS_INTERFACE_SHEEN_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// Share of light that white sheen reflects, at SHEEN_DIRECTIONS directions, which go by sqrt(cos), times SHEEN_ROWS
// perceptual roughnesses, which go by the square of the row from the least to 1. At grazing it exceeds 1 below .3.
REGULUS_CONSTANT SHEEN_DIRECTIONS = 64u;
REGULUS_CONSTANT SHEEN_ROWS = 32u;
// Least roughness of sheen, in hundredths: the density's exponent is 1 / roughness^2.
REGULUS_CONSTANT SHEEN_LEAST_HUNDREDTHS = 7u;

REGULUS_INTERFACE_END

#endif
