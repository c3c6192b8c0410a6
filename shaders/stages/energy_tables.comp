// energy_tables: one plane, cover or side of the tables of what rough interfaces reflect, a node per invocation. Visible normals
// are drawn by a fixed low-discrepancy sequence: the same table every time.
// writes  tables
#version 460
#extension GL_GOOGLE_include_directive : require
#include "interface/energy.h"
#include "lib/cover.glsl"
#include "lib/fresnel.glsl"
#include "lib/microfacet.glsl"

layout(local_size_x = WORKGROUP_SIZE) in;
layout(push_constant, scalar) uniform PushConstants { EnergyArguments arguments; };

const uint POINTS = 2048u;
const uint REFRACTED_POINTS = 1024u;  // errs by at most .007, from inside
const float LEAST_ALPHA = 1e-6;
const float LEAST_POSITION = 1e-3;

// G2 / G1(wo) for light that leaves a facet visible from wo towards wi: what is left of it.
float shadowed(vec3 wo, vec3 wi, vec3 h, float o_dot_h, float i_dot_h, float alpha, bool is_refracted) {
  MicrofacetTerms terms = microfacet_terms(wo, wi, h, o_dot_h, i_dot_h, vec2(alpha), is_refracted);
  return terms.shadowing * abs(wi.z) / terms.visibility_o;
}

void main() {
  uint node = gl_GlobalInvocationID.x;
  bool is_cover = arguments.quantity == ENERGY_COVER_OUT || arguments.quantity == ENERGY_COVER_IN;
  bool is_of_refracted = arguments.quantity >= ENERGY_REFRACTED_OUT;
  bool is_inside = arguments.quantity == ENERGY_SCATTERED_IN || arguments.quantity == ENERGY_COVER_IN ||
                   arguments.quantity == ENERGY_REFRACTED_IN;
  if (node >= (is_cover || is_of_refracted ? COVER_NODES : ENERGY_PLANE_WORDS)) return;
  vec2 position = vec2(node % ENERGY_NODES, node / ENERGY_NODES) / float(ENERGY_NODES - 1u);
  float roughness = position.y;
  if (is_cover || is_of_refracted) roughness = cover_roughness(node / ENERGY_NODES, is_inside || is_of_refracted);
  float alpha = max(square(roughness), LEAST_ALPHA);
  float cos_o = max(position.x, LEAST_POSITION);
  if (is_cover || is_of_refracted) {
    cos_o = cover_cosine(node % ENERGY_NODES, critical_cosine(arguments.ior), is_inside);
  } else if (arguments.quantity != ENERGY_FRESNEL && position.x < 1.0) {
    float cotangent = alpha * cos_o / (1.0 - cos_o);
    cos_o = cotangent * inversesqrt(1.0 + square(cotangent));
  }
  vec3 wo = vec3(safe_sqrt((1.0 - cos_o) * (1.0 + cos_o)), 0.0, cos_o);
  float excess = (arguments.ior - 1.0) * (arguments.ior + 1.0);
  if (is_inside) excess /= -square(arguments.ior);
  float inverse_eta = is_inside ? arguments.ior : 1.0 / arguments.ior;
  float f0 = square((arguments.ior - 1.0) / (arguments.ior + 1.0));

  float transmitted = 0.0;
  precise vec2 sums = vec2(0.0), carry = vec2(0.0);  // reflected, and weighed by reflectance
  uint points = is_of_refracted ? REFRACTED_POINTS : POINTS;
  for (uint i = 0u; i < points; ++i) {
    // R3 sequence (Roberts 2018), in integers: its multiples stay exact.
    uvec3 digits = (i + 1u) * uvec3(3518319155u, 2882110345u, 2360945575u);
    vec3 u = vec3(digits >> 8u) * (1.0 / 16777216.0);
    float u_choice = u.z;
    Facet facet = sample_visible_normal(wo, vec2(alpha), u.xy, u_choice);
    float c = facet.w_dot_h;
    if (!(c > 0.0)) continue;
    float g = refracted_g(c, excess);
    float fresnel = fresnel_dielectric(max(c, MIN_COS), g, excess);
    vec3 mirrored = 2.0 * c * facet.h - wo;
    if (mirrored.z > 0.0) {
      float share = shadowed(wo, mirrored, facet.h, c, c, alpha, false);
      // From inside, summed with compensation: nearly equal numbers would all be rounded to one side, and where nearly all
      // is reflected the little that is missing counts.
      precise vec2 added = vec2(share, share * fresnel) - carry;
      precise vec2 sum = sums + added;
      carry = arguments.quantity == ENERGY_COVER_IN ? (sum - sums) - added : vec2(0.0);
      sums = sum;
    }
    vec3 refracted = -inverse_eta * (wo + (excess / max(c + g, MIN_COS)) * facet.h);
    if (g > 0.0 && refracted.z < 0.0)
      transmitted += (1.0 - fresnel) * shadowed(wo, refracted, facet.h, c, g * inverse_eta, alpha, true);
  }
  float reflected = sums.x, weighted = sums.y;
  if (is_cover && roughness == 0.0) {
    // Exactly 1 at the critical angle, where the square root would blow up a single rounding.
    bool is_total = node % ENERGY_NODES <= COVER_CRITICAL_NODE;
    float smooth_surface = is_total ? 1.0 : fresnel_dielectric(cos_o, refracted_g(cos_o, excess), excess);
    reflected = float(POINTS);
    weighted = reflected * smooth_surface;
  }
  if (is_cover) {
    float positions = (weighted - f0 * reflected) / (1.0 - f0);
    STORE(FloatBuffer, arguments.tables, arguments.plane + 2u * node, reflected / float(POINTS));
    STORE(FloatBuffer, arguments.tables, arguments.plane + 2u * node + 1u, positions / float(POINTS));
    return;
  }
  if (is_of_refracted) {
    float share = transmitted / float(REFRACTED_POINTS);
    if (roughness == 0.0) {
      bool is_total = is_inside && node % ENERGY_NODES <= COVER_CRITICAL_NODE;
      share = is_total ? 0.0 : 1.0 - fresnel_dielectric(cos_o, refracted_g(cos_o, excess), excess);
    }
    STORE(FloatBuffer, arguments.tables, arguments.plane + node, share);
    return;
  }
  float value = reflected / float(POINTS);
  if (arguments.quantity == ENERGY_FRESNEL) {
    float smooth_surface = fresnel_dielectric(cos_o, refracted_g(cos_o, excess), excess);
    value = (weighted / max(reflected, 1e-6) - smooth_surface) / (1.0 - f0);
  }
  if (arguments.quantity >= ENERGY_SCATTERED_OUT) value = (weighted + transmitted) / float(POINTS);
  STORE(FloatBuffer, arguments.tables, arguments.plane + node, value);
}
