// A material at a point, in the form that the scattering functions need (lib/bsdf.glsl has the model): reflectances from
// both sides of the interface, and how a walk chooses between lobes.
#ifndef REGULUS_LIB_BSDF_PARAMETERS_GLSL
#define REGULUS_LIB_BSDF_PARAMETERS_GLSL

#include "lib/cover.glsl"
#include "lib/fresnel.glsl"
#include "lib/lobes/iridescence.glsl"
#include "lib/lobes/sheen.glsl"
#include "lib/ndf.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"
#include "lib/walk_guide.glsl"

// What this pipeline can meet. Macros of one comparison each, because a branch on such a comparison is resolved before the
// driver sees the module (host/gpu/specialize.hpp), while a branch on the result of a function is not; and because
// glslang 12 puts constants that are derived from derived specialization constants into the wrong order.
#define bsdf_has_specular() (spec_material_class != MATERIAL_CLASS_DIFFUSE)
#define bsdf_has_transmission() (spec_material_class == MATERIAL_CLASS_TRANSMISSIVE)
#define bsdf_has_rough() (spec_material_class * (spec_features & FEATURE_ROUGH_SPECULAR) != 0u)
#define bsdf_has_coat() (spec_material_class * (spec_features & FEATURE_CLEARCOAT) != 0u)
#define bsdf_has_coat_normal() (spec_material_class * (spec_features & FEATURE_COAT_NORMALS) != 0u)
#define bsdf_has_delta() (spec_material_class * (spec_features & FEATURE_DELTA_SPECULAR) != 0u)

#define bsdf_has_relief() ((spec_features & FEATURE_NORMAL_MAPS) != 0u)

#define compensates_energy() \
  (spec_energy_compensation * spec_material_class * (spec_features & FEATURE_ROUGH_SPECULAR) != 0u)
// Lobes are raised, and keep their light (lib/raised_light.glsl).
#define raises_lobes() ((spec_regularization & REGULARIZATION_ROUGHNESS) * spec_material_class != 0u)
#define has_rough_base() \
  ((1u - spec_energy_compensation) * spec_material_class * (spec_features & FEATURE_ROUGH_BASE) != 0u)

// Any of the three, without `||`, whose result glslang 12 would put into the wrong order.
#define uses_energy_tables()                                                                                      \
  (spec_material_class * (spec_energy_compensation * (spec_features & FEATURE_ROUGH_SPECULAR) +                   \
                          (1u - spec_energy_compensation) * (spec_features & FEATURE_ROUGH_BASE) +                \
                          (spec_regularization & REGULARIZATION_ROUGHNESS)) != 0u)

// A lobe that is not a delta is evaluated with at least this alpha.
const float MIN_ALPHA = 1e-7;
// The factor that a microfacet lobe's value and pdfs share is kept below this. Their quotient stays exact.
const float MAX_DENSITY = 1e23;
// Least alpha across the direction of an anisotropic material.
const float MIN_ANISOTROPIC_ALPHA = 1e-3;
const float COAT_F0 = 0.04;  // index 1.5
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);  // Rec. 709

// A material at a point, seen from one side.
struct Bsdf {
  vec3 diffuse;          // (1-m)(1-t) base / (1 - F_d,avg)
  vec3 metal;            // m base
  float metallic;        // m
  vec3 f0;               // F_d at normal incidence
  float f90;             // F_d at grazing
  vec3 transmission;     // (1-m) t base
  vec2 alpha;            // 0: delta
  float excess;          // eta^2 - 1
  float inverse_eta_squared;
  float inverse_eta;
  float fresnel_skew;    // argument `skew` of fresnel_dielectric_position
  float inverse_t0;      // argument of the same: 1 / (exact transmittance at normal incidence)
  float min_position;    // lowest Fresnel position that keeps F_d >= 0
  // Luminances as linear functions of position s and Schlick weight k: diffuse d.x + (1 - s) d.y,
  // reflected r.x + k r.y + s r.z, transmitted t.x + (1 - s) t.y.
  vec2 diffuse_luminance;
  vec3 reflected_luminance;
  vec2 transmitted_luminance;
  bool is_thin;
  float coat;            // clearcoat weight on the side of wo
  float coat_across;     // clearcoat weight on the other side, for transmitted light
  vec2 coat_alpha;       // 0: delta
  vec3 coat_normal;      // local, on the side of wo; only with bsdf_has_coat_normal()
  bool is_coat_turned;   // coat_normal is not z (MATERIAL_COAT_NORMAL); only with bsdf_has_coat_normal()
  EnergyTables energy;   // only with compensates_energy(), has_rough_base() or raises_lobes()
  bool is_solid;         // the material refracts; only with compensates_energy()
  vec3 geometric_normal; // local, on the side of wo; z where no relief shadows the base; only with bsdf_has_relief()
  Sheen sheen;           // only with bsdf_has_sheen()
  Film film;             // only with bsdf_has_film()
  vec2 cover;            // share of the rough interface's own albedo in what the base gets, from outside and from inside a
                         // solid (lib/cover.glsl)
  vec2 guide;            // of camera walks, for one direction towards the light: the share of the diffuse lobe's samples that
                         // go by the guide, and its density there; only with has_walk_guide()
};

