// Light selection and sampling as seen from a surface point: emissive triangles, point, spot and
// directional lights, the environment. Radiometry as in glTF: candela and lux are taken as W/sr and W/m^2.
#ifndef REGULUS_LIB_LIGHT_GLSL
#define REGULUS_LIB_LIGHT_GLSL

#include "lib/coverage.glsl"
#include "lib/environment.glsl"
#include "lib/geometry.glsl"
#include "lib/light_guide.glsl"
#include "lib/light_tree.glsl"
#include "lib/mis.glsl"
#include "lib/sampling.glsl"
#include "lib/texture.glsl"

// A light as sampled for next-event estimation from a point.
struct LightSample {
  vec3 wi;        // unit, towards the light
  vec3 target;    // end point of the shadow segment, already off the light's surface (not for distant lights)
  bool is_distant;  // directional or environment: the shadow ray has no end, and no medium attenuates it
  float distance;
  vec3 radiance;  // incident, times the factors that make radiance / pdf an estimate of the irradiance integral
  float pdf;      // solid angle for triangles and the environment; discrete for point, spot and directional lights
  float emission_ratio;  // area pdf of the surface point when the light emits towards it, without the cosine there,
                         // times p_trace / p_connect of the light point (docs/mathematics.md 3.2)
  bool is_delta;
  float bound;    // rho-bar of the light, see lib/history.glsl, 1/sr
  uint index;     // of the light
  vec4 start;     // with a light guide: the numbers with which a light path would start towards the receiver
};

// rho-bar of lights: Lambertian emission, also of what is infinitely far away; a point light's is isotropic.
const float EMITTER_BOUND = INV_PI;
const float POINT_LIGHT_BOUND = 0.25 * INV_PI;

float spot_bound(Light light) { return 0.5 * INV_PI / light.outer_height; }

// Draws a light index by a table of aliases (alias method, Vose 1991).
uint select_from(DeviceAddress aliases, uint count, vec2 u) {
  uint bucket = min(uint(u.x * float(count)), count - 1u);
  LightAlias entry = LOAD(LightAliasBuffer, aliases, bucket);
  return u.y < entry.threshold ? bucket : entry.alias;
}

// In proportion to its selection_pdf.
uint select_by_power(Frame frame, vec2 u) {
  if ((spec_features & FEATURE_MANY_LIGHTS) == 0u) return 0u;
  return select_from(frame.light_aliases, frame.light_count, u);
}

// The light at which a light path starts: by power, or as the guide says.
uint select_emitter(Frame frame, vec2 u) {
  return has_light_guide() ? select_from(frame.guided_light_aliases, frame.light_count, u) : select_by_power(frame, u);
}

// The light that next-event estimation samples. Selected by power, a light's own selection_pdf is its probability, and
// `probability` does not count.
LightChoice choose_light(Frame frame, LightReceiver receiver, vec2 u) {
  if (spec_light_sampling == LIGHT_SAMPLING_BVH) return choose_by_tree(frame.light_tree, receiver, u);
  if (spec_light_sampling == LIGHT_SAMPLING_UNIFORM)
    return LightChoice(min(uint(u.x * float(frame.light_count)), frame.light_count - 1u), 1.0 / float(frame.light_count));
  return LightChoice(select_by_power(frame, u), 1.0);
}

// Probability with which choose_light returns `light`, whose selection_pdf is given.
float choice_probability(Frame frame, LightReceiver receiver, uint light, float selection_pdf) {
  if (spec_light_sampling == LIGHT_SAMPLING_BVH)
    return tree_probability(frame.light_tree, receiver, light);
  return spec_light_sampling == LIGHT_SAMPLING_UNIFORM ? 1.0 / float(frame.light_count) : selection_pdf;
}

// The same for the vertex before the ray in `slot`, a ray that has met the light.
float previous_choice_probability(Frame frame, uint slot, uint light, float selection_pdf) {
  LightReceiver receiver;
  if (spec_light_sampling == LIGHT_SAMPLING_BVH) {
    if (!keeps_receivers()) return selection_pdf;  // no nee: nothing asks
    receiver = LOAD(LightReceiverBuffer, frame.light_receivers, slot);
  }
  return choice_probability(frame, receiver, light, selection_pdf);
}

