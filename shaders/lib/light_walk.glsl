// What a light path does at a surface: leaves a vertex for connections and merges, is seen by the lens (technique
// `splat`), goes on.
#ifndef REGULUS_LIB_LIGHT_WALK_GLSL
#define REGULUS_LIB_LIGHT_WALK_GLSL

#include "lib/camera.glsl"
#include "lib/layers.glsl"
#include "lib/measure.glsl"
#include "lib/queue.glsl"
#include "lib/rng.glsl"
#include "lib/shading.glsl"
#include "lib/shadow_roulette.glsl"

// Appends the vertex to those of the light path in slot `head`. What does not fit is counted, not stored: the
// host then makes room and walks again.
void store_light_vertex(Frame frame, const ShadingPoint point, Path path, vec2 sharp, PathHistory history, Hit hit, uint head,
                        uint slot) {
  uint index = ATOMIC_ADD(frame.light_vertex_count, LIGHT_COUNT_VERTICES, 1u);
  if (index >= frame.light_vertex_capacity) return;
  LightPathHead list = LOAD(LightHeadBuffer, frame.light_heads, head);
  LightVertex vertex;
  vertex.position = point.surface.position;
  vertex.previous = list.last;
  vertex.direction = -path.direction;
  vertex.triangle = hit.triangle;
  vertex.throughput = path.throughput;
  vertex.mis_a = path.mis_a;
  vertex.barycentrics = vec2(hit.u, hit.v);
  vertex.mis_b = path.mis_b;
  vertex.edges = (path.bounce + 1u) | spec_material_class << LIGHT_VERTEX_CLASS_SHIFT |
                 (path.number & LIGHT_VERTEX_STREAM_MASK) << LIGHT_VERTEX_STREAM_SHIFT;
  if (has_dispersed(path)) vertex.edges |= PATH_VERTEX_DISPERSED;
  STORE(LightVertexBuffer, frame.light_vertices, index, vertex);
  if (has_layers())
    STORE(WordBuffer, frame.light_vertex_trails, index, LOAD(WordBuffer, frame.path_trails, slot));
  if (has_contacts()) STORE(MediaSetBuffer, frame.light_vertex_media, index, point.around);
  if (has_sharp_levels()) STORE(Vec2Buffer, frame.light_vertex_sharp, index, sharp);
  if (has_histories()) STORE(PathHistoryBuffer, frame.light_vertex_histories, index, history);
  STORE(LightHeadBuffer, frame.light_heads, head, LightPathHead(index, list.count + 1u));
}

// p_connect / p_trace of the light where a light path starts (docs/mathematics.md 3.2), for its first vertex: how likely nee would
// choose that light from there. Which light it is follows from the path's random numbers. (How a guide has moved the path's
// start is in its accumulators already.)
float first_connect_ratio(Frame frame, const ShadingPoint point, Path path) {
  if ((spec_techniques & TECHNIQUE_NEE) == 0u) return 1.0;
  if (spec_light_sampling == LIGHT_SAMPLING_POWER && !has_light_guide()) return 1.0;
  vec4 u = random_block(frame.seed, path.number & PATH_NUMBER, path.sample_index, DIMENSION_BLOCK_EMISSION);
  uint light = select_emitter(frame, u.xy);
  float selection_pdf = LOAD(LightBuffer, frame.lights, light).selection_pdf;
  float ratio = choice_probability(frame, light_receiver(point), light, selection_pdf) / selection_pdf;
  if (has_light_guide()) ratio *= selection_pdf / LOAD(GuidedLightBuffer, frame.guided_lights, light).selection_pdf;
  return ratio;
}

// The share of a light's power that reaches the path's first vertex: less than 1 for a light of limited range.
float first_range_share(Frame frame, Path path, float distance) {
  if ((spec_features & FEATURE_LIGHT_RANGES) == 0u) return 1.0;
  vec4 u = random_block(frame.seed, path.number & PATH_NUMBER, path.sample_index, DIMENSION_BLOCK_EMISSION);
  return range_share(LOAD(LightBuffer, frame.lights, select_emitter(frame, u.xy)), square(distance));
}

