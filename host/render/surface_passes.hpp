// What camera rays meet first, for AOVs: passes over pixels, once per render.
#pragma once

#include <vector>

#include "render/wavefront.hpp"

namespace regulus::render {

/// By pixel; empty unless the plan keeps STATE_SURFACES.
std::vector<interface::AovPixel> trace_surface_aovs(Wavefront& wavefront);

/// Path diffusion's footprints (lib/footprint.glsl) by pixel; empty unless the plan keeps STATE_SIGMA. What
/// waves left in path slots is lost.
std::vector<interface::vec3> trace_surface_footprints(Wavefront& wavefront);

}  // namespace regulus::render
