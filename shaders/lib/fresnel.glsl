// Reflectance of a smooth interface: exact for dielectrics, its KHR_materials_specular remapping, Schlick for
// metals.
#ifndef REGULUS_LIB_FRESNEL_GLSL
#define REGULUS_LIB_FRESNEL_GLSL

#include "lib/numerics.glsl"

// Unpolarized Fresnel reflectance F of a dielectric for the cosine c on the incident side. excess = eta^2 - 1 with
// eta = n_transmitted / n_incident, and g = eta * (cosine of the refracted direction), so g^2 = c^2 + excess; g = 0 stands
// for total internal reflection. With b = c g + sin^2:
//   r_s = -excess / (c + g)^2    r_p = r_s (c g - sin^2) / b    1 - F = 2 c g (1 + eta^2 / b^2) / (c + g)^2
// Its relative error is below 1e-6, also for eta near 1.
float fresnel_dielectric(float c, float g, float excess) {
  float sum_squared = square(c + g);
  float sin_squared = (1.0 - c) * (1.0 + c);
  float b = c * g + sin_squared;
  float scale = square(1.0 / (sum_squared * b));
  float reflected = 0.5 * square(excess) * (square(c * g - sin_squared) + square(b)) * scale;
  return g > 0.0 ? min(reflected, 1.0) : 1.0;
}

// The Fresnel position s: where F lies between its value at normal incidence (0) and 1. As (s, 1 - s), because F - F_0 would
// cancel. With
// t = eta c, (c + g) b = eta^2 c + g and skew = (-eta^4 + 2 eta^3 + 2 eta^2 + 2 eta - 1) / (2 eta^2), the same for 1 / eta:
//   s = (excess sin^2 / ((c + g)^2 b (g + t)))^2 (g^2 + skew g t + t^2)
// 1 - s has a relative error below 1e-6 at grazing too. inverse_t0 = 1 / (1 - F_0).
vec2 fresnel_dielectric_position(float c, float g, float excess, float skew, float inverse_t0) {
  float sum_squared = square(c + g);
  float sin_squared = (1.0 - c) * (1.0 + c);
  float b = c * g + sin_squared;
  float t = sqrt(1.0 + excess) * c;
  float inverse = 1.0 / (sum_squared * b * (g + t));
  float reflected = square(excess * sin_squared * inverse) * (g * g + t * (skew * g + t));
  float transmitted = 2.0 * c * g * (square(b) + excess + 1.0) * (sum_squared * square((g + t) * inverse));
  return g > 0.0 ? vec2(min(reflected, 1.0), transmitted * inverse_t0) : vec2(1.0, 0.0);
}

// g of fresnel_dielectric for a cosine on the incident side.
float refracted_g(float c, float excess) { return safe_sqrt(c * c + excess); }

// (1 - c)^5
float schlick_weight(float c) {
  float m = clamp(1.0 - c, 0.0, 1.0);
  return square(square(m)) * m;
}

// 1 - (1 - c)^5 by its factor c, accurate also at grazing, where it is little.
float schlick_rest(float c) { return clamp(c * (5.0 + c * (-10.0 + c * (10.0 + c * (-5.0 + c)))), 0.0, 1.0); }

// How far, from 0 at normal incidence to 1 at grazing, the cosine-weighted mean of the exact reflectance lies:
// (F_avg - F_0) / (1 - F_0) for light that comes from outside. Error below 1e-5 for ior in [1, 10], below
// 2e-3 beyond. x = (ior - 1) / (ior + 1).
float fresnel_mean_position_from_thin(float x) {
  float v = sqrt(x);
  float numerator = 0.684179389 + v * (-0.365813115 + v * (0.265738673 + v * (-2.3757069 + v * 1.58485569)));
  float denominator = 1.0 + v * (0.429550602 + v * (4.04550278 - v * 4.76732933));
  float d = safe_sqrt(1.0 - x);
  float high = -0.333333333 + d * (0.10833273 + d * (3.42691573 + d * (-8.70691619 + d * 7.60746608)));
  return x < 0.825 ? x * numerator / denominator : high;
}

// The same for any x: with ior < 1, where the denser medium is outside, n^2 (1 - F_avg(inside)) = 1 - F_avg(outside).
float fresnel_mean_position(float x) {
  float position = fresnel_mean_position_from_thin(abs(x));
  return x < 0.0 ? 1.0 - (1.0 - position) * square((1.0 + x) / (1.0 - x)) : position;
}

#endif
