// The film: per pixel and channel a 96-bit fixed-point sum (3 words, low first, unit 2^-40), so that the
// sum does not depend on the order in which samples arrive and needs no 64-bit integers. Range 3.6e16,
// resolution 9e-13.
#ifndef REGULUS_LIB_FILM_GLSL
#define REGULUS_LIB_FILM_GLSL

#include "lib/buffers.glsl"

// Adds value >= 0 to the sum that starts at word `base`.
void film_add_channel(DeviceAddress film, uint base, float value) {
  uint bits = floatBitsToUint(min(value, 1.8e16));
  uint exponent = bits >> 23u;
  if (exponent == 0u) return;  // zero, or a denormal far below the resolution
  uint mantissa = (bits & 0x7FFFFFu) | 0x800000u;
  int shift = int(exponent) - (127 + 23) + int(FILM_FRACTION_BITS);
  uint word = 0u, low, high = 0u;
  if (shift < 0) {
    low = shift < -24 ? 0u : (mantissa + (1u << uint(-shift - 1))) >> uint(-shift);  // round to nearest
  } else {
    word = uint(shift) >> 5u;
    uint within = uint(shift) & 31u;
    low = mantissa << within;
    high = within > 8u ? mantissa >> (32u - within) : 0u;
  }
  uint before = ATOMIC_ADD(film, base + word, low);
  high += uint(before + low < before);
  if (high != 0u && word < 2u) {
    uint before_high = ATOMIC_ADD(film, base + word + 1u, high);
    if (before_high + high < before_high && word == 0u) ATOMIC_ADD(film, base + 2u, 1u);
  }
}

void film_add(DeviceAddress film, uint pixel, vec3 radiance) {
  uint base = pixel * FILM_WORDS_PER_PIXEL;
  film_add_channel(film, base, radiance.r);
  film_add_channel(film, base + 3u, radiance.g);
  film_add_channel(film, base + 6u, radiance.b);
}

#endif
