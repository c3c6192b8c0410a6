// connect: what the edge between a camera vertex and a light vertex would carry, as a candidate. The more general of the
// two has material class spec_material_class.
// reads  pairs, camera vertices, light vertices          writes  candidates
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/film.glsl"
#include "lib/layers.glsl"
#include "lib/measure.glsl"
#include "lib/queue.glsl"
#include "lib/shading.glsl"
#include "lib/shadow_roulette.glsl"

// Number of connections among which the estimate of one camera vertex is divided.
float connection_count(Frame frame) {
  if (frame.cache_connections == 0u) return 1.0;
  float cached = float(LOAD(WordBuffer, frame.light_vertex_count, LIGHT_COUNT_VERTICES));
  return float(frame.cache_connections) * float(frame.light_path_count) / cached;
}

// The two vertices of a connection.
struct Connection {
  ConnectionPair pair;
  CameraVertex camera;
  LightVertex light;
  ConnectionEval camera_bsdf, light_bsdf;
  bool is_diffused;  // is_diffused of light_vertex_mis
  uint iteration;
  float distance;
  float camera_pdf_scale, light_pdf_scale;  // solid-angle pdf towards the vertex to area pdf there
};

// Both bsdfs, and their product with the weight.
Weighted weighted_value(Frame frame, Connection connection) {
  CameraVertex camera = connection.camera;
  LightVertex light = connection.light;
  TechniqueCounts counts = technique_counts(frame, stage.merge_radius);
  uint camera_edges = camera.edges & PATH_VERTEX_EDGES, light_edges = light.edges & PATH_VERTEX_EDGES;
  PathHistory camera_history, light_history;
  if (has_histories()) {
    camera_history = LOAD(PathHistoryBuffer, frame.camera_vertex_histories, connection.pair.slot);
    light_history = LOAD(PathHistoryBuffer, frame.light_vertex_histories, connection.pair.vertex);
  }
  SubpathEnd camera_subpath = camera_end(mis_camera_vertex(counts, camera.mis_a, camera.mis_b, camera_edges),
                                         camera_history, camera_edges);
  SubpathEnd light_subpath =
      light_end(light_vertex_mis(frame, counts, light, connection.pair.vertex, connection.is_diffused), light_history,
                light_edges, connection.is_diffused);
  return measure_connect(frame, counts, camera_subpath, connection.camera_bsdf, connection.camera_pdf_scale,
                         light_subpath, connection.light_bsdf, connection.light_pdf_scale,
                         edge_length(frame, connection.distance, false),
                         regularization_of(frame, connection.iteration, true));
}

