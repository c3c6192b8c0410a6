// What a camera path does at a surface: meets an emitter (technique `hit`), samples a light (`nee`), goes on.
#ifndef REGULUS_LIB_CAMERA_WALK_GLSL
#define REGULUS_LIB_CAMERA_WALK_GLSL

#include "lib/film.glsl"
#include "lib/footprint.glsl"
#include "lib/layers.glsl"
#include "lib/measure.glsl"
#include "lib/queue.glsl"
#include "lib/rng.glsl"
#include "lib/shading.glsl"
#include "lib/shadow_roulette.glsl"

// True if the path has met a surface that diffuses before the vertex it arrives at.
bool is_diffused(Path path) { return (path.number & PATH_DIFFUSED) != 0u; }

// Technique `hit`: radiance that the surface sends back along the ray that arrived, weighted. An emitter that the
// camera sees directly is found by no other technique.
Weighted emission_towards(Frame frame, ShadingPoint point, Path path, PathHistory history, TechniqueCounts counts,
                          uint slot) {
  const Weighted NONE = Weighted(vec3(0.0), vec3(0.0));
  if ((spec_techniques & TECHNIQUE_HIT) == 0u || (spec_features & FEATURE_TRIANGLE_LIGHTS) == 0u) return NONE;
  if (point.surface.light == INVALID_INDEX) return NONE;
  if (!point.is_front && (point.material.flags & MATERIAL_DOUBLE_SIDED) == 0u) return NONE;
  vec3 radiance = emitted_radiance(frame, point.material, point.material.emission, point.surface.uv, point.surface.color);
  if (path.bounce == 0u) return Weighted(radiance, radiance);
  float selection_pdf = LOAD(LightBuffer, frame.lights, point.surface.light).selection_pdf;
  float pdf_connect = previous_choice_probability(frame, slot, point.surface.light, selection_pdf) / point.surface.area;
  float cos_light = abs(dot(path.direction, point.surface.geometric_normal));
  float pdf_emit = selection_pdf / point.surface.area * triangle_emission_pdf(point.material, cos_light);
  if (has_light_guide()) {
    bool is_two_sided = (point.material.flags & MATERIAL_DOUBLE_SIDED) != 0u;
    pdf_emit *= guided_share(frame, point.surface.light, selection_pdf,
                             triangle_start(point.surface.geometric_normal, is_two_sided, -path.direction));
  }
  return Weighted(radiance * hit_weight(frame, path, history, counts, pdf_connect, pdf_emit, EMITTER_BOUND), radiance);
}

// What a light contributes by technique `nee`, divided by its pdf and by the throughput: bsdf, cosine and weight.
Weighted light_connection(Frame frame, ShadingPoint point, Path path, MisVertex vertex, PathHistory history,
                      Regularization regularization, TechniqueCounts counts, LightSample light, vec3 wi) {
  uvec4 seed = virtual_merge_seed(frame.seed, path.number & PATH_NUMBER, path.sample_index, VIRTUAL_MERGE_AT_CAMERA,
                                  uvec3(path.bounce + 1u, 0u, 0u));
  ConnectionEval bsdf = bsdf_connect(point.bsdf, point.wo, wi, TRANSPORT_RADIANCE, regularization, seed);
  float emission_pdf = light.emission_ratio * arrival_cosine(point, light.wi);
  float per_light = light.is_delta ? 0.0 : 1.0 / light.pdf;
  float distance = edge_length(frame, light.distance, light.is_distant);
  Weighted measured = measure_nee(frame, counts, camera_end(vertex, history, path.bounce + 1u), bsdf, per_light,
                                  emission_pdf, light.bound, distance, regularization);
  return Weighted(measured.value * abs(wi.z), measured.unweighted * abs(wi.z));
}

