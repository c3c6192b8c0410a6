// The diffuse lobe under the base's interface, and the sheen that is drawn as a part of it:
//   (1-m)(1-t) base / pi (1 - E(wo)) (1 - E(wi)) / (1 - E_avg)      E: F_d(cos), of rough interfaces
//   their own albedo (lib/cover.glsl)
// Its density stays below any useful tau, so that regularization leaves it as it is.
#ifndef REGULUS_LIB_LOBES_DIFFUSE_GLSL
#define REGULUS_LIB_LOBES_DIFFUSE_GLSL

#include "lib/lobes/interface.glsl"

// Variance of the angles that the lobe leaves (docs/mathematics.md 5): the diffusion 2 sqrt(variance) is 1 there.
const float MAX_ANGULAR_VARIANCE = 0.25;

bool has_diffuse(const Bsdf bsdf) { return max(bsdf.diffuse.r, max(bsdf.diffuse.g, bsdf.diffuse.b)) > 0.0; }

// Luminance of what the lobe reflects, by the Fresnel position of choices.
float diffuse_luminance(const Bsdf bsdf, vec2 position) { return bsdf.diffuse_luminance.x + position.y * bsdf.diffuse_luminance.y; }

// Luminance of what base and interface reflect and transmit of light from a direction with cosine c and that Fresnel position.
float base_luminance(const Bsdf bsdf, float c, vec2 position) {
  position = choice_position(bsdf, position, c);
  return diffuse_luminance(bsdf, position) + reflected_luminance(bsdf, position, schlick_weight(c)) +
         transmitted_luminance(bsdf, position);
}

// Probability of sampling the diffuse lobe, sheen included, from a direction with cosine c and that Fresnel position, on a
// side with sheen of this largest component.
float diffuse_probability(const Bsdf bsdf, float c, vec2 position, float sheen) {
  if (!bsdf_has_specular()) return 1.0;
  position = choice_position(bsdf, position, c);
  float diffuse = diffuse_luminance(bsdf, position);
  float specular = reflected_luminance(bsdf, position, schlick_weight(c)) + transmitted_luminance(bsdf, position);
  if (bsdf_has_sheen()) {
    SheenLayers layers = sheen_layers(bsdf.sheen, c, sheen, diffuse);
    diffuse = layers.above + layers.below;
    specular *= layers.passed;
  }
  return specular > 0.0 ? diffuse / (diffuse + specular) : 1.0;
}

// Share of sheen among the diffuse lobe's samples, likewise.
float diffuse_sheen(const Bsdf bsdf, float c, vec2 position, float sheen) {
  if (!bsdf_has_sheen() || !(sheen > 0.0)) return 0.0;
  return sheen_share(sheen_layers(bsdf.sheen, c, sheen, diffuse_luminance(bsdf, choice_position(bsdf, position, c))));
}

// Share of the diffuse lobe's samples that are drawn, from inside a solid, from the cone in which the interface lets light
// out: its sine squared is 1 / n^2, and beyond it only what F_90 and facets leave passes. With samples from all directions
// alone, weights would vary by n^2 at every bounce, without bound along a path.
float cone_share(const Bsdf bsdf) {
  if (!bsdf_has_transmission() || !(bsdf.excess < 0.0)) return 0.0;
  float in_cone = (bsdf.f90 - dot(bsdf.f0, LUMINANCE)) / bsdf.inverse_eta_squared;
  return in_cone > 0.0 ? (1.0 - bsdf.cover.x) * (in_cone / (in_cone + (1.0 - bsdf.f90))) : 0.0;
}

// Density of a direction with cosine c among the diffuse lobe's samples, times pi. sheen: the share above.
float diffuse_density(const Bsdf bsdf, float c, float sheen) {
  if (bsdf_has_sheen() && sheen > 0.0) return density_with_sheen(c, sheen);
  float share = cone_share(bsdf);
  if (!(share > 0.0)) return c;
  bool is_in_cone = (1.0 - c) * (1.0 + c) * bsdf.inverse_eta_squared < 1.0;
  return c * (1.0 - share + (is_in_cone ? share * bsdf.inverse_eta_squared : 0.0));
}

