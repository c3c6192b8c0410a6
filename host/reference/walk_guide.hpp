// The guided camera walk from its definition (docs/mathematics.md 18), in double precision: the cell of a
// vertex, and the directions from where it expects light, with their density.
#pragma once

#include <glm/glm.hpp>

#include "scene/walk_guide.hpp"

namespace regulus::reference {

/// Where a vertex looks for light.
struct GuideCell {
  double share = 0;   ///< of the diffuse lobe's samples that go by the guide; 0: there is none
  uint32_t root = 0;  ///< of the tree of directions
};

/// The cell of a point of a surface whose unit geometric normal, on the side of the camera, is `normal`.
GuideCell guide_cell(const scene::WalkGuide& guide, const glm::dvec3& position, const glm::dvec3& normal);

/// The unit direction that two uniform numbers choose.
glm::dvec3 guided_direction(const scene::WalkGuide& guide, const GuideCell& cell, const glm::dvec2& u);

/// Density of a unit direction, 1/sr.
double guided_pdf(const scene::WalkGuide& guide, const GuideCell& cell, const glm::dvec3& w);

}  // namespace regulus::reference
