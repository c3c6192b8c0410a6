// Microfacet regularization (Jendersie and Grosch 2019): where a path is connected or merged, a microfacet lobe is
// evaluated with alpha^ = max(alpha, alpha_tau), where alpha_tau is so wide that the lobe's density stays below tau. Random
// walks keep alpha. The weights then use pdfs times rho^W / rho, with rho^W the regularized value (corrected) or the
// same with its peak blended in (blended, docs/mathematics.md 3.9), in closed forms that exist for delta lobes too (3.4).
#ifndef REGULUS_LIB_REGULARIZATION_GLSL
#define REGULUS_LIB_REGULARIZATION_GLSL

#include "lib/bsdf.glsl"
#include "lib/raised_light.glsl"
#include "lib/rng.glsl"

// What one vertex is regularized with: the bound on a lobe's density and the factor on alpha_tau of its iteration.
struct Regularization {
  float tau;          // 1/sr, for this vertex
  float alpha_scale;  // i^(-1/6) in iteration i = 1, 2, ... of the consistent schedule, otherwise 1; 0: not regularized
  float full_tau;     // the same two for a fully regularized vertex, see full()
  float full_scale;
};

// Path diffusion (--diffusion off: every vertex is regularized fully). What the camera sees directly, or through
// surfaces that are all sharp, stays sharp: mirrors, highlights and what is seen through glass. Path tracing follows the
// width of the bundle of paths (lib/footprint.glsl). With light subpaths there are two levels (docs/mathematics.md 3.8 A): a vertex
// is regularized if some vertex between it and the camera diffuses. That is a function of the path; light subpaths, which
// cannot know it, keep their accumulators for both cases.
const float SHARP_ALPHA = 0.05;

bool diffuses(Bsdf bsdf) {
  if (!bsdf_has_specular()) return true;
  // The coat of either side counts, because this must be a function of the path.
  if (bsdf_has_coat() && max(bsdf.coat, bsdf.coat_across) > 0.0 && bsdf.coat_alpha.x >= SHARP_ALPHA) return true;
  if (bsdf_has_sheen() && max(bsdf.sheen.here, bsdf.sheen.across) > 0.0) return true;
  return bsdf.alpha.x >= SHARP_ALPHA || max(bsdf.diffuse.r, max(bsdf.diffuse.g, bsdf.diffuse.b)) > 0.0;
}

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

// The regularization that this vertex would have if paths from the camera were fully diffused there.
Regularization full(Regularization regularization) {
  regularization.tau = regularization.full_tau;
  regularization.alpha_scale = regularization.full_scale;
  return regularization;
}

// Interfaces whose indices differ by less than this share hardly bend light: no roughness blurs them (docs/mathematics.md 2.5),
// so their transmission is not regularized.
const float MIN_REGULARIZED_BEND = 0.02;

// alpha_tau of a reflection lobe (docs/mathematics.md 2.2; directional: 2.4). c: the cosine at which the directions meet the
// facet.
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

// The largest alpha that a lobe is raised to: beyond 1 / sqrt(2) Beckmann's maximum leaves the normal (docs/mathematics.md 2.3).
float largest_alpha() { return spec_ndf == NDF_BECKMANN ? 0.70710678 : 1.0; }

vec2 regularized_alpha(Bsdf bsdf, Encounter facet, Regularization regularization) {
  float alpha_tau = bsdf_has_transmission() && facet.is_refracted
      ? refraction_alpha(bsdf, regularization.tau)
      : reflection_alpha(regularization.tau, facet.o_dot_h);
  return max(bsdf.alpha, vec2(min(alpha_tau * regularization.alpha_scale, largest_alpha())));
}

vec2 regularized_coat_alpha(Bsdf bsdf, Encounter facet, Regularization regularization) {
  float alpha_tau = reflection_alpha(regularization.tau, facet.o_dot_h) * regularization.alpha_scale;
  return max(bsdf.coat_alpha, vec2(min(alpha_tau, largest_alpha())));
}

// The clearcoat's lobe, raised by a bound of its own (docs/mathematics.md 2.5): value, and value as the weights use it.
struct RaisedCoat {
  float value;
  float value_in_weights;
};

