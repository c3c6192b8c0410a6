// The material model: Lambert under a dielectric interface, microfacet reflection (dielectric and metal),
// rough refraction (MATERIAL_VOLUME) or thin-walled transmission, and their smooth limits as delta events.
//
// Local shading frame: z is the shading normal on the side of wo, so wo.z > 0 (otherwise everything is zero).
// wo points towards the walk's previous vertex, wi away along its next direction; both are unit.
// eta = n_transmitted / n_incident as seen from wo.
//
//   F_r = m F_metal + (1 - m) F_d              Schlick; exact dielectric, remapped by KHR_materials_specular
//   reflection    F_r(wo.h) D G2 / (4 cos_o cos_i)                                     Torrance and Sparrow
//   refraction    (1-m) t base (1 - F_d) D G2 |wo.h| |wi.h| eta^2 / (cos_o cos_i (wo.h + eta wi.h)^2)
//                 Walter et al. 2007, eq. 21; a radiance walk divides by eta^2
//   thin-walled   the reflection lobe mirrored at the surface, with (1-m) t base (1 - F_d)
//   diffuse       (1-m)(1-t) base / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg)      E: F_d(cos), of rough interfaces
//                 their own albedo (lib/cover.glsl)
//
// Under a clearcoat of weight c, with T(w) = 1 - c F_c(cos_w) on the coated side and 1 on the other:
//   T(wo) T(wi) (all of the above) + c F_c(wo.h) D_c G2_c / (4 cos_o cos_i),  F_c = Schlick from 0.04
// KHR_materials_clearcoat in the reciprocal form that it allows. Of a coat with a normal of its own these cosines are those
// with that normal, and its lobe has the factor |cos with the coat's normal| / |cos with the base's| of the direction to the
// light: it reflects what falls on the coat. As with all shading normals that is a function of the path.
// Between the two lies sheen (lib/lobes/sheen.glsl). With --energy-compensation see lib/energy.glsl.
//
// A walk chooses the coat with probability P_c, the diffuse lobe with probability P_d by what each would reflect at wo, else a visible
// normal, then reflection or transmission by the Fresnel weights there.
#ifndef REGULUS_LIB_BSDF_GLSL
#define REGULUS_LIB_BSDF_GLSL

#include "lib/bsdf_parameters.glsl"
#include "lib/microfacet.glsl"

// What is transported along the walk: it decides about the eta^2 of refraction.
const uint TRANSPORT_RADIANCE = 0u;    // walks from the camera
const uint TRANSPORT_IMPORTANCE = 1u;  // walks from lights

const uint BSDF_SAMPLE_VALID = 1u;
const uint BSDF_SAMPLE_DELTA = 2u;
const uint BSDF_SAMPLE_TRANSMITTED = 4u;
const uint BSDF_SAMPLE_DIFFUSE = 8u;  // by the diffuse lobe
const uint BSDF_SAMPLE_COAT = 16u;    // by the clearcoat

// Non-delta lobes at a pair of directions. Densities per solid angle.
struct BsdfEval {
  vec3 value;         // 1/sr, without a cosine
  float pdf_forward;  // of wi given wo
  float pdf_reverse;  // of wo given wi
};

// Where wo and wi meet the microsurface.
struct Encounter {
  vec3 h;               // unit, h.z > 0
  float o_dot_h;        // absolute cosines with h
  float i_dot_h;
  bool is_transmitted;  // wi is below the surface
  bool is_refracted;    // and was bent (not thin-walled)
  bool is_valid;        // false: no facet turns wo into wi
};

struct BsdfSample {
  vec3 wi;
  vec3 weight;        // value |cos_i| / pdf; of a delta event its factor over its probability
  float pdf_forward;  // of wi given wo; of a delta event its discrete probability
  float pdf_reverse;
  uint flags;         // BSDF_SAMPLE_*; weight and pdfs are 0 unless valid
  float eta_scale;    // weight * eta_scale is free of refraction's 1 / eta^2
  Encounter facet;    // where wo and wi meet
};

