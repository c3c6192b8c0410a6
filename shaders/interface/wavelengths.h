// The wavelengths of iterations, where a scene has dispersive glass: see shaders/lib/dispersion.glsl.
#ifndef REGULUS_INTERFACE_WAVELENGTHS_H
#define REGULUS_INTERFACE_WAVELENGTHS_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// There are so many wavelengths, equally likely. The upper bits of an iteration's number of 32 bits say which it has.
REGULUS_CONSTANT WAVELENGTH_BITS = 10u;
REGULUS_CONSTANT WAVELENGTH_COUNT = 1u << WAVELENGTH_BITS;

// From one iteration to the next the number grows by 2^32 over the golden ratio: of all steps that one spreads every run of
// iterations most evenly, and unlike a radical inverse in base 2 it does not go with the samplers' own numbers.
REGULUS_CONSTANT WAVELENGTH_STEP = 0x9E3779B9u;
// Where it begins is the seed's hash, with this in place of a stream.
REGULUS_CONSTANT WAVELENGTH_STREAM = 0x5A7E11E5u;

struct Wavelength {
  float bend;     // (1 / wavelength^2 - 1 / d^2) / (1 / F^2 - 1 / C^2): the index is n_d + bend (n_d - 1) / V_d
  vec3 response;  // linear Rec. 709, of mean 1 over all wavelengths; the three sum to 3
};
REGULUS_LAYOUT(Wavelength, 16);

REGULUS_INTERFACE_END

#endif