// True if the normals disagree about w, a direction towards the light as the bsdf sees it, and the relief of a normal map
// shadows itself: the diffuse lobe is dark then.
bool is_in_relief_shadow(Bsdf bsdf, vec3 w) { return bsdf_has_relief() && dot(w, bsdf.geometric_normal) * w.z < 0.0; }

// Position s of the exact reflectance between F_0 (0) and 1 (1), as (s, 1 - s), both accurate where small:
// F_d = f0 + s (f90 - f0).
vec2 fresnel_position(Bsdf bsdf, float c, float g, float excess) {
  vec2 position = fresnel_dielectric_position(max(c, MIN_COS), g, excess, bsdf.fresnel_skew, bsdf.inverse_t0);
  return vec2(max(position.x, bsdf.min_position), min(position.y, 1.0 - bsdf.min_position));
}

// F_d and 1 - F_d.
vec3 dielectric_reflectance(Bsdf bsdf, vec2 position) { return bsdf.f0 + position.x * (bsdf.f90 - bsdf.f0); }
vec3 dielectric_transmittance(Bsdf bsdf, vec2 position) {
  return (1.0 - bsdf.f90) + position.y * (bsdf.f90 - bsdf.f0);
}

// F_r for Schlick weight k.
vec3 interface_reflectance(Bsdf bsdf, vec2 position, float k) {
  return bsdf.metal + k * (bsdf.metallic - bsdf.metal) +
         (1.0 - bsdf.metallic) * dielectric_reflectance(bsdf, position);
}

// What the interface does to light between a direction with cosine c and the diffuse base, seen from the side to which
// `excess` belongs: the Fresnel position (s, 1 - s) of the light that it reflects, and how much it loses between facets.
vec3 base_passage(Bsdf bsdf, float c, float excess) {
  vec2 position = fresnel_position(bsdf, c, refracted_g(c, excess), excess);
  float cover = excess < 0.0 ? bsdf.cover.y : bsdf.cover.x;
  if (!has_rough_base() || !(cover > 0.0)) return vec3(position, 0.0);
  vec2 albedo = cover_albedo(bsdf.energy, c, excess < 0.0);
  albedo.y = clamp(albedo.y, bsdf.min_position, 1.0);
  return vec3(mix(position, vec2(albedo.y, 1.0 - albedo.y), cover), cover * (1.0 - albedo.x));
}

// The share of light that reaches the base: 1 - E.
vec3 base_transmittance(Bsdf bsdf, vec3 passage) {
  return dielectric_transmittance(bsdf, passage.xy) + passage.z * bsdf.f0;
}

// Mean of the smooth interface's transmittance over all directions of the side that the bsdf is seen from. On its dense side
// 1 - F_avg is 1 / eta^2 of that on the other: both count the same light.
vec3 mean_transmittance(Bsdf bsdf, float ior) {
  float rest = 1.0 - fresnel_mean_position(abs(ior - 1.0) / (ior + 1.0));
  if (bsdf.excess < 0.0) rest /= bsdf.inverse_eta_squared;
  vec3 range = bsdf.f90 - bsdf.f0;
  return max((1.0 - bsdf.f90) + min(rest, 1.0 - bsdf.min_position) * range, vec3(1e-6));
}

