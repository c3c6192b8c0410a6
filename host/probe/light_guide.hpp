// Trains the guide of light paths (docs/mathematics.md 16): the scalar reference walks few paths from the
// camera and notes from where, and which way, light would have to start to reach them.
#pragma once

#include <memory>

#include "reference/walk.hpp"
#include "reference/world.hpp"

namespace regulus::probe {

/// Share of light paths that start by power, whatever the guide says: no start is less likely than this share
/// of what it is without a guide.
inline constexpr double DEFENSIVE_SHARE = 0.2;

/// A guide and what it is worth.
struct TrainedLightGuide {
  std::shared_ptr<const scene::LightGuide> guide;  ///< null: no light reaches what the camera sees
  /// By how much starts by power have a larger second moment than guided ones, of what one light path brings
  /// to where the camera's paths go: trained on one half of the camera's paths, told by the other.
  double gain = 1;
};

/// Walks the samples of the settings of every pixel, on all processors. The result does not depend on their
/// number: it is a function of scene, camera and settings.
/// @param world without a guide
/// @param settings a film of few pixels, techniques TECHNIQUE_HIT | TECHNIQUE_NEE, no regularization
TrainedLightGuide train_light_guide(const reference::World& world, const reference::Settings& settings);

}  // namespace regulus::probe
