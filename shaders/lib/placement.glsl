// Where a vertex of a mesh with instances stands.
#ifndef REGULUS_LIB_PLACEMENT_GLSL
#define REGULUS_LIB_PLACEMENT_GLSL

// World-space position of vertex v, see interface::Instance. `precise`, because traversal and shading must agree to the bit.
vec3 placed_position(vec3 x_axis, vec3 y_axis, vec3 z_axis, vec3 translation, vec3 v) {
  precise vec3 position = x_axis * v.x + y_axis * v.y + z_axis * v.z + translation;
  return position;
}

#endif
