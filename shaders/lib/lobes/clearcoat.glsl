// The clearcoat (KHR_materials_clearcoat): a lobe of microfacets over the whole bsdf, of index 1.5. With weight c and
// T(w) = 1 - c F_c(cos_w) on the coated side and 1 on the other:
//   T(wo) T(wi) (all below) + c F_c(wo.h) D_c G2_c / (4 cos_o cos_i),  F_c = Schlick from 0.04
// in the reciprocal form that the extension allows. Of a coat with a normal of its own these cosines are those with that normal,
// and its lobe has the factor |cos with the coat's normal| / |cos with the base's| of the direction to the light: it reflects
// what falls on the coat. As with all shading normals that is a function of the path.
#ifndef REGULUS_LIB_LOBES_CLEARCOAT_GLSL
#define REGULUS_LIB_LOBES_CLEARCOAT_GLSL

#include "lib/fresnel.glsl"
#include "lib/lobes/facets.glsl"
#include "lib/raised_light.glsl"
#include "lib/sampling.glsl"

// Macros as in lib/bsdf_parameters.glsl.
#define bsdf_has_coat() (spec_material_class * (spec_features & FEATURE_CLEARCOAT) != 0u)
#define bsdf_has_coat_normal() (spec_material_class * (spec_features & FEATURE_COAT_NORMALS) != 0u)

const float COAT_F0 = 0.04;  // index 1.5

struct Coat {
  float here;      // weight on the side of wo
  float across;    // weight on the other side, for transmitted light
  vec2 alpha;      // 0: delta
  vec3 normal;     // local, on the side of wo; only with bsdf_has_coat_normal()
  bool is_turned;  // normal is not z (MATERIAL_COAT_NORMAL); only with bsdf_has_coat_normal()
};

const Coat NO_COAT = Coat(0.0, 0.0, vec2(0.0), vec3(0.0, 0.0, 1.0), false);

// Solids are coated on their outside, everything else on both sides. A caller who knows another normal than z sets it.
Coat make_coat(const Material material, bool is_solid, bool is_front) {
  Coat coat;
  coat.here = is_solid && !is_front ? 0.0 : material.clearcoat;
  coat.across = is_solid && is_front ? 0.0 : material.clearcoat;
  float alpha = square(material.clearcoat_roughness);
  coat.alpha = vec2(material.clearcoat_roughness > 0.0 ? max(alpha, MIN_ALPHA) : 0.0);
  coat.normal = vec3(0.0, 0.0, 1.0);
  coat.is_turned = (material.flags & MATERIAL_COAT_NORMAL) != 0u;
  return coat;
}

bool coat_is_delta(const Coat coat) { return !(coat.alpha.x > 0.0); }

// The coat of either side counts, because this must be a function of the path.
bool coat_diffuses(const Coat coat) { return max(coat.here, coat.across) > 0.0 && coat.alpha.x >= SHARP_ALPHA; }

// A direction in the clearcoat's own frame: z is its normal on the side of wo.
vec3 to_coat(const Coat coat, vec3 w) {
  if (!bsdf_has_coat_normal()) return w;
  vec3 tangent, bitangent;
  orthonormal_basis(coat.normal, tangent, bitangent);
  return coat.is_turned ? vec3(dot(w, tangent), dot(w, bitangent), dot(w, coat.normal)) : w;
}

vec3 from_coat(const Coat coat, vec3 w) {
  if (!bsdf_has_coat_normal()) return w;
  vec3 tangent, bitangent;
  orthonormal_basis(coat.normal, tangent, bitangent);
  return coat.is_turned ? w.x * tangent + w.y * bitangent + w.z * coat.normal : w;
}

// Cosine of w with the clearcoat's normal on w's own side of the surface. Where it is not positive, the coat's lobe does not
// see w.
float coat_cosine(const Coat coat, vec3 w) {
  if (!bsdf_has_coat_normal()) return abs(w.z);
  float cosine = coat.is_turned ? dot(w, coat.normal) : w.z;
  return clamp(w.z < 0.0 ? -cosine : cosine, -1.0, 1.0);
}

// True if the coat sees wo, given in its frame, and what this facet sends on.
bool coat_sees(vec3 w, const Facet visible) { return w.z > 0.0 && 2.0 * visible.w_dot_h * visible.h.z - w.z > 0.0; }

// Share of light that a clearcoat of this weight reflects at cosine c.
float coat_reflectance(float weight, float c) { return weight * (COAT_F0 + (1.0 - COAT_F0) * schlick_weight(c)); }

// The share that it lets pass, accurate also at grazing, where that is little.
float coat_transmittance(float weight, float c) {
  return (1.0 - weight) + weight * (1.0 - COAT_F0) * schlick_rest(c);
}

// Probabilities of sampling the coat and what lies below, in proportion to what each would reflect or transmit. c: coat_cosine
// of the direction; below: luminance of what the base alone would reflect or transmit.
vec2 coat_choice(float weight, float c, float below) {
  float coat = c > 0.0 ? coat_reflectance(weight, c) : 0.0;
  below = coat_transmittance(weight, abs(c)) * max(below, 0.0);
  return coat > 0.0 ? vec2(coat, below) / (coat + below) : vec2(0.0, 1.0);
}

