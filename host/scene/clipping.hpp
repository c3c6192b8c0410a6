// Clipping planes of cameras.
#pragma once

#include "scene/scene.hpp"

namespace regulus::scene {

/// Takes away the planes that hide nothing of what a camera can see: kernels need not look at them. Needs the
/// scene's triangles, copies and bounds. Films more than four times wider or higher than the camera's frame
/// may see beyond what is looked at here.
void drop_idle_planes(Scene& scene);

}  // namespace regulus::scene
