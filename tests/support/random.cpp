#include "support/random.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

namespace regulus::test {

uint64_t base_seed() {
  static const uint64_t seed = [] {
    const char* text = std::getenv("REGULUS_TEST_SEED");
    const uint64_t value = text != nullptr ? std::strtoull(text, nullptr, 10) : 1;
    std::printf("random tests: seed %llu (REGULUS_TEST_SEED)\n", static_cast<unsigned long long>(value));
    return value;
  }();
  return seed;
}

Random::Random(uint64_t stream) {
  std::seed_seq sequence{base_seed(), base_seed() >> 32, stream, stream >> 32};
  engine_.seed(sequence);
}

double Random::log_uniform(double low, double high) {
  return std::exp(uniform(std::log(low), std::log(high)));
}

glm::dvec3 Random::direction() {
  const double z = uniform(-1, 1);
  const double phi = uniform(0, 2 * std::numbers::pi);
  const double sin_theta = std::sqrt(1 - z * z);
  return {sin_theta * std::cos(phi), sin_theta * std::sin(phi), z};
}

}  // namespace regulus::test
