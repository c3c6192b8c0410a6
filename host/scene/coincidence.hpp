// Surfaces that lie in one another.
#pragma once

namespace regulus::scene {

struct Scene;

/// True if two triangles overlap in one plane, within what single precision tells apart, and it matters which
/// of them rays meet: one emits, or one bounds a solid and the other does not, or they differ in material and
/// face the same way or are the two faces of a leaf. (Of other opaque faces that face each other nothing is
/// seen.) Triangles so small that thousands fit on a disk as large as the scene are looked at only if they
/// emit or bound a solid; copies are not. Call when the lights are built.
bool has_coincident_surfaces(const Scene& scene);

}  // namespace regulus::scene
