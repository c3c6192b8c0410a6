// How the 8-bit codes of textures are decoded, by the same single-precision operations in kernels and on the host.
#ifndef REGULUS_INTERFACE_SRGB_H
#define REGULUS_INTERFACE_SRGB_H

#include "types.h"

#ifdef __cplusplus
#include <cmath>
#define REGULUS_INLINE inline
#define REGULUS_PRECISE
#else
#define REGULUS_INLINE
#define REGULUS_PRECISE precise
#endif

REGULUS_INTERFACE_BEGIN

#ifdef __cplusplus
using std::sqrt;
#endif

// Value of an 8-bit code (0 to 255) as a fraction; exactly 1 at 255.
REGULUS_INLINE float code_to_fraction(float code) { return code * 0.00392156886f; }

// Linear value of an 8-bit code of IEC 61966-2-1. With t = (code / 255 + 0.055) / 1.055 that is t^2.4 =
// t^2 (t^0.25)^1.6, the last factor by a polynomial of degree 5: within 4.2e-7 of the exact value, relative, at every
// code, monotonic, and exactly 0 and 1 at the ends.
REGULUS_INLINE float srgb_code_to_linear(float code) {
  REGULUS_PRECISE float t = code * 0.00371712656f + 0.0521326996f;
  REGULUS_PRECISE float q = sqrt(sqrt(t));
  REGULUS_PRECISE float power =
      ((((-0.0266360492f * q + 0.145973578f) * q - 0.383963853f) * q + 1.02214372f) * q + 0.256879508f) * q - 0.0143969255f;
  REGULUS_PRECISE float curved = t * t * power;
  return code <= 10.0f ? code * 0.000303526991f : curved;
}

REGULUS_INTERFACE_END

#endif
