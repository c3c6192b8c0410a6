// The interface of the base: microfacet reflection (dielectric and metal), rough refraction (MATERIAL_VOLUME) or thin-walled
// transmission, and their smooth limits as delta events. What it does to light on its way to the diffuse lobe below is here too.
//
//   F_r = m F_metal + (1 - m) F_d              Schlick; exact dielectric, remapped by KHR_materials_specular
//   reflection    F_r(wo.h) D G2 / (4 cos_o cos_i)                                     Torrance and Sparrow
//   refraction    (1-m) t base (1 - F_d) D G2 |wo.h| |wi.h| eta^2 / (cos_o cos_i (wo.h + eta wi.h)^2)
//                 Walter et al. 2007, eq. 21; a radiance walk divides by eta^2
//   thin-walled   the reflection lobe mirrored at the surface, with (1-m) t base (1 - F_d)
// Under a thin film the Fresnel factors are those of iridescence.glsl, with --energy-compensation see lib/energy.glsl.
#ifndef REGULUS_LIB_LOBES_INTERFACE_GLSL
#define REGULUS_LIB_LOBES_INTERFACE_GLSL

#include "lib/bsdf_parameters.glsl"

// Position s of the exact reflectance between F_0 (0) and 1 (1), as (s, 1 - s), both accurate where small:
// F_d = f0 + s (f90 - f0).
vec2 fresnel_position(const Bsdf bsdf, float c, float g, float excess) {
  vec2 position = fresnel_dielectric_position(max(c, MIN_COS), g, excess, bsdf.fresnel_skew, bsdf.inverse_t0);
  return vec2(max(position.x, bsdf.min_position), min(position.y, 1.0 - bsdf.min_position));
}

// F_d and 1 - F_d.
vec3 dielectric_reflectance(const Bsdf bsdf, vec2 position) { return bsdf.f0 + position.x * (bsdf.f90 - bsdf.f0); }
vec3 dielectric_transmittance(const Bsdf bsdf, vec2 position) {
  return (1.0 - bsdf.f90) + position.y * (bsdf.f90 - bsdf.f0);
}

// F_r for Schlick weight k.
vec3 interface_reflectance(const Bsdf bsdf, vec2 position, float k) {
  return bsdf.metal + k * (bsdf.metallic - bsdf.metal) +
         (1.0 - bsdf.metallic) * dielectric_reflectance(bsdf, position);
}

// What the interface does to light between a direction with cosine c and the diffuse base, seen from the side to which
// `excess` belongs: the Fresnel position (s, 1 - s) of the light that it reflects, and how much it loses between facets.
vec3 base_passage(const Bsdf bsdf, float c, float excess) {
  vec2 position = fresnel_position(bsdf, c, refracted_g(c, excess), excess);
  float cover = excess < 0.0 ? bsdf.cover.y : bsdf.cover.x;
  if (!has_rough_base() || !(cover > 0.0)) return vec3(position, 0.0);
  vec2 albedo = cover_albedo(bsdf.energy, c, excess < 0.0);
  albedo.y = clamp(albedo.y, bsdf.min_position, 1.0);
  return vec3(mix(position, vec2(albedo.y, 1.0 - albedo.y), cover), cover * (1.0 - albedo.x));
}

// The share of light that reaches the base: 1 - E.
vec3 base_transmittance(const Bsdf bsdf, vec3 passage) {
  return dielectric_transmittance(bsdf, passage.xy) + passage.z * bsdf.f0;
}

// Mean of the smooth interface's transmittance over all directions of the side that the bsdf is seen from. On its dense side
// 1 - F_avg is 1 / eta^2 of that on the other: both count the same light.
vec3 mean_transmittance(const Bsdf bsdf, float ior) {
  float rest = 1.0 - fresnel_mean_position(abs(ior - 1.0) / (ior + 1.0));
  if (bsdf.excess < 0.0) rest /= bsdf.inverse_eta_squared;
  vec3 range = bsdf.f90 - bsdf.f0;
  return max((1.0 - bsdf.f90) + min(rest, 1.0 - bsdf.min_position) * range, vec3(1e-6));
}

float reflected_luminance(const Bsdf bsdf, vec2 position, float k) {
  return max(dot(bsdf.reflected_luminance, vec3(1.0, k, position.x)), 0.0);
}

float transmitted_luminance(const Bsdf bsdf, vec2 position) {
  return bsdf_has_transmission() ? bsdf.transmitted_luminance.x + position.y * bsdf.transmitted_luminance.y : 0.0;
}

