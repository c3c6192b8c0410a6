// Points on surfaces in world space: rounding-error bounds, ray origins that cannot hit their own surface,
// and the interpolated attributes of a hit.
#ifndef REGULUS_LIB_GEOMETRY_GLSL
#define REGULUS_LIB_GEOMETRY_GLSL

#include "lib/buffers.glsl"
#include "lib/instances.glsl"
#include "lib/specialization.glsl"
#include "lib/texture_coordinates.glsl"

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

// Origin for a ray that leaves a surface point towards `direction`: shifted along the geometric normal, to the
// side of the direction, by the point's `clearance` (below), and rounded away from the surface.
vec3 offset_origin(vec3 position, float clearance, vec3 normal, vec3 direction) {
  vec3 offset = dot(direction, normal) < 0.0 ? -clearance * normal : clearance * normal;
  return next_float_towards(position + offset, offset);
}

// A point of a triangle.
struct SurfacePoint {
  vec3 position;
  float clearance;  // m along the normal beyond which no ray from here meets the triangle itself, see below
  vec3 normal;      // geometric, unit, front side
  float area;       // of the triangle, m^2
};

const float FLOAT_EPSILON = 5.9604645e-8;  // 2^-24, relative error of one rounding
// Roundings of b0 p0 + b1 p1 + b2 p2, relative to the sum of magnitudes (PBR 4ed, section 6.8.5).
const float POSITION_ERROR = 8.0 * FLOAT_EPSILON;
// Roundings of the traversal's triangle test for an origin on the triangle: the edge functions of its sheared
// vertices err by at most 6 epsilon E^2, with E the distance to the farthest vertex, so the numerator of t
// errs by 20 epsilon E^3, and t by that over the projected area. The shift that outweighs it is
// 20 epsilon E (E^2 / 2 area) whatever the direction. The shape factor is bounded for needles, whose
// worst case would be many times their width while their typical error is a small part of it.
const float PLANE_ERROR = 20.0 * FLOAT_EPSILON;
const float MAX_SHAPE_FACTOR = 64.0;

SurfacePoint point_on_triangle(vec3 p0, vec3 p1, vec3 p2, vec2 barycentrics) {
  SurfacePoint point;
  vec3 a = (1.0 - barycentrics.x - barycentrics.y) * p0, b = barycentrics.x * p1, c = barycentrics.y * p2;
  point.position = a + b + c;
  vec3 cross_product = cross(p1 - p0, p2 - p0);
  // Scaled first: the squared length of a 1e-4 m triangle's cross product would underflow.
  float largest = max(abs(cross_product.x), max(abs(cross_product.y), abs(cross_product.z)));
  vec3 scaled = cross_product / largest;
  float scaled_length = length(scaled);
  point.normal = scaled / scaled_length;
  point.area = 0.5 * largest * scaled_length;

  vec3 to0 = p0 - point.position, to1 = p1 - point.position, to2 = p2 - point.position;
  float extent_squared = max(dot(to0, to0), max(dot(to1, to1), dot(to2, to2)));
  float shape = min(extent_squared / (2.0 * point.area), MAX_SHAPE_FACTOR);
  point.clearance = POSITION_ERROR * dot(abs(point.normal), abs(a) + abs(b) + abs(c)) +
                    PLANE_ERROR * sqrt(extent_squared) * shape;
  if ((spec_features & FEATURE_CONTACTS) != 0u) {
    // Far enough to be beyond whatever else lies in the same plane (lib/contacts.glsl).
    vec3 size = abs(point.position);
    point.clearance += float(CONTACT_CLEARANCE) * FLOAT_EPSILON * max(size.x, max(size.y, size.z));
  }
  return point;
}

// COLOR_0 between the vertices of a triangle, linear RGBA. White if the scene has none.
vec4 vertex_color(Frame frame, Triangle triangle, vec2 barycentrics) {
  if ((spec_features & FEATURE_VERTEX_COLORS) == 0u) return vec4(1.0);
  return (1.0 - barycentrics.x - barycentrics.y) * LOAD(Vec4Buffer, frame.vertex_colors, triangle.v0) +
         barycentrics.x * LOAD(Vec4Buffer, frame.vertex_colors, triangle.v1) +
         barycentrics.y * LOAD(Vec4Buffer, frame.vertex_colors, triangle.v2);
}

