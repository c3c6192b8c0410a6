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

float v_cavity_visibility(float cos_w, float w_dot_h, float cos_h) {
  return min(1.0 / cos_w, 2.0 * cos_h / w_dot_h);
}

// Transmission through V-cavities: a facet pair masks and shadows opposite ends of itself.
float v_cavity_shadowing(float cos_o, float cos_i, float visibility_o, float visibility_i, bool is_transmitted) {
  float g_o = visibility_o * cos_o;
  float g_i = visibility_i * cos_i;
  float g = is_transmitted ? max(g_o + g_i - 1.0, 0.0) : min(g_o, g_i);
  return g / (cos_o * cos_i);
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
    terms.visibility_o = v_cavity_visibility(cos_o, max(o_dot_h, MIN_COS), h.z);
    terms.visibility_i = v_cavity_visibility(cos_i, max(i_dot_h, MIN_COS), h.z);
  }
  if (spec_shadowing == SHADOWING_V_CAVITY) {
    terms.shadowing = v_cavity_shadowing(cos_o, cos_i, terms.visibility_o, terms.visibility_i, is_transmitted);
    return terms;
  }
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
