// weights: the weight of every technique that can find a path, by the recurrences of lib/mis.glsl along both its subpaths.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "stability/batch.glsl"
#include "lib/mis.glsl"

REGULUS_BUFFER(StabilityPathBuffer, StabilityPath);
REGULUS_BUFFER(WeightsBuffer, StabilityWeights);

StabilityStep step_of(uint item, uint i) { return LOAD(StabilityPathBuffer, batch.inputs, item).steps[i]; }

void store(uint item, uint technique, float weight) {
  WeightsBuffer(batch.outputs).items[item].weights[technique] = weight;
}

void main() {
  uint item = gl_GlobalInvocationID.x;
  if (item >= batch.count) return;
  uint edges = LOAD(StabilityPathBuffer, batch.inputs, item).edges;
  float connect_pdf = LOAD(StabilityPathBuffer, batch.inputs, item).connect_pdf;
  float point_pdf = LOAD(StabilityPathBuffer, batch.inputs, item).point_pdf;
  float direction_pdf = LOAD(StabilityPathBuffer, batch.inputs, item).direction_pdf;
  float camera_pdf = LOAD(StabilityPathBuffer, batch.inputs, item).camera_pdf;
  TechniqueCounts counts = TechniqueCounts(1.0, 1.0, LOAD(StabilityPathBuffer, batch.inputs, item).light_paths, 1.0,
                                           LOAD(StabilityPathBuffer, batch.inputs, item).merge);

  // The light's walk, as light_generate starts it.
  vec2 light[STABILITY_MAX_EDGES];
  Path path;
  path.mis_a = connect_pdf / (point_pdf * direction_pdf);
  path.mis_b = step_of(item, 0u).cos_light_end / (point_pdf * direction_pdf);
  for (uint i = 1u; i < edges; ++i) {
    StabilityStep before = step_of(item, i - 1u), here = step_of(item, i);
    mis_arrive(path, before.distance, before.cos_camera_end, false);
    light[i] = vec2(path.mis_a, path.mis_b);
    mis_scatter(counts, mis_light_vertex(counts, path.mis_a, path.mis_b, i), 1.0 / here.forward, here.reverse / here.forward,
                here.cos_light_end, path);
  }

  // The camera's walk.
  path.mis_a = 1.0 / camera_pdf;
  path.mis_b = 0.0;
  float reverse_above = camera_pdf;
  for (uint i = edges - 1u; i > 0u; --i) {
    StabilityStep before = step_of(item, i - 1u), here = step_of(item, i);
    mis_arrive(path, here.distance, here.cos_light_end, false);
    MisVertex camera = mis_camera_vertex(counts, path.mis_a, path.mis_b, edges - i);
    MisVertex at_light = mis_light_vertex(counts, light[i].x, light[i].y, i);
    store(item, STABILITY_MAX_EDGES + i,
          mis_weight_merge(counts, at_light, here.reverse, camera, here.forward, 1.0));
    // Area pdfs of both ends of the edge below, from the other end.
    float area_here = (i == 1u ? direction_pdf : before.forward) * before.cos_camera_end / square(before.distance);
    float area_before = here.reverse * before.cos_light_end / square(before.distance);
    if (i == edges - 1u) {
      float camera_area_pdf = reverse_above * here.cos_light_end / square(here.distance);
      store(item, edges, mis_weight_splat(counts, at_light, here.reverse, camera_area_pdf, 1.0));
    }
    if (i == 1u) {
      store(item, 1u, mis_weight_nee(counts, camera, area_before / connect_pdf, area_here * (point_pdf / connect_pdf),
                                     here.forward, 1.0));
    } else {
      MisVertex light_end = mis_light_vertex(counts, light[i - 1u].x, light[i - 1u].y, i - 1u);
      store(item, i, mis_weight_connect(counts, light_end, before.reverse, area_before, camera, here.forward, area_here, 1.0));
    }
    mis_scatter(counts, camera, 1.0 / here.reverse, here.forward / here.reverse, before.cos_camera_end, path);
  }
  StabilityStep first = step_of(item, 0u);
  mis_arrive(path, first.distance, first.cos_light_end, false);
  store(item, 0u, mis_weight_hit(counts, vec2(path.mis_a, path.mis_b), connect_pdf, point_pdf * direction_pdf, 1.0));
}
