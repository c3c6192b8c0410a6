// Which light next-event estimation samples from a surface point, in double precision: from the definition of
// the light tree's importance (pbrt-v4's BVHLightSampler, with the largest intensity in place of the power),
// by angles.
#pragma once

#include <glm/glm.hpp>
#include <optional>

#include "reference/world.hpp"

namespace regulus::reference {

/// A surface point that light falls on.
struct Receiver {
  glm::dvec3 position{0};
  glm::dvec3 normal{0};  ///< geometric, on the lit side; zero if light may come from both sides
};

/// A surface point that is lit from the side of `w_light`. Where a surface only reflects, that is the side on
/// which it is seen, too.
Receiver receiver_at(const World& world, const Surface& surface, const glm::dvec3& w_light);

/// Probability of choosing the light.
double choice_probability(const World& world, const Receiver& receiver, uint32_t light);

/// The light that two uniform numbers choose; nothing if none can reach the receiver. Precondition: the scene
/// has lights.
std::optional<uint32_t> choose_light(const World& world, const Receiver& receiver, const glm::dvec2& u);

}  // namespace regulus::reference
