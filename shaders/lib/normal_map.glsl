// Normal maps: the shading normal that a texture gives in the tangent frame of the vertices (MikkTSpace: normal and
// tangent are interpolated, not normalized). A function of the position alone.
#ifndef REGULUS_LIB_NORMAL_MAP_GLSL
#define REGULUS_LIB_NORMAL_MAP_GLSL

#include "lib/geometry.glsl"
#include "lib/texture.glsl"

// A mapped normal is raised to at least this cosine with the geometric normal.
const float MIN_MAPPED_COS = 0.01;

// Tangent between the vertices, not normalized; w: 1 or -1, sign of the bitangent w cross(normal, tangent).
vec4 vertex_tangent(Frame frame, PlacedTriangle placed, vec2 barycentrics) {
  vec4 t0 = placed_tangent(frame, placed, placed.triangle.v0);
  vec3 t1 = placed_tangent(frame, placed, placed.triangle.v1).xyz;
  vec3 t2 = placed_tangent(frame, placed, placed.triangle.v2).xyz;
  return vec4((1.0 - barycentrics.x - barycentrics.y) * t0.xyz + barycentrics.x * t1 + barycentrics.y * t2, t0.w);
}

// Unit shading normal of the front side by a texture whose x and y are scaled. The surface's own is the vertices'.
vec3 mapped_normal(Frame frame, uint triangle_number, vec2 barycentrics, Surface surface, uint image, float scale) {
  PlacedTriangle placed = placed_triangle(frame, triangle_number);
  vec3 normal = (1.0 - barycentrics.x - barycentrics.y) * placed_vertex(frame, placed, placed.triangle.v0).normal +
                barycentrics.x * placed_vertex(frame, placed, placed.triangle.v1).normal +
                barycentrics.y * placed_vertex(frame, placed, placed.triangle.v2).normal;
  vec4 tangent = vertex_tangent(frame, placed, barycentrics);
  vec3 map = sample_texture(frame, image, surface.uv).xyz * 2.0 - 1.0;
  map.xy *= scale;
  vec3 mapped = map.x * tangent.xyz + (map.y * tangent.w) * cross(normal, tangent.xyz) + map.z * normal;
  if (dot(normal, surface.geometric_normal) < 0.0) mapped = -mapped;
  float squared = dot(mapped, mapped);
  if (!(squared > 1e-12)) return surface.shading_normal;
  mapped *= inversesqrt(squared);
  float missing = MIN_MAPPED_COS - dot(mapped, surface.geometric_normal);
  return missing > 0.0 ? normalize(mapped + missing * surface.geometric_normal) : mapped;
}

#endif
