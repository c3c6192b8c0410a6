// The acceleration structure as traversal reads it: a tree of up to eight children per node with 8-bit
// quantized child boxes, and triangles in leaf order.
#ifndef REGULUS_INTERFACE_BVH_H
#define REGULUS_INTERFACE_BVH_H

#include "types.h"

REGULUS_INTERFACE_BEGIN

// Entries of the traversal stack of one ray, one per level at most; no tree is built deeper.
REGULUS_CONSTANT BVH_MAX_DEPTH = 24u;
// A leaf holds at most this many triangles.
REGULUS_CONSTANT BVH_MAX_LEAF_SIZE = 4u;

// A reference to a child: BVH_LEAF_BIT | (triangle count - 1) << BVH_LEAF_COUNT_SHIFT | first triangle for a leaf,
// BVH_INSTANCE_BIT | its index for an instance, the node's index otherwise (below 2^24, for the stack packs it with an
// 8-bit mask).
REGULUS_CONSTANT BVH_LEAF_BIT = 0x80000000u;
REGULUS_CONSTANT BVH_LEAF_COUNT_SHIFT = 29u;
REGULUS_CONSTANT BVH_LEAF_FIRST_MASK = 0x1FFFFFFFu;
REGULUS_CONSTANT BVH_MAX_NODES = 1u << 24;
REGULUS_CONSTANT BVH_INSTANCE_BIT = 0x40000000u;
REGULUS_CONSTANT BVH_MAX_INSTANCES = 1u << 24;

// A node. Plane q of an axis lies at origin + q * 2^(e - 127), e the axis' byte of `exponents` (x lowest; bits of the
// fourth byte: which slots have a child).
// planes[4 axis + 0..1] hold the eight children's lower planes, [4 axis + 2..3] the upper ones, one byte
// each. The decoded box contains the child with a margin that covers the rounding of the slab test. Bit k of
// a child's slot tends to be set where the child lies at the upper end of axis k, so that for a ray that runs
// down the axes of the bits of `octant` the slots run front to back by ascending slot ^ octant. An empty slot
// has lower planes 255, upper planes 0 and is never hit.
struct BvhNode {
  vec3 origin;
  uint exponents;
  uint planes[12];
  uint children[8];
};
REGULUS_LAYOUT(BvhNode, 96);

// A triangle in leaf order: vertices as given, in world space or that of a mesh with instances (watertight edge tests
// need the vertices themselves, not edge vectors) and a tag that traversal returns with the hit (its meaning is the caller's:
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
  uint triangle;  // its number (see Instance); INVALID_INDEX: no hit
};
REGULUS_LAYOUT(Hit, 16);

// What the device's own structure (RAYS_HARDWARE) calls the triangles that stand for themselves, and from where on copies.
REGULUS_CONSTANT HARDWARE_PLACED = 0u;
REGULUS_CONSTANT HARDWARE_FIRST_COPY = 1u;

REGULUS_INTERFACE_END

#endif