void main() {
  uint i = stage.first_item + item_index();
  if (i >= queue_count(QUEUE_PAIRS + spec_material_class)) return;
  Frame frame = FRAME;
  ConnectionPair pair = queued_pair(i);
  CameraVertex camera = LOAD(CameraVertexBuffer, frame.camera_vertices, pair.slot);
  LightVertex light = LOAD(LightVertexBuffer, frame.light_vertices, pair.vertex);

  vec3 to_light = light.position - camera.position;
  float squared = dot(to_light, to_light);
  if (!(squared > 0.0)) return;
  float distance = sqrt(squared);
  vec3 direction = to_light / distance;
  MediaSet camera_media = NO_MEDIA, light_media = NO_MEDIA;
  if (has_contacts()) {
    camera_media = LOAD(MediaSetBuffer, frame.camera_vertex_media, pair.slot);
    light_media = LOAD(MediaSetBuffer, frame.light_vertex_media, pair.vertex);
  }
  Path path = LOAD(PathBuffer, frame.paths, pair.slot);
  float bend = bend_of(frame, path.sample_index);
  ShadingPoint camera_point = shading_point(frame, camera.triangle, camera.barycentrics, camera.direction,
                                            TRANSPORT_RADIANCE, camera_media, bend);
  ShadingPoint light_point =
      shading_point(frame, light.triangle, light.barycentrics, light.direction, TRANSPORT_IMPORTANCE, light_media, bend);
  vec3 camera_wi, light_wi = to_local_seen(light_point, -direction);
  if (!to_local_lit(camera_point, direction, camera_wi) || !(light_point.wo.z > 0.0)) return;
  if (is_dark_towards(light_point, -direction)) return;
  look_towards(frame, direction, camera_point);
  look_towards(frame, light.direction, light_point);
  bool camera_diffused = (camera.edges & PATH_VERTEX_DIFFUSED) != 0u;
  bool light_diffused = camera_diffused || diffuses(camera_point.bsdf);
  uvec3 place = uvec3(camera.edges & PATH_VERTEX_EDGES, light.edges & PATH_VERTEX_EDGES,
                      light.edges >> LIGHT_VERTEX_STREAM_SHIFT & LIGHT_VERTEX_STREAM_MASK);
  uint pixel = path.number & PATH_NUMBER;
  ConnectionEval camera_bsdf =
      bsdf_connect(camera_point.bsdf, camera_point.wo, camera_wi, TRANSPORT_RADIANCE,
                   regularization_of(frame, path.sample_index, camera_diffused),
                   virtual_merge_seed(frame.seed, pixel, path.sample_index, VIRTUAL_MERGE_AT_CAMERA, place));
  ConnectionEval light_bsdf =
      bsdf_connect(light_point.bsdf, light_point.wo, light_wi, TRANSPORT_IMPORTANCE,
                   regularization_of(frame, path.sample_index, light_diffused),
                   virtual_merge_seed(frame.seed, pixel, path.sample_index, VIRTUAL_MERGE_AT_LIGHT, place));

  float camera_cos = arrival_cosine(camera_point, direction) / squared;
  float light_cos = abs(dot(direction, light_point.geometric_normal)) / squared;
  Weighted value = weighted_value(frame, Connection(pair, camera, light, camera_bsdf, light_bsdf,
                                                    !has_diffusion() || light_diffused || diffuses(light_point.bsdf),
                                                    path.sample_index, distance, camera_cos, light_cos));
  float correction = shading_correction(light_point, light.direction, light_point.wo.z);
  bool is_dispersed = ((camera.edges | light.edges) & PATH_VERTEX_DISPERSED) != 0u || camera_point.is_dispersive ||
                      light_point.is_dispersive;
  vec3 factor = camera.throughput * light.throughput * response_of(frame, path.sample_index, is_dispersed) *
                (abs(camera_wi.z) * light_cos * correction / connection_count(frame)) *
                transmittance(frame, medium_towards(frame, camera_point, camera.medium, camera_wi.z), distance);
  vec3 contribution = factor * value.value;
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;
  float share = traced_share(frame, contribution, pixel, path.sample_index, place);
  if (!(share > 0.0)) return;

  vec3 target = offset_origin(light.position, light_point.surface.clearance, light_point.geometric_normal, -direction);
  VisibilityCandidate candidate = visibility_segment(camera_point, direction, target);
  candidate.receiver = film_index(frame, path.number & PATH_NUMBER);
  candidate.contribution = contribution / share;
  uint index = append_candidate(candidate);
  if (has_contacts())
    STORE(PathMediaBuffer, frame.candidate_media, index,
          ray_media(camera_point, direction, camera_wi.z, camera.triangle, camera.barycentrics));
  if (has_layers()) {
    uint trail = LOAD(WordBuffer, frame.camera_vertex_trails, pair.slot);
    trail |= LOAD(WordBuffer, frame.light_vertex_trails, pair.vertex);
    trail |= vertex_trail(camera_point.bsdf, (camera.edges & PATH_VERTEX_EDGES) == 1u) | vertex_trail(light_point.bsdf, false);
    STORE(WordBuffer, frame.candidate_trails, index, trail);
  }
  if (has_strategies()) {
    uint layer = strategy_layer(frame, (light.edges & PATH_VERTEX_EDGES) + 1u, (camera.edges & PATH_VERTEX_EDGES) + 1u, false);
    STORE(StrategyCandidateBuffer, frame.candidate_strategies, index,
          StrategyCandidate(factor * value.unweighted / share, layer));
  }
}