// The Fresnel position by which a walk chooses between lobes at cosine c. A film reflects all light at grazing whatever lies
// below it, so there it is at least Schlick's weight.
vec2 choice_position(const Bsdf bsdf, vec2 position, float c) {
  if (!bsdf_has_film() || !(bsdf.film.strength > 0.0)) return position;
  return vec2(max(position.x, schlick_weight(c)), min(position.y, schlick_rest(c)));
}

// Probability of reflection at a facet: c is the cosine with the facet normal of the side it is seen from.
float reflection_probability(const Bsdf bsdf, vec2 position, float c) {
  if (!bsdf_has_transmission()) return 1.0;
  position = choice_position(bsdf, position, c);
  float reflected = reflected_luminance(bsdf, position, schlick_weight(c));
  float transmitted = transmitted_luminance(bsdf, position);
  return transmitted > 0.0 ? reflected / (reflected + transmitted) : 1.0;
}

// Cosine on the thin side of the interface: of a direction with cosine c that sees `excess`, whose refracted_g is g.
float film_cosine(const Bsdf bsdf, float c, float g, float excess) { return excess < 0.0 ? min(g * bsdf.inverse_eta, 1.0) : c; }

FilmBase film_base(const Bsdf bsdf) { return FilmBase(bsdf.metallic, bsdf.f0); }

// Mean Fresnel position over a rough surface's facets, given the position of a smooth surface in that direction.
vec2 rough_position(const Bsdf bsdf, float cosine, vec2 position) {
  if (bsdf.excess < 0.0) return position;  // from inside: where diffuse light matters little
  float more = energy_fresnel(bsdf.energy, cosine);
  return vec2(max(position.x + more, bsdf.min_position), min(position.y - more, 1.0 - bsdf.min_position));
}

// F_r as energy compensation scales it. film_c: cosine as film_reflectance takes it.
vec3 compensated_reflectance(const Bsdf bsdf, vec2 position, float k, float cosine, bool is_inside, float film_c) {
  float kept = bsdf.is_solid ? energy_scattered(bsdf.energy, cosine, is_inside) : energy_reflected(bsdf.energy, cosine);
  vec3 color = bsdf.metal / max(bsdf.metallic, 1e-6);
  vec3 metal_gain = metal_compensation(bsdf.energy, cosine, color);
  vec3 plain = (bsdf.metal + k * (bsdf.metallic - bsdf.metal)) * metal_gain +
               (1.0 - bsdf.metallic) * dielectric_reflectance(bsdf, position) / kept;
  return bsdf_has_film() ? film_reflectance(bsdf.film, film_base(bsdf), plain, film_c, metal_gain, 1.0 / kept) : plain;
}

// The Fresnel positions, and what the diffuse lobe gets, of both directions of a pair.
struct BasePassages {
  vec2 s_o, s_i;              // by which a walk chooses between lobes
  vec3 passage_o, passage_i;  // base_passage, with energy compensation by the rough surface's facets
};

BasePassages base_passages(const Bsdf bsdf, float cos_o, float cos_i, bool is_refracted) {
  BasePassages passages;
  // The reverse walk of a refraction starts on the other side of the interface.
  float excess_i = is_refracted ? -bsdf.excess * bsdf.inverse_eta_squared : bsdf.excess;
  passages.passage_o = base_passage(bsdf, cos_o, bsdf.excess);
  passages.passage_i = base_passage(bsdf, cos_i, excess_i);
  passages.s_o = passages.passage_o.xy;
  passages.s_i = passages.passage_i.xy;
  if (compensates_energy()) {
    passages.passage_o = vec3(rough_position(bsdf, cos_o, passages.s_o), 0.0);
    passages.passage_i = vec3(rough_position(bsdf, cos_i, passages.s_i), 0.0);
  }
  return passages;
}

// The interface's lobe at a pair of directions.
struct InterfaceLobe {
  MicrofacetLobe facets;
  vec3 color;             // Fresnel factor and colour
  float value_scale;      // 1 / eta^2 for refraction in a radiance walk
  bool is_camera_inside;  // the direction towards the camera lies on the denser side
};

const InterfaceLobe NO_INTERFACE_LOBE = InterfaceLobe(NO_MICROFACET_LOBE, vec3(0.0), 1.0, false);

MicrofacetTerms interface_terms(vec3 wo, vec3 wi, const Encounter facet, vec2 alpha) {
  vec3 wi_facet = facet.is_refracted ? wi : vec3(wi.xy, abs(wi.z));
  return microfacet_terms(wo, wi_facet, facet.h, facet.o_dot_h, facet.i_dot_h, max(alpha, vec2(MIN_ALPHA)), facet.is_refracted);
}

