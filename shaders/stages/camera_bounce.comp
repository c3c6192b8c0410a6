// camera_bounce: a path has met a surface of one material class: emission, a light connection, the pairs of vertices to
// connect, the next ray.
// reads  bounce queue of spec_material_class, paths, hits; light vertices
// writes radiance, candidates, camera vertices, pairs, paths, ray queue of the next bounce
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/camera_walk.glsl"
#include "lib/film.glsl"
#include "lib/pairs.glsl"
#include "lib/thickness.glsl"

// The light of the emitter that the path has met.
void add_emission(Frame frame, ShadingPoint point, Path path, vec3 emitted, uint slot) {
  if (has_layers()) {
    uint trail = LOAD(WordBuffer, frame.path_trails, slot) | group_trail(frame, point.surface.light);
    if (!add_to_film(frame, trail, film_index(frame, path.number & PATH_NUMBER), emitted))
      count_events(COUNTER_NON_FINITE, 1u);
  } else {
    STORE(Vec3Buffer, frame.radiance, slot, LOAD(Vec3Buffer, frame.radiance, slot) + emitted);
  }
}

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_BOUNCE + spec_material_class)) return;
  Frame frame = FRAME;
  uint slot = queued_arrival(i);
  Path path = LOAD(PathBuffer, frame.paths, slot);
  Hit hit = LOAD(HitBuffer, frame.hits, slot);

  PathMedia media = start_media(NO_MEDIA);
  if (has_contacts()) media = LOAD(PathMediaBuffer, frame.path_media, slot);
  ShadingPoint point = shading_point(frame, hit.triangle, vec2(hit.u, hit.v), -path.direction, TRANSPORT_RADIANCE,
                                     media.around, bend_of(frame, path.sample_index));
  float way = hit.t;
  if ((spec_features & FEATURE_ABSORPTION) != 0u)
    way = length_in_medium(frame, media, path.direction, hit, point.surface.position);
  if (has_contacts() && path.bounce == 0u) {
    float cut = cut_length(frame.camera, path.direction);
    way -= cut;
    path.throughput *= transmittance_before_plane(frame, cut);
  }
  path.throughput *= transmittance(frame, path.medium, way);
  mis_arrive(path, hit.t, dot(path.direction, point.geometric_normal),
             path.bounce == 0u && frame.camera.kind == CAMERA_ORTHOGRAPHIC);
  PathHistory history;
  if (has_histories()) {
    history = LOAD(PathHistoryBuffer, frame.path_histories, slot);
    history_arrive(frame, history, hit.t, dot(path.direction, point.geometric_normal),
                   path.bounce == 0u && frame.camera.kind == CAMERA_ORTHOGRAPHIC);
  }
  TechniqueCounts counts = technique_counts(frame, stage.merge_radius);
  Weighted emission = emission_towards(frame, point, path, history, counts, slot);
  vec3 carried = path.throughput * response_of(frame, path.sample_index, has_dispersed(path));
  vec3 emitted = carried * emission.value;
  if (any(greaterThan(emitted, vec3(0.0))))
    add_emission(frame, point, path, clamp_contribution(emitted, frame.largest_contribution), slot);
  if (has_strategies())
    add_to_strategy(frame, strategy_layer(frame, 0u, path.bounce + 2u, false), film_index(frame, path.number & PATH_NUMBER),
                    clamp_contribution(emitted, frame.largest_contribution), carried * emission.unweighted);

  // An edge to a light or to the next vertex would be edge bounce + 2 of the path.
  bool ends = path.bounce + 2u > frame.max_depth || point.wo.z <= 0.0;
  if (has_state(STATE_VERTICES))
    store_camera_vertex(frame, point, path, history, hit, slot, !ends && is_connectible(point));
  if (ends) return;
  MisVertex vertex = mis_camera_vertex(counts, path.mis_a, path.mis_b, path.bounce + 1u);
  uint block = DIMENSION_BLOCKS_FIRST + path.bounce * DIMENSION_BLOCKS_PER_BOUNCE;
  uint pixel = path.number & PATH_NUMBER;
  vec4 light_u = random_block(frame.seed, pixel, path.sample_index, block + DIMENSION_BLOCK_LIGHT);
  vec4 bsdf_u = random_block(frame.seed, pixel, path.sample_index, block + DIMENSION_BLOCK_BSDF);
  vec3 footprint = vec3(0.0);
  Regularization regularization = regularization_of(frame, path.sample_index, is_diffused(path));
  if (has_footprints()) {
    footprint = travelled(LOAD(Vec3Buffer, frame.path_footprints, slot), hit.t);
    regularization = diffused_regularization(frame, path.sample_index, diffusion(footprint));
  }
  connect_to_light(frame, point, path, vertex, history, regularization, counts, hit, slot, light_u);
  if ((spec_techniques & TECHNIQUE_CONNECT) != 0u && is_connectible(point)) append_pairs(frame, path, slot);
  scatter(frame, point, path, vertex, history, regularization, counts, hit, footprint, slot, bsdf_u);
}
