// A point light, two perfect mirrors (z = 0, z = 2), a diffuse receiver: irradiance by three connection
// techniques against the second-order image, E = I cos / d^2.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
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
// returns rho_hat (F=1) and its peak value (same G/cos, D at h=n)
D rho(D a, V n, V i, V o, D& pk) {
  D ci = dt(n, i), co = dt(n, o);
  if (ci <= 1e-6 || co <= 1e-6) {
    pk = 0;
    return 0;
  }
  V h = nm(i + o);
  D ch = min(1.0, dt(n, h));
  D G = 1 / (1 + Lm(a, ci) + Lm(a, co));
  D k = G / (4 * ci * co);
  pk = k / (PI * a * a);
  return k * Dg(a, ch);
}
int main() {
  mt19937_64 g(3);
  uniform_real_distribution<D> U(0, 1);
  V L = {0, 0, 1.1}, R = {4, 0.3, 0.9}, nR = {-1, 0, 0};
  V n1 = {0, 0, 1}, n2 = {0, 0, -1};
  D z1 = 0, z2 = 2;
  // exact: unfold. path L -> M1(z=0) -> M2(z=2) -> R : image of L in M1: z=-1.1 ; image in M2 (z=2):
  // z=4+1.1=5.1
  V Li = {L.x, L.y, 5.1};
  V d = Li - R;
  D d2 = dt(d, d);
  D Eex = max(0.0, dt(nR, nm(d))) / d2;
  printf("exact irradiance (I=1): %.6g\n", Eex);
  for (D ah : {0.3, 0.1, 0.05, 0.02}) {
    D Eu[3] = {0, 0, 0}, Ep[3] = {0, 0, 0}, Ek[3] = {0, 0, 0}, M2u = 0, M2p = 0, M2k = 0;
    long N = 20000000;
    for (long t = 0; t < N; t++) {  // light sub-path
      auto hitz = [&](V o, V w, D z, V& x) {
        D s = (z - o.z) / w.z;
        if (!(s > 1e-9) || s > 1e7) return false;
        x = o + s * w;
        return true;
      };
      D c = 1 - 2 * U(g), ph = 2 * PI * U(g), s = sqrt(max(0.0, 1 - c * c));
      V wl = {s * cos(ph), s * sin(ph), c};
      V l1, l2;
      bool bl1 = wl.z < 0 && hitz(L, wl, z1, l1);
      bool bl2 = false;
      if (bl1) {
        V w = {wl.x, wl.y, -wl.z};
        bl2 = hitz(l1, w, z2, l2);
      }
      D r = sqrt(U(g)), p2 = 2 * PI * U(g);
      V wc = {-sqrt(max(0.0, 1 - r * r)), r * cos(p2), r * sin(p2)};
      V c2, c1;
      bool bc2 = wc.z > 0 && hitz(R, wc, z2, c2);
      bool bc1 = false;
      if (bc2) {
        V w = {wc.x, wc.y, -wc.z};
        bc1 = hitz(c2, w, z1, c1);
      }
      auto eval = [&](int k, V x1, V x2) {  // k: technique s=1,2,3 on path L,x1,x2,R
        V a = L - x1, b = x2 - x1, e = R - x2;
        D da = sqrt(dt(a, a)), db = sqrt(dt(b, b)), de = sqrt(dt(e, e));
        V A = (1 / da) * a, B = (1 / db) * b, E = (1 / de) * e;
        D p1, p2_;
        bool s1 = (k == 3), s2 = (k == 1);  // exact specular at x1 if k==3, at x2 if k==1
        D r1 = rho(ah, n1, A, B, p1), r2 = rho(ah, n2, -1.0 * B, E, p2_);
        (void)s1;
        (void)s2;
        D c1a = dt(n1, A), c1b = dt(n1, B), c2b = dt(n2, -1.0 * B), c2e = dt(n2, E),
          cR = max(0.0, dt(nR, -1.0 * E));
        if (r1 <= 0 || r2 <= 0 || cR <= 0) return;
        D gLx1 = c1a / (da * da), g12 = c2b / (db * db), g21 = c1b / (db * db), gR2 = c2e / (de * de);
        D PD = cR / PI * gR2, PL = gLx1 / (4 * PI);
        D val;
        if (k == 1)
          val = PI * r1 * c1a / (da * da);
        else if (k == 2)
          val = (4 * PI) * (PI)*r1 * r2 * c1b * c2b / (db * db) * 1.0 / (1.0) * 1.0;
        else
          val = (4 * PI) * r2 * c2e * cR / (de * de);  // I=1: Phi=4pi ; PD throughput pi ;
        if (k == 2) val = (4 * PI) * PI * r1 * r2 * c1b * c2b / (db * db) / (1.0);
        auto W = [&](D R1, D R2) {
          D q1 = PD * (R2 * c2b * g21), q2 = PL * PD, q3 = PL * (R1 * c1b * g12);
          return (k == 1 ? q1 : k == 2 ? q2 : q3) / (q1 + q2 + q3);
        };
        // cosine-weighted walk pdf: p-hat(dir x1->x2)=rho_hat*cos_out
        D wp = W(r1, r2), wk = W(p1, p2_);
        D v = val;
        if (k == 2) v = val;
        Eu[k - 1] += v;
        Ep[k - 1] += v * wp;
        Ek[k - 1] += v * wk;
        M2u += v * v;
        M2p += v * v * wp * wp;
        M2k += v * v * wk * wk;
      };
      if (bc1) eval(1, c1, c2);
      if (bl1 && bc2) eval(2, l1, c2);
      if (bl2) eval(3, l1, l2);
    }
    printf(
        "alpha_hat=%.2f  per-technique energy/exact: %.3f %.3f %.3f | TOTAL unmodified %.3f  paper(1/I) %.3f "
        " peak %.3f | 2nd moment rel unmod: paper %.3g peak %.3g\n",
        ah, Eu[0] / N / Eex, Eu[1] / N / Eex, Eu[2] / N / Eex, (Eu[0] + Eu[1] + Eu[2]) / N / Eex,
        (Ep[0] + Ep[1] + Ep[2]) / N / Eex, (Ek[0] + Ek[1] + Ek[2]) / N / Eex, M2p / M2u, M2k / M2u);
  }
}
