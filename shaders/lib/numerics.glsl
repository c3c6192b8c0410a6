// Elementary functions with stated error bounds, because the built-in ones are as loose as 62 ulp (exp) or
// 2e-4 absolute (sin on SwiftShader) on the devices we test on. Coefficients without a source are minimax
// fits made for this file. Bounds hold for round-to-nearest float arithmetic.
#ifndef REGULUS_LIB_NUMERICS_GLSL
#define REGULUS_LIB_NUMERICS_GLSL

const float PI = 3.14159265358979;
const float INV_PI = 0.318309886183791;
const float SQRT_PI = 1.77245385090552;
const float INV_SQRT_PI = 0.564189583547756;
const float LN_2_HIGH = 0.693359375;  // 9 bits, so that its product with an exponent is exact
const float LN_2_LOW = -2.12194440e-4;
const float ONE_MINUS_ULP = 0.99999994;  // the largest float below 1
const vec3 LUMINANCE = vec3(0.2126, 0.7152, 0.0722);  // Rec. 709

float square(float x) { return x * x; }
float safe_sqrt(float x) { return sqrt(max(x, 0.0)); }

// e^x, relative error below 3e-7; 0 below x = -87, e^88 above x = 88.
float exp_accurate(float x) {
  float clamped = clamp(x, -87.0, 88.0);
  float n = floor(clamped * 1.44269504 + 0.5);
  precise float r = (clamped - n * LN_2_HIGH) - n * LN_2_LOW;
  float p = 1.0 + r * (1.0 + r * (0.5 + r * (1.66666655e-1 + r * (4.16667648e-2 + r * (8.33215863e-3 +
            r * 1.39198829e-3)))));
  float scaled = p * intBitsToFloat((int(n) + 127) << 23);
  return x < -87.0 ? 0.0 : scaled;
}

vec3 exp_accurate(vec3 x) { return vec3(exp_accurate(x.x), exp_accurate(x.y), exp_accurate(x.z)); }

// Natural logarithm of a positive normal number, relative error below 3e-7 (also around x = 1).
float log_accurate(float x) {
  int bits = floatBitsToInt(x);
  int exponent = (bits - 0x3F3504F3) >> 23;  // mantissa in [sqrt(1/2), sqrt(2))
  float m = intBitsToFloat(bits - (exponent << 23));
  float f = m - 1.0;
  float s = f / (2.0 + f);
  float z = s * s;
  // log(m) = 2 atanh(s)
  float log_m = 2.0 * s * (1.0 + z * (0.333333333 + z * (0.2 + z * (0.142857143 + z * 0.111111111))));
  float e = float(exponent);
  precise float sum = e * LN_2_HIGH + (log_m + e * LN_2_LOW);
  return sum;
}

// log(1 + x) for x >= 0, relative error below 4e-7.
float log1p_accurate(float x) {
  precise float u = 1.0 + x;
  precise float lost = x - (u - 1.0);
  return log_accurate(u) + lost / u;
}

// e^x - 1 for x >= 0, relative error below 2e-6.
float expm1_accurate(float x) {
  float series = x * (1.0 + x * (0.5 + x * (1.66666667e-1 + x * (4.16666667e-2 + x * 8.33333333e-3))));
  return x < 0.25 ? series : exp_accurate(x) - 1.0;
}

// (cos t, sin t) for |t| <= pi/4, absolute error below 1e-7.
vec2 cos_sin_octant(float t) {
  float z = t * t;
  float s = t * (1.0 + z * (-0.1666665461 + z * (0.00833216067 - z * 0.000195152705)));
  float c = 1.0 + z * (-0.4999999969 + z * (0.04166662035 + z * (-0.001388668154 + z * 2.438355741e-5)));
  return vec2(c, s);
}

// (cos(2 pi u), sin(2 pi u)) for u in [0, 1], absolute error below 1.5e-7.
vec2 cos_sin_turns(float u) {
  float quadrant = floor(4.0 * u + 0.5);
  vec2 cs = cos_sin_octant((u - 0.25 * quadrant) * (2.0 * PI));
  uint q = uint(quadrant);
  vec2 turned = (q & 1u) != 0u ? vec2(-cs.y, cs.x) : cs;
  return (q & 2u) != 0u ? -turned : turned;
}

// Angle of the point (x, y) in turns, in [-1/2, 1/2], absolute error below 5e-8; 0 at the origin. The polynomial is that
// of Cephes' atanf (Moshier).
float atan2_turns(float y, float x) {
  float larger = max(abs(x), abs(y));
  float t = larger > 0.0 ? min(abs(x), abs(y)) / larger : 0.0;
  bool is_upper = t > 0.41421356;  // tan(pi/8)
  float r = is_upper ? (t - 1.0) / (t + 1.0) : t;
  float z = r * r;
  float angle = r + r * z * (-3.33329491539e-1 + z * (1.99777106478e-1 + z * (-1.38776856032e-1 + z * 8.05374449538e-2)));
  float turns = (0.5 * INV_PI) * angle + (is_upper ? 0.125 : 0.0);
  if (abs(y) > abs(x)) turns = 0.25 - turns;
  if (x < 0.0) turns = 0.5 - turns;
  return y < 0.0 ? -turns : turns;
}

// e^(x^2) erfc(x) for x >= 0; times e^(-x^2) the absolute error is below 5e-7. The form of Abramowitz and
// Stegun 7.1.26.
float erfc_scaled(float x) {
  float t = 1.0 / (1.0 + 0.3275911 * x);
  return t * (0.254826229 + t * (-0.284480965 + t * (1.42138623 + t * (-1.45313086 + t * 1.06139936))));
}

// Error function, absolute error below 5e-7.
float erf_accurate(float x) {
  float magnitude = 1.0 - erfc_scaled(abs(x)) * exp_accurate(-x * x);
  return x < 0.0 ? -magnitude : magnitude;
}

// erf^-1(1 - complement) for complement in (0, 1]: relative error below 1e-6 down to complement = 1e-7.
// The ratio erf^-1(y) / y is smooth in w = -ln(1 - y^2) (Giles, "Approximating the erfinv function", 2010).
float erf_inverse_complement(float complement) {
  float c = max(complement, 2e-8);
  float w = -log_accurate(c * (2.0 - c));
  float numerator = 0.886227343 + w * (0.363677876 + w * (0.0762216883 + w * (0.0104000334 + w * (8.98975554e-4 +
                    w * 7.72510675e-6))));
  float denominator = 1.0 + w * (0.148577568 + w * (0.034037823 + w * (0.00357877671 + w * 1.31612015e-4)));
  return (1.0 - c) * numerator / denominator;
}

// Inverse of the error function for |y| < 1.
float erf_inverse(float y) {
  float magnitude = erf_inverse_complement(1.0 - abs(y));
  return y < 0.0 ? -magnitude : magnitude;
}

#endif
