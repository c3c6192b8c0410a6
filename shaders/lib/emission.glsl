// Emission: the first vertex and direction of a light path.
#ifndef REGULUS_LIB_EMISSION_GLSL
#define REGULUS_LIB_EMISSION_GLSL

#include "lib/coverage.glsl"
#include "lib/light.glsl"
#include "lib/mis.glsl"

// How a light path starts. For a distant light the origin lies on a disk that covers the scene.
struct Emission {
  vec3 origin;
  vec3 direction;     // unit
  vec3 throughput;    // emitted radiance cos / pdf, W (distant light: irradiance / pdf)
  float inverse_pdf;  // of the direction; distant light: disk area
  float hit_term;     // |cos| at the light over (p_trace * directional pdf); environment: disk area over the pdf of its
                      // direction; 0: the light cannot be hit
  bool is_parallel;
  float bound;        // rho-bar of the light, see lib/history.glsl, 1/sr
  // Triangle lights only, for the light as the lens sees it (techniques without `hit`):
  SurfacePoint point;
  vec3 radiance;
  float area_pdf;
  bool is_two_sided;
};

Emission emit_from_triangle(Frame frame, Light light, vec2 u_position, vec2 u_direction) {
  vec2 barycentrics = sample_triangle(u_position);
  Triangle triangle = LOAD(TriangleBuffer, frame.triangles, light.triangle);
  Vertex v0 = LOAD(VertexBuffer, frame.vertices, triangle.v0);
  Vertex v1 = LOAD(VertexBuffer, frame.vertices, triangle.v1);
  Vertex v2 = LOAD(VertexBuffer, frame.vertices, triangle.v2);
  TextureCoordinates uv = texture_coordinates(triangle, v0.uv, v1.uv, v2.uv, barycentrics);
  Material material = LOAD(MaterialBuffer, frame.materials, light.material);

  Emission emission;
  emission.point = point_on_triangle(v0.position, v1.position, v2.position, barycentrics);
  emission.radiance = emitted_radiance(frame, material, light.intensity, uv, vertex_color(frame, triangle, barycentrics));
  emission.radiance *= coverage_at(frame, triangle, barycentrics);
  emission.is_two_sided = (material.flags & MATERIAL_DOUBLE_SIDED) != 0u;
  bool is_back = emission.is_two_sided && u_direction.x >= 0.5;
  if (emission.is_two_sided) u_direction.x = 2.0 * u_direction.x - (is_back ? 1.0 : 0.0);
  vec3 local = sample_cosine_hemisphere(u_direction);
  vec3 normal = is_back ? -emission.point.normal : emission.point.normal;
  vec3 tangent, bitangent;
  orthonormal_basis(normal, tangent, bitangent);
  emission.direction = normalize(local.x * tangent + local.y * bitangent + local.z * normal);
  emission.origin = offset_origin(emission.point.position, emission.point.clearance, normal, emission.direction);
  emission.area_pdf = light.selection_pdf / light.area;
  float cos_over_pdf = PI * (emission.is_two_sided ? 2.0 : 1.0);  // cos / directional pdf
  emission.throughput = emission.radiance * (cos_over_pdf / emission.area_pdf);
  emission.inverse_pdf = cos_over_pdf / max(local.z, MIN_MIS_COS);
  emission.hit_term = cos_over_pdf / emission.area_pdf;
  emission.is_parallel = false;
  emission.bound = EMITTER_BOUND;
  return emission;
}

