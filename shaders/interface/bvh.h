// The acceleration structure as traversal reads it.
#ifndef REGULUS_INTERFACE_BVH_H
#define REGULUS_INTERFACE_BVH_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// A triangle in leaf order: world-space vertices as given (watertight edge tests need the vertices
// themselves, not edge vectors) and a tag that traversal returns with the hit (its meaning is the caller's:
// Regulus puts the material class in the low 8 bits).
struct BvhTriangle {
  vec3 v0, v1, v2;
  uint tag;
};
REGULUS_LAYOUT(BvhTriangle, 40);

// What the closest-hit query returns. Barycentrics: p = (1 - u - v) p0 + u p1 + v p2.
struct Hit {
  float t;  // distance along the (unit) ray direction
  float u, v;
  uint triangle;  // INVALID_INDEX: no hit
};
REGULUS_LAYOUT(Hit, 16);

REGULUS_INTERFACE_END

#endif
