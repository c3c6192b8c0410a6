// The environment light in double precision: its radiance, and directions drawn in proportion to it by the
// scene's own distribution (interface::Environment).
#pragma once

#include <glm/glm.hpp>

#include "scene/environment.hpp"

namespace regulus::reference {

/// Radiance from unit direction `w` (towards the environment).
glm::dvec3 environment_radiance(const scene::Environment& environment, const glm::dvec3& w);

/// The direction that two uniform numbers choose.
glm::dvec3 sample_environment(const scene::Environment& environment, const glm::dvec2& u);

/// The numbers with which it chooses `w`. Precondition: the environment is a map.
glm::dvec2 environment_numbers(const scene::Environment& environment, const glm::dvec3& w);

/// Density of sample_environment(), 1/sr.
double environment_pdf(const scene::Environment& environment, const glm::dvec3& w);

}  // namespace regulus::reference
