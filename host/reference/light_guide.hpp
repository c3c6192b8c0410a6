// Guided emission from its definition (docs/mathematics.md 16), in double precision: the four numbers that
// make a light path's start, the frozen tree that moves them, and its density.
#pragma once

#include <glm/glm.hpp>

#include "reference/lights.hpp"
#include "scene/light_guide.hpp"

namespace regulus::reference {

/// The numbers from which sample_light_point() (the first two) and sample_emission() (two more) make a ray of
/// light that leaves the point along `direction`, through `at`, a point of the ray in world space. Numbers
/// that make no difference are 0; so is the place on a triangle.
glm::dvec4 start_numbers(const World& world, const LightPoint& point, const glm::dvec3& direction,
                         const glm::dvec3& at);

/// Density of numbers that the tree of a light has moved.
double guide_density(const scene::LightGuide& guide, uint32_t light, const glm::dvec4& numbers);

/// Moves uniform numbers. Which way they go is decided in single precision, as on the device.
glm::dvec4 guide_start(const scene::LightGuide& guide, uint32_t light, const glm::dvec4& u);

}  // namespace regulus::reference
