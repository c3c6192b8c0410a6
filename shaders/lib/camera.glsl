// Camera rays and the pixel filter.
#ifndef REGULUS_LIB_CAMERA_GLSL
#define REGULUS_LIB_CAMERA_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// Amplitudes a1, a2, a3 over a0 of the four-term Blackman-Harris window.
const vec3 BLACKMAN_HARRIS = vec3(1.36108711, 0.393811847, 0.0325574913);

// The window at t in [0, 1], from the middle to the end, as a density.
float blackman_harris_density(float t) {
  float c = cos_sin_turns(0.5 * t).x;
  float c4 = 4.0 * c * c;
  return max(1.0 + dot(BLACKMAN_HARRIS, vec3(c, 0.5 * c4 - 1.0, c * (c4 - 3.0))), 0.0);
}

// Position t in [0, 1] below which the share `v` of one half of the four-term Blackman-Harris window lies (Harris, "On
// the Use of Windows for Harmonic Analysis", 1978; minimum four-term). A rational fit in sqrt(-ln(1 - v)), off by less
// than 0.0032, then two Newton steps: the share below the result differs from v by less than 4e-7.
float invert_blackman_harris(float v) {
  float q = sqrt(-log(max(1.0 - v, 5e-8)));
  float t = q * q * (0.43522578 - 0.0614911 * q) / (1.0 + q * (0.45824791 + 0.01216426 * q));
  for (int step = 0; step < 2; ++step) {
    t = clamp(t, 0.0, 1.0);
    vec2 cs = cos_sin_turns(0.5 * t);
    float c4 = 4.0 * cs.x * cs.x;
    vec3 sines = cs.y * vec3(1.0, 2.0 * cs.x, c4 - 1.0);           // of 1, 2 and 3 pi t
    vec3 cosines = vec3(cs.x, 0.5 * c4 - 1.0, cs.x * (c4 - 3.0));
    float share = t + INV_PI * dot(BLACKMAN_HARRIS, sines * vec3(1.0, 0.5, 0.333333333));
    t -= (share - v) / (1.0 + dot(BLACKMAN_HARRIS, cosines));
  }
  return clamp(t, 0.0, 1.0);
}

// Offset from the pixel centre, in pixels, distributed as the filter (Ernst et al. 2006): every sample then
// has weight 1 and belongs to one pixel. Gaussian: truncated at the radius, separable, by inversion.
// Blackman-Harris: zero at the radius, separable, standard deviation 0.277 radii.
vec2 sample_filter(vec2 u, float radius, float sigma) {
  if (spec_filter == FILTER_BOX) return (2.0 * u - 1.0) * radius;
  if (spec_filter == FILTER_BLACKMAN_HARRIS) {
    vec2 signed_share = 2.0 * u - 1.0;
    vec2 t = vec2(invert_blackman_harris(abs(signed_share.x)), invert_blackman_harris(abs(signed_share.y)));
    return radius * mix(t, -t, lessThan(signed_share, vec2(0.0)));
  }
  float scale = sigma * 1.41421356;
  float inside = erf_accurate(radius / scale);
  vec2 signed_u = (2.0 * u - 1.0) * inside;
  return scale * vec2(erf_inverse(signed_u.x), erf_inverse(signed_u.y));
}

// Ray through film point `film` (pixels, see interface/scene.h); u places it on the lens.
void camera_ray(Camera camera, vec2 film, vec2 size, vec2 u, out vec3 origin, out vec3 direction) {
  vec2 ndc = vec2(2.0 * film.x / size.x - 1.0, 1.0 - 2.0 * film.y / size.y);
  vec3 across = ndc.x * camera.right + ndc.y * camera.up;
  if (camera.kind == CAMERA_ORTHOGRAPHIC) {
    origin = camera.position + across;
    direction = camera.forward;
    return;
  }
  direction = camera.forward + across;
  origin = camera.position;
  if (camera.lens_radius > 0.0) {
    vec2 lens = camera.lens_radius * sample_disk(u);
    vec3 shift = lens.x * normalize(camera.right) + lens.y * normalize(camera.up);
    direction = direction * camera.focus_distance - shift;
    origin += shift;
  }
  direction = normalize(direction);
}

bool has_clipping() { return (spec_features & FEATURE_CLIPPING) != 0u; }

