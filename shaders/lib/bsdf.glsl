// The material model: a diffuse lobe under an interface of microfacets (base), under sheen, under a clearcoat. Each lobe has its
// formulas in lib/lobes; here they are mixed and sampled.
//
// Local shading frame: z is the shading normal on the side of wo, so wo.z > 0 (otherwise everything is zero).
// wo points towards the walk's previous vertex, wi away along its next direction; both are unit.
// eta = n_transmitted / n_incident as seen from wo.
//
// A walk chooses the coat with probability P_c, the diffuse lobe with probability P_d by what each would reflect at wo, else a visible
// normal, then reflection or transmission by the Fresnel weights there.
#ifndef REGULUS_LIB_BSDF_GLSL
#define REGULUS_LIB_BSDF_GLSL

#include "lib/bsdf_material.glsl"

const uint BSDF_SAMPLE_VALID = 1u;
const uint BSDF_SAMPLE_DELTA = 2u;
const uint BSDF_SAMPLE_TRANSMITTED = 4u;
const uint BSDF_SAMPLE_DIFFUSE = 8u;  // by the diffuse lobe
const uint BSDF_SAMPLE_COAT = 16u;    // by the clearcoat

struct BsdfSample {
  vec3 wi;
  vec3 weight;        // value |cos_i| / pdf; of a delta event its factor over its probability
  float pdf_forward;  // of wi given wo; of a delta event its discrete probability
  float pdf_reverse;
  uint flags;         // BSDF_SAMPLE_*; weight and pdfs are 0 unless valid
  float eta_scale;    // weight * eta_scale is free of refraction's 1 / eta^2
  Encounter facet;    // where wo and wi meet
};

// The lobes at (wo, wi) that meet at a facet: what value and pdfs are made of.
struct Lobes {
  BsdfEval diffuse;     // with its share of both pdfs; sheen included
  InterfaceLobe base;
  MicrofacetLobe coat;  // only with bsdf_has_coat()
};

// True if the bsdf has a lobe on the side of wo that is not a delta.
bool has_finite_lobe(const Bsdf bsdf) {
  if (!bsdf_has_delta() || bsdf.alpha.x > 0.0) return true;
  if (bsdf_has_coat() && bsdf.coat.here > 0.0 && bsdf.coat.alpha.x > 0.0) return true;
  if (bsdf_has_sheen() && bsdf.sheen.here > 0.0) return true;
  return has_diffuse(bsdf);
}

// True if some lobe is not sharp, which decides about regularization (lib/regularization.glsl).
bool diffuses(const Bsdf bsdf) {
  if (!bsdf_has_specular()) return true;
  if (bsdf_has_coat() && coat_diffuses(bsdf.coat)) return true;
  if (bsdf_has_sheen() && sheen_diffuses(bsdf.sheen)) return true;
  return bsdf.alpha.x >= SHARP_ALPHA || has_diffuse(bsdf);
}

// Variance of the angles that the microfacet lobe of an event adds (docs/mathematics.md 5).
float facets_spread(const Bsdf bsdf, const BsdfSample event) {
  float spread = facet_spread((event.flags & BSDF_SAMPLE_COAT) != 0u ? bsdf.coat.alpha : bsdf.alpha);
  if (event.facet.is_refracted) spread *= 0.25 * square(1.0 - bsdf.inverse_eta);
  return spread;
}

// Puts all lobes under the coat, and adds its own.
void add_coat(const Bsdf bsdf, vec3 wo, vec3 wi, const Encounter facet, const BasePassages passages, uint transport, inout Lobes lobes) {
  CoatPassage passage =
      coat_passage(bsdf.coat, wo, wi, facet.is_transmitted, base_luminance(bsdf, wo.z, passages.s_o),
                   base_luminance(bsdf, abs(wi.z), passages.s_i));
  lobes.diffuse.value *= passage.passed;
  lobes.base.color *= passage.passed;
  lobes.diffuse.pdf_forward *= passage.chosen_o.y;
  lobes.base.facets.choice_forward *= passage.chosen_o.y;
  lobes.diffuse.pdf_reverse *= passage.chosen_i.y;
  lobes.base.facets.choice_reverse *= passage.chosen_i.y;
  lobes.coat = evaluate_coat(bsdf.coat, passage, wo, wi, facet, transport);
}

