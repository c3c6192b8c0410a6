// What sampler quality and the mixture of regularized and unregularized techniques (`both`) need to know of a path.
//
// Sampler quality (Jendersie and Grosch 2019; docs/mathematics.md 6): a path that some technique samples well needs no
// regularization. The estimator of the technique whose edge joins vertices k and k + 1 is bounded by
// rho-bar_k rho-bar_{k+1} / d_k^2; q is the least of them over the path, made free of scale by the path's squared length.
// Where q < tau^2 the path counts with its unregularized value and weight, otherwise with the regularized ones. q is a
// function of the path alone: every technique computes the same.
//
// both (Bouchard et al. 2013; docs/mathematics.md 7): every connection and merge counts twice, with and without regularization. The
// unregularized copy of a technique enters the balance heuristic with the ratio r = rho^W / rho of its vertices.
#ifndef REGULUS_LIB_HISTORY_GLSL
#define REGULUS_LIB_HISTORY_GLSL

#include "lib/mis.glsl"
#include "lib/regularization.glsl"

const float NO_BOUND = 1e30;  // finite also after products with squared lengths

PathHistory start_history(float mis_a, float mis_b, float bound) {
  return PathHistory(vec2(mis_a, mis_b), NO_BOUND, bound, 0.0, 1.0, 1.0);
}

// rho-bar of the camera: one over the solid angle of the film. An orthographic camera's edge counts as long as the scene,
// and its bound there is one over the area of the film.
float camera_bound(Frame frame) {
  float film = 4.0 * max(length(frame.camera.right) * length(frame.camera.up), 1e-12);
  return frame.camera.kind == CAMERA_ORTHOGRAPHIC ? square(2.0 * frame.scene_radius) / film : 1.0 / film;
}

// The length that an edge counts with. Edges to distant lights, and longer ones, count as long as the scene.
float edge_length(Frame frame, float distance, bool is_parallel) {
  return is_parallel ? 2.0 * frame.scene_radius : min(distance, 2.0 * frame.scene_radius);
}

// To be called on arrival, like mis_arrive.
void history_arrive(Frame frame, inout PathHistory history, float distance, float cos_here, bool is_parallel) {
  Path plain;
  plain.mis_a = history.plain.x;
  plain.mis_b = history.plain.y;
  mis_arrive(plain, distance, cos_here, is_parallel);
  history.plain = vec2(plain.mis_a, plain.mis_b);
  float capped = edge_length(frame, distance, is_parallel);
  history.pending /= max(square(capped), 1e-12);
  history.distance += capped;
}

// The bound once rho-bar of the last vertex is known. technique: whose edge led to it.
float history_worst(PathHistory history, TechniqueCounts counts, float bound, uint technique) {
  float worst = history.worst;
  if ((spec_techniques & technique) != 0u) worst = min(worst, history.pending * bound);
  if ((spec_techniques & TECHNIQUE_MERGE) != 0u) worst = min(worst, bound / counts.merge);
  return worst;
}

// The technique whose edge leads to a vertex that is this many edges from its end of the path.
uint camera_edge_technique(uint edges) { return edges == 1u ? TECHNIQUE_SPLAT : TECHNIQUE_CONNECT; }
uint light_edge_technique(uint edges) { return edges == 1u ? TECHNIQUE_NEE : TECHNIQUE_CONNECT; }

// Half the width of the smooth transition, in natural logarithms of q.
const float SMOOTH_WIDTH = 2.0;

// How much of the regularized estimate a path gets: 1 all, 0 none. Lengths in m, worst in 1/m^2.
float regularized_share(Frame frame, Regularization regularization, float worst, float length_of_path) {
  if (spec_sampler_quality == SAMPLER_QUALITY_OFF) return 1.0;
  float quality = min(worst * square(length_of_path), NO_BOUND);
  // The schedule shrinks alpha_tau; the tau that belongs to it grows by the power of alpha in the bound.
  float shrunk = square(regularization.full_scale);
  if (spec_bound == BOUND_SMITH && spec_shadowing != SHADOWING_V_CAVITY) shrunk = square(shrunk);
  // A raised lobe keeps its light (lib/raised_light.glsl), so it exceeds tau by what it would lose.
  vec2 alpha = vec2(min(reflection_alpha(regularization.full_tau, 1.0) * regularization.full_scale, largest_alpha()));
  shrunk *= energy_reflected(with_alpha(EnergyTables(frame.energy_tables, 0u, 0.0, 0.0), alpha), 1.0);
  float threshold = square(regularization.full_tau / shrunk);
  if (spec_sampler_quality == SAMPLER_QUALITY_ON) return quality < threshold ? 0.0 : 1.0;
  float excess = log_accurate(max(quality, 1e-30)) - log_accurate(min(threshold, NO_BOUND));
  return smoothstep(-SMOOTH_WIDTH, SMOOTH_WIDTH, excess);
}

// With `both`: counts the copies at a vertex of the regularized weights, once the ratio of its bsdf is known. Every technique
// on this side of it exists twice.
void count_copies(TechniqueCounts counts, float previous_ratio, float ratio, inout MisVertex vertex) {
  if (!is_both()) return;
  vertex.n *= 1.0 + previous_ratio * ratio;
  vertex.merge = counts.merge * (1.0 + ratio);
}

// Copies of a technique: 1, or with `both` 1 + the product of its vertices' ratios.
float copies(float ratios) { return is_both() ? 1.0 + ratios : 1.0; }

// Weighted value of a technique: `regularized` and `plain` are its values, `weight` its regularized weight.
vec3 weighted(vec3 regularized, vec3 plain, float weight, float ratios) {
  return is_both() ? weight * (regularized + ratios * plain) : weight * regularized;
}

// To be called after scattering, like mis_scatter. `worst` includes the last vertex, `plain` is its unregularized MIS vertex.
void history_scatter(TechniqueCounts counts, MisVertex plain, float worst, WalkPdf walk, float pdf_ratio, float cos_out,
                     inout PathHistory history) {
  Path carried;
  mis_scatter(counts, plain, walk.plain_inverse, pdf_ratio, cos_out, carried);
  history.plain = vec2(carried.mis_a, carried.mis_b);
  history.worst = worst;
  history.pending = walk.bound;
  history.ratio = walk.ratio;
}

// Weight of technique `hit`, whose value is the same with and without regularization. bound: rho-bar of the light.
float hit_weight(Frame frame, Path path, PathHistory history, TechniqueCounts counts, float pdf_connect, float pdf_emit,
                 float bound) {
  vec2 accumulators = vec2(path.mis_a, path.mis_b);
  if (!has_histories()) return mis_weight_hit(counts, accumulators, pdf_connect, pdf_emit, 1.0);
  float weight = mis_weight_hit(counts, accumulators, pdf_connect, pdf_emit, copies(history.ratio));
  if (!has_sampler_quality()) return weight;
  float worst = history.worst;
  if ((spec_techniques & TECHNIQUE_NEE) != 0u) worst = min(worst, history.pending * bound);
  Regularization regularization = regularization_of(frame, path.sample_index, true);
  float share = regularized_share(frame, regularization, worst, history.distance);
  return mix(mis_weight_hit(counts, history.plain, pdf_connect, pdf_emit, 1.0), weight, share);
}

#endif
