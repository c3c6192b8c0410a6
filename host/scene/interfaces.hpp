// Which interfaces a scene's materials form: what tables of their reflectance are made for.
#pragma once

#include <vector>

#include "interface/scene.h"

namespace regulus::scene {

/// True if the material bounds solids that light enters.
bool bounds_solids(const interface::Material& material);

/// True if the material bounds solids that transmit in part, so that their diffuse base is seen from inside.
bool may_show_base_inside(const interface::Material& material);

/// Indices of refraction of the materials' interfaces, ascending, each once: against air, and if solids may
/// touch (`has_contacts`) of the denser against the other where solids meet. Of dispersive ones at some
/// wavelengths.
std::vector<float> interface_indices(const std::vector<interface::Material>& materials, bool has_contacts);

}  // namespace regulus::scene