RaisedCoat raise_coat(Bsdf bsdf, Lobes lobes, vec3 wo, vec3 wi, Encounter facet, Regularization regularization) {
  if (facet.is_transmitted || !(bsdf.coat > 0.0)) return RaisedCoat(0.0, 0.0);
  if (bsdf_has_coat_normal() && !(lobes.coat_weight > 0.0)) return RaisedCoat(0.0, 0.0);  // not seen by the coat
  vec2 alpha = regularized_coat_alpha(bsdf, facet, regularization);
  if (!(alpha.x > 0.0)) return RaisedCoat(0.0, 0.0);
  MicrofacetTerms raised = coat_microfacet_terms(bsdf, wo, wi, facet, max(alpha, vec2(MIN_ALPHA)));
  float density = min(0.25 * raised.density, MAX_DENSITY);
  float blended = density;
  if (spec_mis == MIS_BLENDED) {
    float peak = min(0.25 * INV_PI / (alpha.x * alpha.y), MAX_DENSITY);
    float beta = 1.0 - (bsdf.coat_alpha.x * bsdf.coat_alpha.y) / (alpha.x * alpha.y);
    blended = beta >= 1.0 ? peak
                          : exp_accurate((1.0 - beta) * log_accurate(max(density, 1e-36)) + beta * log_accurate(peak));
  }
  float weight = lobes.coat_weight * reflection_kept(bsdf.energy, bsdf.coat_alpha, alpha, lobes.coat_camera_cosine);
  return RaisedCoat(weight * density * raised.shadowing, weight * blended * raised.shadowing);
}

// The factor by which the base's lobe, raised to this alpha, keeps its light.
float raised_light_kept(Bsdf bsdf, Lobes lobes, Encounter facet, vec2 alpha) {
  if (bsdf_has_transmission() && facet.is_refracted)
    return refraction_kept(bsdf.energy, bsdf.alpha, alpha, lobes.camera_cosine, lobes.is_camera_inside);
  return reflection_kept(bsdf.energy, bsdf.alpha, alpha, lobes.camera_cosine);
}

// A regularized lobe at one pair of directions.
struct RegularizedLobes {
  vec3 value;
  float pdf_forward;         // p rho^W / rho, of wi given wo
  float pdf_reverse;
  float ratio;               // rho^W / rho; 0 where rho is a delta's
};

// is_delta_event: the pair came from sampling a delta lobe, which outweighs all others there; is_coat: that lobe is the
// clearcoat's.
RegularizedLobes regularize(Bsdf bsdf, Lobes lobes, vec3 wo, vec3 wi, Encounter facet, bool is_delta_event, bool is_coat,
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
  float passed = raised.shadowing * raised_light_kept(bsdf, lobes, facet, alpha);
  RegularizedLobes result;
  result.value = lobes.diffuse + lobes.weight * (density * passed * lobes.value_scale);

  // Values in luminance and without the eta^2 of radiance: r must not depend on the technique (docs/mathematics.md 3.6).
  float diffuse = dot(lobes.diffuse, LUMINANCE);
  float weight = dot(lobes.weight, LUMINANCE);
  float value = diffuse + weight * lobes.density * lobes.terms.shadowing;
  float value_in_weights = diffuse + weight * blended * passed;
  if (bsdf_has_coat()) {
    RaisedCoat coat = raise_coat(bsdf, lobes, wo, wi, facet, regularization);
    result.value += coat.value;
    value += lobes.coat_weight * lobes.coat_density * lobes.coat_terms.shadowing;
    value_in_weights += coat.value_in_weights;
    if (is_delta_event || !(value > 1e-30)) {
      // As in the case below, for the one or two lobes that make the event.
      result.ratio = 0.0;
      float base = is_delta_event && !base_is_in_event(bsdf, is_coat) ? 0.0 : 1.0;
      float over = is_delta_event && !coat_is_in_event(bsdf, is_coat) ? 0.0 : 1.0;
      float shared_value = base * weight * lobes.terms.shadowing + over * lobes.coat_weight * lobes.coat_terms.shadowing;
      float per_choice = value_in_weights / max(shared_value, 1e-30);
      result.pdf_forward = per_choice * (base * lobes.choice_forward * lobes.terms.visibility_o +
                                         over * lobes.coat_forward * lobes.coat_terms.visibility_o);
      result.pdf_reverse = per_choice * (base * lobes.choice_reverse * lobes.terms.visibility_i +
                                         over * lobes.coat_reverse * lobes.coat_terms.visibility_i);
      return result;
    }
  }
  if (is_delta_event || (!(diffuse > 0.0) && !bsdf_has_coat())) {
    // The density cancels from p / rho, and with it the 0 / 0 of a delta lobe.
    result.ratio = value > 0.0 && !is_delta_event ? value_in_weights / value : 0.0;
    float per_choice = value_in_weights / max(weight * lobes.terms.shadowing, 1e-30);
    result.pdf_forward = lobes.choice_forward * lobes.terms.visibility_o * per_choice;
    result.pdf_reverse = lobes.choice_reverse * lobes.terms.visibility_i * per_choice;
  } else {
    BsdfEval plain = evaluate_lobes(lobes);
    result.ratio = value_in_weights / value;
    result.pdf_forward = plain.pdf_forward * result.ratio;
    result.pdf_reverse = plain.pdf_reverse * result.ratio;
  }
  return result;
}

