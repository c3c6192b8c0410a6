// Multiple importance sampling over any set of techniques (docs/architecture.md): the balance heuristic through
// recurrences along both subpaths (Georgiev et al. 2012; docs/mathematics.md 3.2 with the same names). A path x_0 ... x_K
// runs from the light to the camera. A vertex of either subpath holds on arrival
//   A   one over the area pdf with which the walk reached it (light vertex x_1: times p_connect / p_trace of x_0, the
//       probabilities of choosing x_0 from x_1 by nee and for emission)
//   B   the same over all earlier techniques, without the pdf of walking backwards from here
// and the pdfs that enter are those of the corrected weights: multiplied by rho^/rho where a bsdf is regularized.
// Pdfs use geometric normals; roulette is left out (docs/mathematics.md 9).
#ifndef REGULUS_LIB_MIS_GLSL
#define REGULUS_LIB_MIS_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#include "lib/specialization.glsl"

// True if some enabled technique uses light subpaths: without, B is always 0.
bool has_light_subpaths() {
  return (spec_techniques & (TECHNIQUE_SPLAT | TECHNIQUE_CONNECT | TECHNIQUE_MERGE)) != 0u;
}

// Sample counts of the enabled techniques; 0 for one that is not enabled.
struct TechniqueCounts {
  float hit;      // 1
  float nee;      // 1
  float splat;    // light paths per iteration
  float connect;  // 1; to the cache M N / (expected vertices in it): any constant keeps the weights exact
  float merge;    // eta = N pi r^2
};

TechniqueCounts technique_counts(Frame frame, float merge_radius) {
  TechniqueCounts counts;
  float light_paths = float(frame.light_path_count);
  counts.hit = (spec_techniques & TECHNIQUE_HIT) != 0u ? 1.0 : 0.0;
  counts.nee = (spec_techniques & TECHNIQUE_NEE) != 0u ? 1.0 : 0.0;
  counts.splat = (spec_techniques & TECHNIQUE_SPLAT) != 0u ? light_paths : 0.0;
  counts.merge = (spec_techniques & TECHNIQUE_MERGE) != 0u ? light_paths * PI * square(merge_radius) : 0.0;
  counts.connect = 0.0;
  if ((spec_techniques & TECHNIQUE_CONNECT) != 0u)
    counts.connect = frame.cache_connections != 0u ? frame.cache_connect_count : 1.0;
  return counts;
}

// The accumulators of a vertex, and the count n of the technique whose edge leads to it: for a light vertex
// x_i technique s = i, for a camera vertex x_i technique s = i + 1.
struct MisVertex {
  float a, b;
  float n;
  float merge;  // the count of merges here
};

// Cosines below this would overflow what is divided by them.
const float MIN_MIS_COS = 1e-7;

// True if the weight of `hit` needs to know the vertex before: nee's choice of a light depends on it.
bool keeps_receivers() {
  const uint both = TECHNIQUE_HIT | TECHNIQUE_NEE;
  return spec_light_sampling == LIGHT_SAMPLING_BVH && (spec_techniques & both) == both;
}

// A and B on arrival: the ray had the length `distance` and meets the geometric normal at cos_here.
// is_parallel: all rays of this edge run in the same direction (distant light, orthographic camera).
void mis_arrive(inout Path path, float distance, float cos_here, bool is_parallel) {
  float inverse_cos = 1.0 / max(abs(cos_here), MIN_MIS_COS);
  path.mis_a *= is_parallel ? inverse_cos : square(distance) * inverse_cos;
  path.mis_b *= inverse_cos;
}

MisVertex mis_light_vertex(TechniqueCounts counts, float a, float b, uint edges) {
  return MisVertex(a, b, edges == 1u ? counts.nee : counts.connect, counts.merge);
}

MisVertex mis_camera_vertex(TechniqueCounts counts, float a, float b, uint edges) {
  return MisVertex(a, b, edges == 1u ? counts.splat : counts.connect, counts.merge);
}

