// Camera rays and the pixel filter.
#ifndef REGULUS_LIB_CAMERA_GLSL
#define REGULUS_LIB_CAMERA_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// Offset from the pixel centre, in pixels, distributed as the filter (Ernst et al. 2006): every sample then
// has weight 1 and belongs to one pixel. Gaussian: truncated at the radius, separable, by inversion.
vec2 sample_filter(vec2 u, float radius, float sigma) {
  if (spec_filter == FILTER_BOX) return (2.0 * u - 1.0) * radius;
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
