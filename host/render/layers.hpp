// Layers of a film: beside the picture, the light of single kinds and of groups of lights.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "interface/wavefront.h"
#include "scene/scene.hpp"

namespace regulus::render {

/// Which layers a film has, and what of the light goes to which of them.
struct Layers {
  std::vector<std::string> names{};  ///< of their channels, in ascending order
  /// By interface::LIGHT_*; INVALID_INDEX: it has none.
  std::array<uint32_t, interface::LIGHT_KINDS> of_kind{};
  uint32_t first_group = interface::INVALID_INDEX;  ///< the layer of group 0; INVALID_INDEX: no group has one
  std::vector<uint32_t> group_of_light{};           ///< by light
};

/// Of a scene whose lights are built. @param aovs AOV_* bits
Layers choose_layers(const scene::Scene& scene, uint32_t aovs);

}  // namespace regulus::render
