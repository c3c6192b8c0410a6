// A camera path at a surface: the local frame, the material there, and the three things that can happen:
// the surface emits (`hit`), a light is sampled (`nee`), the walk goes on.
#ifndef REGULUS_LIB_SHADING_GLSL
#define REGULUS_LIB_SHADING_GLSL

#include "lib/bsdf.glsl"
#include "lib/light.glsl"
#include "lib/rng.glsl"
#include "lib/stage.glsl"

// A path vertex. Local frame: z is the shading normal on the side that wo is on.
struct ShadingPoint {
  Surface surface;
  Material material;
  Bsdf bsdf;
  vec3 tangent, bitangent, normal;  // local axes in world space
  vec3 geometric_normal;            // on the side of wo
  vec3 wo;                          // local
  bool is_front;                    // wo is on the front side
};

vec3 to_local(ShadingPoint point, vec3 w) {
  return vec3(dot(w, point.tangent), dot(w, point.bitangent), dot(w, point.normal));
}
vec3 to_world(ShadingPoint point, vec3 w) {
  return w.x * point.tangent + w.y * point.bitangent + w.z * point.normal;
}

ShadingPoint shading_point(Frame frame, Hit hit, vec3 wo) {
  ShadingPoint point;
  point.surface = surface_at(frame.triangles, frame.vertices, hit.triangle, vec2(hit.u, hit.v));
  point.is_front = dot(wo, point.surface.geometric_normal) > 0.0;
  float side = point.is_front ? 1.0 : -1.0;
  point.geometric_normal = side * point.surface.geometric_normal;
  point.normal = side * point.surface.shading_normal;
  orthonormal_basis(point.normal, point.tangent, point.bitangent);
  point.wo = to_local(point, wo);
  point.material = LOAD(MaterialBuffer, frame.materials, point.surface.material);
  apply_textures(frame.textures, frame.texels, point.surface.uv, point.material);
  point.bsdf = make_bsdf(point.material, point.is_front);
  return point;
}

// Shadow segments end this much before their target: the traversal's t of the light's own triangle errs by a
// few roundings of the distance.
const float SEGMENT_SCALE = 1.0 - 16.0 * FLOAT_EPSILON;

// True if the geometric and the shading normal agree on which side of the surface w is. Where they do not,
// the bsdf is zero, for walks and connections alike (math.md section 9).
bool sides_agree(ShadingPoint point, vec3 w, vec3 w_local) {
  return dot(w, point.geometric_normal) * w_local.z > 0.0;
}

// Medium on the side of the surface that w leaves to, for a path that arrived through `medium`.
uint medium_towards(ShadingPoint point, uint medium, float w_local_z) {
  if ((spec_features & FEATURE_ABSORPTION) == 0u || spec_material_class != MATERIAL_CLASS_TRANSMISSIVE) return medium;
  if (w_local_z > 0.0 || (point.material.flags & MATERIAL_VOLUME) == 0u) return medium;
  return point.is_front ? point.surface.material : INVALID_INDEX;
}

// Transmittance of `distance` metres of a medium (Beer and Lambert).
vec3 transmittance(Frame frame, uint medium, float distance) {
  if ((spec_features & FEATURE_ABSORPTION) == 0u || medium == INVALID_INDEX) return vec3(1.0);
  vec3 absorption = LOAD(MaterialBuffer, frame.materials, medium).absorption;
  return exp_accurate(-absorption * distance);
}

