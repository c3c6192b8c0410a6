// Energy that a microfacet lobe keeps by single scattering (GGX, F = 1): what raising alpha loses. Visible
// normals are sampled, E = mean(G2 / G1).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <random>
using namespace std;
typedef double D;
const D PI = M_PI;
D Lm(D a, D c) {
  D t2 = max(0.0, 1 - c * c) / (c * c);
  return .5 * (sqrt(1 + a * a * t2) - 1);
}
int main() {
  mt19937_64 g(1);
  uniform_real_distribution<D> U(0, 1);
  const D as[] = {0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0};
  for (int m = 0; m < 2; m++) {
    printf("%s: rows alpha, cols cos_i=1,0.7,0.5,0.2,0.1\n", m ? "height-correlated" : "uncorrelated");
    for (D al : as) {
      printf(" a=%.2f", al);
      const D cs[] = {1., .7, .5, .2, .1};
      for (D c : cs) {
        D ix = sqrt(1 - c * c), iz = c, s = 0;
        int N = 200000;
        for (int k = 0; k < N; k++) {
          D hx = al * ix, hz = iz, n = sqrt(hx * hx + hz * hz);
          hx /= n;
          hz /= n;
          D u = U(g), v = U(g), ph = 2 * PI * u, z = (1 - v) * (1 + hz) - hz, r = sqrt(max(0.0, 1 - z * z));
          D mx = r * cos(ph) + hx, my = r * sin(ph), mz = z + hz;
          mx *= al;
          my *= al;
          D l = sqrt(mx * mx + my * my + mz * mz);
          mx /= l;
          my /= l;
          mz /= l;
          D ih = ix * mx + iz * mz;
          D oz = 2 * ih * mz - iz;
          if (oz <= 0) continue;
          D li = Lm(al, iz), lo = Lm(al, oz);
          s += m ? (1 + li) / (1 + li + lo) : 1 / (1 + lo);
        }
        printf(" %.4f", s / N);
      }
      printf("\n");
    }
  }
}
