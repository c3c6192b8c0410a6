// The random numbers of the device are those of the reference, bit for bit, on every driver.
#include "reference/rng.hpp"

#include <gtest/gtest.h>

#include "kernels/rng_batch.h"
#include "support/device.hpp"
#include "support/random.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {
namespace {

using interface::uvec4;

class Rng : public testing::Test {
 protected:
  void SetUp() override { REGULUS_SKIP_WITHOUT_DEVICE(); }
};

/// Counters (seed, stream, sample, block): every combination of extremes, and random ones.
std::vector<uvec4> counters() {
  std::vector<uvec4> counters;
  const uint32_t extremes[] = {0u, 1u, 0x7FFFFFFFu, 0x80000000u, 0xFFFFFFFFu};
  for (const uint32_t seed : extremes)
    for (const uint32_t stream : extremes)
      for (const uint32_t sample : extremes)
        for (const uint32_t block : extremes) counters.emplace_back(seed, stream, sample, block);
  Random random(61);
  const auto draw = [&random] { return static_cast<uint32_t>(random.uniform() * 0x1p32); };
  while (counters.size() < 20'000) {
    const uint32_t seed = draw(), stream = draw(), sample = draw();
    counters.emplace_back(seed, stream, sample, draw());
  }
  return counters;
}

template <typename Reference>
void expect_equal_bits(uint32_t kind, const Reference& reference) {
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "rng_bits", {});
  const std::vector<uvec4> inputs = counters();
  const auto bits = map_on_device<reference::RandomBits>(kernel, inputs, 1, kind);
  for (size_t i = 0; i < inputs.size(); ++i) {
    const uvec4& v = inputs[i];
    ASSERT_EQ(bits[i], reference(v)) << v.x << ' ' << v.y << ' ' << v.z << ' ' << v.w;
  }
}

TEST_F(Rng, SobolPointsAreThoseOfTheTables) {
  expect_equal_bits(interface::RNG_POINT, [](const uvec4& v) { return reference::sobol(v.x); });
}

TEST_F(Rng, SobolBlocksAreThoseOfTheReference) {
  expect_equal_bits(interface::RNG_SOBOL,
                    [](const uvec4& v) { return reference::sobol_bits(v.x, v.y, v.z, v.w); });
}

TEST_F(Rng, HashBlocksAreThoseOfTheReference) {
  expect_equal_bits(interface::RNG_HASH,
                    [](const uvec4& v) { return reference::hash_bits(v.x, v.y, v.z, v.w); });
}

}  // namespace
}  // namespace regulus::test
