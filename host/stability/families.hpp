// One function a family: makes its cases, runs both sides and returns the sweeps.
#pragma once

#include "stability/report.hpp"

namespace regulus::stability {

/// Microfacet lobes: value, pdfs, regularized values and sampling weights.
std::vector<Sweep> sweep_bsdf(gpu::Device& device, Extent extent);

}  // namespace regulus::stability
