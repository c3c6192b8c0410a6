// Makes the frozen table of guided emission out of deposits: where light would have to start. Its trees serve
// the guide of camera walks, too.
#pragma once

#include <array>
#include <cstdint>
#include <span>
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

/// A weight in whole numbers, of those with this mean: 32 means at most, so that none outweighs all others.
uint64_t whole_weight(double weight, double mean);

/// Appends a tree over the given axes that has its density where deposits lie, and returns its root.
/// `defensive`: share of it that is spread evenly; `least`: deposits of a box that is halved. Reorders the
/// deposits.
uint32_t add_tree(std::vector<interface::GuideNode>& nodes, const std::vector<size_t>& axes,
                  std::span<Deposit> deposits, double defensive, size_t least);

/// Density at the deposit of the tree at `root`.
double tree_density(const std::vector<interface::GuideNode>& nodes, uint32_t root, const Deposit& deposit);

/// The guide that starts light where deposits lie, and with DEFENSIVE_SHARE by power. Lights of which few
/// deposits tell share them with their neighbours in the light tree, in proportion to their power.
/// Precondition: some deposit has a weight.
scene::LightGuide make_light_guide(const scene::Scene& scene, std::vector<Deposit> deposits);

/// Density of the deposit's start by the guide over that by power.
double share_of_start(const scene::Scene& scene, const scene::LightGuide& guide, const Deposit& deposit);

}  // namespace regulus::probe
