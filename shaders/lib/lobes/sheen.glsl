// Sheen: the fibres on top of cloth (KHR_materials_sheen), with the density and the fitted shadowing of Estevez and Kulla,
// "Production Friendly Microfacet Sheen BRDF" (2017):
//   D = (2 + 1/alpha) sin(h)^(1/alpha) / (2 pi),   V = 1 / ((1 + L(cos_o) + L(cos_i)) 4 cos_o cos_i),   alpha = roughness^2
//   sheen colour D V / max(1, E(cos_o), E(cos_i))  over  (1 - max(s_o E'(cos_o), s_i E'(cos_i))) times what lies below
// with E the share that white sheen reflects (interface/sheen.h), E' = min(E, 1), and s the largest component of the colour,
// of the side that each direction is on. The extension's appendix scales what lies below likewise; that the lobe itself
// is divided where E exceeds 1 is ours: no light is made. Reciprocal. A clearcoat lies on top.
// It is drawn uniformly, as a part of the diffuse lobe; regularization leaves both as they are.
#ifndef REGULUS_LIB_LOBES_SHEEN_GLSL
#define REGULUS_LIB_LOBES_SHEEN_GLSL

#include "interface/sheen.h"
#include "lib/buffers.glsl"
#include "lib/lobes/scattering.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// A macro as in lib/bsdf_parameters.glsl.
#define bsdf_has_sheen() (spec_material_class * (spec_features & FEATURE_SHEEN) != 0u)

const float SHEEN_LEAST = 0.01 * float(SHEEN_LEAST_HUNDREDTHS);

struct Sheen {
  vec3 color;           // linear
  float roughness;      // perceptual, from SHEEN_LEAST on
  float here;           // largest component of the colour on the side of wo; 0: there is none on that side
  float across;         // and on the other side
  DeviceAddress table;
};

const Sheen NO_SHEEN = Sheen(vec3(0.0), 1.0, 0.0, 0.0, DeviceAddress(0u));

// Solids have sheen on their outside, everything else on both sides. table: interface/sheen.h
Sheen make_sheen(DeviceAddress table, const Material material, bool is_solid, bool is_front) {
  float largest = max(material.sheen_color.r, max(material.sheen_color.g, material.sheen_color.b));
  return Sheen(material.sheen_color, max(material.sheen_roughness, SHEEN_LEAST), is_solid && !is_front ? 0.0 : largest,
               is_solid && is_front ? 0.0 : largest, table);
}

// The sheen of either side counts, because this must be a function of the path.
bool sheen_diffuses(const Sheen sheen) { return max(sheen.here, sheen.across) > 0.0; }

// L of the paper's section 3, a fit.
float sheen_fit(float x, float a, float b, float c, float d, float e) {
  return a / (1.0 + b * exp_accurate(c * log_accurate(max(x, 1e-12)))) + d * x + e;
}

float sheen_lambda(float cosine, float alpha) {
  float t = square(1.0 - alpha);
  float a = mix(21.5473, 25.3245, t), b = mix(3.82987, 3.32435, t), c = mix(0.19823, 0.16801, t);
  float d = mix(-1.97760, -1.27393, t), e = mix(-4.32054, -4.85967, t);
  float x = cosine < 0.5 ? cosine : 1.0 - cosine;
  float fit = sheen_fit(x, a, b, c, d, e);
  return exp_accurate(cosine < 0.5 ? fit : 2.0 * sheen_fit(0.5, a, b, c, d, e) - fit);
}

float sheen_word(const Sheen sheen, uint word) { return LOAD(FloatBuffer, sheen.table, word); }

