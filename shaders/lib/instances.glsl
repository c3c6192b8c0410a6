// Triangles by their numbers: stored triangles, and those of copies of meshes that are stored once (interface::Instance).
// Without FEATURE_INSTANCES a number is an index. Emissive triangles are never copies, so lights need none of this.
#ifndef REGULUS_LIB_INSTANCES_GLSL
#define REGULUS_LIB_INSTANCES_GLSL

#include "lib/buffers.glsl"
#include "lib/placement.glsl"
#include "lib/specialization.glsl"

bool has_instances() { return (spec_features & FEATURE_INSTANCES) != 0u; }

// A triangle where it stands in the world; placed_vertex gives its vertices.
struct PlacedTriangle {
  Triangle triangle;
  bool is_copy;
  Instance copy;  // if it is one
};

PlacedTriangle placed_triangle(Frame frame, uint number) {
  PlacedTriangle placed;
  placed.is_copy = false;
  uint index = number;
  if (has_instances()) {
    placed.is_copy = number >= frame.stored_triangles;
    if (placed.is_copy) {
      uint block = (number - frame.stored_triangles) >> frame.instance_block_shift;
      placed.copy = LOAD(InstanceBuffer, frame.instances, LOAD(WordBuffer, frame.instance_blocks, block));
      index = number - placed.copy.first_number + placed.copy.first_triangle;
    }
  }
  placed.triangle = LOAD(TriangleBuffer, frame.triangles, index);
  if (has_instances()) {
    if (placed.is_copy) {
      placed.triangle.instance = placed.copy.place;
      Triangle t = placed.triangle;
      if (placed.copy.is_mirrored != 0u) placed.triangle = Triangle(t.v0, t.v2, t.v1, t.material, t.light, t.instance);
    }
  }
  return placed;
}

// Vertex `index` of the triangle, in world space.
Vertex placed_vertex(Frame frame, PlacedTriangle placed, uint index) {
  Vertex vertex = LOAD(VertexBuffer, frame.vertices, index);
  if (has_instances()) {
    if (placed.is_copy) {
      vertex.position = placed_position(placed.copy.x_axis, placed.copy.y_axis, placed.copy.z_axis,
                                        placed.copy.translation, vertex.position);
      vertex.normal = normalize(placed.copy.inverse_x * vertex.normal.x + placed.copy.inverse_y * vertex.normal.y +
                                placed.copy.inverse_z * vertex.normal.z);
    }
  }
  return vertex;
}

// Tangent of vertex `index` of the triangle, in world space; w: sign of the bitangent.
vec4 placed_tangent(Frame frame, PlacedTriangle placed, uint index) {
  vec4 tangent = LOAD(Vec4Buffer, frame.vertex_tangents, index);
  if (has_instances()) {
    if (placed.is_copy) {
      tangent.xyz = normalize(placed.copy.x_axis * tangent.x + placed.copy.y_axis * tangent.y +
                              placed.copy.z_axis * tangent.z);
      if (placed.copy.is_mirrored != 0u) tangent.w = -tangent.w;
    }
  }
  return tangent;
}

#endif