Lobes bsdf_lobes(const Bsdf bsdf, vec3 wo, vec3 wi, const Encounter facet, uint transport) {
  Lobes lobes;
  lobes.base = NO_INTERFACE_LOBE;
  lobes.coat = NO_MICROFACET_LOBE;
  float cos_o = wo.z;
  float cos_i = abs(wi.z);
  bool is_dark = is_in_relief_shadow(bsdf, transport == TRANSPORT_RADIANCE ? wi : wo);
  float same_side = facet.is_transmitted || is_dark ? 0.0 : INV_PI;
  if (!bsdf_has_specular()) {
    lobes.diffuse = evaluate_bare_diffuse(bsdf, cos_o, cos_i, same_side, transport);
    return lobes;
  }
  BasePassages passages = base_passages(bsdf, cos_o, cos_i, facet.is_refracted);
  vec2 sheen = vec2(bsdf.sheen.here, facet.is_transmitted ? bsdf.sheen.across : bsdf.sheen.here);
  vec2 chosen = vec2(diffuse_probability(bsdf, cos_o, passages.s_o, sheen.x),
                     diffuse_probability(bsdf, cos_i, passages.s_i, sheen.y));
  lobes.diffuse = evaluate_diffuse(bsdf, cos_o, cos_i, passages, same_side, chosen, sheen, transport);
  lobes.base = evaluate_interface(bsdf, wo, wi, facet, 1.0 - chosen, transport);
  if (bsdf_has_sheen())
    put_under_sheen(bsdf.sheen, cos_o, cos_i, facet, same_side > 0.0, lobes.diffuse.value, lobes.base.color);
  if (bsdf_has_coat()) add_coat(bsdf, wo, wi, facet, passages, transport, lobes);
  lobes.base.facets.weight = dot(lobes.base.color, LUMINANCE);
  return lobes;
}

// All non-delta lobes at (wo, wi) that meet at a facet. Value and pdfs come from this one place.
BsdfEval evaluate_lobes(const Lobes lobes) {
  BsdfEval eval;
  eval.value = lobes.diffuse.value + interface_value(lobes.base);
  eval.pdf_forward = lobes.diffuse.pdf_forward + facet_pdf_forward(lobes.base.facets);
  eval.pdf_reverse = lobes.diffuse.pdf_reverse + facet_pdf_reverse(lobes.base.facets);
  if (bsdf_has_coat()) {
    eval.value += facet_luminance(lobes.coat);
    eval.pdf_forward += facet_pdf_forward(lobes.coat);
    eval.pdf_reverse += facet_pdf_reverse(lobes.coat);
  }
  return eval;
}

// Value and pdfs of the non-delta lobes; zero where wo or wi lies in the surface.
BsdfEval bsdf_evaluate(const Bsdf bsdf, vec3 wo, vec3 wi, uint transport) {
  BsdfEval eval = evaluate_lobes(bsdf_lobes(bsdf, wo, wi, encounter(bsdf, wo, wi), transport));
  if (!(wo.z > 0.0) || wi.z == 0.0) return NO_SCATTERING;
  return eval;
}

// is_coat: of the clearcoat, which only reflects.
FacetEvent sample_facet_event(const Bsdf bsdf, vec3 wo, bool is_coat, float u_choice, vec2 u) {
  vec3 w = wo;  // in the frame of the lobe
  if (bsdf_has_coat_normal() && is_coat) w = to_coat(bsdf.coat, wo);
  Facet visible = sample_facet(w, is_coat ? bsdf.coat.alpha : bsdf.alpha, u, u_choice);
  bool is_seen = true;
  if (bsdf_has_coat_normal() && is_coat) {
    is_seen = coat_sees(w, visible);
    visible.h = from_coat(bsdf.coat, visible.h);
  }
  return facet_event(bsdf, wo, visible, u_choice, is_coat, is_seen);
}

// Which of the two microfacet lobes have a part in an event that one of them, a delta, has made. Both reflect to the same
// side if both are deltas and have the same normal.
bool base_is_in_event(const Bsdf bsdf, bool is_coat) { return !(bsdf.alpha.x > 0.0) && !(is_coat && bsdf.coat.is_turned); }
bool coat_is_in_event(const Bsdf bsdf, bool is_coat) { return coat_is_delta(bsdf.coat) && (is_coat || !bsdf.coat.is_turned); }

