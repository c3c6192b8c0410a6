// Normal distributions and what masking needs of them: density D, projected area of the visible microsurface
// (that is cos / G1), and sampling. Directions are in the local shading frame, alpha = (alpha_x, alpha_y) > 0.
// The distribution is chosen by the specialization constant spec_ndf.
#ifndef REGULUS_LIB_NDF_GLSL
#define REGULUS_LIB_NDF_GLSL

#include "lib/numerics.glsl"
#include "lib/sampling.glsl"
#include "lib/specialization.glsl"

// In quotients, directions with a smaller cosine count as having this one, which keeps the quotients finite.
const float MIN_COS = 1e-7;

// D(h) for h.z > 0, in 1/sr. Evaluated from the slopes of h divided by alpha, so it is as accurate as h.xy.
//   GGX        1 / (pi ax ay (1 + s^2)^2 cos^4)
//   Beckmann   exp(-s^2) / (pi ax ay cos^4)
//   Cosine     (n + 2) / (2 pi) cos^n with n = 2 / (ax ay) - 2: its slope density
//              (1 + ax ay s^2)^(-1 / (ax ay) - 1) / (pi ax ay), stretched, over cos^4
float ndf_density(vec3 h, vec2 alpha) {
  float area = alpha.x * alpha.y;
  vec2 stretched = h.xy / alpha;
  float radius_squared = dot(stretched, stretched);
  float cos_squared = square(max(h.z, MIN_COS));
  if (spec_ndf == NDF_GGX) return INV_PI / (area * square(cos_squared + radius_squared));
  float slope_squared = radius_squared / cos_squared;
  float exponent = slope_squared;
  if (spec_ndf == NDF_COSINE) exponent = (1.0 / area + 1.0) * log1p_accurate(area * slope_squared);
  // In halves: the exponential alone would underflow before its quotient with cos^4 does.
  return (INV_PI / area) * square(exp_accurate(-0.5 * exponent) / cos_squared);
}

// Tail probability P(slope > cot(theta)) of the Cosine distribution and its first moment there, as
// (tail, moment): Lambda = moment / cot_scaled - tail. With p = 1 / (ax ay) the 1D slope density is Student's
// t; tail = erfc(w) / 2 where w^2 / (p L) runs smoothly from Gamma(p + 1/2)^2 / (p Gamma(p)^2) at L = 0 to 1,
// L = ln(1 + cot^2). Absolute error of the tail below 1e-5, relative error of the moment below 3e-6.
vec2 cosine_tail_and_moment(float cot_scaled, float q) {
  float log_term = log1p_accurate(q * square(cot_scaled));  // L; cot^2 = q cot_scaled^2 with q = 1 / p
  float y = log_term / q;
  float z = 1.0 / (1.0 + 0.1 * log_term);
  float deficit = (-0.20614706 + q * 0.128284) +
                  z * ((0.70436987 - q * 0.31026941) + z * (-0.24759133 + q * 0.14610497));
  float w = sqrt(y * (1.0 - q * deficit));
  float tail = 0.5 * erfc_scaled(w) * exp_accurate(-w * w);
  float gamma_ratio = 1.0 + q * (-0.250064576 + q * (0.0317376581 + q * (0.00701533344 - q * 0.00329224676)));
  float moment = sqrt(gamma_ratio) * INV_SQRT_PI / (2.0 - q) * exp_accurate(0.5 * log_term - y);
  return vec2(tail, moment);
}

// Area of the visible microsurface projected along w, per unit of macrosurface, under Smith's assumption:
// |w.z| (1 + Lambda(w)) = |w.z| / G1(w). Finite and positive down to grazing.
float smith_projected_area(vec3 w, vec2 alpha) {
  float z = max(abs(w.z), MIN_COS);
  vec2 p = alpha * w.xy;
  float radius_squared = dot(p, p);
  if (spec_ndf == NDF_GGX) return 0.5 * (z + sqrt(z * z + radius_squared));
  float radius = sqrt(max(radius_squared, 1e-30));
  float cot_scaled = z / radius;  // 1 / (alpha tan(theta))
  if (spec_ndf == NDF_COSINE) {
    vec2 tail_moment = cosine_tail_and_moment(cot_scaled, alpha.x * alpha.y);
    return z * (1.0 - tail_moment.x) + radius * tail_moment.y;
  }
  float a = min(cot_scaled, 9.0);
  float gauss = exp_accurate(-a * a);
  return z * (1.0 - 0.5 * gauss * erfc_scaled(a)) + (0.5 * INV_SQRT_PI) * radius * gauss;
}

// Normal with pdf D(h) h.z.
vec3 sample_ndf(vec2 alpha, vec2 u) {
  float complement = 1.0 - u.x;
  float slope_squared;
  if (spec_ndf == NDF_GGX) {
    slope_squared = u.x / complement;
  } else {
    float optical = -log_accurate(complement);
    float area = alpha.x * alpha.y;
    slope_squared = spec_ndf == NDF_COSINE ? expm1_accurate(min(area * optical, 80.0)) / area : optical;
  }
  vec2 slope = sqrt(slope_squared) * cos_sin_turns(u.y);
  return normalize(vec3(alpha * slope, 1.0));
}

