// The guided camera walk (docs/mathematics.md 18): a share of the diffuse lobe's samples goes by a frozen distribution of where
// light comes from, that of the vertex' cell. Here are the cells, their directions, and the density of these.
#ifndef REGULUS_LIB_WALK_GUIDE_GLSL
#define REGULUS_LIB_WALK_GUIDE_GLSL

#include "lib/guide_tree.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// True if camera walks are guided. A macro, for the reasons in lib/bsdf_parameters.glsl.
#define has_walk_guide() (spec_walk_guide != 0u)

// Where a vertex looks for light.
struct GuideCell {
  float share;  // of the diffuse lobe's samples that go by the guide; 0: there is none
  uint root;    // of the tree of directions
};

// position: world space; normal: unit, geometric, on the side of the camera.
GuideCell guide_cell(Frame frame, vec3 position, vec3 normal) {
  vec3 place = clamp((position - frame.walk_guide_corner) * frame.walk_guide_scale, 0.0, ONE_MINUS_ULP);
  uint index = 0u;
  GuideNode node = LOAD(GuideNodeBuffer, frame.walk_guide_nodes, index);
  for (uint depth = 0u; depth < WALK_GUIDE_DEPTH; ++depth) {
    uint axis = node.next & WALK_GUIDE_AXIS_MASK;
    if (axis == WALK_GUIDE_CELL) break;
    bool is_lower;
    if (axis >= WALK_GUIDE_NORMALS) {
      bool is_reverse = axis >= WALK_GUIDE_REVERSES;
      float side = 0.01 * float(WALK_GUIDE_SIDE);
      is_lower = normal[axis - (is_reverse ? WALK_GUIDE_REVERSES : WALK_GUIDE_NORMALS)] < (is_reverse ? -side : side);
    } else {
      float doubled = 2.0 * place[axis];
      is_lower = doubled < 1.0;
      place[axis] = is_lower ? doubled : doubled - 1.0;
    }
    index = (node.next >> WALK_GUIDE_AXIS_BITS) + (is_lower ? 0u : 1u);
    node = LOAD(GuideNodeBuffer, frame.walk_guide_nodes, index);
  }
  return GuideCell(node.first_share, node.next >> WALK_GUIDE_AXIS_BITS);
}

// A direction towards light, and its density per steradian. w: unit, world space.
struct GuidedDirection {
  vec3 w;
  float pdf;
};

GuidedDirection guided_direction(Frame frame, GuideCell cell, vec2 u) {
  GuidedNumbers moved = guide_start(frame.walk_guide_nodes, cell.root, vec4(u, 0.0, 0.0));
  return GuidedDirection(sample_sphere(moved.numbers.xy), 0.25 * INV_PI * moved.density);
}

// The density of w per steradian.
float guided_pdf(Frame frame, GuideCell cell, vec3 w) {
  return 0.25 * INV_PI * guide_density(frame.walk_guide_nodes, cell.root, vec4(sphere_numbers(w), 0.0, 0.0));
}

#endif