// The parts of the lobes at (wo, wi) that meet at a facet: what value and pdfs are made of. The microfacet lobe's
// density and shadowing are those of the bsdf's own alpha; all else does not depend on alpha.
struct Lobes {
  vec3 diffuse;           // value of the diffuse lobe
  float diffuse_forward;  // its share of both pdfs
  float diffuse_reverse;
  vec3 weight;            // Fresnel factor and colour of the microfacet lobe
  float density_scale;    // half-vector Jacobian: times D, the factor that value and pdfs share
  float value_scale;      // 1 / eta^2 for refraction in a radiance walk
  float choice_forward;   // probability of choosing the lobe, and of its event at the facet
  float choice_reverse;
  MicrofacetTerms terms;
  float density;          // terms.density * density_scale, 0 for a delta lobe or without a facet
  float camera_cosine;    // of the direction towards the camera
  bool is_camera_inside;  // it lies on the denser side of the interface
  // The same of the clearcoat's lobe, whose density_scale is 1/4. Only with bsdf_has_coat().
  float coat_weight;
  float coat_forward;
  float coat_reverse;
  MicrofacetTerms coat_terms;
  float coat_density;
  float coat_camera_cosine;  // with the coat's normal
};

// Terms of the clearcoat's lobe with this alpha.
MicrofacetTerms coat_microfacet_terms(Bsdf bsdf, vec3 wo, vec3 wi, Encounter facet, vec2 alpha) {
  return microfacet_terms(to_coat(bsdf, wo), to_coat(bsdf, wi), to_coat(bsdf, facet.h), facet.o_dot_h, facet.i_dot_h, alpha,
                          false);
}

// Adds the clearcoat's lobe at (wo, wi) and puts the others under it. position_o, position_i: Fresnel positions of the
// base in both directions.
void add_coat(Bsdf bsdf, vec3 wo, vec3 wi, Encounter facet, vec2 position_o, vec2 position_i, uint transport,
              inout Lobes lobes) {
  float coat_i = facet.is_transmitted ? bsdf.coat_across : bsdf.coat;
  float cosine_o = coat_cosine(bsdf, wo), cosine_i = coat_cosine(bsdf, wi);
  float passed = coat_transmittance(bsdf.coat, abs(cosine_o)) * coat_transmittance(coat_i, abs(cosine_i));
  lobes.diffuse *= passed;
  lobes.weight *= passed;
  vec2 chosen_o = coat_choice(bsdf, bsdf.coat, wo.z, cosine_o, position_o);
  vec2 chosen_i = coat_choice(bsdf, coat_i, abs(wi.z), cosine_i, position_i);
  lobes.diffuse_forward *= chosen_o.y;
  lobes.choice_forward *= chosen_o.y;
  lobes.diffuse_reverse *= chosen_i.y;
  lobes.choice_reverse *= chosen_i.y;
  if (facet.is_transmitted || !(bsdf.coat > 0.0)) return;
  if (bsdf_has_coat_normal() && !(min(cosine_o, cosine_i) > 0.0)) return;
  lobes.coat_weight = coat_reflectance(bsdf.coat, facet.o_dot_h);
  if (bsdf_has_coat_normal())
    lobes.coat_weight *= transport == TRANSPORT_RADIANCE ? cosine_i / max(wi.z, MIN_COS) : cosine_o / max(wo.z, MIN_COS);
  lobes.coat_forward = chosen_o.x;
  lobes.coat_reverse = chosen_i.x;
  lobes.coat_camera_cosine = abs(transport == TRANSPORT_RADIANCE ? cosine_o : cosine_i);
  lobes.coat_terms = coat_microfacet_terms(bsdf, wo, wi, facet, max(bsdf.coat_alpha, vec2(MIN_ALPHA)));
  if (bsdf.coat_alpha.x > 0.0) lobes.coat_density = min(0.25 * lobes.coat_terms.density, MAX_DENSITY);
}

// Puts all lobes under sheen, and adds its own to the diffuse one. is_lit: the diffuse lobe sees both directions.
void put_under_sheen(Bsdf bsdf, vec3 wo, vec3 wi, Encounter facet, bool is_lit, inout Lobes lobes) {
  float cos_i = abs(wi.z);
  SheenPassage passage = sheen_passage(bsdf.sheen, wo.z, cos_i, facet.is_transmitted);
  lobes.diffuse *= passage.passed;
  lobes.weight *= passage.passed;
  if (is_lit && bsdf.sheen.here > 0.0)
    lobes.diffuse += bsdf.sheen.color * sheen_value(bsdf.sheen, facet.h, wo.z, cos_i, passage);
}

