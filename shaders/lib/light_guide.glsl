// Guided emission (docs/mathematics.md 16): the start of a light path is four numbers of the unit cube, place on the light and
// direction, which a frozen tree moves to where light is of use. Here are the moves, their density, and the numbers with
// which a light path would have started along a given ray.
// Of triangles the tree never halves the place, so that their points stay uniform.
#ifndef REGULUS_LIB_LIGHT_GUIDE_GLSL
#define REGULUS_LIB_LIGHT_GUIDE_GLSL

#include "lib/buffers.glsl"
#include "lib/environment.glsl"
#include "lib/guide_tree.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// True if light paths start as a guide says. A macro, for the reasons in lib/bsdf_parameters.glsl.
#define has_light_guide() (spec_light_guide != 0u)

// How many times as likely as by power alone a light path starts with these numbers at this light.
float guided_share(Frame frame, uint light, float selection_pdf, vec4 start) {
  GuidedLight guided = LOAD(GuidedLightBuffer, frame.guided_lights, light);
  return guided.selection_pdf / selection_pdf * guide_density(frame.guide_nodes, guided.root, start);
}

// The numbers from which sample_disk makes the point p of the unit disk.
vec2 disk_numbers(vec2 p) {
  bool is_x_major = abs(p.x) > abs(p.y);
  float major = is_x_major ? p.x : p.y, minor = is_x_major ? p.y : p.x;
  if (major == 0.0) return vec2(0.5);
  float r = length(p) * sign(major);
  float along = 8.0 * r * atan2_turns(minor / major, 1.0);
  return clamp(0.5 + 0.5 * (is_x_major ? vec2(r, along) : vec2(along, r)), 0.0, ONE_MINUS_ULP);
}

// A direction in the basis of a unit axis.
vec3 in_basis_of(vec3 axis, vec3 w) {
  vec3 tangent, bitangent;
  orthonormal_basis(axis, tangent, bitangent);
  return vec3(dot(w, tangent), dot(w, bitangent), dot(w, axis));
}

// Starts along the unit direction w, the way the light travels.

vec4 triangle_start(vec3 front_normal, bool is_two_sided, vec3 w) {
  bool is_back = is_two_sided && dot(w, front_normal) < 0.0;
  vec2 numbers = disk_numbers(in_basis_of(is_back ? -front_normal : front_normal, w).xy);
  if (is_two_sided) numbers.x = min(0.5 * numbers.x + (is_back ? 0.5 : 0.0), ONE_MINUS_ULP);
  return vec4(0.0, 0.0, numbers);
}

vec4 point_start(vec3 w) { return vec4(0.0, 0.0, sphere_numbers(w)); }

// mass: spot_mass of the light.
vec4 spot_start(Light light, vec2 mass, vec3 w) {
  vec3 from_axis = w - light.direction;
  float height = 0.5 * dot(from_axis, from_axis);
  float ramp = clamp((light.outer_height - height) / (light.outer_height - light.inner_height), 0.0, 1.0);
  float below = height > light.inner_height ? mass.x * ramp * ramp * ramp : mass.x + (light.inner_height - height);
  return vec4(0.0, 0.0, clamp(below / mass.y, 0.0, ONE_MINUS_ULP), angle_number(in_basis_of(light.direction, w).xy));
}

// Where the ray through `point` crosses the disk from which distant light starts.
vec2 distant_numbers(Frame frame, vec3 w, vec3 point) {
  return disk_numbers(in_basis_of(w, point - frame.scene_center).xy / frame.scene_radius);
}

// Those of sample_environment.
vec2 environment_numbers(Frame frame, vec3 direction) {
  return (spec_features & FEATURE_ENVIRONMENT_MAP) == 0u ? sphere_numbers(direction) : environment_map_numbers(frame, direction);
}

// numbers: those of the environment's direction.
vec4 environment_start(Frame frame, vec2 numbers, vec3 w, vec3 point) { return vec4(numbers, distant_numbers(frame, w, point)); }

#endif
