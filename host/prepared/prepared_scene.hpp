// A scene with all that is found out about it before it is rendered: made once, shared by every render of it,
// on the device or by the reference.
#pragma once

#include <vector>

#include "bvh/bvh.hpp"
#include "interface/wavelengths.h"
#include "scene/scene.hpp"

namespace regulus {

/// Made by prepare() and const from then on: its parts refer to each other.
struct PreparedScene {
  scene::Scene scene;  ///< triangles in the order of the tree's leaves, lights with their tree, solids
  bvh::Bvh bvh;
  scene::Features features;
  std::vector<float> sheen_table;                  ///< scene::make_sheen_table(), if some material has sheen
  std::vector<interface::Wavelength> wavelengths;  ///< scene::make_wavelengths(), if some solid is dispersive
};

/// Finds the solids, builds the acceleration structure, renumbers the scene's triangles by it, builds the
/// lights and their tree, and finds what touches or holds what, and the features.
/// @param scene as scene::load() gives it
/// @throws regulus::Error as bvh::build()
PreparedScene prepare(scene::Scene scene);

}  // namespace regulus
