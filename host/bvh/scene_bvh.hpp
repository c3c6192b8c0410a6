// The acceleration structure of a scene.
#pragma once

#include "bvh/bvh.hpp"
#include "scene/scene.hpp"

namespace regulus::bvh {

/// Builds the structure over all triangles of `scene` and its copies, tags each with its material class,
/// renumbers the scene's triangles to leaf order (one index serves both) and builds its light list, which
/// refers to them. After this the scene is ready for a renderer or the reference.
/// @throws regulus::Error as build()
Bvh build_for_scene(scene::Scene& scene);

}  // namespace regulus::bvh
