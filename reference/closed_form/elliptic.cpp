// B. C. Carlson, Numerical computation of real or complex elliptic integrals, Numer. Algorithms 10 (1995) 13; the
// amplitude by the arithmetic-geometric mean, Abramowitz and Stegun 16.4.
#include "closed_form/elliptic.hpp"

namespace atwood::closed_form {

namespace {

// Duplication shrinks the deviations fourfold a step; the series below err by their sixth power.
template <class S>
S close_enough() { return exponential(S(-digits<S>) * S(0.6931) / 6) / 4; }

}  // namespace

// R_C(x, y) = atan(sqrt((y - x)/x)) / sqrt(y - x) or its hyperbolic twin; 1/sqrt(x) sum at y = x.
template <class S>
S carlson_rc(S x, S y) {
  const S d = y - x;
  if (magnitude(d) < x / 16) {  // sum_k (-d/x)^k / (2k + 1) / sqrt(x)
    const S ratio = -d / x;
    S term = 1, sum = 0;
    for (int k = 0; magnitude(term) > unit_round_off<S>() / 8; ++k) {
      sum += term / (2 * k + 1);
      term *= ratio;
    }
    return sum / root(x);
  }
  if (d > 0) return arc_tangent(root(d), root(x)) / root(d);
  const S a = root(-d / x);  // atanh(a) / sqrt(-d)
  return log_of_1_plus(2 * a / (1 - a)) / (2 * root(-d));
}

template <class S>
S carlson_rf(S x, S y, S z) {
  S mean = (x + y + z) / 3;
  const S start = mean;
  const S spread = larger(magnitude(mean - x), larger(magnitude(mean - y), magnitude(mean - z)));
  const S x0 = x, y0 = y;
  S quarter = 1;
  while (quarter * spread > close_enough<S>() * mean) {
    const S l = root(x) * root(y) + root(x) * root(z) + root(y) * root(z);
    x = (x + l) / 4;
    y = (y + l) / 4;
    z = (z + l) / 4;
    mean = (mean + l) / 4;
    quarter /= 4;
  }
  const S X = (start - x0) * quarter / mean, Y = (start - y0) * quarter / mean, Z = -X - Y;
  const S e2 = X * Y - Z * Z, e3 = X * Y * Z;
  return (1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44) / root(mean);
}

template <class S>
S carlson_rj(S x, S y, S z, S p) {
  S mean = (x + y + z + 2 * p) / 5;
  const S start = mean, x0 = x, y0 = y, z0 = z;
  S spread = magnitude(mean - p);
  for (const S v : {x, y, z}) spread = larger(spread, magnitude(mean - v));
  S delta = (p - x) * (p - y) * (p - z), quarter = 1, sum = 0;
  while (quarter * spread > close_enough<S>() * mean) {
    const S rx = root(x), ry = root(y), rz = root(z), rp = root(p);
    const S l = rx * ry + rx * rz + ry * rz, d = (rp + rx) * (rp + ry) * (rp + rz);
    const S e = quarter * quarter * quarter * delta / (d * d);
    sum += quarter / d * carlson_rc(S(1), 1 + e);
    x = (x + l) / 4;
    y = (y + l) / 4;
    z = (z + l) / 4;
    p = (p + l) / 4;
    mean = (mean + l) / 4;
    quarter /= 4;
  }
  const S X = (start - x0) * quarter / mean, Y = (start - y0) * quarter / mean, Z = (start - z0) * quarter / mean;
  const S P = -(X + Y + Z) / 2;
  const S e2 = X * Y + X * Z + Y * Z - 3 * P * P, e3 = X * Y * Z + 2 * e2 * P + 4 * P * P * P;
  const S e4 = (2 * X * Y * Z + e2 * P + 3 * P * P * P) * P, e5 = X * Y * Z * P * P;
  const S series = 1 - 3 * e2 / 14 + e3 / 6 + 9 * e2 * e2 / 88 - 3 * e4 / 22 - 9 * e2 * e3 / 52 + 3 * e5 / 26;
  return quarter * series / (mean * root(mean)) + 6 * sum;
}

// a, b -> (a + b)/2, sqrt(a b); phi_N = 2^N a_N u, then backwards sin(2 phi_{n-1} - phi_n) = (c_n / a_n) sin phi_n.
// The arc sine as an arc tangent: its cosine is sqrt(cos^2 + (b_n / a_n)^2 sin^2), well conditioned as k -> 1.
template <class S>
S amplitude(S u, S kc) {
  if (kc == 0) return 2 * arc_tangent(hyperbolic_tangent(u / 2));
  std::array<S, 64> a, b, c;
  a[0] = 1;
  b[0] = kc;
  int n = 0;
  do {
    a[n + 1] = (a[n] + b[n]) / 2;
    b[n + 1] = root(a[n] * b[n]);
    c[n + 1] = (a[n] - b[n]) / 2;
    ++n;
  } while (n < 60 && magnitude(c[n]) > unit_round_off<S>() * a[n] / 4);
  S phi = std::ldexp(1.0, n) * a[n] * u;
  for (; n > 0; --n) {
    const S sn = a[n] * sine(phi), cn = cosine(phi);
    const S along = root(a[n] * a[n] * cn * cn + b[n] * b[n] * (sn / a[n]) * (sn / a[n]));
    phi = (phi + arc_tangent(c[n] * (sn / a[n]), along)) / 2;
  }
  return phi;
}

template Narrow carlson_rc(Narrow, Narrow);
template Wide carlson_rc(Wide, Wide);
template Narrow carlson_rf(Narrow, Narrow, Narrow);
template Wide carlson_rf(Wide, Wide, Wide);
template Narrow carlson_rj(Narrow, Narrow, Narrow, Narrow);
template Wide carlson_rj(Wide, Wide, Wide, Wide);
template Narrow amplitude(Narrow, Narrow);
template Wide amplitude(Wide, Wide);

}  // namespace atwood::closed_form