// Slope x in the plane of incidence with density proportional to max(a - x, 0) exp(-x^2), where a is the
// scaled cotangent of the direction. Folded at 0 the density is exactly the sum of
//   2 a exp(-r^2) on r < a (x = +r with probability (1 - r / a) / 2, else -r),
//   a exp(-r^2) on r > a and r exp(-r^2) on r > a (both x = -r),
// each of which is inverted in closed form, so neither iteration nor table is needed.
float sample_beckmann_slope(float a, float u, inout float u_choice) {
  float gauss = exp_accurate(-a * a);
  float outside = gauss * erfc_scaled(a);  // erfc(a)
  float mass_inner = SQRT_PI * (1.0 - outside);
  float mass_gauss = mass_inner + 0.5 * SQRT_PI * outside;
  float mass_rayleigh = 0.5 * gauss / a;
  float target = u * (mass_gauss + mass_rayleigh);
  float complement = target < mass_inner ? 1.0 - target * INV_SQRT_PI : (mass_gauss - target) * (2.0 * INV_SQRT_PI);
  float radius = erf_inverse_complement(clamp(complement, 2e-8, 1.0));
  float rest = clamp((target - mass_gauss) / max(mass_rayleigh, 1e-30), 0.0, ONE_MINUS_ULP);
  if (target >= mass_gauss) radius = sqrt(a * a - log_accurate(1.0 - rest));
  float positive = target < mass_inner ? 0.5 * max(1.0 - radius / a, 0.0) : 0.0;
  bool is_positive = u_choice < positive;
  u_choice = is_positive ? u_choice / positive : (u_choice - positive) / (1.0 - positive);
  return is_positive ? radius : -radius;
}

// A sampled microfacet normal h and its cosine with the direction it was sampled for.
struct Facet {
  vec3 h;
  float w_dot_h;  // <= 0: invalid
};

// GGX visible normals by spherical caps (Dupuy and Benyoub, "Sampling Visible GGX Normals with Spherical
// Caps", 2023), with z, sin^2 = (1 - z) (1 + z) and w.h written free of cancellation.
Facet sample_visible_ggx(vec3 w, vec2 alpha, vec2 u) {
  vec3 stretched = vec3(alpha * w.xy, max(w.z, MIN_COS));
  float stretched_length = length(stretched);
  stretched /= stretched_length;
  float height = 1.0 + stretched.z;  // of the cap; its point has 1 - z = u.x * height
  float z = (1.0 - u.x) * height;    // of half_vector; the point's 1 + z is this and 1 - stretched.z
  float squared_sine = u.x * height * (dot(stretched.xy, stretched.xy) / height + z);
  vec3 half_vector = vec3(sqrt(squared_sine) * cos_sin_turns(u.y) + stretched.xy, z);
  vec3 unstretched = vec3(alpha * half_vector.xy, half_vector.z);
  float inverse_length = inversesqrt(dot(unstretched, unstretched));
  Facet facet;
  facet.h = unstretched * inverse_length;
  // The closed form has no cancellation at grazing; elsewhere the dot product agrees better with h as rounded.
  float grazing = 0.5 * stretched_length * dot(half_vector, half_vector) * inverse_length;
  float direct = dot(w, facet.h);
  facet.w_dot_h = direct > 0.01 ? direct : grazing;
  return facet;
}

// Beckmann visible normals: Heitz and d'Eon, "Importance Sampling Microfacet-Based BSDFs using the
// Distribution of Visible Normals", 2014, with the slopes of sample_beckmann_slope.
Facet sample_visible_beckmann(vec3 w, vec2 alpha, vec2 u, inout float u_choice) {
  vec2 stretched = alpha * w.xy;
  float radius = sqrt(max(dot(stretched, stretched), 1e-30));
  vec2 azimuth = stretched.x == 0.0 && stretched.y == 0.0 ? vec2(1.0, 0.0) : stretched / radius;
  float a = clamp(w.z / radius, 1e-7, 1e9);
  vec2 slope = vec2(sample_beckmann_slope(a, u.x, u_choice), erf_inverse(2.0 * u.y - 1.0));
  vec2 turned = vec2(azimuth.x * slope.x - azimuth.y * slope.y, azimuth.y * slope.x + azimuth.x * slope.y);
  Facet facet;
  facet.h = normalize(vec3(-alpha * turned, 1.0));
  facet.w_dot_h = dot(w, facet.h);
  return facet;
}

// Visible normals of the V-cavity model for any distribution (Heitz and d'Eon 2014): a normal with pdf
// D(h) h.z, exchanged with its mirrored facet in proportion to what w sees of the two.
Facet sample_visible_v_cavity(vec3 w, vec2 alpha, vec2 u, inout float u_choice) {
  vec3 h = sample_ndf(alpha, u);
  float seen = dot(w, h);
  float seen_mirrored = 2.0 * w.z * h.z - seen;
  float keep = max(seen, 0.0) / max(max(seen, 0.0) + max(seen_mirrored, 0.0), 1e-30);
  bool is_kept = u_choice < keep;
  u_choice = is_kept ? u_choice / keep : (u_choice - keep) / max(1.0 - keep, 1e-30);
  Facet facet;
  facet.h = is_kept ? h : vec3(-h.xy, h.z);
  facet.w_dot_h = is_kept ? seen : seen_mirrored;
  return facet;
}

#endif
