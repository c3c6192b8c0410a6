// Path diffusion in path tracing (docs/mathematics.md 5): how wide the bundle of camera paths around this one has become, by
// isotropic covariance tracing. Where light subpaths meet camera subpaths only the levels of lib/regularization.glsl
// are known from both sides; techniques `hit` and `nee` know the whole way to the camera.
#ifndef REGULUS_LIB_FOOTPRINT_GLSL
#define REGULUS_LIB_FOOTPRINT_GLSL

#include "lib/camera.glsl"
#include "lib/instances.glsl"
#include "lib/mis.glsl"
#include "lib/regularization.glsl"

// A footprint: variance of the position across the ray (m^2), covariance of position and angle (m rad), variance of the
// angle (rad^2), each per axis.

#define has_footprints() has_state(STATE_FOOTPRINTS)

// At the lens: a pixel's solid angle (orthographic: its area), and the lens.
vec3 start_footprint(Frame frame) {
  float pixel = pixel_area(frame.camera, vec2(frame.width, frame.height)) / 12.0;
  if (frame.camera.kind == CAMERA_ORTHOGRAPHIC) return vec3(pixel, 0.0, 0.0);
  return vec3(0.25 * square(frame.camera.lens_radius), 0.0, min(pixel, MAX_ANGULAR_VARIANCE));
}

// After `distance` metres.
vec3 travelled(vec3 footprint, float distance) {
  float gain = distance * footprint.z;
  return vec3(footprint.x + distance * (2.0 * footprint.y + gain), footprint.y + gain, footprint.z);
}

// sigma~ of docs/mathematics.md 5: 0 sharp, 1 as wide as after a Lambert lobe. A vertex is regularized with tau / sigma~.
float diffusion(vec3 footprint) { return min(2.0 * sqrt(max(footprint.z, 0.0)), 1.0); }

// Reflected by a surface of mean curvature `curvature` (1/m), positive where it is convex towards the ray:
// a' = a + 2 H x.
vec3 reflected(vec3 footprint, float curvature) {
  float x = footprint.x, c = footprint.y, bend = 2.0 * curvature;
  return vec3(x, c + bend * x, footprint.z + bend * (2.0 * c + bend * x));
}

// Refracted, with e = eta_i / eta_t: a' = e a - (1 - e) H x.
vec3 refracted(vec3 footprint, float e, float curvature) {
  float x = footprint.x, c = footprint.y, bend = (1.0 - e) * curvature;
  return vec3(x, e * c - bend * x, e * e * footprint.z - bend * (2.0 * e * c - bend * x));
}

// Mean curvature (1/m) of a triangle's interpolated normals: half the trace of dn/dx over its plane. Positive where the
// front is convex. At most one over the longest edge, which is as fine as the mesh can tell.
float mean_curvature(Vertex v0, Vertex v1, Vertex v2) {
  vec3 e1 = v1.position - v0.position, e2 = v2.position - v0.position, e3 = e2 - e1;
  float longest = sqrt(max(dot(e1, e1), max(dot(e2, e2), dot(e3, e3))));
  vec3 u1 = e1 / longest, u2 = e2 / longest;
  vec3 area = cross(u1, u2);
  float squared = dot(area, area);
  if (!(squared > 1e-12)) return 0.0;
  vec3 d1 = v1.normal - v0.normal, d2 = v2.normal - v0.normal;
  // The dual basis of the edges is (u2 x area, area x u1) / area^2.
  float trace = (dot(d1, cross(u2, area)) + dot(d2, cross(area, u1))) / squared;
  // Normals that point to the back of the winding are turned round, as in shading.
  float side = dot(v0.normal + v1.normal + v2.normal, area) < 0.0 ? -1.0 : 1.0;
  return side * clamp(0.5 * trace, -1.0, 1.0) / longest;
}

float curvature_at(Frame frame, uint triangle_number) {
  if ((spec_features & FEATURE_SMOOTH_NORMALS) == 0u) return 0.0;
  PlacedTriangle placed = placed_triangle(frame, triangle_number);
  return mean_curvature(placed_vertex(frame, placed, placed.triangle.v0), placed_vertex(frame, placed, placed.triangle.v1),
                        placed_vertex(frame, placed, placed.triangle.v2));
}

// After scattering by `event` at a surface of mean curvature `curvature`.
vec3 scattered(vec3 footprint, Bsdf bsdf, BsdfSample event, float curvature) {
  if ((event.flags & BSDF_SAMPLE_DIFFUSE) != 0u) return vec3(footprint.x, 0.0, MAX_ANGULAR_VARIANCE);
  float lobe = facets_spread(bsdf, event);
  if (event.facet.is_refracted) {
    footprint = refracted(footprint, bsdf.inverse_eta, curvature);
  } else if (!event.facet.is_transmitted) {
    footprint = reflected(footprint, curvature);
  }
  footprint.z = min(max(footprint.z, 0.0) + lobe, MAX_ANGULAR_VARIANCE);
  float most = sqrt(footprint.x * footprint.z);
  return vec3(footprint.x, clamp(footprint.y, -most, most), footprint.z);
}

#endif
