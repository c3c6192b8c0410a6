// The plan of a render for the scalar reference.
#pragma once

#include "reference/walk.hpp"
#include "render/plan.hpp"

namespace regulus::render {

/// The reference's settings for a plan.
/// @throws regulus::Error (BadUsage) for what the reference does not do: clamping shares of both or of
/// sampler quality.
reference::Settings reference_settings(const Plan& plan);

}  // namespace regulus::render
