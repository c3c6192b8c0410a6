// The counter-based random numbers of the shaders: equidistribution of every dimension of a block, in its
// high and its low bits, and of pairs, within a block and between neighbours, along every counter that a
// render advances. Sobol points are too even by design along the samples of a pixel (their nets are tested in
// numerics/rng_sobol.cpp), so there the sampler `sobol` is left out.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>

#include "interface/wavefront.h"
#include "support/chi_square.hpp"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::random_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using glm::uvec4;
using glm::vec4;
using namespace interface;

constexpr uint32_t COUNT = 1u << 18;
constexpr double FALSE_ALARM = 1e-4;  // of all tests of this file together
constexpr int CELLS = 1024;           // of a dimension
constexpr int SIDE = 32;              // cells of a pair's axis
constexpr int SEEDS = 3, SEQUENCES = 6, SOBOL_SEQUENCES = 4, TESTS_PER_SEQUENCE = 4 + 4 + 6 + 4;

/// The counters of one sequence, as (seed, pixel, sample, block).
struct Sequence {
  const char* name;
  bool has_one_sample_per_pixel;  // and so is a test of the sampler `sobol`, too
  std::function<uvec4(uint32_t seed, uint32_t i)> counter;
};

const Sequence SEQUENCE_LIST[SEQUENCES] = {
    {"pixels of a sample", true,
     [](uint32_t seed, uint32_t i) { return uvec4(seed, i, 0, DIMENSION_BLOCK_CAMERA); }},
    {"samples of a pixel", false,
     [](uint32_t seed, uint32_t i) { return uvec4(seed, 4711, i, DIMENSION_BLOCK_CAMERA); }},
    {"blocks of paths", true, [](uint32_t seed, uint32_t i) { return uvec4(seed, i / 32, 5, i % 32); }},
    {"columns of an image", false,
     [](uint32_t seed, uint32_t i) { return uvec4(seed, 512 * (i % 512), i / 512, 3); }},
    {"light paths", true,
     [](uint32_t seed, uint32_t i) { return uvec4(seed, i, 1, DIMENSION_BLOCK_EMISSION); }},
    {"seeds", true, [](uint32_t seed, uint32_t i) { return uvec4(seed + i, 4711, 2, 1); }},
};

/// Cell of a number in [0, 1) by its leading bits, and by its 10 last of 24.
int high_cell(float u, int cells) {
  return static_cast<int>(u * static_cast<float>(cells));
}
int low_cell(float u) {
  return static_cast<int>(u * 0x1p24f) & (CELLS - 1);
}

/// Counts `count` samples by `cell_of` and tests them for uniformity; returns the smaller tail of the
/// p-value, because numbers that are spread too evenly are not random either.
double tail(uint32_t count, const std::function<int(uint32_t)>& cell_of) {
  std::vector<double> observed(CELLS), expected(CELLS, static_cast<double>(count) / CELLS);
  for (uint32_t i = 0; i < count; ++i) observed.at(cell_of(i)) += 1;
  const ChiSquare result = chi_square_test(observed, expected);
  EXPECT_TRUE(result.problem.empty()) << result.problem;
  return std::min(result.p_value, 1 - result.p_value);
}

/// The smallest tail of all tests of these blocks.
double smallest_tail(const std::vector<vec4>& blocks) {
  double smallest = 1;
  const auto test = [&](uint32_t count, const std::function<int(uint32_t)>& cell_of) {
    smallest = std::min(smallest, tail(count, cell_of));
  };
  for (int d = 0; d < 4; ++d) {
    test(COUNT, [&](uint32_t i) { return high_cell(blocks[i][d], CELLS); });
    test(COUNT, [&](uint32_t i) { return low_cell(blocks[i][d]); });
    for (int e = d + 1; e < 4; ++e)
      test(COUNT,
           [&](uint32_t i) { return SIDE * high_cell(blocks[i][d], SIDE) + high_cell(blocks[i][e], SIDE); });
    // Neighbours in the sequence; the pairs do not overlap, so they are independent.
    test(COUNT / 2, [&](uint32_t i) {
      return SIDE * high_cell(blocks[2 * i][d], SIDE) + high_cell(blocks[2 * i + 1][d], SIDE);
    });
  }
  return smallest;
}

void test_sampler(uint32_t sampler) {
  const gpu::Kernel kernel =
      create_batch_kernel(random_kernels::spirv, "random_blocks", {{SPEC_SAMPLER, sampler}});
  const double significance =
      significance_per_test(FALSE_ALARM, SEEDS * (SEQUENCES + SOBOL_SEQUENCES) * TESTS_PER_SEQUENCE) / 2;
  for (int k = 0; k < SEEDS; ++k) {
    const auto seed =
        static_cast<uint32_t>((base_seed() - 1 + k) * 2654435761u);  // the first is the default seed
    for (const Sequence& sequence : SEQUENCE_LIST) {
      if (sampler == SAMPLER_SOBOL && !sequence.has_one_sample_per_pixel) continue;
      std::vector<uvec4> counters(COUNT);
      for (uint32_t i = 0; i < COUNT; ++i) counters[i] = sequence.counter(seed, i);
      const auto blocks = map_on_device<vec4>(kernel, counters);
      for (const vec4& block : blocks)
        for (int d = 0; d < 4; ++d) ASSERT_TRUE(block[d] >= 0 && block[d] < 1) << block[d];
      const double smallest = smallest_tail(blocks);
      std::printf("seed %10u, %-20s smallest of %d tails %.2g (alarm below %.1e)\n", seed, sequence.name,
                  TESTS_PER_SEQUENCE, smallest, significance);
      EXPECT_GT(smallest, significance) << sequence.name << ", seed " << seed;
    }
  }
}

TEST(RandomNumbers, OfHashAreEquidistributedAloneAndInPairs) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  test_sampler(SAMPLER_HASH);
}

TEST(RandomNumbers, OfSobolAreEquidistributedAloneAndInPairsOverPixels) {
  REGULUS_SKIP_WITHOUT_DEVICE();
  test_sampler(SAMPLER_SOBOL);
}

}  // namespace
}  // namespace regulus::test