// Technique `nee`: queues a shadow segment with what it would contribute.
void connect_to_light(Frame frame, ShadingPoint point, Path path, MisVertex vertex, PathHistory history,
                      Regularization regularization, TechniqueCounts counts, Hit hit, uint slot, vec4 u) {
  if ((spec_techniques & TECHNIQUE_NEE) == 0u || frame.light_count == 0u) return;
  LightSample light = sample_light(frame, light_receiver(point), u);
  if (spec_light_sampling != LIGHT_SAMPLING_POWER && !(light.pdf > 0.0)) return;
  vec3 wi;
  if (!to_local_lit(point, light.wi, wi)) return;
  look_towards(frame, light.wi, point);
  // Lights without extent are not seen in mirrors or through clear glass. A bundle of camera paths, however narrow, would
  // show them there, as glints of all their light in a pixel.
  if (has_footprints() && light.is_delta && !is_diffused(path)) regularization.alpha_scale = 0.0;
  Weighted measured = light_connection(frame, point, path, vertex, history, regularization, counts, light, wi);
  vec3 factor = path.throughput * response_of(frame, path.sample_index, has_dispersed(path) || point.is_dispersive) *
                light.radiance / light.pdf *
                transmittance(frame, medium_towards(frame, point, path.medium, wi.z), light.distance);
  vec3 contribution = factor * measured.value;
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;
  float share = traced_share(frame, contribution, path.number & PATH_NUMBER, path.sample_index,
                             uvec3(path.bounce + 1u, 0u, 0u));
  if (!(share > 0.0)) return;

  VisibilityCandidate candidate = visibility_segment(point, light.wi, light.target);
  if (light.is_distant) {
    candidate.direction = light.wi;
    candidate.t_max = 3.4e38;
  }
  candidate.receiver = (spec_techniques & TECHNIQUE_CONNECT) != 0u ? film_index(frame, path.number & PATH_NUMBER) : slot;
  candidate.contribution = contribution / share;
  uint index = append_candidate(candidate);
  if (has_contacts())
    STORE(PathMediaBuffer, frame.candidate_media, index, ray_media(point, light.wi, wi.z, hit.triangle, vec2(hit.u, hit.v)));
  if (has_layers()) {
    uint trail = LOAD(WordBuffer, frame.path_trails, slot) | vertex_trail(point.bsdf, path.bounce == 0u);
    STORE(WordBuffer, frame.candidate_trails, index, trail | group_trail(frame, light.index));
  }
  if (has_strategies()) {
    uint layer = strategy_layer(frame, 1u, path.bounce + 2u, false);
    STORE(StrategyCandidateBuffer, frame.candidate_strategies, index,
          StrategyCandidate(factor * measured.unweighted / share, layer));
  }
}

