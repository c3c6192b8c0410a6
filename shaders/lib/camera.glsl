// Camera rays and the pixel filter.
#ifndef REGULUS_LIB_CAMERA_GLSL
#define REGULUS_LIB_CAMERA_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// Position t in [0, 1] below which the share `v` of one half of the four-term Blackman-Harris window lies (Harris, "On
// the Use of Windows for Harmonic Analysis", 1978; minimum four-term). A rational fit in sqrt(-ln(1 - v)), off by less
// than 0.0032, then two Newton steps: the share below the result differs from v by less than 4e-7.
float invert_blackman_harris(float v) {
  const vec3 AMPLITUDE = vec3(1.36108711, 0.393811847, 0.0325574913);  // a1, a2, a3 over a0
  float q = sqrt(-log(max(1.0 - v, 5e-8)));
  float t = q * q * (0.43522578 - 0.0614911 * q) / (1.0 + q * (0.45824791 + 0.01216426 * q));
  for (int step = 0; step < 2; ++step) {
    t = clamp(t, 0.0, 1.0);
    vec2 cs = cos_sin_turns(0.5 * t);
    float c4 = 4.0 * cs.x * cs.x;
    vec3 sines = cs.y * vec3(1.0, 2.0 * cs.x, c4 - 1.0);           // of 1, 2 and 3 pi t
    vec3 cosines = vec3(cs.x, 0.5 * c4 - 1.0, cs.x * (c4 - 3.0));
    float share = t + INV_PI * dot(AMPLITUDE, sines * vec3(1.0, 0.5, 0.333333333));
    t -= (share - v) / (1.0 + dot(AMPLITUDE, cosines));
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

#endif
