// The film: per pixel and channel a 96-bit fixed-point sum (3 words, low first), so that the sum does not depend on
// the order in which samples arrive and needs no 64-bit integers. With exponent 0 its range is 3.6e16 and its
// resolution 9e-13. A sum that leaves the range stays marked by its highest bit, in whatever order it is reached: what
// carries out of the highest word sets the bit again, and nothing else can clear it. Its other bits mean nothing then.
#ifndef REGULUS_LIB_FILM_GLSL
#define REGULUS_LIB_FILM_GLSL

#include "lib/buffers.glsl"
#include "lib/specialization.glsl"

// The film holds only the pixels of Frame.crop, row by row; random numbers go by a pixel's number on the whole film,
// y * width + x.
uint film_index(Frame frame, uint pixel) {
  if (spec_crop == 0u) return pixel;
  return (pixel / frame.width - frame.crop.y) * frame.crop.z + pixel % frame.width - frame.crop.x;
}

uint pixel_of(Frame frame, uint index) {
  if (spec_crop == 0u) return index;
  return (index / frame.crop.z + frame.crop.y) * frame.width + index % frame.crop.z + frame.crop.x;
}

const float FILM_LARGEST = 36028797018963968.0;  // 2^FILM_RANGE_BITS: saturates a sum by itself

float power_of_two(int exponent) { return uintBitsToFloat(uint(127 + exponent) << 23u); }

float in_film_units(float value) { return value * power_of_two(-spec_film_exponent); }

// Adds to a word of the film; returns the carry.
uint film_add_word(DeviceAddress film, uint index, uint value) {
  uint before = ATOMIC_ADD(film, index, value);
  return uint(before + value < before);
}

// Adds value >= 0 to the sum that starts at word `base`.
void film_add_channel(DeviceAddress film, uint base, float value) {
  uint bits = floatBitsToUint(min(in_film_units(value), FILM_LARGEST));
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
  uint carry = high + film_add_word(film, base + word, low);
  if (word < 2u && carry != 0u) carry = film_add_word(film, base + word + 1u, carry);
  if (word == 0u && carry != 0u) carry = film_add_word(film, base + 2u, carry);
  if (carry != 0u) ATOMIC_OR(film, base + 2u, FILM_SATURATED);
}

void film_add(DeviceAddress film, uint pixel, vec3 radiance) {
  uint base = pixel * FILM_WORDS_PER_PIXEL;
  film_add_channel(film, base, radiance.r);
  film_add_channel(film, base + 3u, radiance.g);
  film_add_channel(film, base + 6u, radiance.b);
}

// A sample that is not finite, or negative, is a bug: it must not reach the film, and is counted. It is told by its bits,
// because a driver may assume that there are no NaNs and drop comparisons that look for them.
bool is_valid_sample(vec3 radiance) {
  const uint LARGEST = 0x7F7FFFFFu, MINUS_ZERO = 0x80000000u;
  uvec3 bits = floatBitsToUint(radiance);
  bvec3 is_beyond = greaterThan(bits, uvec3(LARGEST));  // also whatever has a sign
  return !any(bvec3(is_beyond.x && bits.x != MINUS_ZERO, is_beyond.y && bits.y != MINUS_ZERO,
                    is_beyond.z && bits.z != MINUS_ZERO));
}

// A baseline to compare regularization with: bright contributions are scaled down, and the energy is lost.
vec3 clamp_contribution(vec3 radiance, float largest) {
  if (spec_clamp == 0u) return radiance;
  float brightest = max(radiance.r, max(radiance.g, radiance.b));
  return brightest > largest ? radiance * (largest / brightest) : radiance;
}

// A sum in the film's own units, kept in registers: any order of adding gives the same bits.
struct FixedSum {
  uvec3 r, g, b;  // words, low first
};

const FixedSum FIXED_SUM_ZERO = FixedSum(uvec3(0u), uvec3(0u), uvec3(0u));

// value >= 0 in the film's units, in words, rounded down to the resolution.
uvec3 fixed_words(float value) {
  value = min(value, FILM_LARGEST);
  uint high = uint(value * 5.9604645e-8);  // 2^24 units of 1
  float rest = (value - float(high) * 16777216.0) * 256.0;
  uint middle = uint(rest);
  return uvec3(uint((rest - float(middle)) * 4294967296.0), middle, high);
}

uvec3 fixed_point(float value) { return fixed_words(in_film_units(value)); }

bool is_saturated(uvec3 words) { return words.z >= FILM_SATURATED; }

uvec3 fixed_add(uvec3 a, uvec3 b) {
  uint carry_low, carry_high;
  uint low = uaddCarry(a.x, b.x, carry_low);
  uint middle = uaddCarry(a.y, b.y, carry_high);
  uint carry;
  middle = uaddCarry(middle, carry_low, carry);
  uint high = a.z + b.z + carry_high + carry;  // 2^32 - 1 at most, unless one is saturated
  return uvec3(low, middle, ((a.z | b.z | high) & FILM_SATURATED) != 0u ? FILM_SATURATED : high);
}

uvec3 fixed_subtract(uvec3 a, uvec3 b) {
  uint borrow_low, borrow_high, borrow;
  uint low = usubBorrow(a.x, b.x, borrow_low);
  uint middle = usubBorrow(a.y, b.y, borrow_high);
  middle = usubBorrow(middle, borrow_low, borrow);
  return uvec3(low, middle, a.z - b.z - borrow_high - borrow);
}

// In the film's units.
float fixed_value(uvec3 words) {
  return float(words.z) * 16777216.0 + float(words.y) * 3.90625e-3 + float(words.x) * 9.094947e-13;  // 2^24, -8, -40
}

void fixed_sum_add(inout FixedSum sum, vec3 radiance) {
  sum.r = fixed_add(sum.r, fixed_point(radiance.r));
  sum.g = fixed_add(sum.g, fixed_point(radiance.g));
  sum.b = fixed_add(sum.b, fixed_point(radiance.b));
}

void film_add_words(DeviceAddress film, uint base, uvec3 words) {
  uint carry_low = film_add_word(film, base, words.x);
  uint middle = words.y + carry_low;
  uint high = words.z + uint(middle < carry_low);
  if (middle != 0u) high += film_add_word(film, base + 1u, middle);
  if (high != 0u && film_add_word(film, base + 2u, high) != 0u) ATOMIC_OR(film, base + 2u, FILM_SATURATED);
}

void film_add_sum(DeviceAddress film, uint pixel, FixedSum sum) {
  uint base = pixel * FILM_WORDS_PER_PIXEL;
  film_add_words(film, base, sum.r);
  film_add_words(film, base + 3u, sum.g);
  film_add_words(film, base + 6u, sum.b);
}

#endif