Lobes bsdf_lobes(Bsdf bsdf, vec3 wo, vec3 wi, Encounter facet, uint transport) {
  Lobes lobes;
  float cos_o = wo.z;
  float cos_i = abs(wi.z);
  bool is_dark = is_in_relief_shadow(bsdf, transport == TRANSPORT_RADIANCE ? wi : wo);
  float same_side = facet.is_transmitted || is_dark ? 0.0 : INV_PI;
  lobes.weight = vec3(0.0);
  lobes.density = 0.0;
  lobes.choice_forward = 0.0;
  lobes.choice_reverse = 0.0;
  lobes.value_scale = 1.0;
  lobes.density_scale = 0.25;
  lobes.terms = MicrofacetTerms(0.0, 0.0, 0.0, 0.0);
  lobes.coat_weight = 0.0;
  lobes.coat_forward = 0.0;
  lobes.coat_reverse = 0.0;
  lobes.coat_terms = MicrofacetTerms(0.0, 0.0, 0.0, 0.0);
  lobes.coat_density = 0.0;
  lobes.coat_camera_cosine = 1.0;
  // The camera's direction, in which energy is counted (lib/energy.glsl, lib/raised_light.glsl).
  bool is_turned = transport == TRANSPORT_IMPORTANCE;
  lobes.camera_cosine = is_turned ? cos_i : cos_o;
  lobes.is_camera_inside = (bsdf.excess < 0.0) != (is_turned && facet.is_refracted);
  if (!bsdf_has_specular()) {
    lobes.diffuse = bsdf.diffuse * same_side;
    lobes.diffuse_forward = cos_i * same_side;
    lobes.diffuse_reverse = cos_o * same_side;
    if (has_walk_guide()) {
      if (is_turned) lobes.diffuse_reverse = guided_density(bsdf, cos_o) * same_side;
      else lobes.diffuse_forward = guided_density(bsdf, cos_i) * same_side;
    }
    return lobes;
  }
  // The reverse walk of a refraction starts on the other side of the interface.
  float excess_i = facet.is_refracted ? -bsdf.excess * bsdf.inverse_eta_squared : bsdf.excess;
  vec3 passage_o = base_passage(bsdf, cos_o, bsdf.excess);
  vec3 passage_i = base_passage(bsdf, cos_i, excess_i);
  vec2 s_o = passage_o.xy, s_i = passage_i.xy;
  float sheen_i = facet.is_transmitted ? bsdf.sheen.across : bsdf.sheen.here;
  float diffuse_o = diffuse_probability(bsdf, cos_o, s_o, bsdf.sheen.here);
  float diffuse_i = diffuse_probability(bsdf, cos_i, s_i, sheen_i);
  if (compensates_energy()) {
    passage_o = vec3(rough_position(bsdf, cos_o, s_o), 0.0);
    passage_i = vec3(rough_position(bsdf, cos_i, s_i), 0.0);
  }
  lobes.diffuse =
      bsdf.diffuse * base_transmittance(bsdf, passage_o) * base_transmittance(bsdf, passage_i) * same_side;
  if (bsdf_has_film() && same_side > 0.0) lobes.diffuse = film_diffuse(bsdf, lobes.diffuse * PI, cos_o, cos_i) * INV_PI;
  float density_i = diffuse_density(bsdf, cos_i, sheen_share(bsdf, cos_o, s_o, bsdf.sheen.here));
  float density_o = diffuse_density(bsdf, cos_o, sheen_share(bsdf, cos_i, s_i, sheen_i));
  if (has_walk_guide()) {
    if (is_turned) density_o = guided_density(bsdf, density_o);
    else density_i = guided_density(bsdf, density_i);
  }
  lobes.diffuse_forward = diffuse_o * density_i * same_side;
  lobes.diffuse_reverse = diffuse_i * density_o * same_side;
  if (!bsdf_has_rough() && spec_regularization == REGULARIZATION_NONE) {
    if (bsdf_has_sheen()) put_under_sheen(bsdf, wo, wi, facet, same_side > 0.0, lobes);
    if (bsdf_has_coat()) add_coat(bsdf, wo, wi, facet, s_o, s_i, transport, lobes);
    return lobes;
  }

  vec3 wi_facet = facet.is_refracted ? wi : vec3(wi.xy, cos_i);
  lobes.terms = microfacet_terms(wo, wi_facet, facet.h, facet.o_dot_h, facet.i_dot_h, max(bsdf.alpha, vec2(MIN_ALPHA)),
                                 facet.is_refracted);

  // A refracted pair knows its own g = eta |wi.h|, which stays accurate where sqrt(c^2 + excess) does not.
  float g = facet.is_refracted ? facet.i_dot_h / bsdf.inverse_eta : refracted_g(facet.o_dot_h, bsdf.excess);
  vec2 s = fresnel_position(bsdf, facet.o_dot_h, g, bsdf.excess);
  float k = schlick_weight(facet.o_dot_h);
  float reflect_o = reflection_probability(bsdf, s, facet.o_dot_h);
  float reflect_i = reflection_probability(bsdf, s, facet.i_dot_h);

  // D times the half-vector Jacobian over the |cos_h| of the visible normals, forward and (times
  // reverse_scale) reverse. |wo.h + eta wi.h| = |g - c| = |excess| / (c + g).
  float reverse_scale = 1.0;
  if (bsdf_has_transmission() && facet.is_refracted) {
    float difference = bsdf.excess / (facet.o_dot_h + g);
    lobes.density_scale = facet.o_dot_h * g / (bsdf.inverse_eta * max(square(difference), 1e-16));
    reverse_scale = bsdf.inverse_eta_squared;
    lobes.value_scale = transport == TRANSPORT_RADIANCE ? bsdf.inverse_eta_squared : 1.0;
  }
  bool is_rough = facet.is_valid && bsdf.alpha.x > 0.0;
  lobes.density = is_rough ? min(lobes.terms.density * lobes.density_scale, MAX_DENSITY) : 0.0;
  float film_c = 0.0;
  if (bsdf_has_film()) film_c = film_cosine(bsdf, facet.o_dot_h, g, bsdf.excess);
  lobes.weight = interface_reflectance(bsdf, s, k);
  if (bsdf_has_film()) lobes.weight = film_reflectance(bsdf, lobes.weight, film_c, vec3(1.0), 1.0);
  if (compensates_energy())
    lobes.weight = compensated_reflectance(bsdf, s, k, lobes.camera_cosine, lobes.is_camera_inside, film_c);
  if (bsdf_has_transmission() && facet.is_transmitted) {
    vec3 passed = dielectric_transmittance(bsdf, s);
    if (bsdf_has_film()) passed = film_refraction(bsdf, passed, film_c);
    lobes.weight = bsdf.transmission * passed;
    if (compensates_energy())
      lobes.weight /= bsdf.is_thin ? energy_reflected(bsdf.energy, lobes.camera_cosine)
                                   : energy_scattered(bsdf.energy, lobes.camera_cosine, lobes.is_camera_inside);
    reflect_o = 1.0 - reflect_o;
    reflect_i = 1.0 - reflect_i;
  }
  lobes.choice_forward = (1.0 - diffuse_o) * reflect_o;
  lobes.choice_reverse = (1.0 - diffuse_i) * reflect_i * reverse_scale;
  if (bsdf_has_sheen()) put_under_sheen(bsdf, wo, wi, facet, same_side > 0.0, lobes);
  if (bsdf_has_coat()) add_coat(bsdf, wo, wi, facet, s_o, s_i, transport, lobes);
  return lobes;
}