// media: where the segment starts; edges: of the light path; trail: of the whole path, with its group; unweighted: the
// contribution without its weight.
void queue_splat(Frame frame, VisibilityCandidate segment, PathMedia media, vec2 film, uint edges, uint trail,
                 vec3 unweighted) {
  uint index = append_splat(SplatCandidate(segment, film));
  if (has_layers()) STORE(WordBuffer, frame.splat_trails, index, trail);
  if (has_contacts()) STORE(PathMediaBuffer, frame.splat_media, index, media);
  if (has_strategies())
    STORE(StrategyCandidateBuffer, frame.splat_strategies, index,
          StrategyCandidate(unweighted, strategy_layer(frame, edges + 1u, 1u, false)));
}

vec2 film_size(Frame frame) { return vec2(frame.width, frame.height); }

// True for a film point that is out of reach of the filters of all rendered pixels.
bool is_off_film(Frame frame, vec2 film) {
  vec2 half_size = 0.5 * vec2(frame.crop.zw);
  vec2 outside = abs(film - vec2(frame.crop.xy) - half_size) - half_size + 0.5;
  return !(max(outside.x, outside.y) <= frame.filter_radius);
}

// Technique `splat`: queues the segment to the lens with what it would contribute.
void connect_to_lens(Frame frame, const ShadingPoint point, Path path, MisVertex vertex, PathHistory history,
                     TechniqueCounts counts, Hit hit, uint slot) {
  if ((spec_techniques & TECHNIQUE_SPLAT) == 0u || stage.is_repeated != 0u) return;
  vec4 u = random_block(frame.seed, path.number & PATH_NUMBER, path.sample_index, DIMENSION_BLOCK_SPLAT + path.bounce);
  LensSample lens = sample_lens(frame.camera, film_size(frame), point.surface.position, u.xy);
  vec3 wi = to_local_seen(point, lens.wi);
  if (!lens.is_visible || is_off_film(frame, lens.film) || is_dark_towards(point, lens.wi)) return;
  Regularization regularization = regularization_of(frame, path.sample_index, false);
  uvec4 seed = virtual_merge_seed(frame.seed, path.number & PATH_NUMBER, path.sample_index, VIRTUAL_MERGE_AT_LIGHT,
                                  uvec3(0u, path.bounce + 1u, 0u));
  ConnectionEval bsdf = bsdf_connect(point.bsdf, point.wo, wi, TRANSPORT_IMPORTANCE, regularization, seed);
  float area_pdf = lens.pdf * abs(dot(lens.wi, point.geometric_normal));
  float distance = edge_length(frame, lens.distance, frame.camera.kind == CAMERA_ORTHOGRAPHIC);
  Weighted measured = measure_splat(frame, counts, light_end(vertex, history, path.bounce + 1u, false), bsdf, area_pdf,
                                    camera_bound(frame), distance, regularization);
  float correction = shading_correction(point, -path.direction, point.wo.z);
  vec3 factor = path.throughput * response_of(frame, path.sample_index, has_dispersed(path) || point.is_dispersive) *
                (correction * area_pdf / float(frame.light_path_count)) *
                transmittance(frame, medium_towards(frame, point, path.medium, wi.z), lens.open_distance) *
                transmittance_before_plane(frame, lens.distance - lens.open_distance);
  vec3 contribution = factor * measured.value;
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;
  float share = traced_share(frame, contribution, path.number & PATH_NUMBER, path.sample_index,
                             uvec3(0u, path.bounce + 1u, 0u));
  if (!(share > 0.0)) return;
  VisibilityCandidate segment =
      visibility_segment(point, lens.wi, point.surface.position + lens.open_distance * lens.wi);
  segment.receiver = 0u;
  segment.contribution = contribution / share;
  uint trail = 0u;
  if (has_layers()) trail = LOAD(WordBuffer, frame.path_trails, slot) | vertex_trail(point.bsdf, true);
  queue_splat(frame, segment, ray_media(point, lens.wi, wi.z, hit.triangle, vec2(hit.u, hit.v)), lens.film, path.bounce + 1u,
              trail, factor * measured.unweighted / share);
}