bool is_environment(Light light) {
  const bool has_others = (spec_features & (FEATURE_TRIANGLE_LIGHTS | FEATURE_POINT_LIGHTS | FEATURE_DIRECTIONAL_LIGHTS)) != 0u;
  return (spec_features & FEATURE_ENVIRONMENT) != 0u && (!has_others || light.kind == LIGHT_ENVIRONMENT);
}

// Solid-angle pdf of reaching, by light sampling, a point of an emissive triangle seen along a ray of length
// `distance` that meets its normal at `cos_light`.
float triangle_light_pdf(float selection_pdf, float area, float distance, float cos_light) {
  return selection_pdf * distance * distance / (area * max(abs(cos_light), 1e-20));
}

// Solid-angle pdf with which an emissive triangle emits at |cos_light| to its normal: cosine-distributed, from both
// faces if it is double-sided.
float triangle_emission_pdf(Material material, float cos_light) {
  float faces = (spec_features & FEATURE_TWO_SIDED_LIGHTS) != 0u && (material.flags & MATERIAL_DOUBLE_SIDED) != 0u ? 0.5 : 1.0;
  return faces * INV_PI * cos_light;
}

// Share of a spot light's mass, in height 1 - cos, that lies in the falloff ring, and the whole of it.
vec2 spot_mass(Light light) {
  float ring = (light.outer_height - light.inner_height) / 3.0;
  return vec2(ring, ring + light.inner_height);
}

// glTF KHR_lights_punctual: squared linear falloff between the cone cosines.
float spot_falloff(Light light, vec3 direction) {
  vec3 from_axis = direction - light.direction;  // 1 - dot() would lose the digits of narrow cones
  float height = 0.5 * dot(from_axis, from_axis);
  float linear = clamp((light.outer_height - height) / (light.outer_height - light.inner_height), 0.0, 1.0);
  return linear * linear;
}

// Factor on the inverse square law for a light of limited range, 0 from its end on, as KHR_lights_punctual recommends.
float range_share(Light light, float squared_distance) {
  if ((spec_features & FEATURE_LIGHT_RANGES) == 0u || light.kind == LIGHT_TRIANGLE || light.area == 0.0) return 1.0;
  return clamp(1.0 - square(squared_distance / square(light.area)), 0.0, 1.0);
}

LightSample sample_triangle_light(Frame frame, Light light, vec3 from, vec2 u) {
  vec2 barycentrics = sample_triangle(u);
  Triangle triangle = LOAD(TriangleBuffer, frame.triangles, light.triangle);
  Vertex v0 = LOAD(VertexBuffer, frame.vertices, triangle.v0);
  Vertex v1 = LOAD(VertexBuffer, frame.vertices, triangle.v1);
  Vertex v2 = LOAD(VertexBuffer, frame.vertices, triangle.v2);
  SurfacePoint point = point_on_triangle(v0.position, v1.position, v2.position, barycentrics);
  TextureCoordinates uv = texture_coordinates(triangle, v0.uv, v1.uv, v2.uv, barycentrics);

  vec3 to_light = point.position - from;
  LightSample result;
  result.distance = length(to_light);
  result.wi = to_light / max(result.distance, 1e-30);
  float cos_light = -dot(point.normal, result.wi);
  bool emits = cos_light > 0.0, is_two_sided = false;
  float emission_pdf = INV_PI * abs(cos_light);
  vec3 radiance = light.intensity;
  if ((spec_features & (FEATURE_TEXTURES | FEATURE_TWO_SIDED_LIGHTS | FEATURE_VERTEX_COLORS)) != 0u) {
    Material material = LOAD(MaterialBuffer, frame.materials, light.material);
    is_two_sided = (material.flags & MATERIAL_DOUBLE_SIDED) != 0u;
    emits = emits || is_two_sided;
    emission_pdf = triangle_emission_pdf(material, abs(cos_light));
    radiance = emitted_radiance(frame, material, radiance, uv, vertex_color(frame, triangle, barycentrics));
  }
  // A ray would meet the light's surface with the probability of its coverage.
  result.radiance = emits ? radiance * coverage_at(frame, triangle, barycentrics) : vec3(0.0);
  result.pdf = triangle_light_pdf(light.selection_pdf, light.area, result.distance, cos_light);
  result.target = offset_origin(point.position, point.clearance, point.normal, -result.wi);
  result.emission_ratio = emission_pdf / max(square(result.distance), 1e-30);
  if (has_light_guide()) result.start = triangle_start(point.normal, is_two_sided, -result.wi);
  result.is_distant = false;
  result.is_delta = false;
  result.bound = EMITTER_BOUND;
  return result;
}