// Continues the walk: samples the bsdf, plays Russian roulette, queues the next ray.
// hit: on the surface; footprint: on arrival there.
void scatter(Frame frame, ShadingPoint point, Path path, MisVertex vertex, PathHistory history,
             Regularization regularization, TechniqueCounts counts, Hit hit, vec3 footprint, uint slot, vec4 u) {
  BsdfChoice choice = bsdf_choose(point.bsdf, point.wo, u.x, u.yz, TRANSPORT_RADIANCE);
  if (has_walk_guide()) guide_choice(frame, u.yz, point, choice);
  BsdfSample next = bsdf_sampled(point.bsdf, point.wo, choice, TRANSPORT_RADIANCE);
  if ((next.flags & BSDF_SAMPLE_VALID) == 0u) return;
  vec3 direction;
  if (!to_world_lit(point, next.wi, direction)) return;

  path.throughput *= next.weight;
  path.eta_scale *= next.eta_scale;
  // A guide that is sure of a direction makes throughput small, and nothing that follows less bright.
  if (has_walk_guide()) path.eta_scale *= guided_ratio(point.bsdf, point.wo, next);
  // Survival by throughput without the eta^2 of refraction, which the way out undoes (PBR 4ed, 14.2). It is
  // left out of the MIS pdfs: weights stay exact (docs/mathematics.md 9).
  float survival = path.bounce < ROULETTE_FIRST_BOUNCE
      ? 1.0
      : min(1.0, max(path.throughput.r, max(path.throughput.g, path.throughput.b)) * path.eta_scale);
  if (!(u.w < survival)) return;
  path.throughput /= survival;

  path.origin = ray_origin(point, direction);
  path.direction = normalize(direction);
  WalkPdf walk = walk_pdf(point.bsdf, point.wo, next, TRANSPORT_RADIANCE, regularization);
  float pdf_ratio = walk_pdf_ratio(point.bsdf, point.wo, next);
  float cos_out = arrival_cosine(point, direction);
  count_copies(counts, history.ratio, walk.ratio, vertex);
  mis_scatter(counts, vertex, walk.inverse, pdf_ratio, cos_out, path);
  if (has_histories()) {
    uint edges = path.bounce + 1u;
    MisVertex plain = mis_camera_vertex(counts, history.plain.x, history.plain.y, edges);
    float worst = history_worst(history, counts, walk.bound, camera_edge_technique(edges));
    history_scatter(counts, plain, worst, walk, pdf_ratio, cos_out, history);
    STORE(PathHistoryBuffer, frame.path_histories, slot, history);
  }
  if (has_footprints()) {
    float curvature = curvature_at(frame, hit.triangle);
    footprint = scattered(footprint, point.bsdf, next, point.is_front ? curvature : -curvature);
    STORE(Vec3Buffer, frame.path_footprints, slot, footprint);
  }
  if (keeps_receivers()) STORE(LightReceiverBuffer, frame.light_receivers, slot, light_receiver(point));
  path.medium = medium_towards(frame, point, path.medium, next.wi.z);
  if (has_contacts())
    STORE(PathMediaBuffer, frame.path_media, slot, ray_media(point, direction, next.wi.z, hit.triangle, vec2(hit.u, hit.v)));
  if (has_layers()) {
    uint trail = LOAD(WordBuffer, frame.path_trails, slot) | vertex_trail(point.bsdf, path.bounce == 0u);
    STORE(WordBuffer, frame.path_trails, slot, trail);
  }
  path.bounce += 1u;
  if (is_regularized() && diffuses(point.bsdf)) path.number |= PATH_DIFFUSED;
  if (has_dispersion() && point.is_dispersive) path.number |= PATH_DISPERSED;
  STORE(PathBuffer, frame.paths, slot, path);
  append_ray(path.bounce, slot);
}

// Keeps the vertex for the connections and merges of this bounce; with 0 edges if it takes part in none.
void store_camera_vertex(Frame frame, ShadingPoint point, Path path, PathHistory history, Hit hit, uint slot,
                         bool is_usable) {
  CameraVertex vertex;
  vertex.position = point.surface.position;
  vertex.medium = path.medium;
  vertex.direction = -path.direction;
  vertex.triangle = hit.triangle;
  vertex.throughput = path.throughput;
  vertex.mis_a = path.mis_a;
  vertex.barycentrics = vec2(hit.u, hit.v);
  vertex.mis_b = path.mis_b;
  vertex.edges = is_usable ? (path.bounce + 1u) | (is_diffused(path) ? PATH_VERTEX_DIFFUSED : 0u) : 0u;
  if (has_dispersed(path) && is_usable) vertex.edges |= PATH_VERTEX_DISPERSED;
  STORE(CameraVertexBuffer, frame.camera_vertices, slot, vertex);
  if (has_layers())
    STORE(WordBuffer, frame.camera_vertex_trails, slot, LOAD(WordBuffer, frame.path_trails, slot));
  if (has_contacts()) STORE(MediaSetBuffer, frame.camera_vertex_media, slot, point.around);
  if (has_histories()) STORE(PathHistoryBuffer, frame.camera_vertex_histories, slot, history);
}

#endif
