// Multiple importance sampling over any set of techniques (docs/architecture.md): the balance heuristic through
// recurrences along both subpaths (Georgiev et al. 2012; docs/mathematics.md 3.2 with the same names). A path x_0 ... x_K
// runs from the light to the camera. A vertex of either subpath holds on arrival
//   A   one over the area pdf with which the walk reached it (light vertex x_1: times p_connect / p_trace of x_0, the
//       probabilities of choosing x_0 from x_1 by nee and for emission)
//   B   the sum of the densities of all earlier techniques over that of the walk, without the pdf of walking backwards from
//       here
// B leaves float's range where densities of techniques on the way lie 38 decades below those before: it then counts in
// powers of 2^64 (RAISED below), so that weights add up to one however far pdfs spread.
// The pdfs that enter are those of the corrected weights: multiplied by rho^/rho where a bsdf is regularized.
// Pdfs use geometric normals; roulette is left out (docs/mathematics.md 9).
#ifndef REGULUS_LIB_MIS_GLSL
#define REGULUS_LIB_MIS_GLSL

#include "lib/buffers.glsl"
#include "lib/numerics.glsl"
#include "lib/specialization.glsl"

// True if some enabled technique uses light subpaths. Otherwise B is always 0.
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

// A pair (A, B) is raised where the sign bit of A is set: the last 7 bits of that word then hold k, the others are A (which
// errs by 2^-17), and B stands for 2^(64 k) times itself. B is stored below 2^64 where it is not raised, as 1 or more where
// it is.
const uint RAISED = 0x80000000u;
const uint RAISED_POWER = 0x7Fu;
const float RAISED_UNIT = 1.8446744073709552e19;         // 2^64
const float RAISED_INVERSE = 5.421010862427522e-20;      // 2^-64
const float RAISED_MIDDLE = 4294967296.0;                // 2^32
const float MIS_SATURATED = 1e38;                        // largest ratio of densities: its weight is 0

// Whether B can be raised at all: without light subpaths it is 0.
bool is_raised(float a) { return has_light_subpaths() && (floatBitsToUint(a) & RAISED) != 0u; }

uint raised_power(float a) { return is_raised(a) ? floatBitsToUint(a) & RAISED_POWER : 0u; }

float unraised_a(float a) { return is_raised(a) ? uintBitsToFloat(floatBitsToUint(a) & ~(RAISED | RAISED_POWER)) : a; }

float raised_a(float a, uint power) {
  uint rounded = (floatBitsToUint(a) + (RAISED_POWER + 1u) / 2u) & ~RAISED_POWER;
  return power == 0u ? a : uintBitsToFloat(RAISED | rounded | min(power, RAISED_POWER));
}

// The accumulators of a vertex, and the count n of the technique whose edge leads to it: s = i for a light vertex x_i,
// s = i + 1 for a camera vertex x_i.
struct MisVertex {
  float a, b;
  float n;
  float merge;  // the count of merges here
  uint power;   // B stands for 2^(64 power) times b
};

// Smaller cosines count as this one: quotients with them would overflow.
const float MIN_MIS_COS = 1e-7;

// True if the weight of `hit` needs to know the previous vertex, because nee's choice of a light depends on it.
#define keeps_receivers() has_state(STATE_RECEIVERS)

// Updates A and B on arrival: the ray had the length `distance` and meets the geometric normal at cos_here.
// is_parallel: all rays of this edge run in the same direction (distant light, orthographic camera).
void mis_arrive(inout Path path, float distance, float cos_here, bool is_parallel) {
  float inverse_cos = 1.0 / max(abs(cos_here), MIN_MIS_COS);
  // 3.2: 1 / P is per area from here on. In B the squared distance cancels that of gR.
  float scale = is_parallel ? inverse_cos : square(distance) * inverse_cos;
  path.mis_a = raised_a(unraised_a(path.mis_a) * scale, raised_power(path.mis_a));
  path.mis_b *= inverse_cos;
}