// All non-delta lobes at (wo, wi) that meet at a facet. Value and pdfs come from this one place.
BsdfEval evaluate_lobes(Lobes lobes) {
  BsdfEval eval;
  eval.value = lobes.diffuse + lobes.weight * (lobes.density * lobes.terms.shadowing * lobes.value_scale);
  eval.pdf_forward = lobes.diffuse_forward + lobes.choice_forward * lobes.density * lobes.terms.visibility_o;
  eval.pdf_reverse = lobes.diffuse_reverse + lobes.choice_reverse * lobes.density * lobes.terms.visibility_i;
  if (bsdf_has_coat()) {
    eval.value += lobes.coat_weight * lobes.coat_density * lobes.coat_terms.shadowing;
    eval.pdf_forward += lobes.coat_forward * lobes.coat_density * lobes.coat_terms.visibility_o;
    eval.pdf_reverse += lobes.coat_reverse * lobes.coat_density * lobes.coat_terms.visibility_i;
  }
  return eval;
}

// The facet that reflects wo into wi (on the same side, wi.z > 0). |wo + wi| = 2 wo.h.
Encounter reflection_encounter(vec3 wo, vec3 wi) {
  vec3 sum = wo + wi;
  float sum_length = sqrt(max(dot(sum, sum), 1e-30));
  Encounter facet;
  facet.h = sum / sum_length;
  facet.o_dot_h = 0.5 * sum_length;
  facet.i_dot_h = facet.o_dot_h;
  facet.is_transmitted = false;
  facet.is_refracted = false;
  facet.is_valid = true;
  return facet;
}

