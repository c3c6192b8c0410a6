// The bsdf of a material: from what the file says to what lobes need.
#ifndef REGULUS_LIB_BSDF_MATERIAL_GLSL
#define REGULUS_LIB_BSDF_MATERIAL_GLSL

#include "lib/lobes/diffuse.glsl"

// Least alpha across the direction of an anisotropic material.
const float MIN_ANISOTROPIC_ALPHA = 1e-3;

// Puts the film on a bsdf. A walk chooses between lobes by what the film reflects on average over thicknesses: at normal
// incidence, and by the Fresnel position from there to all of the light at grazing. albedo: of the diffuse base
void add_film(const Material material, vec3 albedo, inout Bsdf bsdf) {
  bsdf.film = make_film(material, albedo);
  if (!(bsdf.film.strength > 0.0)) return;
  FilmChoice choice = film_choice(bsdf.film, film_base(bsdf));
  float strength = bsdf.film.strength;
  bsdf.reflected_luminance = blend(bsdf.reflected_luminance, choice.reflected, strength);
  bsdf.diffuse_luminance *= 1.0 - strength;
  bsdf.diffuse_luminance.y += strength * choice.least * dot(albedo, LUMINANCE);
  bsdf.transmitted_luminance *= 1.0 - strength;
  bsdf.transmitted_luminance.y += strength * choice.least * dot(bsdf.transmission, LUMINANCE);
}

// The bsdf of a material whose textures have been applied, seen from its front or back face.
Bsdf make_bsdf(const Material material, bool is_front) {
  Bsdf bsdf;
  bsdf.geometric_normal = vec3(0.0, 0.0, 1.0);  // a caller who knows another sets it
  bsdf.guide = vec2(0.0);                       // likewise
  vec3 dielectric = (1.0 - material.metallic) * material.base_color;
  if (!bsdf_has_specular()) {
    bsdf.diffuse = dielectric;
    bsdf.alpha = vec2(0.0);
    bsdf.coat = NO_COAT;
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
  bsdf.coat = make_coat(material, bsdf_has_transmission() && transmission > 0.0 && !bsdf.is_thin, is_front);
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

// Puts sheen on a bsdf.
void add_sheen(DeviceAddress table, const Material material, bool is_front, inout Bsdf bsdf) {
  bool is_solid = bsdf_has_transmission() && material.transmission > 0.0 && !bsdf.is_thin;
  bsdf.sheen = make_sheen(table, material, is_solid, is_front);
}

// Looks up the tables of the material's interface.
void find_tables(DeviceAddress tables, const Material material, inout Bsdf bsdf) {
  bsdf.energy = find_energy_tables(tables, max(material.ior, 1.0 / material.ior), bsdf.alpha);
}

// Prepares a bsdf for energy compensation (lib/energy.glsl): the diffuse lobe gets what a rough interface lets pass.
void compensate_energy(const Material material, inout Bsdf bsdf) {
  bsdf.is_solid = bsdf_has_transmission() && material.transmission > 0.0 && !bsdf.is_thin;
  if (bsdf.excess < 0.0) return;  // as rough_position
  vec3 smooth_mean = mean_transmittance(bsdf, material.ior);
  vec3 rough_mean = max(smooth_mean - energy_fresnel_mean(bsdf.energy) * (bsdf.f90 - bsdf.f0), vec3(1e-6));
  bsdf.diffuse *= smooth_mean / rough_mean;
}

// Gives the diffuse lobe the light that the interface lets pass by its own albedo (lib/cover.glsl). Uses the material's own
// alpha, whatever its lobes are raised to, because the base's light must be a function of the path.
void cover_base(const Material material, inout Bsdf bsdf) {
  if (!has_diffuse(bsdf)) return;
  bsdf.cover = vec2(cover_share(bsdf.energy.roughness), bsdf.energy.roughness > 0.0);
  bool is_inside = bsdf.excess < 0.0;
  vec2 albedo = cover_mean(bsdf.energy, is_inside);
  vec3 smooth_mean = mean_transmittance(bsdf, material.ior);
  vec3 passed = dielectric_transmittance(bsdf, vec2(albedo.y, 1.0 - albedo.y)) + (1.0 - albedo.x) * bsdf.f0;
  bsdf.diffuse *= smooth_mean / mix(smooth_mean, max(passed, vec3(1e-6)), is_inside ? bsdf.cover.y : bsdf.cover.x);
}

// What a bsdf takes from the scene's tables.
void complete_bsdf(const Frame frame, const Material material, bool is_front, inout Bsdf bsdf) {
  if (bsdf_has_sheen()) add_sheen(frame.sheen_table, material, is_front, bsdf);
  if (uses_energy_tables()) find_tables(frame.energy_tables, material, bsdf);
  if (compensates_energy()) compensate_energy(material, bsdf);
  if (has_rough_base()) cover_base(material, bsdf);
}

#endif