float reflected_luminance(Bsdf bsdf, vec2 position, float k) {
  return max(dot(bsdf.reflected_luminance, vec3(1.0, k, position.x)), 0.0);
}

float transmitted_luminance(Bsdf bsdf, vec2 position) {
  return bsdf_has_transmission() ? bsdf.transmitted_luminance.x + position.y * bsdf.transmitted_luminance.y : 0.0;
}

// The Fresnel position by which a walk chooses between lobes at cosine c. A film reflects all light at grazing whatever lies
// below it, so there it is at least Schlick's weight.
vec2 choice_position(Bsdf bsdf, vec2 position, float c) {
  if (!bsdf_has_film() || !(bsdf.film.strength > 0.0)) return position;
  return vec2(max(position.x, schlick_weight(c)), min(position.y, schlick_rest(c)));
}

// A direction in the clearcoat's own frame: z is its normal on the side of wo.
vec3 to_coat(Bsdf bsdf, vec3 w) {
  if (!bsdf_has_coat_normal()) return w;
  vec3 tangent, bitangent;
  orthonormal_basis(bsdf.coat_normal, tangent, bitangent);
  return bsdf.is_coat_turned ? vec3(dot(w, tangent), dot(w, bitangent), dot(w, bsdf.coat_normal)) : w;
}

vec3 from_coat(Bsdf bsdf, vec3 w) {
  if (!bsdf_has_coat_normal()) return w;
  vec3 tangent, bitangent;
  orthonormal_basis(bsdf.coat_normal, tangent, bitangent);
  return bsdf.is_coat_turned ? w.x * tangent + w.y * bitangent + w.z * bsdf.coat_normal : w;
}

// Cosine of w with the clearcoat's normal on w's own side of the surface. Where it is not positive, the coat's lobe does not
// see w.
float coat_cosine(Bsdf bsdf, vec3 w) {
  if (!bsdf_has_coat_normal()) return abs(w.z);
  float cosine = bsdf.is_coat_turned ? dot(w, bsdf.coat_normal) : w.z;
  return clamp(w.z < 0.0 ? -cosine : cosine, -1.0, 1.0);
}

// Share of light that a clearcoat of this weight reflects at cosine c.
float coat_reflectance(float weight, float c) { return weight * (COAT_F0 + (1.0 - COAT_F0) * schlick_weight(c)); }

// The share that it lets pass, accurate also at grazing, where that is little.
float coat_transmittance(float weight, float c) {
  return (1.0 - weight) + weight * (1.0 - COAT_F0) * schlick_rest(c);
}

// Probabilities of sampling the coat and the base, in proportion to what each would reflect or transmit. The direction has
// cosine c (coat_c: coat_cosine) and the base's Fresnel position `position`, on a side with a coat of this weight.
vec2 coat_choice(Bsdf bsdf, float weight, float c, float coat_c, vec2 position) {
  float coat = coat_c > 0.0 ? coat_reflectance(weight, coat_c) : 0.0;
  position = choice_position(bsdf, position, c);
  float base = bsdf.diffuse_luminance.x + position.y * bsdf.diffuse_luminance.y +
               reflected_luminance(bsdf, position, schlick_weight(c)) + transmitted_luminance(bsdf, position);
  float below = coat_transmittance(weight, abs(coat_c)) * max(base, 0.0);
  return coat > 0.0 ? vec2(coat, below) / (coat + below) : vec2(0.0, 1.0);
}

// What becomes of light from a direction with cosine c and that Fresnel position, on a side where the largest component of
// the sheen's colour is this.
struct SheenLayers {
  float above;   // luminance of what sheen reflects
  float below;   // luminance of what the diffuse lobe under it reflects
  float passed;  // factor on everything under the sheen
};

SheenLayers sheen_layers(Bsdf bsdf, float c, vec2 position, float largest) {
  float albedo = min(sheen_albedo(bsdf.sheen, c, largest), 1.0);
  float passed = 1.0 - largest * albedo;
  position = choice_position(bsdf, position, c);
  float diffuse = bsdf.diffuse_luminance.x + position.y * bsdf.diffuse_luminance.y;
  return SheenLayers(albedo * dot(bsdf.sheen.color, LUMINANCE), passed * max(diffuse, 0.0), passed);
}

