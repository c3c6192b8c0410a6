// A thin film on the interface (KHR_materials_iridescence), by Belcour and Barla, "A Practical Extension to Microfacet Theory
// for the Modeling of Varying Iridescence" (2017), as the extension's appendix approximates it. With R12 and R23 what the
// film's two faces reflect (Schlick), T12 = 1 - R12, T23 = 1 - R23, Q = R12 R23, r = sqrt(Q), the film reflects
//   F = R12 + T12^2 R23 / (1 - Q) + (T12^2 R23 / (1 - Q) - T12) (r S_1 + r^2 S_2)
// which is the same as
//   1 - F = T12 T23 / (1 - Q) (1 + r S_1 + r^2 S_2)
// and keeps its digits towards grazing. S_m: twice what Rec. 709 sees of an interference of order m, from Gaussians fitted to the
// colour matching functions. F is held within [0, 1], beyond which saturated colours would go.
// All is a function of the cosine on the thin side of the interface, so it is the same for both ways through it, and 1 where
// the interface reflects totally. What lies below gets 1 - (largest component of F), as in the extension.
#ifndef REGULUS_LIB_LOBES_IRIDESCENCE_GLSL
#define REGULUS_LIB_LOBES_IRIDESCENCE_GLSL

#include "interface/scene.h"
#include "lib/fresnel.glsl"
#include "lib/numerics.glsl"
#include "lib/specialization.glsl"

// A macro as in lib/bsdf_parameters.glsl.
#define bsdf_has_film() (spec_material_class * (spec_features & FEATURE_IRIDESCENCE) != 0u)

// Greatest component of film_sensitivity for waves of one sign, and for any.
const float FILM_SWING = 1.8, FILM_SWING_OF_ANY_SIGNS = 5.3;
// Alphas between which film_passage goes over from a smooth surface to a rough one.
const float FILM_ROUGH_BEGIN = 0.01, FILM_ROUGH_FULL = 0.04;
// By how much, as a factor of alpha and at most, the mean over facets exceeds what the surface's own angle gives.
const float FILM_MARGIN = 0.15, FILM_LARGEST_MARGIN = 0.035;

struct Film {
  float strength;   // share of the surface that it covers
  float ior;
  float thickness;  // nm
  vec3 metal;       // what a metal below reflects at normal incidence
  vec3 albedo;      // of the diffuse base
};

Film make_film(const Material material, vec3 albedo) {
  return Film(material.iridescence, max(material.iridescence_ior, 1.0), material.iridescence_thickness.y, material.base_color,
              albedo);
}

// The film's faces at one angle, for what lies below it.
struct FilmFaces {
  vec3 passed;      // T12 T23 / (1 - Q): 1 - F on average over thicknesses
  vec3 amplitude;   // r
  vec3 sign;        // -1: a component's wave is turned by half a period at one of the faces
  float path;       // difference in optical path, nm
};

// Index of refraction of what reflects this at normal incidence, as the extension has it.
vec3 film_base_ior(vec3 base_f0) {
  vec3 root = sqrt(min(base_f0 + 0.0001, vec3(0.9999)));
  return (1.0 + root) / (1.0 - root);
}

// F at normal incidence on average over thicknesses, accurate also where it is little.
vec3 film_mean(const Film film, vec3 base_f0) {
  vec3 base_ior = film_base_ior(base_f0);
  float r12 = square((film.ior - 1.0) / (film.ior + 1.0));
  vec3 r23 = (base_ior - film.ior) / (base_ior + film.ior);
  r23 *= r23;
  return r12 + square(4.0 * film.ior / square(film.ior + 1.0)) * r23 / (1.0 - clamp(r12 * r23, 1e-5, 0.9999));
}

FilmFaces film_faces(const Film film, vec3 base_f0, float c) {
  vec3 base_ior = film_base_ior(base_f0);
  float c2 = sqrt(c * c + (film.ior - 1.0) * (film.ior + 1.0)) / film.ior;
  float t12 = 4.0 * film.ior / square(film.ior + 1.0) * schlick_rest(c);
  vec3 t23 = 4.0 * film.ior * base_ior / ((base_ior + film.ior) * (base_ior + film.ior)) * schlick_rest(c2);
  vec3 rest = t12 + t23 * (1.0 - t12);  // 1 - Q
  vec3 held = clamp(rest, 0.0001, 0.99999);
  FilmFaces faces;
  faces.passed = t12 * (t23 + (held - rest)) / held;
  faces.amplitude = sqrt(1.0 - held);
  faces.sign = vec3(base_ior.x < film.ior ? 1.0 : -1.0, base_ior.y < film.ior ? 1.0 : -1.0, base_ior.z < film.ior ? 1.0 : -1.0);
  faces.path = 2.0 * film.ior * film.thickness * c2;
  return faces;
}

