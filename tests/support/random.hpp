// Random inputs for tests. Every random test takes its generator from here, so that its seed is printed and
// can be given from outside: REGULUS_TEST_SEED=n.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <random>

namespace regulus::test {

/// The seed of this run: REGULUS_TEST_SEED, or 1. Printed once, when first asked for.
uint64_t base_seed();

/// Uniform numbers for one test, a function of base_seed() and `stream`.
class Random {
 public:
  explicit Random(uint64_t stream);

  double uniform() { return distribution_(engine_); }  ///< [0, 1)
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform in the logarithm; 0 < low < high.
  double log_uniform(double low, double high);
  uint32_t index(uint32_t count) { return static_cast<uint32_t>(uniform() * count); }
  glm::dvec2 square() {
    const double x = uniform();
    return {x, uniform()};
  }
  glm::dvec3 cube() {
    const double x = uniform();
    const double y = uniform();
    return {x, y, uniform()};
  }
  /// Uniform direction on the sphere.
  glm::dvec3 direction();

 private:
  std::mt19937_64 engine_;
  std::uniform_real_distribution<double> distribution_{0.0, 1.0};
};

}  // namespace regulus::test