// chosen: probabilities of choosing the interface, not the diffuse lobe, from wo and from wi.
InterfaceLobe evaluate_interface(const Bsdf bsdf, vec3 wo, vec3 wi, const Encounter facet, vec2 chosen, uint transport) {
  InterfaceLobe lobe = NO_INTERFACE_LOBE;
  if (!bsdf_has_rough() && spec_regularization == REGULARIZATION_NONE) return lobe;
  // The camera's direction, in which energy is counted (lib/energy.glsl, lib/raised_light.glsl).
  bool is_turned = transport == TRANSPORT_IMPORTANCE;
  lobe.facets.camera_cosine = is_turned ? abs(wi.z) : wo.z;
  lobe.is_camera_inside = (bsdf.excess < 0.0) != (is_turned && facet.is_refracted);
  lobe.facets.terms = interface_terms(wo, wi, facet, bsdf.alpha);

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
    lobe.facets.density_scale = facet.o_dot_h * g / (bsdf.inverse_eta * max(square(difference), 1e-16));
    reverse_scale = bsdf.inverse_eta_squared;
    lobe.value_scale = transport == TRANSPORT_RADIANCE ? bsdf.inverse_eta_squared : 1.0;
  }
  bool is_rough = facet.is_valid && bsdf.alpha.x > 0.0;
  lobe.facets.density = is_rough ? facet_density(lobe.facets, lobe.facets.terms) : 0.0;
  float film_c = 0.0;
  if (bsdf_has_film()) film_c = film_cosine(bsdf, facet.o_dot_h, g, bsdf.excess);
  lobe.color = interface_reflectance(bsdf, s, k);
  if (bsdf_has_film()) lobe.color = film_reflectance(bsdf.film, film_base(bsdf), lobe.color, film_c, vec3(1.0), 1.0);
  if (compensates_energy())
    lobe.color = compensated_reflectance(bsdf, s, k, lobe.facets.camera_cosine, lobe.is_camera_inside, film_c);
  if (bsdf_has_transmission() && facet.is_transmitted) {
    vec3 passed = dielectric_transmittance(bsdf, s);
    if (bsdf_has_film()) passed = film_refraction(bsdf.film, film_base(bsdf), passed, film_c);
    lobe.color = bsdf.transmission * passed;
    if (compensates_energy())
      lobe.color /= bsdf.is_thin ? energy_reflected(bsdf.energy, lobe.facets.camera_cosine)
                                 : energy_scattered(bsdf.energy, lobe.facets.camera_cosine, lobe.is_camera_inside);
    reflect_o = 1.0 - reflect_o;
    reflect_i = 1.0 - reflect_i;
  }
  lobe.facets.choice_forward = chosen.x * reflect_o;
  lobe.facets.choice_reverse = chosen.y * reflect_i * reverse_scale;
  return lobe;
}

vec3 interface_value(const InterfaceLobe lobe) { return lobe.color * (facet_scattering(lobe.facets) * lobe.value_scale); }

