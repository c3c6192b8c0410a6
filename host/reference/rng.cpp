#include "reference/rng.hpp"

#include <cstddef>

namespace regulus::reference {
namespace {

using Columns = std::array<uint32_t, 32>;

/// Primitive polynomial over GF(2) and first direction numbers of a dimension, as in the files of Joe and
/// Kuo: x^degree + a_1 x^(degree - 1) + ... + 1, the a_i being the bits of `coefficients`, the first one
/// highest.
struct Dimension {
  uint32_t degree, coefficients;
  std::array<uint32_t, 3> first;
};
constexpr std::array<Dimension, 3> JOE_KUO{{{1, 0, {1}}, {2, 1, {1, 3}}, {3, 1, {1, 3, 1}}}};

/// Direction numbers by the recurrence of Bratley and Fox (1988).
constexpr Columns direction_numbers(const Dimension& dimension) {
  Columns m{};
  for (uint32_t k = 0; k < m.size(); ++k) {
    if (k < dimension.degree) {
      m[k] = dimension.first[k];
      continue;
    }
    m[k] = m[k - dimension.degree] ^ m[k - dimension.degree] << dimension.degree;
    for (uint32_t i = 1; i < dimension.degree; ++i)
      if ((dimension.coefficients >> (dimension.degree - 1 - i) & 1) != 0) m[k] ^= m[k - i] << i;
  }
  for (uint32_t k = 0; k < m.size(); ++k) m[k] <<= 31 - k;
  return m;
}

constexpr Columns identity() {
  Columns columns{};
  for (uint32_t k = 0; k < columns.size(); ++k) columns[k] = 0x80000000u >> k;
  return columns;
}

constexpr std::array<Columns, 4> SOBOL{identity(), direction_numbers(JOE_KUO[0]),
                                       direction_numbers(JOE_KUO[1]), direction_numbers(JOE_KUO[2])};

uint32_t reverse_bits(uint32_t x) {
  uint32_t reversed = 0;
  for (int bit = 0; bit < 32; ++bit) reversed |= (x >> bit & 1) << (31 - bit);
  return reversed;
}

/// Flips every digit of the fraction depending on the digits before it: the hash of Laine and Karras (2011)
/// with the constants of Vegdahl (2021).
uint32_t owen_scramble(uint32_t fraction, uint32_t seed) {
  uint32_t v = reverse_bits(fraction);
  v ^= v * 0x3d20adeau;
  v += seed;
  v *= seed >> 16 | 1;
  v ^= v * 0x05526c56u;
  v ^= v * 0x53a22864u;
  return reverse_bits(v);
}

RandomBits pcg4d(RandomBits v) {
  for (uint32_t& x : v) x = x * 1664525u + 1013904223u;
  const auto mix = [&v] {
    v[0] += v[1] * v[3];
    v[1] += v[2] * v[0];
    v[2] += v[0] * v[1];
    v[3] += v[1] * v[2];
  };
  mix();
  for (uint32_t& x : v) x ^= x >> 16;
  mix();
  return v;
}

/// Swaps samples within each group of four such that the three ways to pair them, by all but the last digit
/// of the index, are equally likely.
uint32_t pair_anew(uint32_t index, uint32_t key) {
  // What becomes of 0, 1, 2, 3. Together stay 0 and 1, then 0 and 2, then 0 and 3.
  constexpr std::array<std::array<uint32_t, 4>, 3> WAYS{{{0, 1, 2, 3}, {0, 2, 1, 3}, {0, 2, 3, 1}}};
  uint32_t hash = (index / 4 ^ key) * 0x9E3779B1u;
  hash = (hash ^ hash >> 15) * 0x85EBCA77u;
  return index / 4 * 4 + WAYS[(hash >> 16) * 3 >> 16][index % 4];
}

}  // namespace

RandomBits sobol(uint32_t index) {
  RandomBits point{};
  for (size_t dimension = 0; dimension < point.size(); ++dimension)
    for (uint32_t bit = 0; bit < 32; ++bit)
      if ((index >> bit & 1) != 0) point[dimension] ^= SOBOL[dimension][bit];
  return point;
}

RandomBits sobol_bits(uint32_t seed, uint32_t stream, uint32_t sample_index, uint32_t block) {
  const RandomBits seeds = pcg4d({stream, 0x2545f491u, block, seed});
  const RandomBits order = pcg4d(seeds);
  RandomBits point = sobol(owen_scramble(pair_anew(sample_index, order[1]), order[0]));
  for (size_t dimension = 0; dimension < point.size(); ++dimension)
    point[dimension] = owen_scramble(point[dimension], seeds[dimension]);
  return point;
}

RandomBits hash_bits(uint32_t seed, uint32_t stream, uint32_t sample_index, uint32_t block) {
  return pcg4d({stream, sample_index, block, seed});
}

double unit_interval(uint32_t bits) {
  return (bits >> 8) * 0x1p-24;
}

}  // namespace regulus::reference
