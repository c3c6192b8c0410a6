// The bsdf with raised lobes (regularization): what connections and merges measure, the pdfs that weights use, the bound of
// sampler quality, and virtual merges. Each lobe says what raising means for it; here they are mixed.
#ifndef REGULUS_LIB_RAISED_BSDF_GLSL
#define REGULUS_LIB_RAISED_BSDF_GLSL

#include "lib/bsdf.glsl"
#include "lib/rng.glsl"

// A regularized bsdf at one pair of directions.
struct RegularizedLobes {
  vec3 value;
  float pdf_forward;         // p rho^W / rho, of wi given wo
  float pdf_reverse;
  float ratio;               // rho^W / rho; 0 where rho is a delta's
};

// is_delta_event: the pair came from sampling a delta lobe, which outweighs all others there; is_coat: that lobe is the
// clearcoat's.
RegularizedLobes regularize(const Bsdf bsdf, const Lobes lobes, vec3 wo, vec3 wi, const Encounter facet, bool is_delta_event, bool is_coat,
                            const Regularization regularization) {
  RaisedLobe raised = raise_interface(bsdf, lobes.base, wo, wi, facet, regularization);
  RegularizedLobes result;
  result.value = lobes.diffuse.value + raised_interface_value(lobes.base, raised);

  // Values in luminance and without the eta^2 of radiance: r must not depend on the technique (docs/mathematics.md 3.6).
  float diffuse = dot(lobes.diffuse.value, LUMINANCE);
  float value = diffuse + facet_luminance(lobes.base.facets);
  float value_in_weights = diffuse + raised_interface_in_weights(bsdf, lobes.base, raised, facet);
  if (bsdf_has_coat()) {
    RaisedLobe coat = raise_coat(bsdf.coat, bsdf.energy, lobes.coat, wo, wi, facet, regularization);
    result.value += raised_coat_value(lobes.coat, coat);
    value += facet_luminance(lobes.coat);
    value_in_weights += raised_coat_in_weights(bsdf.coat, lobes.coat, coat);
    if (is_delta_event || !(value > 1e-30)) {
      // As in the case below, for the one or two lobes that make the event.
      result.ratio = 0.0;
      float base = is_delta_event && !base_is_in_event(bsdf, is_coat) ? 0.0 : 1.0;
      float over = is_delta_event && !coat_is_in_event(bsdf, is_coat) ? 0.0 : 1.0;
      float shared_value = base * facet_share(lobes.base.facets) + over * facet_share(lobes.coat);
      float per_choice = value_in_weights / max(shared_value, 1e-30);
      result.pdf_forward =
          per_choice * (base * facet_share_forward(lobes.base.facets) + over * facet_share_forward(lobes.coat));
      result.pdf_reverse =
          per_choice * (base * facet_share_reverse(lobes.base.facets) + over * facet_share_reverse(lobes.coat));
      return result;
    }
  }
  if (is_delta_event || (!(diffuse > 0.0) && !bsdf_has_coat())) {
    // The density cancels from p / rho, and with it the 0 / 0 of a delta lobe.
    result.ratio = value > 0.0 && !is_delta_event ? value_in_weights / value : 0.0;
    float per_choice = value_in_weights / max(facet_share(lobes.base.facets), 1e-30);
    result.pdf_forward = facet_share_forward(lobes.base.facets) * per_choice;
    result.pdf_reverse = facet_share_reverse(lobes.base.facets) * per_choice;
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
float estimator_bound(const Bsdf bsdf, const Lobes lobes, vec3 wo, vec3 wi, const Encounter facet, const Regularization regularization) {
  float diffuse = dot(lobes.diffuse.value, LUMINANCE);
  if (!bsdf_has_specular()) return max(diffuse, MIN_BOUND);
  RaisedLobe raised = raise_interface(bsdf, lobes.base, wo, wi, facet, full(regularization));
  vec2 specular = bounded_interface(bsdf, lobes.base, raised, facet);
  float sum = diffuse + specular.x;
  float weighted_sum = diffuse * diffuse + specular.y;
  if (bsdf_has_coat()) {
    RaisedLobe raised_coat = raise_coat(bsdf.coat, bsdf.energy, lobes.coat, wo, wi, facet, full(regularization));
    float coat = raised_coat_value(lobes.coat, raised_coat);
    sum += coat;
    weighted_sum += bounded_coat(bsdf.coat, coat);
  }
  return sum > 0.0 ? clamp(weighted_sum / sum, MIN_BOUND, MAX_BOUND) : MIN_BOUND;
}

// Virtual merge (Kaplanyan and Dachsbacher 2013 for delta lobes, Jendersie and Grosch 2019 for all): the share of what the
// base's microfacet lobe, or with is_coat the clearcoat's, scatters that falls into a cone of solid angle 1 / tau around wi,
// over that solid angle and cos_i. seed: see virtual_merge_seed.
vec3 virtual_merge(const Bsdf bsdf, vec3 wo, vec3 wi, bool is_coat, uint transport, const Regularization regularization, uvec4 seed) {
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
    if (bsdf_has_coat() && is_coat) sum += coat_over_pdf(lobes.coat, event.wi);
    else sum += interface_over_pdf(lobes.base, event.probability, event.wi);
  }
  return sum / (float(VIRTUAL_MERGE_TRIES) * solid_angle * max(abs(wi.z), MIN_COS));
}

// Value of all lobes, with raised lobes measured by virtual merges.
vec3 virtual_value(const Bsdf bsdf, const Lobes lobes, vec3 wo, vec3 wi, const Encounter facet, uint transport, const Regularization regularization,
                   uvec4 seed) {
  vec3 value = lobes.diffuse.value;
  if (any(greaterThan(raised_interface_alpha(bsdf, facet, regularization), bsdf.alpha)))
    value += virtual_merge(bsdf, wo, wi, false, transport, regularization, seed);
  else
    value += interface_value(lobes.base);
  if (!bsdf_has_coat() || facet.is_transmitted) return value;
  if (any(greaterThan(raised_coat_alpha(bsdf.coat, facet, regularization), bsdf.coat.alpha)))
    return value + virtual_merge(bsdf, wo, wi, true, transport, regularization, seed);
  return value + facet_luminance(lobes.coat);
}

#endif