Emission emit_from_punctual(Frame frame, Light light, vec2 u_position, vec2 u_direction) {
  Emission emission;
  emission.hit_term = 0.0;
  emission.bound = light.kind == LIGHT_POINT ? POINT_LIGHT_BOUND : EMITTER_BOUND;
  if (light.kind == LIGHT_SPOT) emission.bound = spot_bound(light);
  emission.radiance = vec3(0.0);
  emission.area_pdf = 0.0;
  emission.is_two_sided = false;
  emission.is_parallel = light.kind == LIGHT_DIRECTIONAL;
  emission.origin = light.position;
  emission.inverse_pdf = 4.0 * PI;
  emission.throughput = light.intensity * (emission.inverse_pdf / light.selection_pdf);
  if (light.kind == LIGHT_POINT) {
    emission.direction = sample_sphere(u_direction);
    return emission;
  }
  vec3 tangent, bitangent;
  orthonormal_basis(light.direction, tangent, bitangent);
  if (emission.is_parallel) {
    vec2 disk = frame.scene_radius * sample_disk(u_position);
    emission.direction = light.direction;
    emission.origin = frame.scene_center - frame.scene_radius * light.direction + disk.x * tangent + disk.y * bitangent;
    emission.inverse_pdf = PI * square(frame.scene_radius);
    emission.throughput = light.intensity * (emission.inverse_pdf / light.selection_pdf);
    return emission;
  }
  // Spot: in proportion to the falloff, whose ring is the square of a linear ramp in the cosine.
  vec2 mass = spot_mass(light);
  float v = u_direction.x * mass.y;
  bool in_ring = v < mass.x;
  float ramp = exp_accurate(log_accurate(clamp(v / max(mass.x, 1e-20), 1e-30, 1.0)) / 3.0);
  float height = in_ring ? light.outer_height - ramp * (light.outer_height - light.inner_height)
                         : max(light.inner_height - (v - mass.x), 0.0);
  float falloff = in_ring ? square(ramp) : 1.0;
  vec2 around = safe_sqrt(height * (2.0 - height)) * cos_sin_turns(u_direction.y);
  emission.direction = normalize(around.x * tangent + around.y * bitangent + (1.0 - height) * light.direction);
  float cone = 2.0 * PI * mass.y;
  emission.throughput = light.intensity * (cone / light.selection_pdf);
  emission.inverse_pdf = cone / max(falloff, 1e-20);
  return emission;
}

// The environment, from one direction: parallel rays over the scene's disk, like a directional light's.
Emission emit_from_environment(Frame frame, Light light, vec2 u_direction, vec2 u_disk) {
  EnvironmentSample environment = sample_environment(frame, u_direction);
  vec3 tangent, bitangent;
  orthonormal_basis(-environment.direction, tangent, bitangent);
  vec2 disk = frame.scene_radius * sample_disk(u_disk);
  Emission emission;
  emission.direction = -environment.direction;
  emission.origin =
      frame.scene_center + frame.scene_radius * environment.direction + disk.x * tangent + disk.y * bitangent;
  emission.inverse_pdf = PI * square(frame.scene_radius);
  emission.hit_term = emission.inverse_pdf / (environment.pdf * light.selection_pdf);
  emission.throughput = environment.radiance * emission.hit_term;
  emission.is_parallel = true;
  emission.bound = EMITTER_BOUND;
  emission.radiance = vec3(0.0);
  emission.area_pdf = 0.0;
  emission.is_two_sided = false;
  return emission;
}

// A point of the light and a direction. start: position, direction. (Of the environment the position is a direction, and the
// last two place the ray.)
Emission emit_from(Frame frame, Light light, vec4 start) {
  const bool has_triangles = (spec_features & FEATURE_TRIANGLE_LIGHTS) != 0u;
  const bool has_punctual = (spec_features & (FEATURE_POINT_LIGHTS | FEATURE_DIRECTIONAL_LIGHTS)) != 0u;
  if (is_environment(light)) return emit_from_environment(frame, light, start.xy, start.zw);
  if (has_triangles && (!has_punctual || light.kind == LIGHT_TRIANGLE))
    return emit_from_triangle(frame, light, start.xy, start.zw);
  return emit_from_punctual(frame, light, start.xy, start.zw);
}

// Chooses a light, a point on it and a direction. u_light: light, alias, position; u: direction.
Emission sample_emission(Frame frame, vec4 u_light, vec2 u) {
  uint index = select_emitter(frame, u_light.xy);
  Light light = LOAD(LightBuffer, frame.lights, index);
  if (!has_light_guide()) return emit_from(frame, light, vec4(u_light.zw, u));
  GuidedLight guided = LOAD(GuidedLightBuffer, frame.guided_lights, index);
  light.selection_pdf = guided.selection_pdf;
  GuidedNumbers start = guide_start(frame.guide_nodes, guided.root, vec4(u_light.zw, u));
  Emission emission = emit_from(frame, light, start.numbers);
  emission.throughput /= start.density;
  emission.inverse_pdf /= start.density;
  emission.hit_term /= start.density;
  return emission;
}

#endif