// The facet that joins any two directions.
Encounter encounter(Bsdf bsdf, vec3 wo, vec3 wi) {
  Encounter facet = reflection_encounter(wo, vec3(wi.xy, abs(wi.z)));
  if (!bsdf_has_transmission()) {
    facet.is_transmitted = wi.z <= 0.0;
    facet.is_valid = wi.z > 0.0;
    return facet;
  }
  if (wi.z > 0.0) return facet;
  facet.is_transmitted = true;
  if (bsdf.is_thin) return facet;
  facet.is_refracted = true;
  vec3 sum = wo * bsdf.inverse_eta + wi;  // along -+ h
  sum = sum.z < 0.0 ? -sum : sum;
  facet.h = sum * inversesqrt(max(dot(sum, sum), 1e-30));
  float o_dot_h = dot(wo, facet.h);
  float i_dot_h = dot(wi, facet.h);
  facet.is_valid = o_dot_h > 0.0 && i_dot_h < 0.0 && facet.h.z > 0.0;
  facet.o_dot_h = abs(o_dot_h);
  facet.i_dot_h = abs(i_dot_h);
  return facet;
}

// Value and pdfs of the non-delta lobes; zero where wo or wi lies in the surface.
BsdfEval bsdf_evaluate(Bsdf bsdf, vec3 wo, vec3 wi, uint transport) {
  BsdfEval eval = evaluate_lobes(bsdf_lobes(bsdf, wo, wi, encounter(bsdf, wo, wi), transport));
  if (!(wo.z > 0.0) || wi.z == 0.0) return BsdfEval(vec3(0.0), 0.0, 0.0);
  return eval;
}

// A direction chosen at a microfacet (or, if alpha is 0, at the surface itself).
struct FacetEvent {
  vec3 wi;
  Encounter facet;
  vec2 position;       // Fresnel position at the facet
  float probability;   // of this choice between reflection and transmission
};

// is_coat: of the clearcoat, which only reflects.
FacetEvent sample_facet_event(Bsdf bsdf, vec3 wo, bool is_coat, float u_choice, vec2 u) {
  vec2 alpha = is_coat ? bsdf.coat_alpha : bsdf.alpha;
  vec3 w = wo;  // in the frame of the lobe
  if (bsdf_has_coat_normal() && is_coat) w = to_coat(bsdf, wo);
  Facet visible = Facet(vec3(0.0, 0.0, 1.0), w.z);
  if (bsdf_has_rough()) {
    float u_rest = u_choice;
    Facet rough = sample_visible_normal(w, max(alpha, vec2(MIN_ALPHA)), u, u_rest);
    if (!bsdf_has_delta() || alpha.x > 0.0) {
      visible = rough;
      u_choice = u_rest;
    }
  }
  bool is_seen = true;
  if (bsdf_has_coat_normal() && is_coat) {
    is_seen = w.z > 0.0 && 2.0 * visible.w_dot_h * visible.h.z - w.z > 0.0;  // by the coat, as is what it sends on
    visible.h = from_coat(bsdf, visible.h);
  }
  FacetEvent event;
  float c = visible.w_dot_h;
  float g = refracted_g(c, bsdf.excess);
  event.position = fresnel_position(bsdf, c, g, bsdf.excess);
  event.probability = is_coat ? 1.0 : reflection_probability(bsdf, event.position, c);
  bool is_transmitted = bsdf_has_transmission() && !is_coat && u_choice >= event.probability;
  bool is_refracted = is_transmitted && !bsdf.is_thin;
  event.wi = 2.0 * c * visible.h - wo;
  bool is_valid = c > 0.0 && event.wi.z > 0.0 && is_seen;
  if (bsdf_has_transmission() && is_transmitted) {
    event.probability = 1.0 - event.probability;
    event.wi.z = -event.wi.z;
  }
  float i_dot_h = c;
  if (bsdf_has_transmission() && is_refracted) {
    // (c / eta - cos_t) h - wo / eta with c - g = -excess / (c + g)
    event.wi = -bsdf.inverse_eta * (wo + (bsdf.excess / max(c + g, MIN_COS)) * visible.h);
    i_dot_h = g * bsdf.inverse_eta;
    is_valid = c > 0.0 && g > 0.0 && event.wi.z < 0.0;
  }
  event.wi *= inversesqrt(dot(event.wi, event.wi));
  event.facet = Encounter(visible.h, max(c, MIN_COS), i_dot_h, is_transmitted, is_refracted, is_valid);
  return event;
}