// The facet that joins any two directions.
Encounter encounter(const Bsdf bsdf, vec3 wo, vec3 wi) {
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

// A direction chosen at a microfacet (or, if alpha is 0, at the surface itself).
struct FacetEvent {
  vec3 wi;
  Encounter facet;
  vec2 position;       // Fresnel position at the facet
  float probability;   // of this choice between reflection and transmission
};

// At a visible facet. reflects: without a choice, and only if is_seen; that is the clearcoat's event.
FacetEvent facet_event(const Bsdf bsdf, vec3 wo, const Facet visible, float u_choice, bool reflects, bool is_seen) {
  FacetEvent event;
  float c = visible.w_dot_h;
  float g = refracted_g(c, bsdf.excess);
  event.position = fresnel_position(bsdf, c, g, bsdf.excess);
  event.probability = reflects ? 1.0 : reflection_probability(bsdf, event.position, c);
  bool is_transmitted = bsdf_has_transmission() && !reflects && u_choice >= event.probability;
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

// Factor and discrete probabilities of a delta event (alpha = 0, h = z). The reverse walk meets the surface at
// the same Fresnel position: the exact reflectance is that of both directions of a refracted pair. chosen: probabilities of
// choosing the interface, from wo and from wi; reflect_o: of this choice between reflection and transmission.
BsdfEval evaluate_interface_delta(const Bsdf bsdf, vec3 wo, const FacetEvent event, vec2 chosen, float reflect_o, uint transport) {
  float reflect_i = reflection_probability(bsdf, event.position, abs(event.wi.z));
  BsdfEval eval;
  float film_c = 0.0;
  if (bsdf_has_film()) film_c = film_cosine(bsdf, wo.z, refracted_g(wo.z, bsdf.excess), bsdf.excess);
  eval.value = interface_reflectance(bsdf, event.position, schlick_weight(wo.z));
  if (bsdf_has_film()) eval.value = film_reflectance(bsdf.film, film_base(bsdf), eval.value, film_c, vec3(1.0), 1.0);
  if (bsdf_has_transmission() && event.facet.is_transmitted) {
    vec3 passed = dielectric_transmittance(bsdf, event.position);
    if (bsdf_has_film()) passed = film_refraction(bsdf.film, film_base(bsdf), passed, film_c);
    eval.value = bsdf.transmission * passed;
    if (event.facet.is_refracted && transport == TRANSPORT_RADIANCE) eval.value *= bsdf.inverse_eta_squared;
    reflect_i = 1.0 - reflect_i;
  }
  eval.pdf_forward = chosen.x * reflect_o;
  eval.pdf_reverse = chosen.y * reflect_i;
  return eval;
}

// Regularization: alpha^ of the interface where directions meet at this facet.
vec2 raised_interface_alpha(const Bsdf bsdf, const Encounter facet, const Regularization regularization) {
  float alpha_tau = bsdf_has_transmission() && facet.is_refracted
      ? refraction_alpha(bsdf.inverse_eta, bsdf.excess, regularization.tau)
      : reflection_alpha(regularization.tau, facet.o_dot_h);
  return raised_alpha(bsdf.alpha, alpha_tau, regularization);
}

RaisedLobe raise_interface(const Bsdf bsdf, const InterfaceLobe lobe, vec3 wo, vec3 wi, const Encounter facet, const Regularization regularization) {
  RaisedLobe raised;
  raised.alpha = raised_interface_alpha(bsdf, facet, regularization);
  MicrofacetTerms terms = interface_terms(wo, wi, facet, raised.alpha);
  raised.density = facet.is_valid ? facet_density(lobe.facets, terms) : 0.0;
  raised.shadowing = terms.shadowing;
  if (bsdf_has_transmission() && facet.is_refracted)
    raised.kept =
        refraction_kept(bsdf.energy, bsdf.alpha, raised.alpha, lobe.facets.camera_cosine, lobe.is_camera_inside);
  else
    raised.kept = reflection_kept(bsdf.energy, bsdf.alpha, raised.alpha, lobe.facets.camera_cosine);
  return raised;
}

vec3 raised_interface_value(const InterfaceLobe lobe, const RaisedLobe raised) {
  float density = raised.alpha.x > 0.0 ? raised.density : 0.0;
  return lobe.color * (density * (raised.shadowing * raised.kept) * lobe.value_scale);
}

// The luminance of the same as weights use it, without the eta^2 of radiance.
float raised_interface_in_weights(const Bsdf bsdf, const InterfaceLobe lobe, const RaisedLobe raised, const Encounter facet) {
  float blended = blended_density(lobe.facets, raised, bsdf.alpha, facet.is_valid && raised.alpha.x > 0.0);
  return lobe.facets.weight * blended * (raised.shadowing * raised.kept);
}

// Luminance of the raised lobe, and the same times its largest value, for sampler quality (lib/history.glsl).
vec2 bounded_interface(const Bsdf bsdf, const InterfaceLobe lobe, const RaisedLobe raised, const Encounter facet) {
  float value = 0.0;
  if (facet.is_valid) value = lobe.facets.weight * raised.density * raised.shadowing * raised.kept;
  float peak_scale = 0.25;
  if (bsdf_has_transmission() && facet.is_refracted) {
    float eta = 1.0 / bsdf.inverse_eta;
    peak_scale = square(max(eta, 1.0) * (eta + 1.0) / max(abs(bsdf.excess), 1e-6));
  }
  return vec2(value, value * facet_peak(peak_scale, bsdf.alpha, 1e-10));
}

// Value over pdf of a direction that the lobe's own facets have given, cosine included: the density cancels. probability: of
// its choice between reflection and transmission.
vec3 interface_over_pdf(const InterfaceLobe lobe, float probability, vec3 wi) {
  return lobe.color * (lobe.facets.terms.shadowing * lobe.value_scale * abs(wi.z) /
                       max(probability * lobe.facets.terms.visibility_o, 1e-30));
}

#endif
