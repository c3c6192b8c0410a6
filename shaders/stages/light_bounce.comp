// light_bounce: a light path has met a surface of one material class: a stored vertex, a splat, the next ray.
// reads  bounce queue of spec_material_class, paths, hits
// writes light vertices and heads, splat candidates, paths, ray queue of the next bounce
#version 460
#extension GL_GOOGLE_include_directive : require
#include "lib/light_walk.glsl"
#include "lib/thickness.glsl"

void main() {
  uint i = item_index();
  if (i >= queue_count(QUEUE_BOUNCE + spec_material_class)) return;
  Frame frame = FRAME;
  uint slot = queued_arrival(i);
  Path path = LOAD(PathBuffer, frame.paths, slot);
  Hit hit = LOAD(HitBuffer, frame.hits, slot);
  PathMedia media = start_media(NO_MEDIA);
  if (has_contacts()) media = LOAD(PathMediaBuffer, frame.path_media, slot);
  ShadingPoint point = shading_point(frame, hit.triangle, vec2(hit.u, hit.v), -path.direction, TRANSPORT_IMPORTANCE,
                                     media.around, bend_of(frame, path.sample_index));
  look_towards(frame, -path.direction, point);
  float way = hit.t;
  if ((spec_features & FEATURE_ABSORPTION) != 0u)
    way = length_in_medium(frame, media, path.direction, hit, point.surface.position);
  path.throughput *= transmittance(frame, path.medium, way);
  if (path.bounce == 0u) path.throughput *= first_range_share(frame, path, hit.t);
  if ((spec_features & FEATURE_LIGHT_RANGES) != 0u && path.throughput == vec3(0.0)) return;
  bool is_parallel = path.bounce == 0u && (path.number & PATH_PARALLEL) != 0u;
  float cos_here = dot(path.direction, point.geometric_normal);
  float connect_ratio = path.bounce == 0u ? first_connect_ratio(frame, point, path) : 1.0;
  path.mis_a *= connect_ratio;
  Path sharp_path = path;
  mis_arrive(path, hit.t, cos_here, is_parallel);
  // Accumulators with the previous vertex not regularized, for a camera that sees everything from here on sharply. Whether
  // this vertex diffuses is known to whoever uses it: a merge has the camera's surface here.
  vec2 sharp = vec2(path.mis_a, path.mis_b);
  if (has_sharp_levels() && path.bounce > 0u) {
    vec2 carried = LOAD(Vec2Buffer, frame.light_path_sharp, slot);
    sharp_path.mis_a = carried.x;
    sharp_path.mis_b = carried.y;
    mis_arrive(sharp_path, hit.t, cos_here, is_parallel);
    sharp = vec2(sharp_path.mis_a, sharp_path.mis_b);
  }
  bool hides_sharpness = !has_diffusion() || diffuses(point.bsdf);

  PathHistory history;
  if (has_histories()) {
    history = LOAD(PathHistoryBuffer, frame.path_histories, slot);
    history.plain.x *= connect_ratio;
    history_arrive(frame, history, hit.t, cos_here, is_parallel);
  }

  TechniqueCounts counts = technique_counts(frame, stage.merge_radius);
  MisVertex vertex = mis_light_vertex(counts, path.mis_a, path.mis_b, path.bounce + 1u);
  if (is_connectible(point) && has_state(STATE_VERTICES)) {
    uint head = frame.light_head_modulus == 0u ? slot : path.number & PATH_NUMBER;
    store_light_vertex(frame, point, path, sharp, history, hit, head, slot);
  }
  // The walk ends where the normals disagree about its arrival. A merge has the camera's surface here, where they may
  // agree: the vertex counts all the same.
  if (point.wo.z <= 0.0) return;
  if (hides_sharpness) {
    sharp = vec2(path.mis_a, path.mis_b);
    if (has_histories()) history.sharp_ratio = history.ratio;
  }
  MisVertex sharp_vertex = mis_light_vertex(counts, sharp.x, sharp.y, path.bounce + 1u);
  // A light path has at least one edge, and the edge to the lens comes on top.
  if (is_connectible(point) && path.bounce + 2u <= frame.max_depth) {
    connect_to_lens(frame, point, path, sharp_vertex, history, counts, hit, slot);
  }
  // The next vertex would be edge bounce + 2, and one more edge has to lead to the camera.
  if (path.bounce + 3u <= frame.max_depth) scatter_light(frame, point, path, vertex, sharp_vertex, history, counts, hit, slot);
}
