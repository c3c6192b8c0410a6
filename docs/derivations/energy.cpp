// Energy that different weights keep where techniques are regularized: one vertex, a connection and a walk.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
#include <vector>
using namespace std;
typedef double D;
const D PI = M_PI;
// slope-plane model, GGX kernel  rho_a(u)=1/(pi a^2 (1+u/a^2)^2), u = theta^2, dA = pi du ; gaussian kernel
// exp(-u/a^2)/(pi a^2)
int KER = 0;
D K(D a, D u) {
  D t = u / (a * a);
  return KER == 0 ? 1 / (PI * a * a * (1 + t) * (1 + t)) : exp(-t) / (PI * a * a);
}
template <class F>
D integ(F f, D umin = 1e-14, D umax = 1e10) {  // log-spaced in u, integral of f(u) pi du
  const int N = 12000;
  D l0 = log(umin), l1 = log(umax), s = 0;
  for (int i = 0; i < N; i++) {
    D x = l0 + (i + .5) * (l1 - l0) / N, u = exp(x);
    s += f(u) * PI * u * (l1 - l0) / N;
  }
  return s;
}
int main() {
  const D ah = 1;  // alpha-hat =1 unit in slope plane
  printf(
      "A = connection with rho_hat (pdf a const), B = walk with rho (pdf b*rho).  kappa = a/(b*P_hat).  E = "
      "total energy, ideal 1\n");
  for (KER = 0; KER < 2; KER++) {
    printf("kernel %s\n", KER ? "gaussian(Beckmann-like)" : "GGX");
    D P = K(ah, 0);
    for (D R : {1., 1.5, 2., 4., 10., 100., 1000.}) {
      D al = ah / R;
      printf(" alpha_hat/alpha=%-6g\n", R);
      for (D kap : {0.01, 0.1, 0.3, 1., 3., 10., 100.}) {
        D b = 1, a = kap * P * b;
        D E[6], M[6];
        for (int m = 0; m < 6; m++) {  // 0 unmodified, 1 paper 1/I, 2 np/f^2, 3 peak(beta=1), 4
                                       // beta=1-(al/ah)^2, 5 beta = 0.5*(1-(al/ah)^2)
          D bet = m == 3 ? 1 : m == 4 ? 1 - 1 / (R * R) : m == 5 ? .5 * (1 - 1 / (R * R)) : 0;
          auto wA = [&](D u) {
            D r = K(al, u), rh = K(ah, u);
            D pa, pb;
            if (m == 0) {
              pa = a;
              pb = b * r;
            } else if (m == 2) {
              pa = a / (rh * rh);
              pb = b / r;
            } else {
              D W = rh * pow(P / rh, bet);
              pa = a;
              pb = b * W;
            }
            return (pa + pb) > 0 ? pa / (pa + pb) : 1.0;
          };
          E[m] = integ([&](D u) {
            D w = wA(u);
            return w * K(ah, u) + (1 - w) * K(al, u);
          });
          M[m] = integ([&](D u) {
            D w = wA(u);
            D r = K(al, u), rh = K(ah, u);
            return w * w * rh * rh / a + (1 - w) * (1 - w) * r / b;
          });
        }
        printf(
            "   kappa=%-6g E: unmod %.3f paper %.3f np/f2 %.3f peak %.3f blend(1-1/R^2) %.3f half %.3f | 2nd "
            "moment rel. to unmod: paper %.3g np/f2 %.3g peak %.3g blend %.3g half %.3g\n",
            kap, E[0], E[1], E[2], E[3], E[4], E[5], M[1] / M[0], M[2] / M[0], M[3] / M[0], M[4] / M[0],
            M[5] / M[0]);
      }
    }
  }
  KER = 0;
  printf("closed form (alpha->0, GGX kernel) E=sqrt(k)*atan(1/sqrt(k))+1/(1+k): ");
  for (D k : {.01, .1, .2, .3, .5, 1., 3., 10., 100.})
    printf(" k=%g:%.4f", k, sqrt(k) * atan(1 / sqrt(k)) + 1 / (1 + k));
  printf("\nclosed form (Beckmann) E=k ln(1+1/k)+1/(1+k): ");
  for (D k : {.01, .1, .3, .5, 1., 3., 10.}) printf(" k=%g:%.4f", k, k * log(1 + 1 / k) + 1 / (1 + k));
  printf("\n");
  // ---- two connection techniques on the same vertex with different blur (per-side sigma, or BIOP13
  // reg+unreg)
  printf(
      "\nTwo CONNECTION techniques at the same vertex with different blur a1<=a2 (pdfs equal): E of 1/I "
      "weights (harmonic mean) vs plain vs peak\n");
  for (KER = 0; KER < 2; KER++)
    for (D R : {1., 1.5, 2., 4., 10., 100.}) {
      D a1 = 1 / R, a2 = 1;
      D Eh = integ([&](D u) {
        D f1 = K(a1, u), f2 = K(a2, u);
        return f1 + f2 > 0 ? 2 * f1 * f2 / (f1 + f2) : 0;
      });
      D P1 = K(a1, 0), P2 = K(a2, 0), w1 = (1 / P1) / (1 / P1 + 1 / P2);
      printf("  %s R=%-5g  E(1/I)=%.4f  E(p only)=1  E(peak weights)=%.4f (w of sharper technique %.4f)\n",
             KER ? "gauss" : "GGX", R, Eh, w1 + (1 - w1), w1);
    }
  KER = 0;
  // ---- two specular vertices in a row: K=3 segments, techniques s=1,2,3 (connections) [+ s=0 emission hit]
  printf(
      "\nTwo DELTA vertices (x1,x2), K=3. Techniques s=1..3 (+s=0 if light hittable). C_s = relative "
      "1/(n*rest) ; E ideal 1\n");
  mt19937_64 g(1);
  uniform_real_distribution<D> U(0, 1);
  auto run = [&](D k0, D k1, D k2, D k3,
                 bool s0) {  // Ihat_0=k0, Ihat_1=k1*y1, Ihat_2=k2*y1*y2, Ihat_3=k3*y2 with y=rho_hat/P
                             // in(0,1], y=v^2 for GGX importance-distributed v
    int N = 400000;
    D Ep = 0, Eu = 0, Ek = 0;
    for (int i = 0; i < N; i++) {
      D y1 = pow(U(g), 2), y2 = pow(U(g), 2);
      auto W = [&](int s, D a, D b) {
        D t[4] = {s0 ? 1 / k0 : 0, 1 / (k1 * a), 1 / (k2 * a * b), 1 / (k3 * b)};
        return t[s] / (t[0] + t[1] + t[2] + t[3]);
      };
      Ep += (s0 ? W(0, 1, 1) : 0) + W(1, y1, 1) + W(2, y1, y2) + W(3, 1, y2);
      Ek += (s0 ? W(0, 1, 1) : 0) + W(1, 1, 1) + W(2, 1, 1) + W(3, 1, 1);
      Eu += (s0 ? 1 : 0) + 3;
    }
    printf("  k0=%g k1=%g k2=%g k3=%g s0=%d : unmodified %.3f  paper(1/I) %.3f  peak-weights %.3f\n", k0, k1,
           k2, k3, s0, Eu / N, Ep / N, Ek / N);
  };
  for (bool s0 : {false, true}) {
    run(1, 1, 1, 1, s0);
    run(1, 10, 10, 10, s0);
    run(1, .1, 1, 10, s0);
    run(1, 1, 100, 1, s0);
    run(10, 3, 3, 3, s0);
    run(1, 3, .3, 3, s0);
    run(1, 3, 10, 3, s0);
  }
  // ---- MC: real path tracer, delta mirror at z=0, orthographic camera at normal incidence, disc light
  // radius Rl at height 1 facing down
  printf(
      "\n3D PT: delta mirror + disc light radius R at h=1 above, ortho camera along -z (rays pass the light: "
      "camera below light plane logically). total image energy / ideal\n");
  auto Dg = [&](D a, D c) {
    D t2 = (1 - c * c) / (c * c);
    D k = 1 + t2 / (a * a);
    return 1 / (PI * a * a * c * c * c * c * k * k);
  };
  auto Lm = [&](D a, D c) {
    D t2 = (1 - c * c) / (c * c);
    return .5 * (sqrt(1 + a * a * t2) - 1);
  };
  for (D ahat : {0.02, 0.05})
    for (D ratio : {0.5, 2., 3.65, 7., 20.}) {
      D Rl = ratio * ahat;
      D A = PI * Rl * Rl;
      int N = 4000000;
      D L = Rl + 60 * ahat;  // image half size
      D eu = 0, ep = 0, ek = 0;
      for (int i = 0; i < N; i++) {
        D x = (2 * U(g) - 1) * L,
          y = (2 * U(g) - 1) * L;  // pixel sample position on the mirror; incident dir from +z
        // emission hit: reflected ray goes straight up, hits light iff inside disc
        D P = 1 / (4 * PI * ahat * ahat);  // rho_hat at h=n normal incidence * cos(=1), F=1 ; Phat walk pdf
        if (x * x + y * y < Rl * Rl) {
          D pl = 1 / A; /*cos=1,d=1*/
          eu += 1;
          ep += P / (P + pl);
          ek += P / (P + pl);
        }
        // NEE
        D r = Rl * sqrt(U(g)), ph = 2 * PI * U(g);
        D dx = r * cos(ph) - x, dy = r * sin(ph) - y, d2 = dx * dx + dy * dy + 1, d = sqrt(d2);
        D co = 1 / d;
        D hz = (1 + co), hx = dx / d, hy = dy / d;
        D hn = sqrt(hx * hx + hy * hy + hz * hz);
        D ch = hz / hn;
        D G = 1 / (1 + Lm(ahat, 1 - 1e-15) + Lm(ahat, co));
        D rho = Dg(ahat, ch) * G / (4 * co);
        D geo = co * co / d2;
        D val = rho * geo * A;
        D pl = d2 / (A * co);
        D pw = rho * co;
        D pk = pw * Dg(ahat, 1 - 1e-15) / Dg(ahat, ch);
        eu += val;
        ep += val * pl / (pl + pw);
        ek += val * pl / (pl + pk);
      }
      D sc = 4 * L * L / N / (PI * Rl * Rl);
      D kap = 4 * ahat * ahat / (Rl * Rl);
      printf("  ahat=%.3f R/ahat=%-5g kappa=%-8.4g unmod %.3f  paper %.3f (closed form %.3f)  peak %.3f\n",
             ahat, ratio, kap, eu * sc, ep * sc, sqrt(kap) * atan(1 / sqrt(kap)) + 1 / (1 + kap), ek * sc);
    }
}