// E of a direction with this cosine, on a side where the colour has this largest component: 0 where there is no sheen.
float sheen_albedo(const Sheen sheen, float cosine, float largest) {
  if (!(largest > 0.0)) return 0.0;
  float place = sqrt(clamp(cosine, 0.0, 1.0)) * float(SHEEN_DIRECTIONS - 1u);
  uint node = min(uint(place), SHEEN_DIRECTIONS - 2u);
  float row = sqrt(clamp((sheen.roughness - SHEEN_LEAST) / (1.0 - SHEEN_LEAST), 0.0, 1.0)) * float(SHEEN_ROWS - 1u);
  uint below = min(uint(row), SHEEN_ROWS - 2u);
  uint corner = below * SHEEN_DIRECTIONS + node;
  float low = mix(sheen_word(sheen, corner), sheen_word(sheen, corner + 1u), place - float(node));
  float high = mix(sheen_word(sheen, corner + SHEEN_DIRECTIONS), sheen_word(sheen, corner + SHEEN_DIRECTIONS + 1u),
                   place - float(node));
  return mix(low, high, row - float(below));
}

// What is on its way through sheen between two directions.
struct SheenPassage {
  float albedo_o, albedo_i;  // E
  float passed;              // factor on all that lies below
};

// is_transmitted: the directions are on different sides.
SheenPassage sheen_passage(const Sheen sheen, float cos_o, float cos_i, bool is_transmitted) {
  SheenPassage passage;
  float other = is_transmitted ? sheen.across : sheen.here;
  passage.albedo_o = sheen_albedo(sheen, cos_o, sheen.here);
  passage.albedo_i = sheen_albedo(sheen, cos_i, other);
  passage.passed = 1.0 - max(sheen.here * min(passage.albedo_o, 1.0), other * min(passage.albedo_i, 1.0));
  return passage;
}

// Value of the lobe, without the colour, for a facet with normal h between directions on one side.
float sheen_value(const Sheen sheen, vec3 h, float cos_o, float cos_i, const SheenPassage passage) {
  float alpha = square(sheen.roughness);
  float sine_squared = max(dot(h.xy, h.xy), 1e-30);
  float density = (2.0 + 1.0 / alpha) * 0.5 * INV_PI * exp_accurate(log_accurate(sine_squared) * (0.5 / alpha));
  float shadowing = 1.0 + sheen_lambda(cos_o, alpha) + sheen_lambda(cos_i, alpha);
  return density / (shadowing * 4.0 * max(cos_o * cos_i, 1e-12) * max(1.0, max(passage.albedo_o, passage.albedo_i)));
}

// Puts a diffuse lobe and the interface's colour under sheen, and adds sheen's own value to the diffuse one. is_lit: the diffuse
// lobe sees both directions.
void put_under_sheen(const Sheen sheen, float cos_o, float cos_i, const Encounter facet, bool is_lit, inout vec3 diffuse, inout vec3 color) {
  SheenPassage passage = sheen_passage(sheen, cos_o, cos_i, facet.is_transmitted);
  diffuse *= passage.passed;
  color *= passage.passed;
  if (is_lit && sheen.here > 0.0) diffuse += sheen.color * sheen_value(sheen, facet.h, cos_o, cos_i, passage);
}

// What becomes of light from a direction with this cosine, on a side where the largest component of the sheen's colour is this.
struct SheenLayers {
  float above;   // luminance of what sheen reflects
  float below;   // luminance of what the diffuse lobe under it reflects
  float passed;  // factor on everything under the sheen
};

// diffuse: luminance of what the diffuse lobe would reflect without sheen.
SheenLayers sheen_layers(const Sheen sheen, float cosine, float largest, float diffuse) {
  float albedo = min(sheen_albedo(sheen, cosine, largest), 1.0);
  float passed = 1.0 - largest * albedo;
  return SheenLayers(albedo * dot(sheen.color, LUMINANCE), passed * max(diffuse, 0.0), passed);
}

// Share of sheen among the diffuse lobe's samples.
float sheen_share(const SheenLayers layers) { return layers.above > 0.0 ? layers.above / (layers.above + layers.below) : 0.0; }

// Density of a direction with cosine c among the diffuse lobe's samples, times pi, where sheen has this share of them.
float density_with_sheen(float c, float share) { return mix(c, 0.5, share); }

vec3 sample_with_sheen(vec2 u, float share) {
  bool is_sheen = u.x < share;
  u.x = min(is_sheen ? u.x / share : (u.x - share) / max(1.0 - share, 1e-7), ONE_MINUS_ULP);
  return is_sheen ? sample_cone(u, 1.0) : sample_cosine_hemisphere(u);
}

#endif