MisVertex mis_light_vertex(TechniqueCounts counts, float a, float b, uint edges) {
  return MisVertex(unraised_a(a), b, edges == 1u ? counts.nee : counts.connect, counts.merge, raised_power(a));
}

MisVertex mis_camera_vertex(TechniqueCounts counts, float a, float b, uint edges) {
  return MisVertex(unraised_a(a), b, edges == 1u ? counts.splat : counts.connect, counts.merge, raised_power(a));
}

// True if light paths and vertices also have accumulators for a camera that sees them sharply.
#define has_sharp_levels() has_state(STATE_SHARP)

// The accumulators of a stored light vertex. is_diffused: this vertex or one between it and the camera diffuses, so that
// the one before it is regularized.
MisVertex light_vertex_mis(Frame frame, TechniqueCounts counts, LightVertex light, uint index, bool is_diffused) {
  vec2 accumulators = vec2(light.mis_a, light.mis_b);
  if (has_sharp_levels() && !is_diffused)
    accumulators = LOAD(Vec2Buffer, frame.light_vertex_sharp, index);
  return mis_light_vertex(counts, accumulators.x, accumulators.y, light.edges & PATH_VERTEX_EDGES);
}

// x 2^(64 power - 32), at most MIS_SATURATED. Precondition: power > 0.
float lowered(float x, uint power) {
  uint exponent = min(64u * power - 32u, 252u);
  uint half_exponent = exponent / 2u;
  x *= uintBitsToFloat((127u + half_exponent) << 23);
  return min(x * uintBitsToFloat((127u + exponent - half_exponent) << 23), MIS_SATURATED);
}

// `scale` times the techniques on one side of a vertex, over the pdf of arriving at it from the other side: `pdf_back` is
// the solid-angle pdf of walking back along the subpath. `merge`: the count of merges at the vertex itself, or 0.
float mis_side(float scale, float merge, MisVertex vertex, float pdf_back) {
  if (!has_light_subpaths() || vertex.power == 0u) return scale * (merge + (vertex.n * vertex.a + pdf_back * vertex.b));
  return scale * (merge + vertex.n * vertex.a) +
         lowered(pdf_back * (vertex.b * RAISED_MIDDLE) * scale, vertex.power);
}

// What mis_scatter does where B is raised, or leaves its range: the same sum, in units of 2^(64 power).
void mis_scatter_raised(MisVertex vertex, float inverse_pdf, float pdf_ratio, float cos_out, inout Path path) {
  uint power = vertex.power;
  float here = (abs(cos_out) * (inverse_pdf * RAISED_INVERSE)) * (vertex.merge + vertex.n * vertex.a);  // power 1
  float b = vertex.b;
  // For ratios up to 2^80 the product stays within float's range.
  if (b >= RAISED_MIDDLE) {
    b *= RAISED_INVERSE;
    power += 1u;
  }
  b *= abs(cos_out) * pdf_ratio;
  for (uint i = 0u; i < 2u && b < 1.0 && power > 1u; ++i) {
    b *= RAISED_UNIT;
    power -= 1u;
  }
  if (power == 0u) {
    b *= RAISED_INVERSE;
    power = 1u;
  }
  b += power == 1u ? here : power == 2u ? here * RAISED_INVERSE : 0.0;
  bool is_low = b < 1.0, is_high = b >= RAISED_UNIT;
  b *= is_low ? RAISED_UNIT : is_high ? RAISED_INVERSE : 1.0;
  power = is_low ? power - 1u : is_high ? power + 1u : power;
  path.mis_a = raised_a(inverse_pdf, power);
  path.mis_b = min(b, MIS_SATURATED);
}

