// Trains the guide of camera walks (docs/mathematics.md 18): the scalar reference walks few paths from the
// camera, to learn where they go, and more from lights, to learn from where light arrives there.
#pragma once

#include <memory>

#include "reference/walk.hpp"
#include "reference/world.hpp"

namespace regulus::probe {

/// A guide and what it is worth.
struct TrainedWalkGuide {
  std::shared_ptr<const scene::WalkGuide> guide;  ///< null: no light arrives that a walk would have to find
  double gain = 1;                                ///< see MadeWalkGuide
};

/// Walks the samples of the settings of every pixel, and light paths by the world's own light guide, on all
/// processors. The result does not depend on their number: it is a function of scene, camera and settings.
/// @param settings a film of few pixels; their techniques say what is left for a walk to find, and there are
/// as many light paths as they say at most, in batches of 8192
TrainedWalkGuide train_walk_guide(const reference::World& world, const reference::Settings& settings);

}  // namespace regulus::probe
