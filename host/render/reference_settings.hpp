// The plan of a render for the scalar reference.
#pragma once

#include "reference/walk.hpp"
#include "render/plan.hpp"

namespace regulus::render {

/// The reference's settings for a plan.
/// @throws regulus::Error (BadUsage) for the one thing that the reference cannot do: clamping together with
/// `both` or sampler quality, which split a contribution into shares
reference::Settings reference_settings(const Plan& plan);

}  // namespace regulus::render
