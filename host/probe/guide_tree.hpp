// Makes the frozen table of guided emission out of deposits: where light would have to start.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/light_guide.hpp"
#include "scene/scene.hpp"

namespace regulus::probe {

/// Light that started like this was of use. Whole numbers, so that sums do not depend on their order.
struct Deposit {
  uint32_t light = 0;
  std::array<uint16_t, 4> cell{};  ///< start_numbers() in units of 2^-GUIDE_HALVINGS
  uint64_t weight = 0;
};

/// The guide that starts light where deposits lie, and with DEFENSIVE_SHARE by power. Lights of which few
/// deposits tell share them with their neighbours in the light tree, in proportion to their power.
/// Precondition: some deposit has a weight.
scene::LightGuide make_light_guide(const scene::Scene& scene, std::vector<Deposit> deposits);

/// Density of the deposit's start by the guide over that by power.
double share_of_start(const scene::Scene& scene, const scene::LightGuide& guide, const Deposit& deposit);

}  // namespace regulus::probe
