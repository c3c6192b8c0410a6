// How wide microfacet lobes are made where a vertex is regularized: alpha^ = max(alpha, alpha_tau), where alpha_tau is so wide
// that the lobe's density stays below tau (docs/mathematics.md 2).
#ifndef REGULUS_LIB_RAISED_ALPHA_GLSL
#define REGULUS_LIB_RAISED_ALPHA_GLSL

#include "lib/numerics.glsl"
#include "lib/specialization.glsl"

// What one vertex is regularized with: the bound on a lobe's density and the factor on alpha_tau of its iteration.
struct Regularization {
  float tau;          // 1/sr, for this vertex
  float alpha_scale;  // i^(-1/6) in iteration i = 1, 2, ... of the consistent schedule, otherwise 1; 0: not regularized
  float full_tau;     // the same two for a fully regularized vertex, see full()
  float full_scale;
};

// The regularization that this vertex would have if paths from the camera were fully diffused there.
Regularization full(Regularization regularization) {
  regularization.tau = regularization.full_tau;
  regularization.alpha_scale = regularization.full_scale;
  return regularization;
}

// Interfaces whose indices differ by less than this share hardly bend light: no roughness blurs them (docs/mathematics.md 2.5),
// so their transmission is not regularized.
const float MIN_REGULARIZED_BEND = 0.02;

// alpha_tau of a reflection lobe (docs/mathematics.md 2.2; directional: 2.4). c: the cosine at which the directions meet the
// facet.
float reflection_alpha(float tau, float c) {
  if (spec_bound == BOUND_PEAK || (spec_bound == BOUND_SMITH && spec_shadowing == SHADOWING_V_CAVITY))
    return 0.5 * inversesqrt(PI * tau);
  if (spec_bound == BOUND_SMITH) return sqrt(sqrt((spec_ndf == NDF_GGX ? INV_PI : 1.0) / tau));
  c = max(c, 1e-4);
  if (spec_shadowing == SHADOWING_V_CAVITY) return 0.5 * inversesqrt(PI * tau) / c;
  float sine_squared = 1.0 - c * c;
  if (spec_shadowing == SHADOWING_SMITH) {
    // x sqrt(c^2 + x s^2) = k with x = alpha^2
    float k = 0.25 * INV_PI / (tau * c);
    float x = min(k / c, exp_accurate(log_accurate(k) * (2.0 / 3.0)));
    for (int i = 0; i < 4; ++i) {
      float root = sqrt(c * c + x * sine_squared);
      x -= (x * root - k) / (root + 0.5 * x * sine_squared / root);
    }
    return sqrt(max(x, 0.0));
  }
  // alpha (c + sqrt(c^2 + alpha^2 s^2)) = k
  float k = inversesqrt(PI * tau);
  float alpha = min(k / (2.0 * c), sqrt(k));
  for (int i = 0; i < 4; ++i) {
    float root = sqrt(c * c + alpha * alpha * sine_squared);
    alpha -= (alpha * (c + root) - k) / (c + root + alpha * alpha * sine_squared / root);
  }
  return alpha;
}

// alpha_tau of a refraction lobe; its bound does not depend on the angle. excess: eta^2 - 1.
float refraction_alpha(float inverse_eta, float excess, float tau) {
  float eta = 1.0 / inverse_eta;
  float bend = abs(excess) / (eta + 1.0);  // |eta - 1|
  float larger = max(eta, 1.0);
  if (bend < MIN_REGULARIZED_BEND * larger) return 0.0;
  float e = square(larger / bend);
  if (spec_bound == BOUND_SMITH && spec_shadowing != SHADOWING_V_CAVITY)
    return sqrt(sqrt(4.0 * e * (spec_ndf == NDF_GGX ? INV_PI : 1.0) / tau));
  return sqrt(e * INV_PI / tau);
}

// The largest alpha that a lobe is raised to: beyond 1 / sqrt(2) Beckmann's maximum leaves the normal (docs/mathematics.md 2.3).
float largest_alpha() { return spec_ndf == NDF_BECKMANN ? 0.70710678 : 1.0; }

// The walk's alpha raised to alpha_tau.
vec2 raised_alpha(vec2 alpha, float alpha_tau, Regularization regularization) {
  return max(alpha, vec2(min(alpha_tau * regularization.alpha_scale, largest_alpha())));
}

#endif
