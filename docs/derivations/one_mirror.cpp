// Path tracing alone: a point light, a perfect mirror z = 0, a diffuse point; only nee at the mirror with
// rho^ finds the light. Energy and variance against alpha^, schedules, equation 16; the same where the raised
// lobe keeps its light, divided by what it reflects of even light towards the diffuse point.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>
using namespace std;
typedef double D;
const D PI = M_PI;
struct V {
  D x, y, z;
};
V operator-(V a, V b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
V operator+(V a, V b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
V operator*(D s, V a) {
  return {s * a.x, s * a.y, s * a.z};
}
D dt(V a, V b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
V nm(V a) {
  return (1 / sqrt(dt(a, a))) * a;
}
D Dg(D a, D c) {
  D t2 = max(0.0, 1 - c * c) / (c * c);
  D k = 1 + t2 / (a * a);
  return 1 / (PI * a * a * c * c * c * c * k * k);
}
D Lm(D a, D c) {
  D t2 = max(0.0, 1 - c * c) / (c * c);
  return .5 * (sqrt(1 + a * a * t2) - 1);
}
mt19937_64 g(3);
uniform_real_distribution<D> U(0, 1);
V L = {0, 0, 1.1}, R = {2, 0.3, 0.9};
// Share of even light that a raised mirror reflects towards cosine c at once: the mean over facets, drawn by
// D cos, of G2 (o.h) / (c h_z).
D reflected(D a, D c) {
  const int N = 256;
  const V o = {sqrt(1 - c * c), 0, c};
  D sum = 0;
  for (int i = 0; i < N; i++)
    for (int k = 0; k < N; k++) {
      D u = (i + .5) / N, p = 2 * PI * (k + .5) / N;
      D t = a * sqrt(u / (1 - u)), z = 1 / sqrt(1 + t * t);
      V h = {t * z * cos(p), t * z * sin(p), z};
      D oh = dt(o, h);
      V w = 2 * oh * h - o;
      if (oh > 0 && w.z > 0) sum += oh / (c * z) / (1 + Lm(a, c) + Lm(a, w.z));
    }
  return sum / (N * N);
}
// By a table, linear in alpha^ and in the cosine.
const int AS = 64, CS = 128;
const D A_MAX = .4;
vector<D> table;
D kept(D a, D c) {
  if (table.empty())
    for (int i = 0; i <= AS; i++)
      for (int k = 0; k <= CS; k++) table.push_back(i ? reflected(A_MAX * i / AS, max(k, 1) / D(CS)) : 1);
  D x = min(a / A_MAX * AS, AS - 1e-9), y = min(c * CS, CS - 1e-9);
  int i = x, k = y;
  x -= i;
  y -= k;
  D *p = &table[i * (CS + 1) + k], *q = p + CS + 1;
  return (1 - x) * ((1 - y) * p[0] + y * p[1]) + x * ((1 - y) * q[0] + y * q[1]);
}
bool keeps = false;
D sample(D ah) {
  D r = sqrt(U(g)), p2 = 2 * PI * U(g);
  V wc = {-sqrt(max(0.0, 1 - r * r)), r * cos(p2), r * sin(p2)};
  if (wc.z >= 0) return 0;
  V x = R + (-R.z / wc.z) * wc;
  V a = L - x;
  D d2 = dt(a, a);
  V A = (1 / sqrt(d2)) * a, B = -1.0 * wc;
  V h = nm(A + B);
  D ci = A.z, co = B.z;
  if (ci <= 1e-9 || co <= 1e-9) return 0;
  D rho = Dg(ah, min(1.0, h.z)) / (1 + Lm(ah, ci) + Lm(ah, co)) / (4 * ci * co);
  if (keeps) rho /= kept(ah, co);
  return PI * rho * ci / d2;
}
int main() {
  V Li = {0, 0, -1.1};
  V d = Li - R;
  D Eex = (-d.x / sqrt(dt(d, d))) / dt(d, d);
  for (bool k : {false, true}) {
    keeps = k;
    printf("(1%s) alpha_hat  tau_peak=1/(4 pi a^2)  E/exact  rel.variance  rel.variance*a^2\n",
           keeps ? ", light kept" : "");
    for (D ah : {0.4, 0.2, 0.1, 0.05, 0.025, 0.0125}) {
      long N = 8000000;
      D s = 0, q = 0;
      for (long i = 0; i < N; i++) {
        D v = sample(ah) / Eex;
        s += v;
        q += v * v;
      }
      s /= N;
      q = q / N - s * s;
      printf("   %.4f  %9.3g  %.4f  %10.4g  %.4g\n", ah, 1 / (4 * PI * ah * ah), s, q, q * ah * ah);
    }
  }
  keeps = false;
  printf(
      "(2) progressive, 200 samples/iteration, alpha_1=0.4: rel RMSE over 60 runs; schedules: fixed | a_i=a1 "
      "i^-1/6 (KD13, tau_peak~i^1/3) | a_i=a1 i^-1/12 (eq.16 tau fed into the Smith 1/a^4 bound) | i^-1/4\n");
  const auto progressive = [&](D ex, const vector<int>& counts, int runs, int paths) {
    printf("   exponent -%.4f :", ex);
    for (int n : counts) {
      D mse = 0, bias = 0;
      for (int r = 0; r < runs; r++) {
        D acc = 0;
        for (int i = 1; i <= n; i++) {
          D ah = 0.4 * pow(i, -ex), s = 0;
          for (int k = 0; k < paths; k++) s += sample(ah);
          acc += s / paths;
        }
        D e = acc / n / Eex - 1;
        mse += e * e;
        bias += e;
      }
      printf("  n=%d rmse %.4f bias %+.4f", n, sqrt(mse / runs), bias / runs);
    }
    printf("\n");
  };
  for (D ex : {0., 1 / 6., 1 / 12., 1 / 4.}) progressive(ex, {16, 64, 256, 1024, 4096}, 60, 200);
  keeps = true;
  printf("(2, light kept)\n");
  for (D ex : {0., 1 / 6.}) progressive(ex, {16, 256, 2048}, 200, 1024);
  printf("(3) eq.16 schedule tau_i=1/(2pi(1-cos(atan(i^-1/6 tan th0)))):");
  for (D t0 : {1., 30.}) {
    D th = acos(1 - 1 / (2 * PI * t0));
    printf("\n   tau0=%g:", t0);
    for (int i : {1, 8, 64, 1000, 10000, 1000000})
      printf(" i=%d:%.4g", i, 1 / (2 * PI * (1 - cos(atan(pow(i, -1 / 6.) * tan(th))))));
  }
  printf("\n");
  printf("(4) s^2(a)=2a^2[-(1+b)ln b-2(1-b)]/(1-b)^3, b=a^2: ");
  for (D a : {.01, .03, .1, .2, .3, .5, .7}) {
    D b = a * a;
    printf(" a=%.2f:%.4f", a, sqrt(2 * b * (-(1 + b) * log(b) - 2 * (1 - b)) / pow(1 - b, 3)));
  }
  printf("\n");
}
