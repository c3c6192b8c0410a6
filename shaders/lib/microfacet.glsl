// The microsurface model: normal distribution (spec_ndf) with shadowing (spec_shadowing). Gives the terms that
// a microfacet lobe's value and its pdfs in both directions share, and samples visible normals. alpha is an
// argument throughout, so that a lobe can be evaluated wider than it is sampled.
#ifndef REGULUS_LIB_MICROFACET_GLSL
#define REGULUS_LIB_MICROFACET_GLSL

#include "lib/ndf.glsl"

// The Cosine distribution has no closed-form sampler of Smith-visible normals: the V-cavity's serve, with
// their own exact pdf.
bool samples_v_cavity() { return spec_shadowing == SHADOWING_V_CAVITY || spec_ndf == NDF_COSINE; }

// Terms of a microfacet lobe at one (wo, wi, h).
struct MicrofacetTerms {
  float density;         // D(h)
  float shadowing;       // G2 / (|cos_o| |cos_i|)
  float visibility_o;    // D_visible(h; wo) = visibility_o * |wo.h| * D(h); this is G1(wo) / |cos_o|
  float visibility_i;    // the same for wi
};

// G1 of V-cavities. Exactly 1 where nothing is masked, on which v_cavity_shadowing relies.
float v_cavity_masking(float cos_w, float w_dot_h, float cos_h) {
  return min(2.0 * cos_h * cos_w / max(w_dot_h, MIN_COS), 1.0);
}

// G2 of V-cavities. Two directions on the same side lose the larger of two overlapping parts of a facet; seen
// from opposite sides the parts lie at opposite ends: g_o + g_i - 1, here without its cancellation.
float v_cavity_shadowing(float masking_o, float masking_i, bool is_transmitted) {
  float low = min(masking_o, masking_i);
  return is_transmitted ? max(low - (1.0 - max(masking_o, masking_i)), 0.0) : low;
}

// o_dot_h, i_dot_h: absolute cosines with h. Requires h.z > 0. is_transmitted: wo and wi see the facet from
// opposite sides.
MicrofacetTerms microfacet_terms(vec3 wo, vec3 wi, vec3 h, float o_dot_h, float i_dot_h, vec2 alpha,
                                 bool is_transmitted) {
  float cos_o = max(abs(wo.z), MIN_COS);
  float cos_i = max(abs(wi.z), MIN_COS);
  MicrofacetTerms terms;
  terms.density = ndf_density(h, alpha);
  if (samples_v_cavity()) {
    float masking_o = v_cavity_masking(cos_o, o_dot_h, h.z);
    float masking_i = v_cavity_masking(cos_i, i_dot_h, h.z);
    terms.visibility_o = masking_o / cos_o;
    terms.visibility_i = masking_i / cos_i;
    terms.shadowing = v_cavity_shadowing(masking_o, masking_i, is_transmitted) / (cos_o * cos_i);
  }
  if (spec_shadowing == SHADOWING_V_CAVITY) return terms;
  float area_o = smith_projected_area(wo, alpha);
  float area_i = smith_projected_area(wi, alpha);
  if (!samples_v_cavity()) {
    terms.visibility_o = 1.0 / area_o;
    terms.visibility_i = 1.0 / area_i;
  }
  // 1 / (1 + Lambda_o + Lambda_i), and 1 / ((1 + Lambda_o) (1 + Lambda_i)), each over the cosines.
  terms.shadowing = spec_shadowing == SHADOWING_SMITH
      ? 1.0 / (area_o * cos_i + (area_i - cos_i) * cos_o)
      : 1.0 / (area_o * area_i);
  return terms;
}

// Normal visible from w, w.z > 0. u_choice is a uniform random number from which the discrete choices are
// taken; what remains of it is uniform again.
Facet sample_visible_normal(vec3 w, vec2 alpha, vec2 u, inout float u_choice) {
  if (samples_v_cavity()) return sample_visible_v_cavity(w, alpha, u, u_choice);
  if (spec_ndf == NDF_GGX) return sample_visible_ggx(w, alpha, u);
  return sample_visible_beckmann(w, alpha, u, u_choice);
}

#endif