// Probability of sampling the diffuse lobe, sheen included, from a direction with cosine c and that Fresnel position, on a
// side with sheen of this largest component.
float diffuse_probability(Bsdf bsdf, float c, vec2 position, float sheen) {
  if (!bsdf_has_specular()) return 1.0;
  position = choice_position(bsdf, position, c);
  float diffuse = bsdf.diffuse_luminance.x + position.y * bsdf.diffuse_luminance.y;
  float specular = reflected_luminance(bsdf, position, schlick_weight(c)) + transmitted_luminance(bsdf, position);
  if (bsdf_has_sheen()) {
    SheenLayers layers = sheen_layers(bsdf, c, position, sheen);
    diffuse = layers.above + layers.below;
    specular *= layers.passed;
  }
  return specular > 0.0 ? diffuse / (diffuse + specular) : 1.0;
}

// Probability of reflection at a facet: c is the cosine with the facet normal of the side it is seen from.
float reflection_probability(Bsdf bsdf, vec2 position, float c) {
  if (!bsdf_has_transmission()) return 1.0;
  position = choice_position(bsdf, position, c);
  float reflected = reflected_luminance(bsdf, position, schlick_weight(c));
  float transmitted = transmitted_luminance(bsdf, position);
  return transmitted > 0.0 ? reflected / (reflected + transmitted) : 1.0;
}

// Cosine on the thin side of the interface: of a direction with cosine c that sees `excess`, whose refracted_g is g.
float film_cosine(Bsdf bsdf, float c, float g, float excess) { return excess < 0.0 ? min(g * bsdf.inverse_eta, 1.0) : c; }

// F_r under the film. plain: without it; *_gain: of energy compensation.
vec3 film_reflectance(Bsdf bsdf, vec3 plain, float c, vec3 metal_gain, float dielectric_gain) {
  if (!(bsdf.film.strength > 0.0)) return plain;
  vec3 covered = vec3(0.0);
  if (bsdf.metallic > 0.0) covered += bsdf.metallic * metal_gain * (1.0 - film_transmittance(bsdf.film, bsdf.film.metal, c));
  if (bsdf.metallic < 1.0)
    covered += (1.0 - bsdf.metallic) * dielectric_gain * (1.0 - film_transmittance(bsdf.film, bsdf.f0, c));
  return blend(plain, covered, bsdf.film.strength);
}

// What passes into the dielectric, for 1 - F_d without the film.
vec3 film_refraction(Bsdf bsdf, vec3 plain, float c) {
  if (!(bsdf.film.strength > 0.0)) return plain;
  return blend(plain, vec3(least_component(film_transmittance(bsdf.film, bsdf.f0, c))), bsdf.film.strength);
}

// Value of the diffuse lobe, times pi.
vec3 film_diffuse(Bsdf bsdf, vec3 plain, float cos_o, float cos_i) {
  if (!(bsdf.film.strength > 0.0)) return plain;
  bool is_inside = bsdf.excess < 0.0;
  float passed_o = film_passage(bsdf.film, bsdf.f0, film_cosine(bsdf, cos_o, refracted_g(cos_o, bsdf.excess), bsdf.excess),
                                bsdf.alpha, is_inside);
  float passed_i = film_passage(bsdf.film, bsdf.f0, film_cosine(bsdf, cos_i, refracted_g(cos_i, bsdf.excess), bsdf.excess),
                                bsdf.alpha, is_inside);
  return blend(plain, bsdf.film.albedo * min(passed_o, passed_i), bsdf.film.strength);
}