// Bounds are kept between these: products of two and a squared distance stay finite and positive.
const float MIN_BOUND = 1e-10, MAX_BOUND = 1e10;

// rho-bar: the largest value of the lobe that a pair of directions belongs to, with the walk's alpha. For a mixture, the mean
// over its lobes by their shares of the fully regularized value at the pair, which are the same for all techniques.
float estimator_bound(Bsdf bsdf, Lobes lobes, vec3 wo, vec3 wi, Encounter facet, Regularization regularization) {
  float diffuse = dot(lobes.diffuse, LUMINANCE);
  if (!bsdf_has_specular()) return max(diffuse, MIN_BOUND);
  vec2 alpha = regularized_alpha(bsdf, facet, full(regularization));
  vec3 wi_facet = facet.is_refracted ? wi : vec3(wi.xy, abs(wi.z));
  MicrofacetTerms raised = microfacet_terms(wo, wi_facet, facet.h, facet.o_dot_h, facet.i_dot_h,
                                            max(alpha, vec2(MIN_ALPHA)), facet.is_refracted);
  float specular = 0.0;
  if (facet.is_valid)
    specular = dot(lobes.weight, LUMINANCE) * min(raised.density * lobes.density_scale, MAX_DENSITY) * raised.shadowing *
               raised_light_kept(bsdf, lobes, facet, alpha);
  float peak_scale = 0.25;
  if (bsdf_has_transmission() && facet.is_refracted) {
    float eta = 1.0 / bsdf.inverse_eta;
    peak_scale = square(max(eta, 1.0) * (eta + 1.0) / max(abs(bsdf.excess), 1e-6));
  }
  float peak = peak_scale * INV_PI / max(bsdf.alpha.x * bsdf.alpha.y, 1e-10);
  float sum = diffuse + specular;
  float weighted_sum = diffuse * diffuse + specular * peak;
  if (bsdf_has_coat()) {
    float coat = raise_coat(bsdf, lobes, wo, wi, facet, full(regularization)).value;
    sum += coat;
    weighted_sum += coat * 0.25 * INV_PI / max(bsdf.coat_alpha.x * bsdf.coat_alpha.y, 1e-28);
  }
  return sum > 0.0 ? clamp(weighted_sum / sum, MIN_BOUND, MAX_BOUND) : MIN_BOUND;
}

// Where the numbers of a virtual merge come from. stream: the camera path's pixel, of a splat its light path; end:
// VIRTUAL_MERGE_AT_*; place: edges from the camera and from the light, and bits of the light path.
uvec4 virtual_merge_seed(uint seed, uint stream, uint iteration, uint end, uvec3 place) {
  if (!is_virtual_merge()) return uvec4(0u);
  return pcg4d(hash_bits(seed, stream, iteration, DIMENSION_BLOCK_VIRTUAL_MERGE + end) + uvec4(place, 0u));
}