// After sampling the next direction: what the path carries until it arrives. inverse_pdf: one over the pdf of the
// direction (0 for a delta event, which no connection can replace); pdf_ratio: pdf of walking back over
// pdf forward; cos_out: of the direction with the geometric normal.
void mis_scatter(TechniqueCounts counts, MisVertex vertex, float inverse_pdf, float pdf_ratio, float cos_out,
                 inout Path path) {
  path.mis_a = inverse_pdf;  // 3.2: A_{i+1} = 1 / P_{i+1}, per solid angle until the path arrives
  path.mis_b = 0.0;
  if (!has_light_subpaths()) return;
  // 3.2: B_{i+1} = gR_{i+1} / P_{i+1} (eta + n_i A_i + rev_i B_i)
  path.mis_b = abs(cos_out) * ((vertex.merge + vertex.n * vertex.a) * inverse_pdf + pdf_ratio * vertex.b);
  if (vertex.power != 0u || !(path.mis_b < RAISED_UNIT)) mis_scatter_raised(vertex, inverse_pdf, pdf_ratio, cos_out, path);
}

// The weights. `copies`: how often the technique exists: once, or with `both` (lib/history.glsl) 1 + r times.

// Technique s = 0. ab: the accumulators on arrival. pdf_connect: area pdf of the light point by nee; pdf_emit: by emission,
// times the solid-angle pdf of emitting towards the camera. nee_copies: of technique nee.
float mis_weight_hit(TechniqueCounts counts, vec2 ab, float pdf_connect, float pdf_emit, float nee_copies) {
  float connected = counts.nee * nee_copies * pdf_connect * unraised_a(ab.x);  // 3.2, hit: pc A^C_0
  uint power = raised_power(ab.x);
  // 3.2, hit: pt fwd_0 B^C_0
  float emitted = power == 0u ? pdf_emit * ab.y : lowered(pdf_emit * (ab.y * RAISED_MIDDLE), power);
  return 1.0 / (1.0 + connected + emitted);
}

// Technique s = 1. hit_ratio: pdf of the bsdf hitting the light over that of nee (0 for a delta light); emission_pdf: area pdf
// of the camera vertex when the light emits towards it, times p_trace / p_connect of the light point.
float mis_weight_nee(TechniqueCounts counts, MisVertex camera, float hit_ratio, float emission_pdf,
                     float pdf_towards_camera, float copies) {
  // 3.2, nee: P<_0 / pc + (pt / pc) P>_1 (eta + n_2 A^C_1 + fwd_1 B^C_1)
  float others = counts.hit * hit_ratio;
  if (has_light_subpaths()) others += mis_side(emission_pdf, camera.merge, camera, pdf_towards_camera);
  return 1.0 / (copies + others);
}

// Techniques s, t >= 2. area_pdf_light: of the light vertex, reached from the camera vertex; area_pdf_camera: the reverse.
float mis_weight_connect(TechniqueCounts counts, MisVertex light, float light_pdf_back, float area_pdf_light,
                         MisVertex camera, float camera_pdf_back, float area_pdf_camera, float copies) {
  // 3.2, connect: P<_{s-1} (eta + A^L + rev B^L)_{s-1} + P>_s (eta + n A^C + fwd B^C)_s
  float others = mis_side(area_pdf_light, light.merge, light, light_pdf_back) +
                 mis_side(area_pdf_camera, camera.merge, camera, camera_pdf_back);
  return counts.connect / (counts.connect * copies + others);
}

// Technique t = 1. camera_area_pdf: area pdf of the light vertex when the lens samples it (film density 1 per pixel area).
float mis_weight_splat(TechniqueCounts counts, MisVertex light, float light_pdf_back, float camera_area_pdf,
                       float copies) {
  // 3.2, splat: (P<_{K-1} / N) (eta + A^L + rev B^L)_{K-1}
  return counts.splat / (counts.splat * copies + mis_side(camera_area_pdf, light.merge, light, light_pdf_back));
}

float mis_weight_merge(TechniqueCounts counts, MisVertex light, float light_pdf_back, MisVertex camera,
                       float camera_pdf_back, float copies) {
  // 3.2, merge: (A^L + rev B^L)_j / eta + (n A^C + fwd B^C)_j / eta
  return counts.merge / (counts.merge * copies + mis_side(1.0, 0.0, light, light_pdf_back) +
                         mis_side(1.0, 0.0, camera, camera_pdf_back));
}

#endif
