// Emitters that lie in one another.
#pragma once

#include <cstddef>

namespace regulus::scene {

struct Scene;

/// Takes from emissive triangles what lies in the plane of another one that shines to the same side: rays
/// would meet one of the two, light sampling both. What emits from both sides stays, then what comes first in
/// the file. The rest of a triangle becomes triangles of its own. Surfaces with holes by alpha hide nothing,
/// boundaries of refracting solids are left alone. Returns how many triangles lost something. Call when
/// materials are known, before anything refers to triangles by number.
size_t cut_overlapping_emitters(Scene& scene);

}  // namespace regulus::scene
