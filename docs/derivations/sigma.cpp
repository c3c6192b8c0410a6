// The state of path diffusion (v_x, c, v_a) against sampled bundles of rays.
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
mt19937_64 g(5);
uniform_real_distribution<D> U(0, 1);
normal_distribution<D> Nrm(0, 1);
void onb(V n, V& a, V& b) {
  a = nm(fabs(n.x) > .9 ? V{n.y, -n.x, 0} : V{0, n.z, -n.y});
  b = {n.y * a.z - n.z * a.y, n.z * a.x - n.x * a.z, n.x * a.y - n.y * a.x};
}
V toW(V n, V l) {
  V a, b;
  onb(n, a, b);
  return l.x * a + l.y * b + l.z * n;
}
V toL(V n, V w) {
  V a, b;
  onb(n, a, b);
  return {dt(w, a), dt(w, b), dt(w, n)};
}
V vndf(V i, D al) {
  V h = nm(V{al * i.x, al * i.y, i.z});
  D u = U(g), v = U(g);
  D ph = 2 * PI * u;
  D z = (1 - v) * (1 + h.z) - h.z;
  D s = sqrt(max(0.0, 1 - z * z));
  V c = {s * cos(ph), s * sin(ph), z};
  V m = c + h;
  return nm(V{al * m.x, al * m.y, max(1e-9, m.z)});
}
V sampGGX(V n, V wi, D al) {
  V i = toL(n, wi);
  for (;;) {
    V h = vndf(i, al);
    V o = (2 * dt(i, h)) * h - i;
    if (o.z > 0) return toW(n, o);
  }
}
V sampLam(V n) {
  D r = sqrt(U(g)), p = 2 * PI * U(g);
  return toW(n, V{r * cos(p), r * sin(p), sqrt(max(0.0, 1 - r * r))});
}
// tangential std (per axis) of directions about a reference axis: project on plane perpendicular to the axis
D tstd(const vector<V>& w, V ax) {
  D s = 0;
  for (auto& v : w) {
    D c = dt(v, ax);
    s += max(0.0, 1 - c * c);
  }
  return sqrt(.5 * s / w.size());
}
int main() {
  int N = 400000;
  {
    vector<V> w;
    for (int i = 0; i < N; i++) w.push_back(sampLam({0, 0, 1}));
    printf("Lambert: sigma=%.4f (theory 0.5)\n", tstd(w, {0, 0, 1}));
  }
  printf(
      "GGX reflection lobe: tangential std about mirror direction; columns theta_i=0,45,70deg ; candidate "
      "s(a)\n");
  for (D al : {0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0}) {
    printf(" a=%.2f :", al);
    for (D th : {0., 45., 70.}) {
      V i = {sin(th * PI / 180), 0, cos(th * PI / 180)}, m = {-i.x, 0, i.z};
      vector<V> w;
      for (int k = 0; k < N; k++) w.push_back(sampGGX({0, 0, 1}, i, al));
      printf(" %.4f", tstd(w, m));
    }
    D v = 2 * al * al * log(1 + 1 / (al * al)) / 1.0;  // log-corrected GGX variance guess
    D s1 = 1 / sqrt(1 / (2 * al * al) + 4), s2 = 1 / sqrt(1 / v + 4);
    printf("   sqrt(2)a sat: %.4f   log-corrected sat: %.4f\n", s1, s2);
  }
  // ---- chain: collimated beam + GGX(a) + travel d1 + curved mirror radius R (convex, H=1/R) + travel d2 :
  // angular std
  printf(
      "chain: delta-beam -> GGX(a) flat (45deg) -> travel d1 -> sphere mirror (radius R, centre of the beam "
      "hits the pole, normal incidence) -> sigma on leaving\n");
  for (D al : {0.003, 0.01})
    for (D R : {1., 3., -4.})
      for (D d1 : {0.5, 2.}) {
        V i = nm(V{-1, 0, 1});
        V m = {1 / sqrt(2.), 0, 1 / sqrt(2.)};
        vector<V> w0, w1;
        V c = (d1 + R) * m;  // convex sphere centre further along (R>0); concave: centre before
        for (int k = 0; k < N; k++) {
          V w = sampGGX({0, 0, 1}, i, al);
          if (dt(w, m) < cos(12 * al)) continue; /*trim GGX tail: both measured alike*/
          V oc = V{0, 0, 0} - c;
          D b = dt(oc, w), cc = dt(oc, oc) - R * R, q = b * b - cc;
          if (q < 0) continue;
          D t = R > 0 ? -b - sqrt(q) : -b + sqrt(q);
          V x = t * w;
          V n = nm(x - c);
          if (dt(n, w) > 0) n = -1.0 * n;
          V o = w - (2 * dt(w, n)) * n;
          w0.push_back(w);
          w1.push_back(o);
        }
        D s0 = tstd(w0, m), s1 = tstd(w1, -1.0 * m);
        D vx = 0, cx = 0, va = s0 * s0;
        vx += 2 * d1 * cx + d1 * d1 * va;
        cx += d1 * va;
        D H = 1 / R;
        D va2 = va + 2 * (2 * H) * cx + 4 * H * H * vx;  // reflect: a' = a + 2 H x
        printf("  a=%.3f R=%g d1=%g : measured in %.5f out %.5f | predicted out %.5f\n", al, R, d1, s0, s1,
               sqrt(max(0.0, va2)));
      }
  printf(
      "refraction through flat interface eta=ni/nt: a'=eta*a ; through sphere surface radius R: a'=eta a "
      "-(1-eta) H x (collimated spot sigma_x)\n");
  for (D R : {2., 5.})
    for (D eta : {1 / 1.5, 1.5}) {
      vector<V> w1;
      D sx = 0.01;
      for (int k = 0; k < N; k++) {
        D x = sx * Nrm(g), y = sx * Nrm(g);
        D z = sqrt(R * R - x * x - y * y);
        V n = {x / R, y / R, z / R};
        V w = {0, 0, -1};
        D ci = -dt(w, n);
        D s2 = eta * eta * (1 - ci * ci);
        if (s2 > 1) continue;
        V o = eta * w + (eta * ci - sqrt(1 - s2)) * n;
        w1.push_back(nm(o));
      }
      printf("  R=%g eta=%.3f : measured %.6f predicted |1-eta|*sx/R = %.6f\n", R, eta, tstd(w1, {0, 0, -1}),
             fabs(1 - eta) * sx / R);
    }
  // ---- mixture, saturation: GGX after Lambert
  printf(
      "direction after 2 events (Lambert -> GGX mirror a): marginal incoming std about the mean axis; "
      "saturating sum 1/v=1/(v1+v2)+1/vmax with vmax=1/4\n");
  for (D al : {0.1, 0.3, 0.6}) {
    vector<V> w;
    for (int k = 0; k < N; k++) {
      V a = sampLam({0, 0, 1});
      V i = {-a.x, -a.y, a.z}; /*arrives at plane parallel above, use as wi*/
      V o = sampGGX({0, 0, 1}, i, al);
      w.push_back(o);
    }
    printf("  a=%.1f measured %.4f\n", al, tstd(w, {0, 0, 1}));
  }
}
