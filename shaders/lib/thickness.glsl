// How far a path goes through a medium, between the surface points themselves: rays start off their surfaces, and across a
// thin slab t is little more than rounding. Short ways are measured with pairs of floats, whose sum is the number (Dekker
// 1971, Knuth; no fused multiply-add is needed).
#ifndef REGULUS_LIB_THICKNESS_GLSL
#define REGULUS_LIB_THICKNESS_GLSL

#include "lib/media.glsl"

// a + b and a b without error.
vec2 pair_sum(float a, float b) {
  precise float sum = a + b;
  precise float of_b = sum - a;
  precise float rest = (a - (sum - of_b)) + (b - of_b);
  return vec2(sum, rest);
}

vec2 pair_product(float a, float b) {
  const float SPLIT = 4097.0;  // 2^12 + 1
  precise float scaled_a = SPLIT * a;
  precise float high_a = scaled_a - (scaled_a - a);
  precise float low_a = a - high_a;
  precise float scaled_b = SPLIT * b;
  precise float high_b = scaled_b - (scaled_b - b);
  precise float low_b = b - high_b;
  precise float product = a * b;
  precise float rest = ((high_a * high_b - product) + high_a * low_b + low_a * high_b) + low_a * low_b;
  return vec2(product, rest);
}

vec2 pair_add(vec2 a, vec2 b) {
  vec2 high = pair_sum(a.x, b.x), low = pair_sum(a.y, b.y);
  vec2 sum = pair_sum(high.x, high.y + low.x);
  return pair_sum(sum.x, sum.y + low.y);
}

vec2 pair_multiply(vec2 a, vec2 b) {
  vec2 product = pair_product(a.x, b.x);
  return pair_sum(product.x, product.y + (a.x * b.y + a.y * b.x));
}

// A vector of pairs: columns x, y, z.
mat3x2 pair_difference(vec3 a, vec3 b) {
  return mat3x2(pair_sum(a.x, -b.x), pair_sum(a.y, -b.y), pair_sum(a.z, -b.z));
}

vec2 pair_minor(mat3x2 a, mat3x2 b, int i, int j) {
  return pair_add(pair_multiply(a[i], b[j]), -pair_multiply(a[j], b[i]));
}

vec2 pair_dot(mat3x2 a, mat3x2 b) {
  return pair_add(pair_add(pair_multiply(a[0], b[0]), pair_multiply(a[1], b[1])), pair_multiply(a[2], b[2]));
}

// Distance along `direction` from a point of one triangle to the plane of another.
float distance_to_plane(vec3 a0, vec3 a1, vec3 a2, vec2 barycentrics, vec3 b0, vec3 b1, vec3 b2, vec3 direction) {
  mat3x2 first = pair_difference(b1, b0), second = pair_difference(b2, b0);
  mat3x2 normal = mat3x2(pair_minor(first, second, 1, 2), pair_minor(first, second, 2, 0), pair_minor(first, second, 0, 1));
  // From the point to b0; ways within the first triangle's plane are scaled by its two barycentrics.
  mat3x2 along_u = pair_difference(a1, a0), along_v = pair_difference(a2, a0), to_plane = pair_difference(b0, a0);
  vec2 height = pair_dot(normal, to_plane);
  height = pair_add(height, -pair_multiply(vec2(barycentrics.x, 0.0), pair_dot(normal, along_u)));
  height = pair_add(height, -pair_multiply(vec2(barycentrics.y, 0.0), pair_dot(normal, along_v)));
  float slope = dot(vec3(normal[0].x, normal[1].x, normal[2].x), direction);
  return height.x / slope;
}

// Length of the way from where `media` says that the ray starts to the hit, whose surface point is `position`.
float length_in_medium(Frame frame, PathMedia media, vec3 direction, Hit hit, vec3 position) {
  // On ways longer than this share of the coordinates the rounding of points does not matter.
  const float SHORT = 1e-3;
  if (!has_contacts() || media.triangle == INVALID_INDEX) return hit.t;
  PlacedTriangle start = placed_triangle(frame, media.triangle);
  vec3 a0 = placed_vertex(frame, start, start.triangle.v0).position;
  vec3 a1 = placed_vertex(frame, start, start.triangle.v1).position;
  vec3 a2 = placed_vertex(frame, start, start.triangle.v2).position;
  vec2 b = media.barycentrics;
  float apart = distance(position, (1.0 - b.x - b.y) * a0 + b.x * a1 + b.y * a2);
  vec3 size = abs(position);
  if (apart > SHORT * max(size.x, max(size.y, size.z))) return apart;
  PlacedTriangle end = placed_triangle(frame, hit.triangle);
  float along = distance_to_plane(a0, a1, a2, b, placed_vertex(frame, end, end.triangle.v0).position,
                                  placed_vertex(frame, end, end.triangle.v1).position,
                                  placed_vertex(frame, end, end.triangle.v2).position, direction);
  // Only rounding makes it negative. Where the second plane is parallel to the ray it means nothing.
  float most = 2.0 * apart + 1e-5 * max(size.x, max(size.y, size.z));
  return along <= most ? max(along, 0.0) : apart;
}

#endif
