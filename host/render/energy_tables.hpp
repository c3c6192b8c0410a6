// The tables of energy compensation (shaders/lib/energy.glsl) of a scene, made on the device when they are
// asked for.
#pragma once

#include <vector>

#include "gpu/gpu.hpp"
#include "interface/scene.h"
#include "render/settings.hpp"

namespace regulus::render {

/// Integrates the tables for the interfaces of these materials under settings.ndf and settings.shadowing.
gpu::Buffer make_energy_tables(gpu::Device& device, const std::vector<interface::Material>& materials,
                               const RenderSettings& settings);

}  // namespace regulus::render
