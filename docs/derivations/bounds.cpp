// The bounds on lobes against their largest value over directions, by search.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <vector>
using namespace std;
typedef double D;
const D PI = M_PI;
struct V {
  D x, y, z;
};
V operator*(D s, V a) {
  return {s * a.x, s * a.y, s * a.z};
}
V operator+(V a, V b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
D dot(V a, V b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
V norm(V a) {
  return (1 / sqrt(dot(a, a))) * a;
}
enum Dist { GGX, BECK, COSN };
enum Geo { VCAV, SMITH_UNC, SMITH_HC };
D Dn(Dist d, D a, D c) {
  if (c <= 0) return 0;
  D t2 = (1 - c * c) / (c * c);
  if (d == GGX) {
    D k = 1 + t2 / (a * a);
    return 1 / (PI * a * a * c * c * c * c * k * k);
  }
  if (d == BECK) return exp(-t2 / (a * a)) / (PI * a * a * c * c * c * c);
  D n = 2 / (a * a) - 2;
  if (n < 0) n = 0;
  return (n + 2) / (2 * PI) * pow(c, n);
}
D Lam(Dist d, D a, D c) {
  c = fabs(c);
  D t = sqrt(max(0.0, 1 - c * c)) / c;
  if (t == 0) return 0;
  if (d == GGX) return 0.5 * (sqrt(1 + a * a * t * t) - 1);
  D x = 1 / (a * t);
  return 0.5 * (erf(x) - 1) + exp(-x * x) / (2 * x * sqrt(PI));
}
// exact V-cavity (Cook-Torrance/Torrance-Sparrow) G2 = min(1, 2 nh ni/|ih|, 2 nh no/|oh|) (reflection);
// Heitz&d'Eon transmission form: max(0, G1i+G1o-1); we use the product-free min for reflection only.
D G1v(D nh, D ni, D ih) {
  return min(1.0, 2 * nh * fabs(ni) / fabs(ih));
}
D G2(Geo g, Dist d, D a, V i, V o, V h, bool refr) {
  D ni = i.z, no = o.z, nh = h.z, ih = dot(i, h), oh = dot(o, h);
  if (g == VCAV) {
    D x = G1v(nh, ni, ih), y = G1v(nh, no, oh);
    return refr ? max(0.0, x + y - 1) : min(x, y);
  }
  D li = Lam(d, a, ni), lo = Lam(d, a, no);
  if (g == SMITH_UNC) return 1 / ((1 + li) * (1 + lo));
  if (refr) return 1 / ((1 + li) * (1 + lo));  // (HC refraction uses Beta fn; not used)
  return 1 / (1 + li + lo);
}
D frefl(Geo g, Dist d, D a, V i, V o) {
  if (i.z <= 0 || o.z <= 0) return 0;
  V h = norm(i + o);
  return Dn(d, a, h.z) * G2(g, d, a, i, o, h, false) / (4 * i.z * o.z);
}  // F=1
D ftran(Geo g, Dist d, D a, D ei, D eo, V i, V o) {  // Walter07 eq21 with F=0 ; i above, o below
  V h = norm(-1.0 * (ei * i + eo * o));
  if (h.z < 0) h = -1.0 * h;
  D ih = dot(i, h), oh = dot(o, h);
  if (ih * i.z <= 0 || oh * o.z <= 0) return 0;
  if (ih * oh >= 0) return 0;
  D den = ei * ih + eo * oh;
  if (den == 0) return 0;
  return fabs(ih * oh) / (fabs(i.z * o.z)) * eo * eo * Dn(d, a, h.z) * G2(g, d, a, i, o, h, true) /
         (den * den);
}
V dir(D th, D ph) {
  return {sin(th) * cos(ph), sin(th) * sin(ph), cos(th)};
}
bool refr(V i, V h, D ei, D eo, V& o) {
  D c = dot(i, h);
  D e = ei / eo;
  D s = 1 - e * e * (1 - c * c);
  if (s < 0) return false;
  D sg = c >= 0 ? 1 : -1;
  o = (e * c - sg * sqrt(s)) * h + (-e) * i;
  return true;
}
V refl(V i, V h) {
  return (2 * dot(i, h)) * h + (-1.0) * i;
}
int main() {
  const char* dn[] = {"GGX", "Beckmann", "Cosine"};
  const char* gn[] = {"V-cavity", "Smith-uncorrelated", "Smith-height-corr"};
  D alphas[] = {0.01, 0.03, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0};
  auto maxR = [&](Geo g, Dist d, D a, D thmax,
                  int w) -> D {  // w=0 rho ; 1 rho*cos_o ; 2 rho*sqrt(ci co); scan theta_i x (theta_h,phi_h)
    D best = 0;
    vector<D> ths;
    for (int k = 0; k <= 160; k++) {
      D u = k / 160.0;
      ths.push_back(thmax * (1 - pow(1 - u, 3)));
    }
    for (D ti : ths) {
      V i = dir(ti, 0);
      for (int a1 = 0; a1 <= 60; a1++) {
        D th = atan(a * 3.0 * pow(a1 / 60.0, 1.5));
        for (int p = 0; p <= (a1 ? 12 : 0); p++) {
          V h = dir(th, PI * p / 12);
          if (dot(i, h) <= 0) continue;
          V o = refl(i, h);
          if (o.z < cos(thmax)) continue;
          D f = frefl(g, d, a, i, o);
          if (w == 1) f *= o.z;
          if (w == 2) f *= sqrt(i.z * o.z);
          best = max(best, f);
        }
      }
    }
    return best;
  };
  auto Gb = [&](Geo g, Dist d, D a) -> D {
    if (g == VCAV) return 1;
    if (d == GGX) return 4 / (a * a);
    return 4 * PI / (a * a);
  };
  printf(
      "=== REFLECTION: max_dir(rho)/rho_bar ; F=1.   cols: theta<=30deg, 60, 80, 89, 89.9 ; then "
      "rho(normal,normal)/bound\n");
  for (auto g : {VCAV, SMITH_UNC, SMITH_HC})
    for (auto d : {GGX, BECK, COSN}) {
      printf("-- %s / %s\n", gn[g], dn[d]);
      for (D a : alphas) {
        D b = Gb(g, d, a) / (4 * PI * a * a);
        printf(" a=%.2f bound=%.4g :", a, b);
        for (D t : {30., 60., 80., 89., 89.9}) printf(" %9.4g", maxR(g, d, a, t * PI / 180, 0) / b);
        V n = {0, 0, 1};
        printf("   nrm %.4g\n", frefl(g, d, a, n, n) / b);
      }
    }
  printf(
      "\n=== cos-weighted: max rho*cos_o (89.9deg) times 4 pi a^2 [V-cav/normal-incidence units] and times 2 "
      "pi a^3\n");
  for (auto g : {VCAV, SMITH_UNC, SMITH_HC})
    for (D a : {0.03, 0.1, 0.3, 1.0}) {
      D m = maxR(g, GGX, a, 89.9 * PI / 180, 1), s = maxR(g, GGX, a, 89.9 * PI / 180, 2);
      printf(
          " %-20s a=%.2f  rho*co: %9.4g (x4pia^2=%.3f, x2pia^3=%.3f)   rho*sqrt(ci co): %9.4g "
          "(x4pia^2=%.3f)\n",
          gn[g], a, m, m * 4 * PI * a * a, m * 2 * PI * a * a * a, s, s * 4 * PI * a * a);
    }
  printf("\n=== REFRACTION (Walter07, 1-F=1): max rho / bound ; light going ei->eo\n");
  for (auto g : {VCAV, SMITH_UNC})
    for (auto d : {GGX, BECK})
      for (auto pr : vector<pair<D, D>>{{1, 1.5}, {1.5, 1}, {1, 1.1}, {1, 1.01}, {1, 2.4}}) {
        D ei = pr.first, eo = pr.second;
        printf("-- %s/%s ei=%.2f eo=%.2f\n", gn[g], dn[d], ei, eo);
        for (D a : {0.01, 0.1, 0.3, 0.7, 1.0}) {
          D mx = max(ei, eo), b = mx * mx / (PI * a * a * (ei - eo) * (ei - eo)) * Gb(g, d, a);
          printf(" a=%.2f bound=%.4g :", a, b);
          for (D tm : {30., 60., 80., 89.9}) {
            D thmax = tm * PI / 180, best = 0;
            for (int k = 0; k <= 150; k++) {
              D ti = thmax * (1 - pow(1 - k / 150.0, 3));
              V i = dir(ti, 0);
              for (int a1 = 0; a1 <= 60; a1++) {
                D th = atan(a * 3 * pow(a1 / 60.0, 1.5));
                for (int p = 0; p <= (a1 ? 12 : 0); p++) {
                  V h = dir(th, PI * p / 12);
                  if (dot(i, h) <= 0) continue;
                  V o;
                  if (!refr(i, h, ei, eo, o)) continue;
                  if (-o.z < cos(thmax)) continue;
                  best = max(best, ftran(g, d, a, ei, eo, i, o));
                }
              }
            }
            printf(" %9.4g", best / b);
          }
          V n = {0, 0, 1}, o = {0, 0, -1};
          printf("   nrm %.4g\n", ftran(g, d, a, ei, eo, n, o) / b);
        }
      }
  printf("\n=== D max vs 1/(pi a^2)\n");
  for (auto d : {GGX, BECK, COSN})
    for (D a : {0.3, 0.5, 0.7, 0.8, 0.9, 1.0}) {
      D m = 0;
      for (int k = 0; k < 20000; k++) {
        m = max(m, Dn(d, a, cos(k / 20000.0 * PI / 2)));
      }
      printf(" %-9s a=%.1f  maxD*pi a^2 = %.4f\n", dn[d], a, m * PI * a * a);
    }
  printf(
      "\n=== alpha_tau for tau (clamped to 1): V-cavity refl | Smith GGX refl | Smith Beck refl | V-cav refr "
      "1.5 | GGX refr 1.5 | GGX refr 1.1 | cone half-angle of tau [deg]\n");
  for (D t : {0.3, 1., 3., 10., 30., 100., 300., 1e3, 1e4, 1e5, 1e6}) {
    auto c = [&](D x) { return min(1.0, x); };
    D x = 1 / (2 * PI * t);
    printf(" tau=%-8g %.4f | %.4f | %.4f | %.4f | %.4f | %.4f | %.3f\n", t, c(sqrt(1 / (4 * PI * t))),
           c(pow(1 / (PI * t), .25)), c(pow(t, -.25)), c(1.5 / (0.5 * sqrt(PI * t))),
           c(pow(4 * 1.5 * 1.5 / (PI * t * .25), .25)), c(pow(4 * 1.1 * 1.1 / (PI * t * .01), .25)),
           x < 2 ? acos(1 - x) * 180 / PI : 180.0);
  }
}
