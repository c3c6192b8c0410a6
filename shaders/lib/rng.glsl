// Random numbers by counter: a block of four is a pure function of (seed, stream, sample, block), so any order of
// evaluation, wave size or sample range gives the same numbers. Two samplers (spec_sampler):
// sobol  each (stream, block) is a four-dimensional Sobol sequence over the samples, its order shuffled and its
//        digits scrambled (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020). Blocks and streams are
//        independent. Components xy of a block are its best pair, a (0, 2)-sequence.
// hash   independent numbers.
// A camera path's stream is its pixel. The twin of this file in C++ is host/reference/rng.hpp.
#ifndef REGULUS_LIB_RNG_GLSL
#define REGULUS_LIB_RNG_GLSL

#include "lib/specialization.glsl"

// PCG4D (Jarzynski and Olano, "Hash Functions for GPU Rendering", JCGT 2020).
uvec4 pcg4d(uvec4 v) {
  v = v * 1664525u + 1013904223u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  v ^= v >> 16u;
  v.x += v.y * v.w;
  v.y += v.z * v.x;
  v.z += v.x * v.y;
  v.w += v.y * v.z;
  return v;
}

// Owen scrambling of numbers whose digits are in reverse, lowest bit first: every bit is flipped depending on the
// bits below it alone. The hash is Laine and Karras's (2011) with the constants of Vegdahl (2021), as in pbrt-v4's
// FastOwenScrambler.
uvec4 owen_scramble_reversed(uvec4 v, uvec4 seed) {
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= (seed >> 16u) | 1u;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return v;
}

// Point `index` of the Sobol sequence with the first four direction numbers of Joe and Kuo (2008), as 32-bit
// fractions with their digits in reverse. Dimension 1, Pascal's matrix, takes five steps (Ahmed 2024); 2 and 3 add up
// the columns of their matrices, written out because not every driver unrolls a loop over a table.
uvec4 sobol_reversed(uint index) {
  uint pascal = index;
  pascal ^= pascal >> 16u;
  pascal ^= (pascal & 0xFF00FF00u) >> 8u;
  pascal ^= (pascal & 0xF0F0F0F0u) >> 4u;
  pascal ^= (pascal & 0xCCCCCCCCu) >> 2u;
  pascal ^= (pascal & 0xAAAAAAAAu) >> 1u;
  uvec2 sum = uvec2(0u);
#define SOBOL_COLUMN(bit, column2, column3) sum ^= uvec2(column2, column3) & uint(bitfieldExtract(int(index), bit, 1));
  SOBOL_COLUMN(0, 0x00000001u, 0x00000001u)
  SOBOL_COLUMN(1, 0x00000003u, 0x00000003u)
  SOBOL_COLUMN(2, 0x00000006u, 0x00000004u)
  SOBOL_COLUMN(3, 0x00000009u, 0x0000000au)
  SOBOL_COLUMN(4, 0x00000017u, 0x0000001fu)
  SOBOL_COLUMN(5, 0x0000003au, 0x0000002eu)
  SOBOL_COLUMN(6, 0x00000071u, 0x00000045u)
  SOBOL_COLUMN(7, 0x000000a3u, 0x000000c9u)
  SOBOL_COLUMN(8, 0x00000116u, 0x0000011bu)
  SOBOL_COLUMN(9, 0x00000339u, 0x000002a4u)
  SOBOL_COLUMN(10, 0x00000677u, 0x0000079au)
  SOBOL_COLUMN(11, 0x000009aau, 0x00000b67u)
  SOBOL_COLUMN(12, 0x00001601u, 0x0000101eu)
  SOBOL_COLUMN(13, 0x00003903u, 0x0000302du)
  SOBOL_COLUMN(14, 0x00007706u, 0x00004041u)
  SOBOL_COLUMN(15, 0x0000aa09u, 0x0000a0c3u)
  SOBOL_COLUMN(16, 0x00010117u, 0x0001f104u)
  SOBOL_COLUMN(17, 0x0003033au, 0x0002e28au)
  SOBOL_COLUMN(18, 0x00060671u, 0x000457dfu)
  SOBOL_COLUMN(19, 0x000909a3u, 0x000c9baeu)
  SOBOL_COLUMN(20, 0x00171616u, 0x0011a105u)
  SOBOL_COLUMN(21, 0x003a3939u, 0x002a7289u)
  SOBOL_COLUMN(22, 0x00717777u, 0x0079e7dbu)
  SOBOL_COLUMN(23, 0x00a3aaaau, 0x00b6dba4u)
  SOBOL_COLUMN(24, 0x01170001u, 0x0100011au)
  SOBOL_COLUMN(25, 0x033a0003u, 0x030002a7u)
  SOBOL_COLUMN(26, 0x06710006u, 0x0400079eu)
  SOBOL_COLUMN(27, 0x09a30009u, 0x0a000b6du)
  SOBOL_COLUMN(28, 0x16160017u, 0x1f001001u)
  SOBOL_COLUMN(29, 0x3939003au, 0x2e003003u)
  SOBOL_COLUMN(30, 0x77770071u, 0x45004004u)
  SOBOL_COLUMN(31, 0xaaaa00a3u, 0xc900a00au)
#undef SOBOL_COLUMN
  return uvec4(index, pascal, sum);
}

// A block of the Sobol sampler, as 32 bits each.
uvec4 sobol_bits(uint seed, uint stream, uint sample_index, uint block) {
  uvec4 seeds = pcg4d(uvec4(stream, 0x2545f491u, block, seed));
  uint order = pcg4d(seeds).x;
  uint shuffled = bitfieldReverse(owen_scramble_reversed(uvec4(bitfieldReverse(sample_index)), uvec4(order)).x);
  return bitfieldReverse(owen_scramble_reversed(sobol_reversed(shuffled), seeds));
}

uvec4 hash_bits(uint seed, uint stream, uint sample_index, uint block) {
  return pcg4d(uvec4(stream, sample_index, block, seed));
}

// Uniform in [0, 1): the upper 24 bits, so every value is a float and 1 is never reached.
vec4 unit_interval(uvec4 bits) { return vec4(bits >> 8u) * (1.0 / 16777216.0); }

vec4 random_block(uint seed, uint stream, uint sample_index, uint block) {
  return unit_interval(spec_sampler == SAMPLER_SOBOL ? sobol_bits(seed, stream, sample_index, block)
                                                     : hash_bits(seed, stream, sample_index, block));
}

#endif
