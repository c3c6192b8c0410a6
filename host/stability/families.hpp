// One function a family: makes its cases, runs both sides and returns the sweeps.
#pragma once

#include "stability/report.hpp"

namespace regulus::stability {

/// Microfacet lobes: value, pdfs, regularized values and sampling weights.
std::vector<Sweep> sweep_bsdf(gpu::Device& device, Extent extent);

/// Weights of multiple importance sampling, and that they sum to one.
std::vector<Sweep> sweep_weights(gpu::Device& device, Extent extent);

/// Rays against triangles: distances, and rays that no closed surface may let through.
std::vector<Sweep> sweep_geometry(gpu::Device& device, Extent extent);

/// Power and falloff of spots however narrow.
std::vector<Sweep> sweep_lights(gpu::Device& device, Extent extent);

/// Pictures of scenes whose radiance is known.
std::vector<Sweep> sweep_pictures(gpu::Device& device, Extent extent);

/// Connections and merges where surfaces meet: corners, borders of materials, the horizon.
std::vector<Sweep> sweep_connections(gpu::Device& device, Extent extent);

/// Sums of the film, and samples that it must refuse.
std::vector<Sweep> sweep_film(gpu::Device& device, Extent extent);

}  // namespace regulus::stability
