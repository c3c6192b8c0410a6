// Trees of halved boxes (docs/mathematics.md 16) that guides are made of: numbers that are uniform in the unit cube are moved to
// where a tree has its density, and a node is GUIDE_LEAF or gives its lower half along one axis a share.
#ifndef REGULUS_LIB_GUIDE_TREE_GLSL
#define REGULUS_LIB_GUIDE_TREE_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"

// Numbers that a tree has moved, and their density.
struct GuidedNumbers {
  vec4 numbers;
  float density;
};

// Up to where numbers of [first, last] lead to the lower half: decided as in the reference, step by step in single precision.
// A function of its own, because the shader compiler carries `precise` back through structs for ever.
float last_of_lower(float first, float last, float share) {
  precise float middle = first + share * (last - first);
  return middle;
}

// Density of a half over that of the box.
float density_of_half(GuideNode node, bool is_lower) { return 2.0 * (is_lower ? node.first_share : 1.0 - node.first_share); }

uint node_of_half(GuideNode node, bool is_lower) { return (node.next >> GUIDE_AXIS_BITS) + (is_lower ? 0u : 1u); }

GuidedNumbers guide_start(DeviceAddress nodes, uint root, vec4 u) {
  vec4 corner = vec4(0.0), size = vec4(1.0);  // of the box
  vec4 first = vec4(0.0), last = vec4(1.0);   // of the numbers that lead into it
  float density = 1.0;
  uint index = root;
  for (uint depth = 0u; depth < GUIDE_DEPTH; ++depth) {
    GuideNode node = LOAD(GuideNodeBuffer, nodes, index);
    if (node.next == GUIDE_LEAF) break;
    uint axis = node.next & GUIDE_AXIS_MASK;
    float middle = last_of_lower(first[axis], last[axis], node.first_share);
    bool is_lower = u[axis] < middle;
    size[axis] *= 0.5;
    if (is_lower) {
      last[axis] = middle;
    } else {
      first[axis] = middle;
      corner[axis] += size[axis];
    }
    density *= density_of_half(node, is_lower);
    index = node_of_half(node, is_lower);
  }
  return GuidedNumbers(corner + size * min((u - first) / (last - first), ONE_MINUS_ULP), density);
}

// Density of the moved numbers `start`.
float guide_density(DeviceAddress nodes, uint root, vec4 start) {
  float density = 1.0;
  uint index = root;
  for (uint depth = 0u; depth < GUIDE_DEPTH; ++depth) {
    GuideNode node = LOAD(GuideNodeBuffer, nodes, index);
    if (node.next == GUIDE_LEAF) break;
    uint axis = node.next & GUIDE_AXIS_MASK;
    float place = 2.0 * start[axis];
    bool is_lower = place < 1.0;
    start[axis] = is_lower ? place : place - 1.0;
    density *= density_of_half(node, is_lower);
    index = node_of_half(node, is_lower);
  }
  return density;
}

#endif