// Which of the two microfacet lobes have a part in an event that one of them, a delta, has made. Both reflect to the same
// side if both are deltas and have the same normal.
bool base_is_in_event(Bsdf bsdf, bool is_coat) { return !(bsdf.alpha.x > 0.0) && !(is_coat && bsdf.is_coat_turned); }
bool coat_is_in_event(Bsdf bsdf, bool is_coat) { return !(bsdf.coat_alpha.x > 0.0) && (is_coat || !bsdf.is_coat_turned); }

// Puts a delta event of the base under the clearcoat; a lobe that has no part in it is left out.
// position_o, position_i: the base's Fresnel positions in both directions.
void add_coat_to_delta(Bsdf bsdf, vec3 wo, FacetEvent event, bool is_coat, uint transport, vec2 position_o, vec2 position_i,
                       inout BsdfEval eval) {
  bool is_transmitted = event.facet.is_transmitted;
  float coat_i = is_transmitted ? bsdf.coat_across : bsdf.coat;
  float cosine_o = coat_cosine(bsdf, wo), cosine_i = coat_cosine(bsdf, event.wi);
  vec2 chosen_o = coat_choice(bsdf, bsdf.coat, wo.z, cosine_o, position_o);
  vec2 chosen_i = coat_choice(bsdf, coat_i, abs(event.wi.z), cosine_i, position_i);
  float base = base_is_in_event(bsdf, is_coat) ? 1.0 : 0.0;
  eval.value *= base * coat_transmittance(bsdf.coat, abs(cosine_o)) * coat_transmittance(coat_i, abs(cosine_i));
  eval.pdf_forward *= base * chosen_o.y;
  eval.pdf_reverse *= base * chosen_i.y;
  if (is_transmitted || !coat_is_in_event(bsdf, is_coat)) return;
  // Of radiance the coat reflects its share, whatever the angle to the base; a light walk's factor is |cos_i| / |cos_o| of
  // that.
  float turned = 1.0;
  if (bsdf_has_coat_normal() && transport == TRANSPORT_IMPORTANCE) turned = abs(event.wi.z) / max(wo.z, MIN_COS);
  eval.value += coat_reflectance(bsdf.coat, abs(cosine_o)) * turned;
  eval.pdf_forward += chosen_o.x;
  eval.pdf_reverse += chosen_i.x;
}

// Factor and discrete probabilities of a delta event (alpha = 0, h = z). The reverse walk meets the surface at
// the same Fresnel position: the exact reflectance is that of both directions of a refracted pair.
BsdfEval evaluate_delta(Bsdf bsdf, vec3 wo, FacetEvent event, bool is_coat, float diffuse_o, uint transport) {
  float cos_i = abs(event.wi.z);
  float reflect_i = reflection_probability(bsdf, event.position, cos_i);
  // An event of the clearcoat brings the base's along; its own choice was not the base's.
  float reflect_o =
      bsdf_has_coat() ? reflection_probability(bsdf, event.position, wo.z) : event.probability;
  if (bsdf_has_coat() && event.facet.is_transmitted) reflect_o = event.probability;
  BsdfEval eval;
  float film_c = 0.0;
  if (bsdf_has_film()) film_c = film_cosine(bsdf, wo.z, refracted_g(wo.z, bsdf.excess), bsdf.excess);
  eval.value = interface_reflectance(bsdf, event.position, schlick_weight(wo.z));
  if (bsdf_has_film()) eval.value = film_reflectance(bsdf, eval.value, film_c, vec3(1.0), 1.0);
  if (bsdf_has_transmission() && event.facet.is_transmitted) {
    vec3 passed = dielectric_transmittance(bsdf, event.position);
    if (bsdf_has_film()) passed = film_refraction(bsdf, passed, film_c);
    eval.value = bsdf.transmission * passed;
    if (event.facet.is_refracted && transport == TRANSPORT_RADIANCE) eval.value *= bsdf.inverse_eta_squared;
    reflect_i = 1.0 - reflect_i;
  }
  eval.pdf_forward = (1.0 - diffuse_o) * reflect_o;
  float sheen_i = event.facet.is_transmitted ? bsdf.sheen.across : bsdf.sheen.here;
  eval.pdf_reverse = (1.0 - diffuse_probability(bsdf, cos_i, event.position, sheen_i)) * reflect_i;
  if (bsdf_has_sheen()) eval.value *= sheen_passage(bsdf.sheen, wo.z, cos_i, event.facet.is_transmitted).passed;
  if (bsdf_has_coat()) {
    vec2 position_o = event.position, position_i = event.position;
    if (is_coat && (has_rough_base() || (bsdf_has_coat_normal() && bsdf.is_coat_turned))) {
      position_o = base_passage(bsdf, wo.z, bsdf.excess).xy;
      position_i = base_passage(bsdf, cos_i, bsdf.excess).xy;
    }
    add_coat_to_delta(bsdf, wo, event, is_coat, transport, position_o, position_i, eval);
  }
  return eval;
}