// Continues the walk. Roulette keeps the power of all light paths alike: a path survives with the bsdf's own factor.
// `sharp`: the vertex as it counts for a camera path that has not diffused on its way here.
void scatter_light(Frame frame, const ShadingPoint point, Path path, MisVertex vertex, MisVertex sharp, PathHistory history,
                   TechniqueCounts counts, Hit hit, uint slot) {
  vec4 u = random_block(frame.seed, path.number & PATH_NUMBER, path.sample_index, DIMENSION_BLOCK_LIGHT_BSDF + path.bounce);
  BsdfSample next = bsdf_sample(point.bsdf, point.wo, u.x, u.yz, TRANSPORT_IMPORTANCE);
  if ((next.flags & BSDF_SAMPLE_VALID) == 0u) return;
  vec3 direction = to_world_seen(point, next.wi);
  if (is_dark_towards(point, direction)) return;
  float cos_out = dot(direction, point.geometric_normal);
  float correction = shading_correction(point, -path.direction, point.wo.z);
  if ((spec_features & FEATURE_SMOOTH_NORMALS) != 0u) correction *= abs(cos_out) / max(abs(next.wi.z), 1e-7);
  vec3 factor = next.weight * correction;
  float survival =
      path.bounce < ROULETTE_FIRST_BOUNCE ? 1.0 : min(1.0, max(factor.r, max(factor.g, factor.b)));
  if (!(u.w < survival)) return;
  path.throughput *= factor / survival;

  path.origin = ray_origin(point, direction);
  path.direction = normalize(direction);
  float pdf_ratio = walk_pdf_ratio(point.bsdf, point.wo, next);
  Regularization regularization = regularization_of(frame, path.sample_index, true);
  WalkPdf walk = walk_pdf(point.bsdf, point.wo, next, TRANSPORT_IMPORTANCE, regularization);
  if (is_regularized()) {
    // For a camera path that has not diffused, the surface here is not regularized.
    float sharp_ratio = (next.flags & BSDF_SAMPLE_DELTA) != 0u ? 0.0 : 1.0;
    if (has_sharp_levels()) {
      Path sharp_path = path;
      count_copies(counts, history.sharp_ratio, sharp_ratio, sharp);
      mis_scatter(counts, sharp, walk.plain_inverse, pdf_ratio, cos_out, sharp_path);
      STORE(Vec2Buffer, frame.light_path_sharp, slot, vec2(sharp_path.mis_a, sharp_path.mis_b));
    }
    if (has_histories()) {
      uint edges = path.bounce + 1u;
      count_copies(counts, history.ratio, walk.ratio, vertex);
      MisVertex plain = mis_light_vertex(counts, history.plain.x, history.plain.y, edges);
      float worst = history_worst(history, counts, walk.bound, light_edge_technique(edges));
      history_scatter(counts, plain, worst, walk, pdf_ratio, cos_out, history);
      history.sharp_ratio = sharp_ratio;
      STORE(PathHistoryBuffer, frame.path_histories, slot, history);
    }
  }
  mis_scatter(counts, vertex, walk.inverse, pdf_ratio, cos_out, path);
  path.medium = medium_towards(frame, point, path.medium, next.wi.z);
  if (has_contacts())
    STORE(PathMediaBuffer, frame.path_media, slot, ray_media(point, direction, next.wi.z, hit.triangle, vec2(hit.u, hit.v)));
  if (has_layers())
    STORE(WordBuffer, frame.path_trails, slot, LOAD(WordBuffer, frame.path_trails, slot) | vertex_trail(point.bsdf, false));
  path.bounce += 1u;
  if (has_dispersion() && point.is_dispersive) path.number |= PATH_DISPERSED;
  STORE(PathBuffer, frame.paths, slot, path);
  append_ray(path.bounce, slot);
}

#endif
