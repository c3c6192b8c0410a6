// The frozen trees that guides are made of, from their definition (docs/mathematics.md 16), in double
// precision: numbers of the unit cube, moved, and their density.
#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "interface/scene.h"

namespace regulus::reference {

/// Density of numbers that the tree at `root` has moved.
double tree_density(const std::vector<interface::GuideNode>& nodes, uint32_t root, const glm::dvec4& numbers);

/// Moves uniform numbers. Which way they go is decided in single precision, as on the device.
glm::dvec4 tree_start(const std::vector<interface::GuideNode>& nodes, uint32_t root, const glm::dvec4& u);

}  // namespace regulus::reference