// Technique `hit`: radiance that the surface sends back along a ray which arrived with pdf `path.pdf`, with
// its balance-heuristic weight against `nee`.
vec3 emission_towards(Frame frame, ShadingPoint point, Path path, float distance) {
  if ((spec_techniques & TECHNIQUE_HIT) == 0u || (spec_features & FEATURE_TRIANGLE_LIGHTS) == 0u) return vec3(0.0);
  if (point.surface.light == INVALID_INDEX) return vec3(0.0);
  if (!point.is_front && (point.material.flags & MATERIAL_DOUBLE_SIDED) == 0u) return vec3(0.0);
  vec3 radiance = emitted_radiance(frame.textures, frame.texels, point.material.emission,
                                   point.material.emissive_texture, point.surface.uv);
  float weight = 1.0;
  if ((spec_techniques & TECHNIQUE_NEE) != 0u && path.pdf > 0.0) {
    float selection_pdf = LOAD(LightBuffer, frame.lights, point.surface.light).selection_pdf;
    float cos_light = dot(path.direction, point.surface.geometric_normal);
    float light_pdf = triangle_light_pdf(selection_pdf, point.surface.area, distance, cos_light);
    weight = path.pdf / (path.pdf + light_pdf);
  }
  return weight * radiance;
}

// Technique `nee`: queues a shadow segment with what it would contribute.
void connect_to_light(Frame frame, ShadingPoint point, Path path, uint slot, vec4 u) {
  if ((spec_techniques & TECHNIQUE_NEE) == 0u || frame.light_count == 0u) return;
  LightSample light = sample_light(frame, point.surface.position, u);
  vec3 wi = to_local(point, light.wi);
  if (!sides_agree(point, light.wi, wi)) return;
  BsdfEval bsdf = bsdf_evaluate(point.bsdf, point.wo, wi, TRANSPORT_RADIANCE);
  float weight = 1.0;
  if ((spec_techniques & TECHNIQUE_HIT) != 0u && !light.is_delta) weight = light.pdf / (light.pdf + bsdf.pdf_forward);
  vec3 contribution = path.throughput * bsdf.value * light.radiance * (abs(wi.z) * weight / light.pdf);
  contribution *= transmittance(frame, medium_towards(point, path.medium, wi.z), light.distance);
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;

  VisibilityCandidate candidate;
  candidate.origin = offset_origin(point.surface.position, point.surface.clearance, point.geometric_normal, light.wi);
  if (light.is_directional) {
    candidate.direction = light.wi;
    candidate.t_max = 3.4e38;
  } else {
    vec3 segment = light.target - candidate.origin;
    float distance = length(segment);
    candidate.direction = segment / distance;
    candidate.t_max = distance * SEGMENT_SCALE;
  }
  candidate.path = slot;
  candidate.contribution = contribution;
  uint index = queue_reserve(queue_head(QUEUE_VISIBILITY));
  STORE(CandidateBuffer, frame.candidates, index, candidate);
}

// Continues the walk: samples the bsdf, plays Russian roulette, queues the next ray.
void scatter(Frame frame, ShadingPoint point, Path path, uint slot, vec4 u) {
  BsdfSample next = bsdf_sample(point.bsdf, point.wo, u.x, u.yz, TRANSPORT_RADIANCE);
  if ((next.flags & BSDF_SAMPLE_VALID) == 0u) return;
  vec3 direction = to_world(point, next.wi);
  if (!sides_agree(point, direction, next.wi)) return;

  path.throughput *= next.weight;
  path.eta_scale *= next.eta_scale;
  // Survival by throughput without the eta^2 of refraction, which the way out undoes (PBR 4ed, 14.2). It is
  // left out of the MIS pdfs: weights stay exact (math.md section 9).
  float survival = path.bounce < ROULETTE_FIRST_BOUNCE
      ? 1.0
      : min(1.0, max(path.throughput.r, max(path.throughput.g, path.throughput.b)) * path.eta_scale);
  if (!(u.w < survival)) return;
  path.throughput /= survival;

  path.origin = offset_origin(point.surface.position, point.surface.clearance, point.geometric_normal, direction);
  path.direction = normalize(direction);
  path.pdf = (next.flags & BSDF_SAMPLE_DELTA) != 0u ? 0.0 : next.pdf_forward;
  path.medium = medium_towards(point, path.medium, next.wi.z);
  path.bounce += 1u;
  STORE(PathBuffer, frame.paths, slot, path);
  append_ray(path.bounce, slot);
}

#endif
