// How large merges are: by what the camera sees, never by the scene's bounds, which a sky dome or a ground
// plane of a kilometre inflates. Nothing here depends on film size, crop, samples, seed or device.
#pragma once

#include "reference/world.hpp"

namespace regulus::reference {

/// Where no radius is given, merges have the footprint of this share of the picture's height at the surfaces
/// seen.
inline constexpr double MERGE_FOOTPRINT = 1e-3;
/// Largest default radius, and bounds on a given one, in extents of what is seen.
inline constexpr double LARGEST_DEFAULT_RADIUS = 0.01, LARGEST_GIVEN_RADIUS = 0.1, LEAST_GIVEN_RADIUS = 1e-6;
/// Radius where camera rays meet no surface at all, in radii of the scene: nothing can merge then.
inline constexpr double UNSEEN_RADIUS = 0.003;

/// What a fixed set of camera rays meets.
struct SeenSurfaces {
  /// m: MERGE_FOOTPRINT of the picture's height where the rays meet surfaces, the median; 0: they meet none.
  double footprint = 0;
  /// m: median distance of those points from their middle, which is their median along each axis.
  double extent = 0;
};

/// Follows 32 x 32 rays, evenly spread over a film of width x height pixels (whose shape alone matters),
/// through mirrors and clear glass to the first surface where paths can merge: one with a lobe that is not a
/// delta, and that does not emit light itself. If no ray comes to such a surface, the first surfaces that
/// rays meet count.
SeenSurfaces see_surfaces(const World& world, const scene::SceneCamera& camera, uint32_t width,
                          uint32_t height);

/// A radius with the rule that it follows, for headers and statistics.
struct MergeRadius {
  float metres;  ///< rounded to three digits, so that the last bits of a machine's mathematics do not show
  const char* rule;  ///< a few words
};

/// The radius where none is given: the footprint, at most LARGEST_DEFAULT_RADIUS of the extent.
MergeRadius default_merge_radius(const SeenSurfaces& seen, double scene_radius);

/// The radius in metres where a share of the extent is asked for, at most the whole extent. Where nothing is
/// seen, the share is of the scene's radius.
float radius_of_share(float share, const SeenSurfaces& seen, double scene_radius);

/// The radius where `metres` (finite, above 0) are asked for: kept between LEAST_GIVEN_RADIUS and
/// LARGEST_GIVEN_RADIUS of the extent.
MergeRadius given_merge_radius(float metres, const SeenSurfaces& seen, double scene_radius);

}  // namespace regulus::reference
