// Maps from the unit square to the domains that are sampled everywhere, each with its pdf, and the basis that
// turns local directions into world ones. Random numbers are in [0, 1).
#ifndef REGULUS_LIB_SAMPLING_GLSL
#define REGULUS_LIB_SAMPLING_GLSL

#include "lib/numerics.glsl"

// Tangents that complete the unit vector n to a right-handed orthonormal basis (Duff et al., "Building an
// Orthonormal Basis, Revisited", JCGT 2017).
void orthonormal_basis(vec3 n, out vec3 tangent, out vec3 bitangent) {
  float side = n.z < 0.0 ? -1.0 : 1.0;
  float a = -1.0 / (side + n.z);
  float b = n.x * n.y * a;
  tangent = vec3(1.0 + side * n.x * n.x * a, side * b, -side * n.x);
  bitangent = vec3(b, side + n.y * n.y * a, -n.y);
}

// Uniform point of the unit disk (pdf 1 / pi) by the concentric map (Shirley and Chiu 1997). `radius`: its distance
// from the centre, exact, so that 1 - radius^2 can be had without cancellation.
vec2 sample_disk(vec2 u, out float radius) {
  vec2 p = 2.0 * u - 1.0;
  bool is_x_major = abs(p.x) > abs(p.y);
  float r = is_x_major ? p.x : p.y;
  float minor = is_x_major ? p.y : p.x;
  vec2 cs = cos_sin_octant(r == 0.0 ? 0.0 : (0.25 * PI) * (minor / r));
  radius = abs(r);
  return r * (is_x_major ? cs : cs.yx);
}

vec2 sample_disk(vec2 u) {
  float radius;
  return sample_disk(u, radius);
}

// Direction about +z with pdf cos(theta) / pi (Malley).
vec3 sample_cosine_hemisphere(vec2 u) {
  float radius;
  vec2 disk = sample_disk(u, radius);
  return vec3(disk, safe_sqrt((1.0 - radius) * (1.0 + radius)));
}

// Uniform point of a triangle as barycentrics (of the second and third vertex), pdf 1 / area. Low distortion
// (Heitz, "A Low-Distortion Map Between Triangle and Square", 2019).
vec2 sample_triangle(vec2 u) {
  vec2 b = u.y > u.x ? vec2(0.5 * u.x, u.y - 0.5 * u.x) : vec2(u.x - 0.5 * u.y, 0.5 * u.y);
  return b;
}

// Uniform direction, pdf 1 / (4 pi).
vec3 sample_sphere(vec2 u) {
  return vec3(2.0 * sqrt(u.x * (1.0 - u.x)) * cos_sin_turns(u.y), 1.0 - 2.0 * u.x);
}

// The share of a turn, in [0, 1), at which p lies around the origin.
float angle_number(vec2 p) {
  float turns = atan2_turns(p.y, p.x);
  return min(turns < 0.0 ? turns + 1.0 : turns, ONE_MINUS_ULP);
}

// Those of sample_sphere.
vec2 sphere_numbers(vec3 w) { return vec2(clamp(0.5 - 0.5 * w.z, 0.0, ONE_MINUS_ULP), angle_number(w.xy)); }

// Uniform direction in the cone about +z of height 1 - cos(angle), pdf 1 / (2 pi height). The height is the
// parameter because the cosine of a small angle loses it.
vec3 sample_cone(vec2 u, float height) {
  float h = u.x * height;
  return vec3(safe_sqrt(h * (2.0 - h)) * cos_sin_turns(u.y), 1.0 - h);
}

#endif