// Puts the film on a bsdf. A walk chooses between lobes by what the film reflects on average over thicknesses: at normal
// incidence, and by the Fresnel position from there to all of the light at grazing.
void add_film(Material material, vec3 albedo, inout Bsdf bsdf) {
  bsdf.film = Film(material.iridescence, max(material.iridescence_ior, 1.0), material.iridescence_thickness.y,
                   material.base_color, albedo);
  if (!(bsdf.film.strength > 0.0)) return;
  float metal = dot(film_mean(bsdf.film, bsdf.film.metal), LUMINANCE);
  vec3 mean = film_mean(bsdf.film, bsdf.f0);
  float dielectric = dot(mean, LUMINANCE);
  float least = least_component(film_faces(bsdf.film, bsdf.f0, 1.0).passed);
  float rest = 1.0 - bsdf.metallic;
  vec3 reflected = vec3(bsdf.metallic * metal + rest * dielectric, bsdf.metallic * (1.0 - metal), rest * (1.0 - dielectric));
  float strength = bsdf.film.strength;
  bsdf.reflected_luminance = blend(bsdf.reflected_luminance, reflected, strength);
  bsdf.diffuse_luminance *= 1.0 - strength;
  bsdf.diffuse_luminance.y += strength * least * dot(albedo, LUMINANCE);
  bsdf.transmitted_luminance *= 1.0 - strength;
  bsdf.transmitted_luminance.y += strength * least * dot(bsdf.transmission, LUMINANCE);
}

// The bsdf of a material whose textures have been applied, seen from its front or back face.
Bsdf make_bsdf(Material material, bool is_front) {
  Bsdf bsdf;
  bsdf.geometric_normal = vec3(0.0, 0.0, 1.0);  // a caller who knows another sets it
  bsdf.guide = vec2(0.0);                       // likewise
  vec3 dielectric = (1.0 - material.metallic) * material.base_color;
  if (!bsdf_has_specular()) {
    bsdf.diffuse = dielectric;
    bsdf.alpha = vec2(0.0);
    bsdf.coat = 0.0;
    bsdf.coat_across = 0.0;
    bsdf.coat_alpha = vec2(0.0);
    bsdf.coat_normal = vec3(0.0, 0.0, 1.0);
    bsdf.is_coat_turned = false;
    bsdf.sheen = NO_SHEEN;
    bsdf.cover = vec2(0.0);
    return bsdf;
  }
  float transmission = bsdf_has_transmission() ? material.transmission : 0.0;
  bsdf.metallic = material.metallic;
  bsdf.metal = material.metallic * material.base_color;
  bsdf.transmission = transmission * dielectric;
  bsdf.is_thin = (material.flags & MATERIAL_VOLUME) == 0u;

  float alpha = material.roughness * material.roughness;
  bsdf.alpha = vec2(material.roughness > 0.0 ? max(alpha, MIN_ALPHA) : 0.0);
  if ((spec_features & FEATURE_ANISOTROPY) != 0u && material.anisotropy > 0.0)
    bsdf.alpha = max(vec2(mix(alpha, 1.0, square(material.anisotropy)), alpha), vec2(MIN_ANISOTROPIC_ALPHA));
  // Solids are coated on their outside, everything else on both sides.
  bool is_solid = bsdf_has_transmission() && transmission > 0.0 && !bsdf.is_thin;
  bsdf.coat = is_solid && !is_front ? 0.0 : material.clearcoat;
  bsdf.coat_across = is_solid && is_front ? 0.0 : material.clearcoat;
  float coat_alpha = square(material.clearcoat_roughness);
  bsdf.coat_alpha = vec2(material.clearcoat_roughness > 0.0 ? max(coat_alpha, MIN_ALPHA) : 0.0);

  bsdf.coat_normal = vec3(0.0, 0.0, 1.0);  // a caller who knows another sets it
  bsdf.is_coat_turned = (material.flags & MATERIAL_COAT_NORMAL) != 0u;

  bsdf.sheen = NO_SHEEN;  // the caller, who has the table, adds it

  // eta^2 - 1 by factors: 1 / ior - 1 rounded first would lose its digits for ior near 1.
  float ior = material.ior;
  float excess = (ior - 1.0) * (ior + 1.0);
  bool is_inside = bsdf_has_transmission() && transmission > 0.0 && !bsdf.is_thin && !is_front;
  bsdf.excess = is_inside ? -excess / (ior * ior) : excess;
  bsdf.inverse_eta = is_inside ? ior : 1.0 / ior;
  bsdf.inverse_eta_squared = square(bsdf.inverse_eta);

  float x = (ior - 1.0) / (ior + 1.0);
  bsdf.fresnel_skew = 1.0 + (ior + 1.0 / ior) - 0.5 * (square(ior) + 1.0 / square(ior));
  bsdf.inverse_t0 = square(ior + 1.0) / (4.0 * ior);
  bsdf.f0 = min(x * x * material.specular_color, vec3(1.0)) * material.specular;
  bsdf.f90 = material.specular;
  vec3 range = bsdf.f90 - bsdf.f0;
  float darkest = min(bsdf.f0.r, min(bsdf.f0.g, bsdf.f0.b));
  bsdf.min_position = -darkest / max(bsdf.f90 - darkest, 1e-6);

  vec3 albedo = (1.0 - transmission) * dielectric;
  bsdf.diffuse = albedo / mean_transmittance(bsdf, ior);
  bsdf.cover = vec2(0.0);

  float dielectric_share = 1.0 - bsdf.metallic;
  bsdf.diffuse_luminance = vec2((1.0 - bsdf.f90) * dot(albedo, LUMINANCE), dot(albedo * range, LUMINANCE));
  bsdf.reflected_luminance = vec3(dot(bsdf.metal + dielectric_share * bsdf.f0, LUMINANCE),
                                  bsdf.metallic - dot(bsdf.metal, LUMINANCE),
                                  dielectric_share * dot(range, LUMINANCE));
  bsdf.transmitted_luminance =
      vec2((1.0 - bsdf.f90) * dot(bsdf.transmission, LUMINANCE), dot(bsdf.transmission * range, LUMINANCE));
  if (bsdf_has_film()) add_film(material, albedo, bsdf);
  return bsdf;
}

