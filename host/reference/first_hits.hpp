// What camera rays meet first, for AOVs.
#pragma once

#include <vector>

#include "reference/walk.hpp"

namespace regulus::reference {

/// An interface::AovPixel for each rendered pixel, row by row, in single precision: means over AOV_RAYS
/// camera rays, those of the pixel's first samples, and what the ray through the middles of lens and pixel
/// meets.
std::vector<interface::AovPixel> first_hits(const World& world, const Camera& camera,
                                            const Settings& settings);

/// Of each of those rays, AOV_RAYS of a pixel: the instance and the material that it meets, or INVALID_INDEX.
std::vector<glm::uvec2> first_ids(const World& world, const Camera& camera, const Settings& settings);

}  // namespace regulus::reference
