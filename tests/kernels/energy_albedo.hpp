// What surfaces return of even light on the device, by the kernel energy_albedo.
#ifndef REGULUS_TESTS_ENERGY_ALBEDO_HPP
#define REGULUS_TESTS_ENERGY_ALBEDO_HPP

#include <span>
#include <string_view>
#include <vector>

#include "energy_case.h"
#include "support/device.hpp"

namespace regulus::test_kernels {
std::span<const uint32_t> spirv(std::string_view name);
}

namespace regulus::test {

/// Albedo of each case by the same `samples` points, the kernel built with `constants`.
inline std::vector<glm::dvec3> energy_albedos(const std::vector<interface::EnergyCase>& cases,
                                              uint32_t samples, const Constants& constants) {
  const gpu::Kernel kernel = create_batch_kernel(test_kernels::spirv, "energy_albedo", constants);
  const std::vector<glm::vec3> events = map_on_device<glm::vec3>(kernel, cases, samples, samples);
  std::vector<glm::dvec3> albedos(cases.size(), glm::dvec3(0));
  for (size_t i = 0; i < events.size(); ++i)
    albedos[i / samples] += glm::dvec3(events[i]) / static_cast<double>(samples);
  return albedos;
}

}  // namespace regulus::test

#endif