// Puts a delta event of the base under the clearcoat; a lobe that has no part in it is left out.
void add_coat_to_delta(const Bsdf bsdf, vec3 wo, const FacetEvent event, bool is_coat, uint transport, inout BsdfEval eval) {
  float cos_i = abs(event.wi.z);
  vec2 position_o = event.position, position_i = event.position;
  if (is_coat && (has_rough_base() || (bsdf_has_coat_normal() && bsdf.coat.is_turned))) {
    position_o = base_passage(bsdf, wo.z, bsdf.excess).xy;
    position_i = base_passage(bsdf, cos_i, bsdf.excess).xy;
  }
  CoatPassage passage =
      coat_passage(bsdf.coat, wo, event.wi, event.facet.is_transmitted, base_luminance(bsdf, wo.z, position_o),
                   base_luminance(bsdf, cos_i, position_i));
  float base = base_is_in_event(bsdf, is_coat) ? 1.0 : 0.0;
  eval.value *= base * passage.passed;
  eval.pdf_forward *= base * passage.chosen_o.y;
  eval.pdf_reverse *= base * passage.chosen_i.y;
  if (!event.facet.is_transmitted && coat_is_in_event(bsdf, is_coat))
    add_coat_delta(bsdf.coat, passage, wo.z, cos_i, transport, eval);
}

// Factor and discrete probabilities of a delta event. diffuse_o: diffuse_probability from wo.
BsdfEval evaluate_delta(const Bsdf bsdf, vec3 wo, const FacetEvent event, bool is_coat, float diffuse_o, uint transport) {
  float cos_i = abs(event.wi.z);
  // An event of the clearcoat brings the base's along; its own choice was not the base's.
  float reflect_o =
      bsdf_has_coat() ? reflection_probability(bsdf, event.position, wo.z) : event.probability;
  if (bsdf_has_coat() && event.facet.is_transmitted) reflect_o = event.probability;
  float sheen_i = event.facet.is_transmitted ? bsdf.sheen.across : bsdf.sheen.here;
  vec2 chosen = vec2(diffuse_o, diffuse_probability(bsdf, cos_i, event.position, sheen_i));
  BsdfEval eval = evaluate_interface_delta(bsdf, wo, event, 1.0 - chosen, reflect_o, transport);
  if (bsdf_has_sheen()) eval.value *= sheen_passage(bsdf.sheen, wo.z, cos_i, event.facet.is_transmitted).passed;
  if (bsdf_has_coat()) add_coat_to_delta(bsdf, wo, event, is_coat, transport, eval);
  return eval;
}

const BsdfSample INVALID_BSDF_SAMPLE = BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, 0.0, 0u, 1.0, NO_ENCOUNTER);

// A direction that a walk has chosen, before it is evaluated.
struct BsdfChoice {
  vec3 wi;
  Encounter facet;   // where wo and wi meet
  BsdfEval delta;    // of a delta event
  bool is_diffuse;   // by the diffuse lobe
  bool is_coat;      // by the clearcoat
  bool is_delta;
  float u_diffuse;   // of the diffuse lobe: what is left of the number that chose it, in [0, 1)
};

// Chooses wi. u_lobe chooses the lobe, u the direction; all in [0, 1).
BsdfChoice bsdf_choose(const Bsdf bsdf, vec3 wo, float u_lobe, vec2 u, uint transport) {
  vec2 s_o = vec2(0.0);
  if (bsdf_has_specular()) s_o = base_passage(bsdf, wo.z, bsdf.excess).xy;
  float sheen = 0.0;
  if (bsdf_has_sheen()) sheen = diffuse_sheen(bsdf, wo.z, s_o, bsdf.sheen.here);
  vec3 diffuse_wi = sample_diffuse(bsdf, u, sheen);
  BsdfChoice choice;
  choice.facet = reflection_encounter(wo, diffuse_wi);
  choice.wi = diffuse_wi;
  choice.is_diffuse = true;
  choice.is_coat = false;
  choice.is_delta = false;
  choice.u_diffuse = u_lobe;
  if (bsdf_has_specular()) {
    float diffuse_o = diffuse_probability(bsdf, wo.z, s_o, bsdf.sheen.here);
    float coat_o = bsdf_has_coat() ? coat_choice(bsdf.coat.here, coat_cosine(bsdf.coat, wo), base_luminance(bsdf, wo.z, s_o)).x : 0.0;
    choice.is_coat = bsdf_has_coat() && u_lobe < coat_o;
    if (bsdf_has_coat()) {
      u_lobe = choice.is_coat ? u_lobe / max(coat_o, 1e-7) : (u_lobe - coat_o) / max(1.0 - coat_o, 1e-7);
      u_lobe = clamp(u_lobe, 0.0, ONE_MINUS_ULP);
    }
    choice.is_diffuse = !choice.is_coat && u_lobe < diffuse_o;
    choice.u_diffuse = u_lobe / max(diffuse_o, 1e-7);
    float u_choice = clamp((u_lobe - diffuse_o) / max(1.0 - diffuse_o, 1e-7), 0.0, ONE_MINUS_ULP);
    if (choice.is_coat) u_choice = u_lobe;
    FacetEvent event = sample_facet_event(bsdf, wo, choice.is_coat, u_choice, u);
    choice.is_delta = !choice.is_diffuse && bsdf_has_delta() && (choice.is_coat ? bsdf.coat.alpha.x : bsdf.alpha.x) == 0.0;
    if (bsdf_has_delta()) choice.delta = evaluate_delta(bsdf, wo, event, choice.is_coat, diffuse_o, transport);
    choice.wi = choice.is_diffuse ? diffuse_wi : event.wi;
    if (!choice.is_diffuse) choice.facet = event.facet;
  }
  return choice;
}