// Of a stored light vertex. is_diffused: this vertex or one between it and the camera diffuses, so that the one before it
// is regularized.
MisVertex light_vertex_mis(Frame frame, TechniqueCounts counts, PathVertex light, uint index, bool is_diffused) {
  vec2 accumulators = vec2(light.mis_a, light.mis_b);
  if ((spec_regularization & REGULARIZATION_DIFFUSION) != 0u && !is_diffused)
    accumulators = LOAD(Vec2Buffer, frame.light_vertex_sharp, index);
  return mis_light_vertex(counts, accumulators.x, accumulators.y, light.edges & PATH_VERTEX_EDGES);
}

// The techniques on one side of a vertex, over the pdf of arriving at it from the other side: `pdf_back` is the
// solid-angle pdf of walking back along the subpath. Without the merge at the vertex itself.
float mis_subpath(MisVertex vertex, float pdf_back) { return vertex.n * vertex.a + pdf_back * vertex.b; }

// After sampling the next direction: what the path carries until it arrives. inverse_pdf: one over the pdf of the
// direction (0 for a delta event, which no connection can replace); pdf_ratio: pdf of walking back over
// pdf forward; cos_out: of the direction with the geometric normal.
void mis_scatter(TechniqueCounts counts, MisVertex vertex, float inverse_pdf, float pdf_ratio, float cos_out,
                 inout Path path) {
  path.mis_a = inverse_pdf;
  path.mis_b = 0.0;
  if (has_light_subpaths())
    path.mis_b = abs(cos_out) * ((vertex.merge + vertex.n * vertex.a) * inverse_pdf + pdf_ratio * vertex.b);
}

// In the weights `copies` is how often the technique exists: once, or with `both` (lib/history.glsl) 1 + r.

// s = 0. ab: the accumulators on arrival. pdf_connect: area pdf of the light point by nee; pdf_emit: by emission, times
// the solid-angle pdf of emitting towards the camera. nee_copies: of technique nee.
float mis_weight_hit(TechniqueCounts counts, vec2 ab, float pdf_connect, float pdf_emit, float nee_copies) {
  return 1.0 / (1.0 + counts.nee * nee_copies * pdf_connect * ab.x + pdf_emit * ab.y);
}

// s = 1. hit_ratio: pdf of the bsdf hitting the light over that of nee (0 for a delta light); emission_pdf: area pdf
// of the camera vertex when the light emits towards it, times p_trace / p_connect of the light point.
float mis_weight_nee(TechniqueCounts counts, MisVertex camera, float hit_ratio, float emission_pdf,
                     float pdf_towards_camera, float copies) {
  float others = counts.hit * hit_ratio;
  if (has_light_subpaths()) others += emission_pdf * (camera.merge + mis_subpath(camera, pdf_towards_camera));
  return 1.0 / (copies + others);
}

// s, t >= 2. area_pdf_light: of the light vertex, reached from the camera vertex; area_pdf_camera: the reverse.
float mis_weight_connect(TechniqueCounts counts, MisVertex light, float light_pdf_back, float area_pdf_light,
                         MisVertex camera, float camera_pdf_back, float area_pdf_camera, float copies) {
  float others = area_pdf_light * (light.merge + mis_subpath(light, light_pdf_back)) +
                 area_pdf_camera * (camera.merge + mis_subpath(camera, camera_pdf_back));
  return counts.connect / (counts.connect * copies + others);
}

// t = 1. camera_area_pdf: area pdf of the light vertex when the lens samples it (film density 1 per pixel area).
float mis_weight_splat(TechniqueCounts counts, MisVertex light, float light_pdf_back, float camera_area_pdf,
                       float copies) {
  return counts.splat / (counts.splat * copies + camera_area_pdf * (light.merge + mis_subpath(light, light_pdf_back)));
}

float mis_weight_merge(TechniqueCounts counts, MisVertex light, float light_pdf_back, MisVertex camera,
                       float camera_pdf_back, float copies) {
  return counts.merge / (counts.merge * copies + mis_subpath(light, light_pdf_back) + mis_subpath(camera, camera_pdf_back));
}

#endif
