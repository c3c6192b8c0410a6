// Points on surfaces in world space: rounding-error bounds, ray origins that cannot hit their own surface,
// and the interpolated attributes of a hit.
#ifndef REGULUS_LIB_GEOMETRY_GLSL
#define REGULUS_LIB_GEOMETRY_GLSL

#include "lib/buffers.glsl"
#include "lib/specialization.glsl"

// The next float away from zero in the direction of `sign_of`'s sign, componentwise (Pharr et al., PBR 4ed,
// section 6.8.6); 0 stays within one denormal.
vec3 next_float_towards(vec3 value, vec3 sign_of) {
  ivec3 bits = floatBitsToInt(value);
  ivec3 away = ivec3(lessThan(bits, ivec3(0)));                  // negative numbers grow downwards in bits
  ivec3 up = ivec3(1) - 2 * away;                                // bit step that increases the value
  ivec3 step_bits = ivec3(sign(sign_of)) * up;
  bvec3 is_zero = equal(value, vec3(0.0));
  vec3 stepped = intBitsToFloat(bits + step_bits);
  return mix(stepped, value, is_zero);
}

// Origin for a ray that leaves `position` towards `direction`: shifted along the geometric normal to the
// side of the direction by more than the rounding error of the position (PBR 4ed, section 6.8.6).
vec3 offset_origin(vec3 position, vec3 position_error, vec3 normal, vec3 direction) {
  vec3 side = dot(direction, normal) < 0.0 ? -normal : normal;
  vec3 offset = dot(abs(side), position_error) * side;
  return next_float_towards(position + offset, offset);
}

// A point of a triangle with its absolute rounding error per axis.
struct SurfacePoint {
  vec3 position;
  vec3 position_error;
  vec3 normal;  // geometric, unit, front side
  float area;   // of the triangle, m^2
};

// Bound on the error of b0 p0 + b1 p1 + b2 p2 evaluated in float, relative to the sum of magnitudes: 7
// roundings of the interpolation (PBR 4ed, section 6.8.5) and as many again of the traversal's plane test
// that the offset must outweigh.
const float POSITION_ERROR = 16.0 * 5.9604645e-8;

SurfacePoint point_on_triangle(vec3 p0, vec3 p1, vec3 p2, vec2 barycentrics) {
  SurfacePoint point;
  vec3 a = (1.0 - barycentrics.x - barycentrics.y) * p0, b = barycentrics.x * p1, c = barycentrics.y * p2;
  point.position = a + b + c;
  point.position_error = POSITION_ERROR * (abs(a) + abs(b) + abs(c));
  vec3 cross_product = cross(p1 - p0, p2 - p0);
  // Scaled first: the squared length of a 1e-4 m triangle's cross product would underflow.
  float largest = max(abs(cross_product.x), max(abs(cross_product.y), abs(cross_product.z)));
  vec3 scaled = cross_product / largest;
  float scaled_length = length(scaled);
  point.normal = scaled / scaled_length;
  point.area = 0.5 * largest * scaled_length;
  return point;
}

// Everything shading needs of a hit.
struct Surface {
  vec3 position;
  vec3 position_error;
  vec3 geometric_normal;  // unit, front side
  vec3 shading_normal;    // unit, in the hemisphere of geometric_normal
  vec2 uv;
  uint material;
  uint light;
  float area;  // of the triangle, m^2
};

Surface surface_at(DeviceAddress triangles, DeviceAddress vertices, uint triangle_index, vec2 barycentrics) {
  Triangle triangle = LOAD(TriangleBuffer, triangles, triangle_index);
  Vertex v0 = LOAD(VertexBuffer, vertices, triangle.v0);
  Vertex v1 = LOAD(VertexBuffer, vertices, triangle.v1);
  Vertex v2 = LOAD(VertexBuffer, vertices, triangle.v2);
  SurfacePoint point = point_on_triangle(v0.position, v1.position, v2.position, barycentrics);

  Surface surface;
  surface.position = point.position;
  surface.position_error = point.position_error;
  surface.geometric_normal = point.normal;
  surface.area = point.area;
  surface.shading_normal = point.normal;
  float b0 = 1.0 - barycentrics.x - barycentrics.y;
  if ((spec_features & FEATURE_SMOOTH_NORMALS) != 0u) {
    vec3 normal = b0 * v0.normal + barycentrics.x * v1.normal + barycentrics.y * v2.normal;
    float squared = dot(normal, normal);
    if (squared > 1e-12) {
      normal *= inversesqrt(squared);
      surface.shading_normal = dot(normal, point.normal) < 0.0 ? -normal : normal;
    }
  }
  surface.uv = b0 * v0.uv + barycentrics.x * v1.uv + barycentrics.y * v2.uv;
  surface.material = triangle.material;
  surface.light = triangle.light;
  return surface;
}

#endif