// Everything that shading needs to know of a hit.
struct Surface {
  vec3 position;
  float clearance;        // see SurfacePoint
  vec3 geometric_normal;  // unit, front side
  vec3 shading_normal;    // unit, in the hemisphere of geometric_normal
  TextureCoordinates uv;
  vec4 color;             // vertex colour
  uint material;
  uint light;
  float area;  // of the triangle, m^2
  // Only with FEATURE_BULGES: the side on which the vertex normals spread (1 the front, -1 the back, 0 neither), and the way
  // from the triangle to the curved surface that they suggest on that side, m.
  float bulge;
  vec3 rise;
};

// Vertex normals that spread by less than this, in radians, hide no facet.
const float LEAST_BULGE = 1e-3;

// Hanika, "Hacking the Shadow Terminator", Ray Tracing Gems II, 2021: the point is projected onto the tangent planes of the
// vertices that lie above it, and these points are interpolated. sign_of_normals: -1 if the vertex normals point to the back.
void find_bulge(Vertex v0, Vertex v1, Vertex v2, vec3 b, float sign_of_normals, inout Surface surface) {
  vec3 e0 = v1.position - v0.position, e1 = v2.position - v1.position, e2 = v0.position - v2.position;
  float spread = sign_of_normals * (dot(e0, v1.normal - v0.normal) + dot(e1, v2.normal - v1.normal) +
                                    dot(e2, v0.normal - v2.normal));
  if (!(abs(spread) > LEAST_BULGE * (length(e0) + length(e1) + length(e2)))) return;
  surface.bulge = spread > 0.0 ? 1.0 : -1.0;
  float side = surface.bulge * sign_of_normals;
  vec3 n0 = side * normalize(v0.normal), n1 = side * normalize(v1.normal), n2 = side * normalize(v2.normal);
  surface.rise = b.x * max(dot(v0.position - surface.position, n0), 0.0) * n0 +
                 b.y * max(dot(v1.position - surface.position, n1), 0.0) * n1 +
                 b.z * max(dot(v2.position - surface.position, n2), 0.0) * n2;
}

// triangle_number: see interface::Instance.
Surface surface_at(Frame frame, uint triangle_number, vec2 barycentrics) {
  PlacedTriangle placed = placed_triangle(frame, triangle_number);
  Triangle triangle = placed.triangle;
  Vertex v0 = placed_vertex(frame, placed, triangle.v0);
  Vertex v1 = placed_vertex(frame, placed, triangle.v1);
  Vertex v2 = placed_vertex(frame, placed, triangle.v2);
  SurfacePoint point = point_on_triangle(v0.position, v1.position, v2.position, barycentrics);

  Surface surface;
  surface.position = point.position;
  surface.clearance = point.clearance;
  surface.geometric_normal = point.normal;
  surface.area = point.area;
  surface.shading_normal = point.normal;
  surface.bulge = 0.0;
  surface.rise = vec3(0.0);
  float b0 = 1.0 - barycentrics.x - barycentrics.y;
  if ((spec_features & FEATURE_SMOOTH_NORMALS) != 0u) {
    vec3 normal = b0 * v0.normal + barycentrics.x * v1.normal + barycentrics.y * v2.normal;
    float squared = dot(normal, normal);
    if (squared > 1e-12) {
      normal *= inversesqrt(squared);
      float sign_of_normals = dot(normal, point.normal) < 0.0 ? -1.0 : 1.0;
      surface.shading_normal = sign_of_normals * normal;
      if ((spec_features & FEATURE_BULGES) != 0u)
        find_bulge(v0, v1, v2, vec3(b0, barycentrics), sign_of_normals, surface);
    }
  }
  surface.uv = texture_coordinates(triangle, v0.uv, v1.uv, v2.uv, barycentrics);
  surface.color = vertex_color(frame, triangle, barycentrics);
  surface.material = triangle.material;
  surface.light = triangle.light;
  return surface;
}

#endif