// The part of a camera ray between the clipping planes, as distances along it: nothing before or behind is seen.
vec2 clipped_range(Camera camera, vec3 direction) {
  if (!has_clipping()) return vec2(0.0, 3.4e38);
  float cos_axis = max(dot(direction, camera.forward), 1e-20);
  return vec2(camera.z_near / cos_axis, min(camera.z_far / cos_axis, 3.4e38));
}

// Density per pixel area of the filter of a pixel whose centre is `offset` pixels away: what sample_filter draws
// from.
float filter_density(vec2 offset, float radius, float sigma) {
  if (max(abs(offset.x), abs(offset.y)) > radius) return 0.0;
  if (spec_filter == FILTER_BOX) return radius > 0.0 ? 0.25 / square(radius) : 0.0;
  if (spec_filter == FILTER_BLACKMAN_HARRIS)
    return blackman_harris_density(abs(offset.x) / radius) * blackman_harris_density(abs(offset.y) / radius) *
           (0.25 / square(radius));
  float scale = sigma * 1.41421356;
  float norm = sqrt(PI) * scale * erf_accurate(radius / scale);
  return exp_accurate(-dot(offset, offset) / square(scale)) / square(norm);
}

// Area of a pixel on the plane one metre in front of a perspective camera; of an orthographic one in m^2.
float pixel_area(Camera camera, vec2 size) { return 4.0 * length(camera.right) * length(camera.up) / (size.x * size.y); }

// Solid-angle pdf of a perspective camera's rays for a film density of 1 per pixel area; of an orthographic one per
// area perpendicular to the rays.
float camera_ray_pdf(Camera camera, vec2 size, vec3 direction) {
  float area = pixel_area(camera, size);
  if (camera.kind == CAMERA_ORTHOGRAPHIC) return 1.0 / area;
  float cos_theta = dot(direction, camera.forward);
  return 1.0 / (area * cos_theta * cos_theta * cos_theta);
}

// Length of the part of a camera ray before the near plane, in m.
float cut_length(Camera camera, vec3 direction) { return has_clipping() ? clipped_range(camera, direction).x : 0.0; }

// A point as the lens sees it.
struct LensSample {
  vec3 wi;           // unit, towards the lens
  float distance;    // m, to the lens
  float open_distance;  // m, to the near clipping plane: what is nearer to the lens hides nothing
  vec2 film;         // pixels
  float pdf;         // area pdf of the point when the camera samples it, without the cosine there
  bool is_visible;   // in front of the camera, between its clipping planes (it may still lie outside the film)
};

// Connects a point to the point of the lens that u chooses.
LensSample sample_lens(Camera camera, vec2 size, vec3 position, vec2 u) {
  LensSample result;
  vec3 right = normalize(camera.right), up = normalize(camera.up);
  vec2 half_size = vec2(length(camera.right), length(camera.up));  // m at a distance of 1 m
  vec3 to_point = position - camera.position;
  float depth = dot(to_point, camera.forward);
  result.is_visible = depth > 0.0;
  if (has_clipping()) result.is_visible = result.is_visible && depth >= camera.z_near && depth <= camera.z_far;
  vec2 on_plane = vec2(dot(to_point, right), dot(to_point, up));
  if (camera.kind == CAMERA_ORTHOGRAPHIC) {
    result.wi = -camera.forward;
    result.distance = depth;
    result.pdf = camera_ray_pdf(camera, size, camera.forward);
  } else {
    vec2 lens = vec2(0.0);
    if (camera.lens_radius > 0.0) lens = camera.lens_radius * sample_disk(u);
    vec3 from_lens = to_point - lens.x * right - lens.y * up;
    float squared = dot(from_lens, from_lens);
    result.distance = sqrt(squared);
    result.wi = -from_lens / result.distance;
    // Where the ray from the lens point meets the plane in focus, seen from the lens' centre.
    on_plane = (on_plane - lens) / depth;
    if (camera.lens_radius > 0.0) on_plane += lens / camera.focus_distance;
    result.pdf = camera_ray_pdf(camera, size, -result.wi) / squared;
  }
  result.open_distance = result.distance;
  if (has_clipping()) result.open_distance *= 1.0 - camera.z_near / max(depth, 1e-30);
  vec2 ndc = on_plane / half_size;
  result.film = vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size;
  return result;
}

#endif