// What Rec. 709 sees of interference over this difference in path (nm): the Fourier transforms of the Gaussians.
vec3 film_sensitivity(float path, vec3 sign) {
  const vec4 AMPLITUDES = vec4(0.846590002, 1.00022189, 1.00112249, 0.153868307);      // X, Y, Z, second peak of X
  const vec4 TURNS = vec4(1.6810e-3, 1.7953e-3, 2.2084e-3, 2.2399e-3);                 // 1/nm
  const vec4 DECAYS = vec4(1.70854696e-7, 3.67330884e-7, 2.61035245e-7, 1.78766171e-7);  // 1/nm^2
  const float LONGEST_PATH = 3e4;  // nm: nothing is left of the colours
  path = min(path, LONGEST_PATH);
  vec4 turns = fract(TURNS * path);
  vec4 waves = vec4(cos_sin_turns(turns.x).x, cos_sin_turns(turns.y).x, cos_sin_turns(turns.z).x, cos_sin_turns(turns.w).x);
  vec4 decays = DECAYS * (path * path);
  waves *= AMPLITUDES * vec4(exp_accurate(-decays.xyz), exp_accurate(-decays.w));
  vec3 xyz = sign * vec3(waves.x + waves.w, waves.y, waves.z);
  return vec3(3.2404542 * xyz.x - 1.5371385 * xyz.y - 0.4985314 * xyz.z,
              -0.9692660 * xyz.x + 1.8760108 * xyz.y + 0.0415560 * xyz.z,
              0.0556434 * xyz.x - 0.2040259 * xyz.y + 1.0572252 * xyz.z);
}

// 1 - F for what reflects base_f0 at normal incidence without the film. c: cosine on the thin side.
vec3 film_transmittance(const Film film, vec3 base_f0, float c) {
  FilmFaces faces = film_faces(film, base_f0, c);
  vec3 first = 2.0 * film_sensitivity(faces.path, faces.sign);
  vec3 second = 2.0 * film_sensitivity(2.0 * faces.path, vec3(1.0));
  return clamp(faces.passed * (1.0 + faces.amplitude * (first + faces.amplitude * second)), 0.0, 1.0);
}

// (1 - share) bare + share covered, which is exact at the ends. mix() may be bare + share (covered - bare), and lose what is
// much less than bare.
vec3 blend(vec3 bare, vec3 covered, float share) { return (1.0 - share) * bare + share * covered; }

float least_component(vec3 color) { return min(color.r, min(color.g, color.b)); }

// Share of light from a direction with cosine c (as above) that a film on a dielectric with these facets leaves to a diffuse
// base: what is not reflected. Facets of a rough surface stand at other angles; the base gets no more than the brightest colours
// of any thickness leave, so that it never returns more than it gets (docs/mathematics.md 14). From inside a solid, where
// facets blur total reflection, it gets nothing.
float film_passage(const Film film, vec3 base_f0, float c, vec2 alpha, bool is_inside) {
  float roughest = max(alpha.x, alpha.y);
  if (is_inside && roughest > 0.0) return 0.0;
  float least = least_component(film_transmittance(film, base_f0, c));
  if (!(roughest > 0.0)) return least;
  FilmFaces faces = film_faces(film, base_f0, c);
  bool is_plain = abs(faces.sign.x + faces.sign.y + faces.sign.z) > 2.0;
  float swing = 2.0 * (is_plain ? FILM_SWING : FILM_SWING_OF_ANY_SIGNS);
  float rough = least_component(faces.passed * max(1.0 - swing * faces.amplitude * (1.0 + faces.amplitude), 0.0));
  float share = smoothstep(FILM_ROUGH_BEGIN, FILM_ROUGH_FULL, roughest);
  return max(mix(least, rough, share) - min(FILM_MARGIN * roughest, FILM_LARGEST_MARGIN), 0.0);
}

// The interface below a film: share of metal, and what its dielectric part reflects at normal incidence.
struct FilmBase {
  float metallic;
  vec3 f0;
};

// F_r under the film. plain: without it; c: cosine on the thin side; *_gain: of energy compensation.
vec3 film_reflectance(const Film film, const FilmBase base, vec3 plain, float c, vec3 metal_gain, float dielectric_gain) {
  if (!(film.strength > 0.0)) return plain;
  vec3 covered = vec3(0.0);
  if (base.metallic > 0.0) covered += base.metallic * metal_gain * (1.0 - film_transmittance(film, film.metal, c));
  if (base.metallic < 1.0)
    covered += (1.0 - base.metallic) * dielectric_gain * (1.0 - film_transmittance(film, base.f0, c));
  return blend(plain, covered, film.strength);
}

// What passes into the dielectric, for 1 - F_d without the film.
vec3 film_refraction(const Film film, const FilmBase base, vec3 plain, float c) {
  if (!(film.strength > 0.0)) return plain;
  return blend(plain, vec3(least_component(film_transmittance(film, base.f0, c))), film.strength);
}

// What a walk chooses between lobes by: what the film reflects on average over thicknesses at normal incidence.
struct FilmChoice {
  vec3 reflected;  // as Bsdf::reflected_luminance
  float least;     // factor on the colours of the diffuse base and of transmission, at normal incidence
};

FilmChoice film_choice(const Film film, const FilmBase base) {
  float metal = dot(film_mean(film, film.metal), LUMINANCE);
  vec3 mean = film_mean(film, base.f0);
  float dielectric = dot(mean, LUMINANCE);
  float least = least_component(film_faces(film, base.f0, 1.0).passed);
  float rest = 1.0 - base.metallic;
  return FilmChoice(vec3(base.metallic * metal + rest * dielectric, base.metallic * (1.0 - metal), rest * (1.0 - dielectric)),
                    least);
}

#endif
