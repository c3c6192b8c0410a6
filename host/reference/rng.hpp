// The random numbers of shaders/lib/rng.glsl, bit for bit, written from their definitions: the Sobol sequence
// from tables of direction numbers, digits in their usual order.
#pragma once

#include <array>
#include <cstdint>

namespace regulus::reference {

/// Four 32-bit fractions: value / 2^32 in [0, 1).
using RandomBits = std::array<uint32_t, 4>;

/// Point `index` of the four-dimensional Sobol sequence with the direction numbers of Joe and Kuo
/// ("Constructing Sobol Sequences with Better Two-Dimensional Projections", 2008; their first four
/// dimensions).
RandomBits sobol(uint32_t index);

/// Block of the sampler `sobol`: the sequence over `sample_index`, shuffled and scrambled by (seed, stream,
/// block) (Burley, "Practical Hash-based Owen Scrambling", JCGT 2020), each four samples paired anew
/// (docs/mathematics.md 11). A camera path's stream is its pixel.
RandomBits sobol_bits(uint32_t seed, uint32_t stream, uint32_t sample_index, uint32_t block);

/// Block of the sampler `hash`: PCG4D (Jarzynski and Olano, JCGT 2020) of the four numbers.
RandomBits hash_bits(uint32_t seed, uint32_t stream, uint32_t sample_index, uint32_t block);

/// The number in [0, 1) that shaders use: the upper 24 bits.
double unit_interval(uint32_t bits);

}  // namespace regulus::reference