// Share of the diffuse lobe's samples that are drawn, from inside a solid, from the cone in which the interface lets light
// out: its sine squared is 1 / n^2, and beyond it only what F_90 and facets leave passes. With samples from all directions
// alone, weights would vary by n^2 at every bounce, without bound along a path.
float cone_share(Bsdf bsdf) {
  if (!bsdf_has_transmission() || !(bsdf.excess < 0.0)) return 0.0;
  float in_cone = (bsdf.f90 - dot(bsdf.f0, LUMINANCE)) / bsdf.inverse_eta_squared;
  return in_cone > 0.0 ? (1.0 - bsdf.cover.x) * (in_cone / (in_cone + (1.0 - bsdf.f90))) : 0.0;
}

// Share of sheen among the diffuse lobe's samples, from a direction with cosine c and that Fresnel position.
float sheen_share(Bsdf bsdf, float c, vec2 position, float sheen) {
  if (!bsdf_has_sheen() || !(sheen > 0.0)) return 0.0;
  SheenLayers layers = sheen_layers(bsdf, c, position, sheen);
  return layers.above > 0.0 ? layers.above / (layers.above + layers.below) : 0.0;
}

// Density of a direction with cosine c among the diffuse lobe's samples, times pi. sheen: the share above.
float diffuse_density(Bsdf bsdf, float c, float sheen) {
  if (bsdf_has_sheen() && sheen > 0.0) return mix(c, 0.5, sheen);
  float share = cone_share(bsdf);
  if (!(share > 0.0)) return c;
  bool is_in_cone = (1.0 - c) * (1.0 + c) * bsdf.inverse_eta_squared < 1.0;
  return c * (1.0 - share + (is_in_cone ? share * bsdf.inverse_eta_squared : 0.0));
}

// The same where a guide takes its share: of the direction towards the light, on the lit side. density: times pi.
float guided_density(Bsdf bsdf, float density) { return mix(density, PI * bsdf.guide.y, bsdf.guide.x); }

vec3 sample_diffuse(Bsdf bsdf, vec2 u, float sheen) {
  if (bsdf_has_sheen() && sheen > 0.0) {
    bool is_sheen = u.x < sheen;
    u.x = min(is_sheen ? u.x / sheen : (u.x - sheen) / max(1.0 - sheen, 1e-7), ONE_MINUS_ULP);
    return is_sheen ? sample_cone(u, 1.0) : sample_cosine_hemisphere(u);
  }
  float share = cone_share(bsdf);
  if (!(share > 0.0)) return sample_cosine_hemisphere(u);
  bool is_in_cone = u.x < share;
  u.x = is_in_cone ? u.x / share : (u.x - share) / (1.0 - share);
  vec3 w = sample_cosine_hemisphere(min(u, vec2(ONE_MINUS_ULP)));
  if (!is_in_cone) return w;
  w.xy *= inversesqrt(bsdf.inverse_eta_squared);
  return vec3(w.xy, sqrt(1.0 - dot(w.xy, w.xy)));
}

