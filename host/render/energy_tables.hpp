// A scene's tables of what rough interfaces reflect and refract, made on the device: for energy
// compensation (shaders/lib/energy.glsl), for diffuse bases under rough dielectrics (shaders/lib/cover.glsl),
// and for raised lobes (shaders/lib/raised_light.glsl).
#pragma once

#include <vector>

#include "gpu/gpu.hpp"
#include "interface/scene.h"
#include "render/settings.hpp"

namespace regulus::render {

/// What the tables are for; those that nothing uses are left empty.
struct EnergyUses {
  bool has_compensation = false;
  bool has_rough_bases = false;
  bool raises_lobes = false;
};

/// Integrates the tables for the interfaces of these materials under settings.ndf and settings.shadowing.
/// `has_contacts`: solids may meet each other.
gpu::Buffer make_energy_tables(gpu::Device& device, const std::vector<interface::Material>& materials,
                               const CommonSettings& settings, const EnergyUses& uses,
                               bool has_contacts = false);

}  // namespace regulus::render
