// Clipping planes of cameras.
#pragma once

#include "scene/scene.hpp"

namespace regulus::scene {

/// Takes away the planes that hide nothing of what a camera can see: kernels need not look at them. Needs the
/// scene's triangles, copies and bounds. Films more than four times wider or higher than the camera's frame
/// may see beyond what is looked at here.
void drop_idle_planes(Scene& scene);

/// How far from its axis a camera may see at its near plane, horizontally or vertically, m. Films as above.
double half_extent_at_near_plane(const SceneCamera& camera);

}  // namespace regulus::scene