// Value and pdfs of what was chosen.
BsdfSample bsdf_sampled(const Bsdf bsdf, vec3 wo, const BsdfChoice choice, uint transport) {
  vec3 wi = choice.wi;
  Encounter facet = choice.facet;
  BsdfEval eval = evaluate_lobes(bsdf_lobes(bsdf, wo, wi, facet, transport));
  float numerator = abs(wi.z);
  if (bsdf_has_delta() && choice.is_delta) {
    eval = choice.delta;
    numerator = 1.0;
  }
  bool is_dark = choice.is_diffuse && is_in_relief_shadow(bsdf, transport == TRANSPORT_RADIANCE ? wi : wo);
  bool is_valid = facet.is_valid && wo.z > 0.0 && numerator > 0.0 && eval.pdf_forward > 0.0 && !is_dark;
  if (!is_valid) return INVALID_BSDF_SAMPLE;

  BsdfSample result;
  result.wi = wi;
  result.facet = facet;
  result.weight = eval.value * (numerator / eval.pdf_forward);
  result.pdf_forward = eval.pdf_forward;
  result.pdf_reverse = eval.pdf_reverse;
  result.flags = BSDF_SAMPLE_VALID | (choice.is_delta ? BSDF_SAMPLE_DELTA : 0u) |
                 (facet.is_transmitted ? BSDF_SAMPLE_TRANSMITTED : 0u) | (choice.is_diffuse ? BSDF_SAMPLE_DIFFUSE : 0u) |
                 (choice.is_coat ? BSDF_SAMPLE_COAT : 0u);
  bool is_scaled = bsdf_has_transmission() && facet.is_refracted && transport == TRANSPORT_RADIANCE;
  result.eta_scale = is_scaled ? 1.0 / bsdf.inverse_eta_squared : 1.0;
  return result;
}

// Samples wi. u_lobe chooses the lobe, u the direction; all in [0, 1).
BsdfSample bsdf_sample(const Bsdf bsdf, vec3 wo, float u_lobe, vec2 u, uint transport) {
  return bsdf_sampled(bsdf, wo, bsdf_choose(bsdf, wo, u_lobe, u, transport), transport);
}

// With a guide: how many times as likely as without it a camera walk goes the way it does.
float guided_ratio(Bsdf bsdf, vec3 wo, const BsdfSample event) {
  if ((event.flags & BSDF_SAMPLE_DELTA) != 0u) return 1.0;
  bsdf.guide = vec2(0.0);
  BsdfEval plain = evaluate_lobes(bsdf_lobes(bsdf, wo, event.wi, event.facet, TRANSPORT_RADIANCE));
  return event.pdf_forward / max(plain.pdf_forward, 1e-30);
}

// Pdf of walking back over pdf forward of a sampled direction, both per solid angle of that direction. The delta
// distributions at the two ends of a smooth refraction differ by the Jacobian of Snell's law,
// n_i^2 cos_i dw_i = n_o^2 cos_o dw_o, as the densities of a rough one do by themselves.
float walk_pdf_ratio(const Bsdf bsdf, vec3 wo, const BsdfSample event) {
  float ratio = event.pdf_reverse / event.pdf_forward;
  const uint REFRACTED = BSDF_SAMPLE_DELTA | BSDF_SAMPLE_TRANSMITTED;
  if (!bsdf_has_delta() || !bsdf_has_transmission() || (event.flags & REFRACTED) != REFRACTED || bsdf.is_thin)
    return ratio;
  return ratio * bsdf.inverse_eta_squared * wo.z / max(abs(event.wi.z), MIN_COS);
}

#endif
