// Microfacet regularization (Jendersie and Grosch 2019): where a path is connected or merged, a microfacet lobe is
// evaluated with alpha^ = max(alpha, alpha_tau) (lib/raised_alpha.glsl). Random walks keep alpha. The weights then use pdfs times
// rho^W / rho, with rho^W the regularized value (corrected) or the same with its peak blended in (blended, docs/mathematics.md
// 3.9), in closed forms that exist for delta lobes too (3.4). Which vertices are regularized, and by how much, is decided here;
// what that makes of a bsdf stands in lib/raised_bsdf.glsl and in the lobes.
#ifndef REGULUS_LIB_REGULARIZATION_GLSL
#define REGULUS_LIB_REGULARIZATION_GLSL

#include "lib/raised_bsdf.glsl"

// Macros, for the reasons in lib/bsdf_parameters.glsl.
#define is_regularized() ((spec_regularization & REGULARIZATION_ROUGHNESS) != 0u)
#define has_diffusion() ((spec_regularization & REGULARIZATION_DIFFUSION) != 0u)
#define is_virtual_merge() ((spec_regularization & REGULARIZATION_VIRTUAL_MERGE) != 0u)
#define is_both() ((spec_regularization & REGULARIZATION_BOTH) != 0u)
#define has_sampler_quality() ((spec_regularization & REGULARIZATION_ROUGHNESS) * spec_sampler_quality != 0u)
// True if paths carry a PathHistory (lib/history.glsl).
#define has_histories() has_state(STATE_HISTORIES)

// A vertex with less diffusion than this is not regularized.
const float MIN_DIFFUSION = 1e-6;

// Path diffusion (--diffusion off: every vertex is regularized fully). What the camera sees directly, or through
// surfaces that are all sharp, stays sharp: mirrors, highlights and what is seen through glass. Path tracing follows the
// width of the bundle of paths (lib/footprint.glsl). With light subpaths there are two levels (docs/mathematics.md 3.8 A): a vertex
// is regularized if some vertex between it and the camera diffuses. That is a function of the path; light subpaths, which
// cannot know it, keep their accumulators for both cases.

// How a vertex is regularized at which paths from the camera have this diffusion, in [0, 1].
Regularization diffused_regularization(Frame frame, uint iteration, float diffusion) {
  float scale = 1.0;
  if ((spec_regularization & REGULARIZATION_CONSISTENT) != 0u)
    scale = exp_accurate(log_accurate(float(iteration) + 1.0) * (-1.0 / 6.0));
  return Regularization(frame.tau / max(diffusion, MIN_DIFFUSION), diffusion > MIN_DIFFUSION ? scale : 0.0, frame.tau,
                        scale);
}

// The same with two levels. is_diffused: some vertex between this one and the camera diffuses.
Regularization regularization_of(Frame frame, uint iteration, bool is_diffused) {
  return diffused_regularization(frame, iteration, is_diffused || !has_diffusion() ? 1.0 : 0.0);
}

// Where the numbers of a virtual merge come from. stream: the camera path's pixel, of a splat its light path; end:
// VIRTUAL_MERGE_AT_*; place: edges from the camera and from the light, and bits of the light path.
uvec4 virtual_merge_seed(uint seed, uint stream, uint iteration, uint end, uvec3 place) {
  if (!is_virtual_merge()) return uvec4(0u);
  return pcg4d(hash_bits(seed, stream, iteration, DIMENSION_BLOCK_VIRTUAL_MERGE + end) + uvec4(place, 0u));
}

// A bsdf at the directions of a connection or merge.
struct ConnectionEval {
  BsdfEval eval;   // what is measured, with the pdfs that its weight uses
  BsdfEval plain;  // without regularization
  float ratio;     // see RegularizedLobes
  float bound;     // rho-bar, 1/sr
};

// What a connection or merge measures at (wo, wi). Zero where wo or wi lies in the surface.
// seed: see virtual_merge_seed.
ConnectionEval bsdf_connect(const Bsdf bsdf, vec3 wo, vec3 wi, uint transport, const Regularization regularization, uvec4 seed) {
  ConnectionEval result = ConnectionEval(NO_SCATTERING, NO_SCATTERING, 1.0, 0.0);
  if (!is_regularized() || (!bsdf_has_specular() && !has_histories())) {
    result.eval = bsdf_evaluate(bsdf, wo, wi, transport);
    return result;
  }
  if (!(wo.z > 0.0) || wi.z == 0.0) return result;
  Encounter facet = encounter(bsdf, wo, wi);
  Lobes lobes = bsdf_lobes(bsdf, wo, wi, facet, transport);
  result.plain = evaluate_lobes(lobes);
  result.eval = result.plain;
  if (has_sampler_quality()) result.bound = estimator_bound(bsdf, lobes, wo, wi, facet, regularization);
  if (!bsdf_has_specular()) return result;
  RegularizedLobes raised = regularize(bsdf, lobes, wo, wi, facet, false, false, regularization);
  result.ratio = raised.ratio;
  result.eval.value = raised.value;
  if (is_virtual_merge() && regularization.alpha_scale > 0.0)
    result.eval.value = virtual_value(bsdf, lobes, wo, wi, facet, transport, regularization, seed);
  if (spec_mis != MIS_UNMODIFIED) {
    result.eval.pdf_forward = raised.pdf_forward;
    result.eval.pdf_reverse = raised.pdf_reverse;
  }
  return result;
}

// One over the pdfs of a sampled direction that weights use.
struct WalkPdf {
  float inverse;        // 0 for a delta event that no connection can replace
  float plain_inverse;  // without regularization
  float ratio;          // see RegularizedLobes
  float bound;          // rho-bar, 1/sr
};

// transport: of the walk.
WalkPdf walk_pdf(const Bsdf bsdf, vec3 wo, const BsdfSample event, uint transport, const Regularization regularization) {
  bool is_delta = (event.flags & BSDF_SAMPLE_DELTA) != 0u;
  WalkPdf result;
  result.plain_inverse = is_delta ? 0.0 : 1.0 / event.pdf_forward;
  result.inverse = result.plain_inverse;
  result.ratio = is_delta ? 0.0 : 1.0;
  result.bound = 0.0;
  if (!is_regularized()) return result;
  if (has_sampler_quality()) {
    Lobes lobes = bsdf_lobes(bsdf, wo, event.wi, event.facet, transport);
    result.bound = estimator_bound(bsdf, lobes, wo, event.wi, event.facet, regularization);
  }
  if (spec_mis == MIS_UNMODIFIED || !bsdf_has_specular() || regularization.alpha_scale == 0.0) return result;
  if (is_delta && raised_interface_alpha(bsdf, event.facet, regularization).x == 0.0) return result;
  Lobes lobes = bsdf_lobes(bsdf, wo, event.wi, event.facet, transport);
  bool is_coat = (event.flags & BSDF_SAMPLE_COAT) != 0u;
  RegularizedLobes raised = regularize(bsdf, lobes, wo, event.wi, event.facet, is_delta, is_coat, regularization);
  result.inverse = raised.pdf_forward > 0.0 ? 1.0 / raised.pdf_forward : 0.0;
  result.ratio = raised.ratio;
  return result;
}

#endif