// What is on its way through the coat between two directions.
struct CoatPassage {
  float cosine_o, cosine_i;  // coat_cosine
  float passed;              // factor on all that lies below
  vec2 chosen_o, chosen_i;   // coat_choice
};

// below_o, below_i: as coat_choice takes them.
CoatPassage coat_passage(const Coat coat, vec3 wo, vec3 wi, bool is_transmitted, float below_o, float below_i) {
  CoatPassage passage;
  float coat_i = is_transmitted ? coat.across : coat.here;
  passage.cosine_o = coat_cosine(coat, wo);
  passage.cosine_i = coat_cosine(coat, wi);
  passage.passed = coat_transmittance(coat.here, abs(passage.cosine_o)) * coat_transmittance(coat_i, abs(passage.cosine_i));
  passage.chosen_o = coat_choice(coat.here, passage.cosine_o, below_o);
  passage.chosen_i = coat_choice(coat_i, passage.cosine_i, below_i);
  return passage;
}

// Terms of the lobe with this alpha.
MicrofacetTerms coat_terms(const Coat coat, vec3 wo, vec3 wi, const Encounter facet, vec2 alpha) {
  return microfacet_terms(to_coat(coat, wo), to_coat(coat, wi), to_coat(coat, facet.h), facet.o_dot_h, facet.i_dot_h,
                          max(alpha, vec2(MIN_ALPHA)), false);
}

// The lobe at (wo, wi).
MicrofacetLobe evaluate_coat(const Coat coat, const CoatPassage passage, vec3 wo, vec3 wi, const Encounter facet, uint transport) {
  MicrofacetLobe lobe = NO_MICROFACET_LOBE;
  if (facet.is_transmitted || !(coat.here > 0.0)) return lobe;
  if (bsdf_has_coat_normal() && !(min(passage.cosine_o, passage.cosine_i) > 0.0)) return lobe;
  lobe.weight = coat_reflectance(coat.here, facet.o_dot_h);
  if (bsdf_has_coat_normal())
    lobe.weight *= transport == TRANSPORT_RADIANCE ? passage.cosine_i / max(wi.z, MIN_COS)
                                                   : passage.cosine_o / max(wo.z, MIN_COS);
  lobe.choice_forward = passage.chosen_o.x;
  lobe.choice_reverse = passage.chosen_i.x;
  lobe.camera_cosine = abs(transport == TRANSPORT_RADIANCE ? passage.cosine_o : passage.cosine_i);
  lobe.terms = coat_terms(coat, wo, wi, facet, coat.alpha);
  if (coat.alpha.x > 0.0) lobe.density = facet_density(lobe, lobe.terms);
  return lobe;
}

// Adds the coat's part to a delta event on the same side. Of radiance it reflects its share, whatever the angle to the base; a
// light walk's factor is |cos_i| / |cos_o| of that.
void add_coat_delta(const Coat coat, const CoatPassage passage, float cos_o, float cos_i, uint transport, inout BsdfEval eval) {
  float turned = 1.0;
  if (bsdf_has_coat_normal() && transport == TRANSPORT_IMPORTANCE) turned = cos_i / max(cos_o, MIN_COS);
  eval.value += coat_reflectance(coat.here, abs(passage.cosine_o)) * turned;
  eval.pdf_forward += passage.chosen_o.x;
  eval.pdf_reverse += passage.chosen_i.x;
}

// Regularization: the coat has a bound of its own (docs/mathematics.md 2.5).
vec2 raised_coat_alpha(const Coat coat, const Encounter facet, const Regularization regularization) {
  return raised_alpha(coat.alpha, reflection_alpha(regularization.tau, facet.o_dot_h), regularization);
}

RaisedLobe raise_coat(const Coat coat, const EnergyTables tables, const MicrofacetLobe lobe, vec3 wo, vec3 wi, const Encounter facet,
                      const Regularization regularization) {
  if (!(lobe.weight > 0.0)) return NO_RAISED_LOBE;  // there is none, or it does not see both directions
  vec2 alpha = raised_coat_alpha(coat, facet, regularization);
  if (!(alpha.x > 0.0)) return NO_RAISED_LOBE;
  MicrofacetTerms terms = coat_terms(coat, wo, wi, facet, alpha);
  return RaisedLobe(alpha, facet_density(lobe, terms), terms.shadowing,
                    reflection_kept(tables, coat.alpha, alpha, lobe.camera_cosine));
}

float raised_coat_value(const MicrofacetLobe lobe, const RaisedLobe raised) {
  return lobe.weight * raised.kept * raised.density * raised.shadowing;
}

// The same as weights use it.
float raised_coat_in_weights(const Coat coat, const MicrofacetLobe lobe, const RaisedLobe raised) {
  float blended = blended_density(lobe, raised, coat.alpha, raised.alpha.x > 0.0);
  return lobe.weight * raised.kept * blended * raised.shadowing;
}

// Value times the lobe's largest, for sampler quality (lib/history.glsl).
float bounded_coat(const Coat coat, float value) { return facet_peak(value * 0.25, coat.alpha, 1e-28); }

// Value over pdf of a direction that the lobe's own facets have given, cosine included: the density cancels.
float coat_over_pdf(const MicrofacetLobe lobe, vec3 wi) {
  return facet_share(lobe) * abs(wi.z) / max(lobe.terms.visibility_o, 1e-30);
}

#endif
