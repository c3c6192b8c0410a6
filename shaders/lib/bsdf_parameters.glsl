// A material at a point, in the form that the scattering functions need (lib/bsdf.glsl has the model): what each lobe owns, and
// the members of the base, which is an interface (lobes/interface.glsl) over a diffuse lobe (lobes/diffuse.glsl).
#ifndef REGULUS_LIB_BSDF_PARAMETERS_GLSL
#define REGULUS_LIB_BSDF_PARAMETERS_GLSL

#include "lib/cover.glsl"
#include "lib/lobes/clearcoat.glsl"
#include "lib/lobes/iridescence.glsl"
#include "lib/lobes/sheen.glsl"
#include "lib/walk_guide.glsl"

// What this pipeline can meet; what a lobe alone needs stands in its file. Macros of one comparison each, because a branch on
// such a comparison is resolved before the driver sees the module (host/gpu/specialize.hpp), while a branch on the result of a
// function is not; and because glslang 12 puts constants that are derived from derived specialization constants into the wrong
// order.
#define bsdf_has_specular() (spec_material_class != MATERIAL_CLASS_DIFFUSE)
#define bsdf_has_transmission() (spec_material_class == MATERIAL_CLASS_TRANSMISSIVE)
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
  Coat coat;             // only with bsdf_has_coat()
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
bool is_in_relief_shadow(const Bsdf bsdf, vec3 w) { return bsdf_has_relief() && dot(w, bsdf.geometric_normal) * w.z < 0.0; }

#endif