// Virtual merge (Kaplanyan and Dachsbacher 2013 for delta lobes, Jendersie and Grosch 2019 for all): the share of what the
// microfacet lobe, or with is_coat the clearcoat's, scatters that falls into a cone of solid angle 1 / tau around wi, over
// that solid angle and cos_i.
vec3 virtual_merge(Bsdf bsdf, vec3 wo, vec3 wi, bool is_coat, uint transport, Regularization regularization, uvec4 seed) {
  float solid_angle = min(square(regularization.alpha_scale) / regularization.tau, 2.0 * PI);
  vec3 sum = vec3(0.0);
  for (uint i = 0u; i < VIRTUAL_MERGE_TRIES; ++i) {
    vec4 u = unit_interval(pcg4d(seed + i + (is_coat ? VIRTUAL_MERGE_TRIES : 0u)));
    float u_choice = min((u.x + float(i)) / float(VIRTUAL_MERGE_TRIES), ONE_MINUS_ULP);
    FacetEvent event = sample_facet_event(bsdf, wo, is_coat, u_choice, u.yz);
    // Between unit vectors 2 (1 - cos) is the chord's square, which keeps its digits for narrow cones.
    vec3 chord = event.wi - wi;
    if (!event.facet.is_valid || dot(chord, chord) > solid_angle * INV_PI) continue;
    Lobes lobes = bsdf_lobes(bsdf, wo, event.wi, event.facet, transport);
    // The density cancels from value over pdf.
    if (bsdf_has_coat() && is_coat)
      sum += lobes.coat_weight * lobes.coat_terms.shadowing * abs(event.wi.z) / max(lobes.coat_terms.visibility_o, 1e-30);
    else
      sum += lobes.weight * (lobes.terms.shadowing * lobes.value_scale * abs(event.wi.z) /
                             max(event.probability * lobes.terms.visibility_o, 1e-30));
  }
  return sum / (float(VIRTUAL_MERGE_TRIES) * solid_angle * max(abs(wi.z), MIN_COS));
}

// Value of all lobes, with raised lobes measured by virtual merges.
vec3 virtual_value(Bsdf bsdf, Lobes lobes, vec3 wo, vec3 wi, Encounter facet, uint transport, Regularization regularization,
                   uvec4 seed) {
  vec3 value = lobes.diffuse;
  if (any(greaterThan(regularized_alpha(bsdf, facet, regularization), bsdf.alpha)))
    value += virtual_merge(bsdf, wo, wi, false, transport, regularization, seed);
  else
    value += lobes.weight * (lobes.density * lobes.terms.shadowing * lobes.value_scale);
  if (!bsdf_has_coat() || facet.is_transmitted) return value;
  if (any(greaterThan(regularized_coat_alpha(bsdf, facet, regularization), bsdf.coat_alpha)))
    return value + virtual_merge(bsdf, wo, wi, true, transport, regularization, seed);
  return value + lobes.coat_weight * lobes.coat_density * lobes.coat_terms.shadowing;
}

// A bsdf at the directions of a connection or merge.
struct ConnectionEval {
  BsdfEval eval;   // what is measured, with the pdfs that its weight uses
  BsdfEval plain;  // without regularization
  float ratio;     // see RegularizedLobes
  float bound;     // rho-bar, 1/sr
};

const BsdfEval NO_SCATTERING = BsdfEval(vec3(0.0), 0.0, 0.0);

// What a connection or merge measures at (wo, wi). Zero where wo or wi lies in the surface.
// seed: see virtual_merge_seed.
ConnectionEval bsdf_connect(Bsdf bsdf, vec3 wo, vec3 wi, uint transport, Regularization regularization, uvec4 seed) {
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
WalkPdf walk_pdf(Bsdf bsdf, vec3 wo, BsdfSample event, uint transport, Regularization regularization) {
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
  if (is_delta && regularized_alpha(bsdf, event.facet, regularization).x == 0.0) return result;
  Lobes lobes = bsdf_lobes(bsdf, wo, event.wi, event.facet, transport);
  bool is_coat = (event.flags & BSDF_SAMPLE_COAT) != 0u;
  RegularizedLobes raised = regularize(bsdf, lobes, wo, event.wi, event.facet, is_delta, is_coat, regularization);
  result.inverse = raised.pdf_forward > 0.0 ? 1.0 / raised.pdf_forward : 0.0;
  result.ratio = raised.ratio;
  return result;
}

#endif