// The same where a guide takes its share: of the direction towards the light, on the lit side. density: times pi.
float guided_density(const Bsdf bsdf, float density) { return mix(density, PI * bsdf.guide.y, bsdf.guide.x); }

vec3 sample_diffuse(const Bsdf bsdf, vec2 u, float sheen) {
  if (bsdf_has_sheen() && sheen > 0.0) return sample_with_sheen(u, sheen);
  float share = cone_share(bsdf);
  if (!(share > 0.0)) return sample_cosine_hemisphere(u);
  bool is_in_cone = u.x < share;
  u.x = is_in_cone ? u.x / share : (u.x - share) / (1.0 - share);
  vec3 w = sample_cosine_hemisphere(min(u, vec2(ONE_MINUS_ULP)));
  if (!is_in_cone) return w;
  w.xy *= inversesqrt(bsdf.inverse_eta_squared);
  return vec3(w.xy, sqrt(1.0 - dot(w.xy, w.xy)));
}

// Value of the lobe under a film, times pi, by that without it.
vec3 film_diffuse(const Bsdf bsdf, vec3 plain, float cos_o, float cos_i) {
  if (!(bsdf.film.strength > 0.0)) return plain;
  bool is_inside = bsdf.excess < 0.0;
  float passed_o = film_passage(bsdf.film, bsdf.f0, film_cosine(bsdf, cos_o, refracted_g(cos_o, bsdf.excess), bsdf.excess),
                                bsdf.alpha, is_inside);
  float passed_i = film_passage(bsdf.film, bsdf.f0, film_cosine(bsdf, cos_i, refracted_g(cos_i, bsdf.excess), bsdf.excess),
                                bsdf.alpha, is_inside);
  return blend(plain, bsdf.film.albedo * min(passed_o, passed_i), bsdf.film.strength);
}

// Where there is nothing but the diffuse lobe. same_side: 1 / pi where it sees both directions, otherwise 0.
BsdfEval evaluate_bare_diffuse(const Bsdf bsdf, float cos_o, float cos_i, float same_side, uint transport) {
  BsdfEval lobe;
  lobe.value = bsdf.diffuse * same_side;
  lobe.pdf_forward = cos_i * same_side;
  lobe.pdf_reverse = cos_o * same_side;
  if (has_walk_guide()) {
    if (transport == TRANSPORT_IMPORTANCE) lobe.pdf_reverse = guided_density(bsdf, cos_o) * same_side;
    else lobe.pdf_forward = guided_density(bsdf, cos_i) * same_side;
  }
  return lobe;
}

// Under the interface, without sheen's own value. chosen: diffuse_probability from wo and from wi; sheen: its largest
// component on the side of each.
BsdfEval evaluate_diffuse(const Bsdf bsdf, float cos_o, float cos_i, const BasePassages passages, float same_side, vec2 chosen, vec2 sheen,
                          uint transport) {
  BsdfEval lobe;
  lobe.value = bsdf.diffuse * base_transmittance(bsdf, passages.passage_o) * base_transmittance(bsdf, passages.passage_i) *
               same_side;
  if (bsdf_has_film() && same_side > 0.0) lobe.value = film_diffuse(bsdf, lobe.value * PI, cos_o, cos_i) * INV_PI;
  float density_i = diffuse_density(bsdf, cos_i, diffuse_sheen(bsdf, cos_o, passages.s_o, sheen.x));
  float density_o = diffuse_density(bsdf, cos_o, diffuse_sheen(bsdf, cos_i, passages.s_i, sheen.y));
  if (has_walk_guide()) {
    if (transport == TRANSPORT_IMPORTANCE) density_o = guided_density(bsdf, density_o);
    else density_i = guided_density(bsdf, density_i);
  }
  lobe.pdf_forward = chosen.x * density_i * same_side;
  lobe.pdf_reverse = chosen.y * density_o * same_side;
  return lobe;
}

#endif
