// What the techniques that join two subpaths measure: nee, splat, connect, merge. Each has a product of bsdfs, regularized
// and not, and a weight for each (lib/mis.glsl); how the two are mixed (lib/history.glsl) stands in `measure` alone.
#ifndef REGULUS_LIB_MEASURE_GLSL
#define REGULUS_LIB_MEASURE_GLSL

#include "lib/history.glsl"
#include "lib/strategies.glsl"

// The end of a subpath as weights see it.
struct SubpathEnd {
  MisVertex regularized;  // accumulators at the technique's level of path diffusion
  float ratio;            // rho^W / rho of the vertex before, at that level
  PathHistory history;    // accumulators of the unregularized weights, and bounds; only with has_histories()
  uint edges;             // from the walk's start
};

SubpathEnd camera_end(MisVertex vertex, PathHistory history, uint edges) {
  return SubpathEnd(vertex, history.ratio, history, edges);
}

// is_diffused: see light_vertex_mis.
SubpathEnd light_end(MisVertex vertex, PathHistory history, uint edges, bool is_diffused) {
  return SubpathEnd(vertex, is_diffused ? history.ratio : history.sharp_ratio, history, edges);
}

MisVertex plain_camera(TechniqueCounts counts, SubpathEnd end) {
  return mis_camera_vertex(counts, end.history.plain.x, end.history.plain.y, end.edges);
}

MisVertex plain_light(TechniqueCounts counts, SubpathEnd end) {
  return mis_light_vertex(counts, end.history.plain.x, end.history.plain.y, end.edges);
}

float camera_worst(TechniqueCounts counts, SubpathEnd end, float bound) {
  return history_worst(end.history, counts, bound, camera_edge_technique(end.edges));
}

float light_worst(TechniqueCounts counts, SubpathEnd end, float bound) {
  return history_worst(end.history, counts, bound, light_edge_technique(end.edges));
}

// Products of the bsdfs at the ends with their weights; ratios: rho^W / rho of all; share: of the regularized ones.
Weighted measure(vec3 regularized, vec3 plain, float ratios, float weight, float plain_weight, float share) {
  Weighted value = Weighted(weighted(regularized, plain, weight, ratios), weighted(regularized, plain, 1.0, ratios));
  if (!has_sampler_quality()) return value;
  return Weighted(mix(plain * plain_weight, value.value, share), mix(plain, value.unweighted, share));
}

// An edge between vertices of these bounds: what its estimator is bounded by.
float edge_worst(float bounds, float distance) { return bounds / max(square(distance), 1e-12); }

// per_light: 1 over the pdf of the light's point by nee, as a solid angle, or 0; emission_pdf: see mis_weight_nee; distance:
// that with which the edge counts (edge_length).
Weighted measure_nee(Frame frame, TechniqueCounts counts, SubpathEnd camera, const ConnectionEval bsdf, float per_light, float emission_pdf,
                     float light_bound, float distance, Regularization regularization) {
  count_copies(counts, camera.ratio, bsdf.ratio, camera.regularized);
  float weight = mis_weight_nee(counts, camera.regularized, bsdf.eval.pdf_forward * per_light, emission_pdf,
                                bsdf.eval.pdf_reverse, copies(bsdf.ratio));
  float plain_weight = 0.0, share = 1.0;
  if (has_sampler_quality()) {
    plain_weight = mis_weight_nee(counts, plain_camera(counts, camera), bsdf.plain.pdf_forward * per_light, emission_pdf,
                                  bsdf.plain.pdf_reverse, 1.0);
    float worst = min(camera_worst(counts, camera, bsdf.bound), edge_worst(bsdf.bound * light_bound, distance));
    share = regularized_share(frame, regularization, worst, camera.history.distance + distance);
  }
  return measure(bsdf.eval.value, bsdf.plain.value, bsdf.ratio, weight, plain_weight, share);
}