// Puts sheen on a bsdf, on the sides that a clearcoat would be on.
void add_sheen(DeviceAddress table, Material material, bool is_front, inout Bsdf bsdf) {
  bool is_solid = bsdf_has_transmission() && material.transmission > 0.0 && !bsdf.is_thin;
  float largest = max(material.sheen_color.r, max(material.sheen_color.g, material.sheen_color.b));
  bsdf.sheen = Sheen(material.sheen_color, max(material.sheen_roughness, SHEEN_LEAST), is_solid && !is_front ? 0.0 : largest,
                     is_solid && is_front ? 0.0 : largest, table);
}

// Looks up the tables of the material's interface.
void find_tables(DeviceAddress tables, Material material, inout Bsdf bsdf) {
  bsdf.energy = find_energy_tables(tables, max(material.ior, 1.0 / material.ior), bsdf.alpha);
}

// Prepares a bsdf for energy compensation (lib/energy.glsl): the diffuse lobe gets what a rough interface lets pass.
void compensate_energy(Material material, inout Bsdf bsdf) {
  bsdf.is_solid = bsdf_has_transmission() && material.transmission > 0.0 && !bsdf.is_thin;
  if (bsdf.excess < 0.0) return;  // as rough_position
  vec3 smooth_mean = mean_transmittance(bsdf, material.ior);
  vec3 rough_mean = max(smooth_mean - energy_fresnel_mean(bsdf.energy) * (bsdf.f90 - bsdf.f0), vec3(1e-6));
  bsdf.diffuse *= smooth_mean / rough_mean;
}

// Gives the diffuse lobe the light that the interface lets pass by its own albedo (lib/cover.glsl). Uses the material's own
// alpha, whatever its lobes are raised to, because the base's light must be a function of the path.
void cover_base(Material material, inout Bsdf bsdf) {
  if (!(max(bsdf.diffuse.r, max(bsdf.diffuse.g, bsdf.diffuse.b)) > 0.0)) return;
  bsdf.cover = vec2(cover_share(bsdf.energy.roughness), bsdf.energy.roughness > 0.0);
  bool is_inside = bsdf.excess < 0.0;
  vec2 albedo = cover_mean(bsdf.energy, is_inside);
  vec3 smooth_mean = mean_transmittance(bsdf, material.ior);
  vec3 passed = dielectric_transmittance(bsdf, vec2(albedo.y, 1.0 - albedo.y)) + (1.0 - albedo.x) * bsdf.f0;
  bsdf.diffuse *= smooth_mean / mix(smooth_mean, max(passed, vec3(1e-6)), is_inside ? bsdf.cover.y : bsdf.cover.x);
}

// Mean Fresnel position over a rough surface's facets, given the position of a smooth surface in that direction.
vec2 rough_position(Bsdf bsdf, float cosine, vec2 position) {
  if (bsdf.excess < 0.0) return position;  // from inside: where diffuse light matters little
  float more = energy_fresnel(bsdf.energy, cosine);
  return vec2(max(position.x + more, bsdf.min_position), min(position.y - more, 1.0 - bsdf.min_position));
}

// F_r as energy compensation scales it. film_c: cosine as film_reflectance takes it.
vec3 compensated_reflectance(Bsdf bsdf, vec2 position, float k, float cosine, bool is_inside, float film_c) {
  float kept = bsdf.is_solid ? energy_scattered(bsdf.energy, cosine, is_inside) : energy_reflected(bsdf.energy, cosine);
  vec3 color = bsdf.metal / max(bsdf.metallic, 1e-6);
  vec3 metal_gain = metal_compensation(bsdf.energy, cosine, color);
  vec3 plain = (bsdf.metal + k * (bsdf.metallic - bsdf.metal)) * metal_gain +
               (1.0 - bsdf.metallic) * dielectric_reflectance(bsdf, position) / kept;
  return bsdf_has_film() ? film_reflectance(bsdf, plain, film_c, metal_gain, 1.0 / kept) : plain;
}

#endif