const Encounter NO_ENCOUNTER = Encounter(vec3(0.0, 0.0, 1.0), 1.0, 1.0, false, false, false);
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
BsdfChoice bsdf_choose(Bsdf bsdf, vec3 wo, float u_lobe, vec2 u, uint transport) {
  vec2 s_o = vec2(0.0);
  if (bsdf_has_specular()) s_o = base_passage(bsdf, wo.z, bsdf.excess).xy;
  float sheen = 0.0;
  if (bsdf_has_sheen()) sheen = sheen_share(bsdf, wo.z, s_o, bsdf.sheen.here);
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
    float coat_o = bsdf_has_coat() ? coat_choice(bsdf, bsdf.coat, wo.z, coat_cosine(bsdf, wo), s_o).x : 0.0;
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
    choice.is_delta = !choice.is_diffuse && bsdf_has_delta() && (choice.is_coat ? bsdf.coat_alpha.x : bsdf.alpha.x) == 0.0;
    if (bsdf_has_delta()) choice.delta = evaluate_delta(bsdf, wo, event, choice.is_coat, diffuse_o, transport);
    choice.wi = choice.is_diffuse ? diffuse_wi : event.wi;
    if (!choice.is_diffuse) choice.facet = event.facet;
  }
  return choice;
}

// Value and pdfs of what was chosen.
BsdfSample bsdf_sampled(Bsdf bsdf, vec3 wo, BsdfChoice choice, uint transport) {
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
BsdfSample bsdf_sample(Bsdf bsdf, vec3 wo, float u_lobe, vec2 u, uint transport) {
  return bsdf_sampled(bsdf, wo, bsdf_choose(bsdf, wo, u_lobe, u, transport), transport);
}

// With a guide: how many times as likely as without it a camera walk goes the way it does.
float guided_ratio(Bsdf bsdf, vec3 wo, BsdfSample event) {
  if ((event.flags & BSDF_SAMPLE_DELTA) != 0u) return 1.0;
  bsdf.guide = vec2(0.0);
  BsdfEval plain = evaluate_lobes(bsdf_lobes(bsdf, wo, event.wi, event.facet, TRANSPORT_RADIANCE));
  return event.pdf_forward / max(plain.pdf_forward, 1e-30);
}

// Pdf of walking back over pdf forward of a sampled direction, both per solid angle of that direction. The delta
// distributions at the two ends of a smooth refraction differ by the Jacobian of Snell's law,
// n_i^2 cos_i dw_i = n_o^2 cos_o dw_o, as the densities of a rough one do by themselves.
float walk_pdf_ratio(Bsdf bsdf, vec3 wo, BsdfSample event) {
  float ratio = event.pdf_reverse / event.pdf_forward;
  const uint REFRACTED = BSDF_SAMPLE_DELTA | BSDF_SAMPLE_TRANSMITTED;
  if (!bsdf_has_delta() || !bsdf_has_transmission() || (event.flags & REFRACTED) != REFRACTED || bsdf.is_thin)
    return ratio;
  return ratio * bsdf.inverse_eta_squared * wo.z / max(abs(event.wi.z), MIN_COS);
}

#endif
