// The tables of what rough interfaces reflect, of a scene, made on the device: for energy compensation
// (shaders/lib/energy.glsl), or for diffuse bases under rough dielectrics (shaders/lib/cover.glsl).
#pragma once

#include <vector>

#include "gpu/gpu.hpp"
#include "interface/scene.h"
#include "render/settings.hpp"

namespace regulus::render {

/// Integrates the tables for the interfaces of these materials under settings.ndf and settings.shadowing:
/// with settings.has_energy_compensation those of energy compensation, otherwise the covers of diffuse bases.
/// `has_contacts`: solids may meet each other.
gpu::Buffer make_energy_tables(gpu::Device& device, const std::vector<interface::Material>& materials,
                               const CommonSettings& settings, bool has_contacts = false);

}  // namespace regulus::render
