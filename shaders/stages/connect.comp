// connect: a camera vertex and a light vertex, of which the more general has material class spec_material_class:
// what their edge would carry, as a candidate.
// reads  pairs, camera vertices, light vertices          writes  candidates
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/mis.glsl"
#include "lib/regularization.glsl"
#include "lib/shading.glsl"

// Over how many connections the estimate of one camera vertex is divided.
float connection_count(Frame frame) {
  if (frame.cache_connections == 0u) return 1.0;
  float cached = float(LOAD(WordBuffer, frame.light_vertex_count, 0u));
  return float(frame.cache_connections) * float(frame.light_path_count) / cached;
}

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_PAIRS + spec_material_class)) return;
  Frame frame = FRAME;
  ConnectionPair pair = LOAD(ConnectionPairBuffer, frame.pairs, spec_material_class * frame.pair_capacity + i);
  PathVertex camera = LOAD(PathVertexBuffer, frame.camera_vertices, pair.slot);
  PathVertex light = LOAD(PathVertexBuffer, frame.light_vertices, pair.vertex);

  vec3 to_light = light.position - camera.position;
  float squared = dot(to_light, to_light);
  if (!(squared > 0.0)) return;
  float distance = sqrt(squared);
  vec3 direction = to_light / distance;
  ShadingPoint camera_point = shading_point(frame, camera.triangle, camera.barycentrics, camera.direction, TRANSPORT_RADIANCE);
  ShadingPoint light_point = shading_point(frame, light.triangle, light.barycentrics, light.direction, TRANSPORT_IMPORTANCE);
  vec3 camera_wi = to_local(camera_point, direction), light_wi = to_local_seen(light_point, -direction);
  if (!sides_agree(camera_point, direction, camera_wi) || !(light_point.wo.z > 0.0)) return;
  Path path = LOAD(PathBuffer, frame.paths, pair.slot);
  bool camera_diffused = (camera.edges & PATH_VERTEX_DIFFUSED) != 0u;
  bool light_diffused = camera_diffused || diffuses(camera_point.bsdf);
  BsdfEval camera_bsdf = bsdf_connect(camera_point.bsdf, camera_point.wo, camera_wi, TRANSPORT_RADIANCE,
                                      regularization_of(frame, path.sample_index, camera_diffused));
  BsdfEval light_bsdf = bsdf_connect(light_point.bsdf, light_point.wo, light_wi, TRANSPORT_IMPORTANCE,
                                     regularization_of(frame, path.sample_index, light_diffused));

  float camera_cos = abs(dot(direction, camera_point.geometric_normal)) / squared;
  float light_cos = abs(dot(direction, light_point.geometric_normal)) / squared;
  TechniqueCounts counts = technique_counts(frame, stage.merge_radius);
  MisVertex camera_mis = mis_camera_vertex(counts, camera.mis_a, camera.mis_b, camera.edges & PATH_VERTEX_EDGES);
  MisVertex light_mis = light_vertex_mis(frame, counts, light, pair.vertex, light_diffused);
  float weight = mis_weight_connect(counts, light_mis, light_bsdf.pdf_reverse, camera_bsdf.pdf_forward * light_cos,
                                    camera_mis, camera_bsdf.pdf_reverse, light_bsdf.pdf_forward * camera_cos);
  float correction = shading_correction(light_point, light.direction, light_point.wo.z);
  vec3 contribution = camera.throughput * camera_bsdf.value * light_bsdf.value * light.throughput *
                      (abs(camera_wi.z) * light_cos * correction * weight / connection_count(frame));
  contribution *= transmittance(frame, medium_towards(camera_point, camera.link, camera_wi.z), distance);
  if (!(max(contribution.r, max(contribution.g, contribution.b)) > 0.0)) return;

  vec3 target = offset_origin(light.position, light_point.surface.clearance, light_point.geometric_normal, -direction);
  VisibilityCandidate candidate = visibility_segment(camera_point, direction, target);
  candidate.path = path.pixel & PATH_PIXEL;
  candidate.contribution = contribution;
  uint index = queue_reserve(queue_head(QUEUE_VISIBILITY));
  STORE(CandidateBuffer, frame.candidates, index, candidate);
}
