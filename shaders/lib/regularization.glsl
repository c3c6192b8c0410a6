// Microfacet regularization (Jendersie and Grosch 2019): where a path is connected or merged, a microfacet lobe is
// evaluated with alpha^ = max(alpha, alpha_tau), alpha_tau so wide that the lobe's density stays below tau. Random
// walks keep alpha. The weights then use pdfs times rho^W / rho, with rho^W the regularized value (corrected) or the
// same with its peak blended in (blended, math.md 3.9), in closed forms that exist for delta lobes too (3.4).
#ifndef REGULUS_LIB_REGULARIZATION_GLSL
#define REGULUS_LIB_REGULARIZATION_GLSL

#include "lib/bsdf.glsl"

// What one path is regularized with: the bound on a lobe's density and the factor on alpha_tau of its iteration.
struct Regularization {
  float tau;          // 1/sr
  float alpha_scale;  // i^(-1/6) in iteration i = 1, 2, ... of the consistent schedule, otherwise 1; 0: not at all
};

const Regularization UNREGULARIZED = Regularization(1e30, 0.0);

// What the camera sees directly, or through surfaces that are all sharp, is not regularized: mirrors, highlights and
// what is seen through glass stay as they are. Path diffusion with two levels (math.md 3.8 A): a vertex is regularized
// if some vertex between it and the camera diffuses. That is a function of the path; light subpaths, which cannot know
// it, keep their accumulators for both cases.
const float SHARP_ALPHA = 0.05;

bool diffuses(Bsdf bsdf) {
  if (!bsdf_has_specular()) return true;
  return bsdf.alpha.x >= SHARP_ALPHA || max(bsdf.diffuse.r, max(bsdf.diffuse.g, bsdf.diffuse.b)) > 0.0;
}

bool is_regularized() { return (spec_regularization & REGULARIZATION_ROUGHNESS) != 0u; }

// is_diffused: some vertex between this one and the camera diffuses.
Regularization regularization_of(Frame frame, uint iteration, bool is_diffused) {
  if (!is_diffused) return UNREGULARIZED;
  Regularization regularization = Regularization(frame.tau, 1.0);
  if ((spec_regularization & REGULARIZATION_CONSISTENT) != 0u)
    regularization.alpha_scale = exp_accurate(log_accurate(float(iteration) + 1.0) * (-1.0 / 6.0));
  return regularization;
}

// Interfaces whose indices differ by less than this share hardly bend light: no roughness blurs them (math.md 2.5),
// so their transmission is not regularized.
const float MIN_REGULARIZED_BEND = 0.02;

// alpha_tau of a reflection lobe whose facet the directions meet at cosine c (math.md 2.2; directional: 2.4).
float reflection_alpha(float tau, float c) {
  if (spec_bound == BOUND_PEAK || (spec_bound == BOUND_SMITH && spec_shadowing == SHADOWING_V_CAVITY))
    return 0.5 * inversesqrt(PI * tau);
  if (spec_bound == BOUND_SMITH) return sqrt(sqrt((spec_ndf == NDF_GGX ? INV_PI : 1.0) / tau));
  c = max(c, 1e-4);
  if (spec_shadowing == SHADOWING_V_CAVITY) return 0.5 * inversesqrt(PI * tau) / c;
  float sine_squared = 1.0 - c * c;
  if (spec_shadowing == SHADOWING_SMITH) {
    // x sqrt(c^2 + x s^2) = k with x = alpha^2
    float k = 0.25 * INV_PI / (tau * c);
    float x = min(k / c, exp_accurate(log_accurate(k) * (2.0 / 3.0)));
    for (int i = 0; i < 4; ++i) {
      float root = sqrt(c * c + x * sine_squared);
      x -= (x * root - k) / (root + 0.5 * x * sine_squared / root);
    }
    return sqrt(max(x, 0.0));
  }
  // alpha (c + sqrt(c^2 + alpha^2 s^2)) = k
  float k = inversesqrt(PI * tau);
  float alpha = min(k / (2.0 * c), sqrt(k));
  for (int i = 0; i < 4; ++i) {
    float root = sqrt(c * c + alpha * alpha * sine_squared);
    alpha -= (alpha * (c + root) - k) / (c + root + alpha * alpha * sine_squared / root);
  }
  return alpha;
}

// alpha_tau of a refraction lobe; its bound does not depend on the angle.
float refraction_alpha(Bsdf bsdf, float tau) {
  float eta = 1.0 / bsdf.inverse_eta;
  float bend = abs(bsdf.excess) / (eta + 1.0);  // |eta - 1|
  float larger = max(eta, 1.0);
  if (bend < MIN_REGULARIZED_BEND * larger) return 0.0;
  float e = square(larger / bend);
  if (spec_bound == BOUND_SMITH && spec_shadowing != SHADOWING_V_CAVITY)
    return sqrt(sqrt(4.0 * e * (spec_ndf == NDF_GGX ? INV_PI : 1.0) / tau));
  return sqrt(e * INV_PI / tau);
}

// Largest alpha a lobe is raised to: beyond 1 / sqrt(2) Beckmann's maximum leaves the normal (math.md 2.3).
float largest_alpha() { return spec_ndf == NDF_BECKMANN ? 0.70710678 : 1.0; }

