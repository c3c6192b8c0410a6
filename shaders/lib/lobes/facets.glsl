// A lobe of microfacets: what the base's interface (interface.glsl) and the clearcoat (clearcoat.glsl) share. Its value is a
// Fresnel factor times D G2 / (|cos_o| |cos_i|) times the half-vector Jacobian, its pdfs are the probability of its choice times
// the visible normals' density times the same Jacobian. Raised (regularization) it is the same with a larger alpha.
#ifndef REGULUS_LIB_LOBES_FACETS_GLSL
#define REGULUS_LIB_LOBES_FACETS_GLSL

#include "lib/lobes/scattering.glsl"
#include "lib/microfacet.glsl"
#include "lib/raised_alpha.glsl"

// Macros as in lib/bsdf_parameters.glsl.
#define bsdf_has_rough() (spec_material_class * (spec_features & FEATURE_ROUGH_SPECULAR) != 0u)
#define bsdf_has_delta() (spec_material_class * (spec_features & FEATURE_DELTA_SPECULAR) != 0u)

// A lobe that is not a delta is evaluated with at least this alpha.
const float MIN_ALPHA = 1e-7;
// The factor that a microfacet lobe's value and pdfs share is kept below this. Their quotient stays exact.
const float MAX_DENSITY = 1e23;

// Visible normal of the lobe with this alpha, and what is left of the number that chose it: the normal itself where alpha is 0.
// w is in the lobe's frame.
Facet sample_facet(vec3 w, vec2 alpha, vec2 u, inout float u_choice) {
  Facet visible = Facet(vec3(0.0, 0.0, 1.0), w.z);
  if (bsdf_has_rough()) {
    float u_rest = u_choice;
    Facet rough = sample_visible_normal(w, max(alpha, vec2(MIN_ALPHA)), u, u_rest);
    if (!bsdf_has_delta() || alpha.x > 0.0) {
      visible = rough;
      u_choice = u_rest;
    }
  }
  return visible;
}

// The lobe at (wo, wi) that meet at a facet. Nothing but `terms` and `density` depends on alpha.
struct MicrofacetLobe {
  float weight;           // its Fresnel factor, colour included, in luminance
  float density_scale;    // half-vector Jacobian: times D, the factor that value and pdfs share
  float choice_forward;   // probability of choosing the lobe, and of its event at the facet
  float choice_reverse;
  MicrofacetTerms terms;
  float density;          // terms.density * density_scale, 0 for a delta lobe or without a facet
  float camera_cosine;    // with the lobe's normal, of the direction towards the camera
};

const MicrofacetLobe NO_MICROFACET_LOBE =
    MicrofacetLobe(0.0, 0.25, 0.0, 0.0, MicrofacetTerms(0.0, 0.0, 0.0, 0.0), 0.0, 1.0);

float facet_density(const MicrofacetLobe lobe, const MicrofacetTerms terms) { return min(terms.density * lobe.density_scale, MAX_DENSITY); }

// Value without the Fresnel factor, and the value's luminance. Without the eta^2 of radiance.
float facet_scattering(const MicrofacetLobe lobe) { return lobe.density * lobe.terms.shadowing; }
float facet_luminance(const MicrofacetLobe lobe) { return lobe.weight * lobe.density * lobe.terms.shadowing; }

// Densities of wi given wo, and of wo given wi.
float facet_pdf_forward(const MicrofacetLobe lobe) { return lobe.choice_forward * lobe.density * lobe.terms.visibility_o; }
float facet_pdf_reverse(const MicrofacetLobe lobe) { return lobe.choice_reverse * lobe.density * lobe.terms.visibility_i; }

// The same over the density, which a delta lobe has not: what cancels in quotients of values and pdfs.
float facet_share(const MicrofacetLobe lobe) { return lobe.weight * lobe.terms.shadowing; }
float facet_share_forward(const MicrofacetLobe lobe) { return lobe.choice_forward * lobe.terms.visibility_o; }
float facet_share_reverse(const MicrofacetLobe lobe) { return lobe.choice_reverse * lobe.terms.visibility_i; }

// The lobe with a larger alpha.
struct RaisedLobe {
  vec2 alpha;
  float density;    // as in MicrofacetLobe
  float shadowing;
  float kept;       // factor by which it keeps its light (lib/raised_light.glsl)
};

const RaisedLobe NO_RAISED_LOBE = RaisedLobe(vec2(0.0), 0.0, 0.0, 1.0);

// The density that weights use: with MIS_BLENDED the lobe's peak is blended in, by how much wider the lobe is than the walk's,
// of alpha `walked` (docs/mathematics.md 3.9). has_facet: the directions meet at one, and the lobe is no delta.
float blended_density(const MicrofacetLobe lobe, const RaisedLobe raised, vec2 walked, bool has_facet) {
  if (spec_mis != MIS_BLENDED) return raised.density;
  if (!has_facet) return raised.density;
  vec2 alpha = raised.alpha;
  float peak = min(INV_PI / (alpha.x * alpha.y) * lobe.density_scale, MAX_DENSITY);
  float beta = 1.0 - (walked.x * walked.y) / (alpha.x * alpha.y);
  return beta >= 1.0 ? peak
                     : exp_accurate((1.0 - beta) * log_accurate(max(raised.density, 1e-36)) + beta * log_accurate(peak));
}

// Largest density of a lobe of this alpha, times `scale`, which is 1/4 for reflection. least: of alpha's product.
float facet_peak(float scale, vec2 alpha, float least) { return scale * INV_PI / max(alpha.x * alpha.y, least); }

// Variance of the angles that a lobe of this alpha adds by reflection (docs/mathematics.md 5).
float facet_spread(vec2 alpha) { return 2.0 * alpha.x * alpha.y; }

#endif
