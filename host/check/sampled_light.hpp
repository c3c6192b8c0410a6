// Which light the device sampled: single precision may take another decision on the way down the light tree.
#pragma once

#include <glm/glm.hpp>

#include "interface/wavefront.h"
#include "reference/light_choice.hpp"

namespace regulus::check {

/// How the light that the device sampled relates to the reference's.
enum class LightChoice {
  Same,
  Tie,         ///< chosen by numbers that rounding may have moved there
  Unexplained  ///< no light that can be chosen lies where the segment leads
};

/// What a shadow segment tells of its light.
struct SampledLight {
  uint32_t light = interface::INVALID_INDEX;  ///< the likeliest; INVALID_INDEX: none can be chosen
  LightChoice choice = LightChoice::Unexplained;
};

/// The light that a candidate of next-event estimation was sampled from, told by where its segment leads: of
/// the one that the numbers (x, y) choose, or those that numbers moved by rounding do, the nearest. (z, w)
/// place the point on the light.
SampledLight sampled_light(const reference::World& world, const reference::Receiver& receiver,
                           const glm::dvec4& numbers, const interface::VisibilityCandidate& candidate);

}  // namespace regulus::check