vec2 regularized_alpha(Bsdf bsdf, Encounter facet, Regularization regularization) {
  float alpha_tau = bsdf_has_transmission() && facet.is_refracted
      ? refraction_alpha(bsdf, regularization.tau)
      : reflection_alpha(regularization.tau, facet.o_dot_h);
  return max(bsdf.alpha, vec2(min(alpha_tau * regularization.alpha_scale, largest_alpha())));
}

// A regularized lobe at one pair of directions.
struct RegularizedLobes {
  vec3 value;
  float pdf_forward;         // p rho^W / rho, of wi given wo
  float pdf_reverse;
};

// is_delta_event: the pair came from sampling a delta lobe, which outweighs all others there.
RegularizedLobes regularize(Bsdf bsdf, Lobes lobes, vec3 wo, vec3 wi, Encounter facet, bool is_delta_event,
                            Regularization regularization) {
  vec2 alpha = regularized_alpha(bsdf, facet, regularization);
  vec3 wi_facet = facet.is_refracted ? wi : vec3(wi.xy, abs(wi.z));
  MicrofacetTerms raised = microfacet_terms(wo, wi_facet, facet.h, facet.o_dot_h, facet.i_dot_h,
                                            max(alpha, vec2(MIN_ALPHA)), facet.is_refracted);
  bool has_facet = facet.is_valid && alpha.x > 0.0;
  float density = has_facet ? min(raised.density * lobes.density_scale, MAX_DENSITY) : 0.0;

  float blended = density;
  if (spec_mis == MIS_BLENDED && has_facet) {
    float peak = min(INV_PI / (alpha.x * alpha.y) * lobes.density_scale, MAX_DENSITY);
    float beta = 1.0 - (bsdf.alpha.x * bsdf.alpha.y) / (alpha.x * alpha.y);
    blended = beta >= 1.0 ? peak
                          : exp_accurate((1.0 - beta) * log_accurate(max(density, 1e-36)) + beta * log_accurate(peak));
  }
  RegularizedLobes result;
  result.value = lobes.diffuse + lobes.weight * (density * raised.shadowing * lobes.value_scale);

  // Values in luminance and without the eta^2 of radiance: r must not depend on the technique (math.md 3.6).
  float diffuse = dot(lobes.diffuse, LUMINANCE);
  float weight = dot(lobes.weight, LUMINANCE);
  float value = diffuse + weight * lobes.density * lobes.terms.shadowing;
  float value_in_weights = diffuse + weight * blended * raised.shadowing;
  if (is_delta_event || !(diffuse > 0.0)) {
    // The density cancels from p / rho, and with it what is 0 / 0 for a delta lobe.
    float per_choice = value_in_weights / max(weight * lobes.terms.shadowing, 1e-30);
    result.pdf_forward = lobes.choice_forward * lobes.terms.visibility_o * per_choice;
    result.pdf_reverse = lobes.choice_reverse * lobes.terms.visibility_i * per_choice;
  } else {
    BsdfEval plain = evaluate_lobes(lobes);
    float ratio = value_in_weights / value;
    result.pdf_forward = plain.pdf_forward * ratio;
    result.pdf_reverse = plain.pdf_reverse * ratio;
  }
  return result;
}

// What a connection or merge measures at (wo, wi), with the pdfs that its weight uses. Zero where wo or wi lies in
// the surface.
BsdfEval bsdf_connect(Bsdf bsdf, vec3 wo, vec3 wi, uint transport, Regularization regularization) {
  if (!is_regularized() || !bsdf_has_specular()) return bsdf_evaluate(bsdf, wo, wi, transport);
  if (!(wo.z > 0.0) || wi.z == 0.0) return BsdfEval(vec3(0.0), 0.0, 0.0);
  Encounter facet = encounter(bsdf, wo, wi);
  Lobes lobes = bsdf_lobes(bsdf, wo, wi, facet, transport);
  RegularizedLobes raised = regularize(bsdf, lobes, wo, wi, facet, false, regularization);
  BsdfEval eval = BsdfEval(raised.value, raised.pdf_forward, raised.pdf_reverse);
  if (spec_mis == MIS_UNMODIFIED) {
    BsdfEval plain = evaluate_lobes(lobes);
    eval.pdf_forward = plain.pdf_forward;
    eval.pdf_reverse = plain.pdf_reverse;
  }
  return eval;
}

// One over the pdf that weights use for a sampled direction: 0 for a delta event that no connection can replace.
float inverse_walk_pdf(Bsdf bsdf, vec3 wo, BsdfSample event, Regularization regularization) {
  bool is_delta = (event.flags & BSDF_SAMPLE_DELTA) != 0u;
  if (!is_regularized() || spec_mis == MIS_UNMODIFIED || !bsdf_has_specular())
    return is_delta ? 0.0 : 1.0 / event.pdf_forward;
  if (regularization.alpha_scale == 0.0) return is_delta ? 0.0 : 1.0 / event.pdf_forward;
  if (is_delta && regularized_alpha(bsdf, event.facet, regularization).x == 0.0) return 0.0;
  Lobes lobes = bsdf_lobes(bsdf, wo, event.wi, event.facet, TRANSPORT_IMPORTANCE);
  float pdf = regularize(bsdf, lobes, wo, event.wi, event.facet, is_delta, regularization).pdf_forward;
  return pdf > 0.0 ? 1.0 / pdf : 0.0;
}

#endif