// area_pdf: of the light vertex when the lens samples it; lens_bound: rho-bar of the camera.
Weighted measure_splat(Frame frame, TechniqueCounts counts, SubpathEnd light, const ConnectionEval bsdf, float area_pdf, float lens_bound,
                       float distance, Regularization regularization) {
  count_copies(counts, light.ratio, bsdf.ratio, light.regularized);
  float weight =
      mis_weight_splat(counts, light.regularized, bsdf.eval.pdf_reverse, area_pdf, copies(bsdf.ratio));
  float plain_weight = 0.0, share = 1.0;
  if (has_sampler_quality()) {
    plain_weight = mis_weight_splat(counts, plain_light(counts, light), bsdf.plain.pdf_reverse, area_pdf, 1.0);
    float worst = min(light_worst(counts, light, bsdf.bound), edge_worst(bsdf.bound * lens_bound, distance));
    share = regularized_share(frame, regularization, worst, light.history.distance + distance);
  }
  return measure(bsdf.eval.value, bsdf.plain.value, bsdf.ratio, weight, plain_weight, share);
}

// to_camera, to_light: solid-angle pdf towards the vertex to area pdf there.
Weighted measure_connect(Frame frame, TechniqueCounts counts, SubpathEnd camera, const ConnectionEval at_camera, float to_camera,
                         SubpathEnd light, const ConnectionEval at_light, float to_light, float distance,
                         Regularization regularization) {
  float ratios = at_camera.ratio * at_light.ratio;
  count_copies(counts, camera.ratio, at_camera.ratio, camera.regularized);
  count_copies(counts, light.ratio, at_light.ratio, light.regularized);
  float weight = mis_weight_connect(counts, light.regularized, at_light.eval.pdf_reverse,
                                    at_camera.eval.pdf_forward * to_light, camera.regularized,
                                    at_camera.eval.pdf_reverse, at_light.eval.pdf_forward * to_camera, copies(ratios));
  float plain_weight = 0.0, share = 1.0;
  if (has_sampler_quality()) {
    plain_weight = mis_weight_connect(counts, plain_light(counts, light), at_light.plain.pdf_reverse,
                                      at_camera.plain.pdf_forward * to_light, plain_camera(counts, camera),
                                      at_camera.plain.pdf_reverse, at_light.plain.pdf_forward * to_camera, 1.0);
    float worst = min(camera_worst(counts, camera, at_camera.bound), light_worst(counts, light, at_light.bound));
    worst = min(worst, edge_worst(at_camera.bound * at_light.bound, distance));
    share = regularized_share(frame, regularization, worst, camera.history.distance + light.history.distance + distance);
  }
  return measure(at_camera.eval.value * at_light.eval.value, at_camera.plain.value * at_light.plain.value, ratios, weight,
                 plain_weight, share);
}

// bsdf: at the merged vertex, of the camera's surface.
Weighted measure_merge(Frame frame, TechniqueCounts counts, SubpathEnd camera, SubpathEnd light, const ConnectionEval bsdf,
                       Regularization regularization) {
  count_copies(counts, camera.ratio, bsdf.ratio, camera.regularized);
  count_copies(counts, light.ratio, bsdf.ratio, light.regularized);
  float weight = mis_weight_merge(counts, light.regularized, bsdf.eval.pdf_forward, camera.regularized,
                                  bsdf.eval.pdf_reverse, copies(bsdf.ratio));
  float plain_weight = 0.0, share = 1.0;
  if (has_sampler_quality()) {
    plain_weight = mis_weight_merge(counts, plain_light(counts, light), bsdf.plain.pdf_forward,
                                    plain_camera(counts, camera), bsdf.plain.pdf_reverse, 1.0);
    float worst = min(camera_worst(counts, camera, bsdf.bound), light_worst(counts, light, bsdf.bound));
    share = regularized_share(frame, regularization, worst, camera.history.distance + light.history.distance);
  }
  return measure(bsdf.eval.value, bsdf.plain.value, bsdf.ratio, weight, plain_weight, share);
}

#endif
