// Path diffusion blurs the two sides of a path differently: one glossy vertex, three techniques (an
// unregularized connection, a regularized one, the walk), weights from rho^W = rho^ (D(n) / D(h))^beta with
// one beta per vertex.
#include <cmath>
#include <cstdio>
#include <initializer_list>
using namespace std;
typedef double D;
const D PI = M_PI;
D K(D a, D u) {
  D t = u / (a * a);
  return 1 / (PI * a * a * (1 + t) * (1 + t));
}
template <class F>
D integ(F f) {
  const int N = 20000;
  D l0 = log(1e-16), l1 = log(1e10), s = 0;
  for (int i = 0; i < N; i++) {
    D u = exp(l0 + (i + .5) * (l1 - l0) / N);
    s += f(u) * PI * u * (l1 - l0) / N;
  }
  return s;
}
int main() {
  printf(
      "E (ideal 1) and 2nd moment (relative to standard p-only MIS)   pdfs: X: x, A: a (both relative to "
      "b*P_hat), B: b*rho\n");
  for (D R : {2., 10., 100.})
    for (D x : {0., 1.})
      for (D a : {.1, 1., 10.})
        for (D b : {1., 1e-6}) {
          D al = 1 / R, P = K(1, 0), PX = K(al, 0);
          D X = x * P, A = a * P;
          D E[4], M[4];
          for (int m = 0; m < 4; m++) {
            D be = m == 2 ? 1 : m == 3 ? 1 - 1 / (R * R) : 0;
            auto w = [&](D u, D& wx, D& wa, D& wb) {
              D r = K(al, u), rh = K(1, u);
              D px, pa, pb;
              if (m == 0) {
                px = X;
                pa = A;
                pb = b * r;
              } else {
                D WX = r * pow(PX / r, be), WA = rh * pow(P / rh, be); /*phat: multiply all by W_ref=WA*/
                px = X * WA / WX;
                pa = A;
                pb = b * WA;
              }
              D S = px + pa + pb;
              wx = px / S;
              wa = pa / S;
              wb = pb / S;
            };
            E[m] = integ([&](D u) {
              D wx, wa, wb;
              w(u, wx, wa, wb);
              return wx * K(al, u) + wa * K(1, u) + wb * K(al, u);
            });
            M[m] = integ([&](D u) {
              D wx, wa, wb;
              w(u, wx, wa, wb);
              D r = K(al, u), rh = K(1, u);
              return (X > 0 ? wx * wx * r * r / X : 0) + wa * wa * rh * rh / A + wb * wb * r / b;
            });
          }
          printf(
              " R=%-4g x=%g a=%-4g b=%-5g: E p-only %.3f  paper 1/I %.3f  peak %.3f  blend %.3f | M2: paper "
              "%.3g peak %.3g blend %.3g\n",
              R, x, a, b, E[0], E[1], E[2], E[3], M[1] / M[0], M[2] / M[0], M[3] / M[0]);
        }
}