LightSample sample_environment_light(Frame frame, Light light, vec3 from, vec2 u) {
  EnvironmentSample environment = sample_environment(frame, u);
  LightSample result;
  result.wi = environment.direction;
  result.target = from;
  result.is_distant = true;
  result.distance = 0.0;
  result.radiance = environment.radiance;
  result.pdf = environment.pdf * light.selection_pdf;
  result.emission_ratio = INV_PI / square(frame.scene_radius);
  if (has_light_guide()) result.start = environment_start(frame, u, -result.wi, from);
  result.is_delta = false;
  result.bound = EMITTER_BOUND;
  return result;
}

LightSample sample_punctual_light(Frame frame, Light light, vec3 from) {
  LightSample result;
  result.is_delta = true;
  result.bound = light.kind == LIGHT_POINT ? POINT_LIGHT_BOUND : EMITTER_BOUND;
  if (light.kind == LIGHT_SPOT) result.bound = spot_bound(light);
  result.pdf = light.selection_pdf;
  result.is_distant = light.kind == LIGHT_DIRECTIONAL;
  if (result.is_distant) {
    result.wi = -light.direction;
    result.radiance = light.intensity;
    result.distance = 0.0;
    result.emission_ratio = INV_PI / square(frame.scene_radius);
    if (has_light_guide()) result.start = vec4(distant_numbers(frame, light.direction, from), 0.0, 0.0);
    result.target = from;
    return result;
  }
  vec3 to_light = light.position - from;
  float squared = max(dot(to_light, to_light), 1e-30);
  result.distance = sqrt(squared);
  result.wi = to_light / result.distance;
  result.radiance = light.intensity / squared;
  if ((spec_features & FEATURE_LIGHT_RANGES) != 0u) result.radiance *= range_share(light, squared);
  result.emission_ratio = 0.25 * INV_PI / squared;
  if (has_light_guide()) result.start = point_start(-result.wi);
  if (light.kind == LIGHT_SPOT) {
    float falloff = spot_falloff(light, -result.wi);
    result.radiance *= falloff;
    result.emission_ratio = 0.5 * INV_PI * falloff / (spot_mass(light).y * squared);
    if (has_light_guide()) result.start = spot_start(light, spot_mass(light), -result.wi);
  }
  result.target = light.position;
  return result;
}

// A point of the light, as seen from a surface point; the pdf includes the light's selection_pdf.
LightSample sample_point_of_light(Frame frame, Light light, vec3 from, vec2 u) {
  const bool has_triangles = (spec_features & FEATURE_TRIANGLE_LIGHTS) != 0u;
  const bool has_punctual = (spec_features & (FEATURE_POINT_LIGHTS | FEATURE_DIRECTIONAL_LIGHTS)) != 0u;
  if (is_environment(light)) return sample_environment_light(frame, light, from, u);
  if (has_triangles && (!has_punctual || light.kind == LIGHT_TRIANGLE)) return sample_triangle_light(frame, light, from, u);
  return sample_punctual_light(frame, light, from);
}

// Chooses a light and samples a point on it. u is one block of random numbers. The pdf is 0 if no light can reach the
// receiver.
LightSample sample_light(Frame frame, LightReceiver receiver, vec4 u) {
  LightChoice choice = choose_light(frame, receiver, u.xy);
  LightSample result;
  result.pdf = 0.0;
  if (spec_light_sampling == LIGHT_SAMPLING_BVH && choice.light == INVALID_INDEX) return result;
  Light light = LOAD(LightBuffer, frame.lights, choice.light);
  float emission_selection_pdf = light.selection_pdf;
  if (spec_light_sampling != LIGHT_SAMPLING_POWER) light.selection_pdf = choice.probability;
  result = sample_point_of_light(frame, light, receiver.position, u.zw);
  result.index = choice.light;
  if (spec_light_sampling != LIGHT_SAMPLING_POWER) result.emission_ratio *= emission_selection_pdf / choice.probability;
  if (has_light_guide()) result.emission_ratio *= guided_share(frame, choice.light, emission_selection_pdf, result.start);
  return result;
}

#endif
