// B. C. Carlson, Numerical computation of real or complex elliptic integrals, Numer. Algorithms 10 (1995) 13; Jacobi's
// functions by the arithmetic-geometric mean.
#include "closed_form/elliptic.hpp"

#include <limits>

namespace atwood::closed_form {

namespace {

constexpr int kMaxDuplications = 500;  // the deviations of two arguments that are 0 never shrink
constexpr int kMaxMeans = 60;

template <class S> S not_a_number() { return S(std::numeric_limits<double>::quiet_NaN()); }

// Each duplication divides the deviations by four; the error of the series below is of their sixth power.
template <class S> S close_enough() { return exp(S(-kDigits<S>) * S(0.6931) / 6) / 4; }

}  // namespace

// R_C(x, y) = atan(sqrt((y - x)/x)) / sqrt(y - x) or its hyperbolic form; 1/sqrt(x) sum at y = x.
template <class S> S carlson_rc(S x, S y) {
  const S d = y - x;
  if (magnitude(d) < x / 16) {  // sum_k (-d/x)^k / (2k + 1) / sqrt(x)
    const S quotient = -d / x;
    S term = 1, sum = 0;
    for (int k = 0; magnitude(term) > unit_round_off<S>() / 8; ++k) {
      sum += term / (2 * k + 1);
      term *= quotient;
    }
    return sum / sqrt(x);
  }
  if (d > 0) return atan2(sqrt(d), sqrt(x)) / sqrt(d);
  const S a = sqrt(-d / x);  // atanh(a) / sqrt(-d)
  return log1p(2 * a / (1 - a)) / (2 * sqrt(-d));
}

template <class S> S carlson_rf(S x, S y, S z) {
  S mean = (x + y + z) / 3;
  const S start = mean;
  const S deviation = larger(magnitude(mean - x), larger(magnitude(mean - y), magnitude(mean - z)));
  const S x0 = x, y0 = y;
  S quarter = 1;
  for (int k = 0; quarter * deviation > close_enough<S>() * mean; ++k) {
    if (k == kMaxDuplications) return not_a_number<S>();
    const S l = sqrt(x) * sqrt(y) + sqrt(x) * sqrt(z) + sqrt(y) * sqrt(z);
    x = (x + l) / 4;
    y = (y + l) / 4;
    z = (z + l) / 4;
    mean = (mean + l) / 4;
    quarter /= 4;
  }
  const S X = (start - x0) * quarter / mean, Y = (start - y0) * quarter / mean, Z = -X - Y;
  const S e2 = X * Y - Z * Z, e3 = X * Y * Z;
  return (1 - e2 / 10 + e3 / 14 + e2 * e2 / 24 - 3 * e2 * e3 / 44) / sqrt(mean);
}

template <class S> S carlson_rj(S x, S y, S z, S p) {
  S mean = (x + y + z + 2 * p) / 5;
  const S start = mean, x0 = x, y0 = y, z0 = z;
  S deviation = magnitude(mean - p);
  for (const S v : {x, y, z}) deviation = larger(deviation, magnitude(mean - v));
  S delta = (p - x) * (p - y) * (p - z), quarter = 1, sum = 0;
  for (int k = 0; quarter * deviation > close_enough<S>() * mean; ++k) {
    if (k == kMaxDuplications) return not_a_number<S>();
    const S rx = sqrt(x), ry = sqrt(y), rz = sqrt(z), rp = sqrt(p);
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
  return quarter * series / (mean * sqrt(mean)) + 6 * sum;
}

// R. Bulirsch, Numer. Math. 7 (1965) 78: Gauss's transformation a, b -> (a + b)/2, sqrt(a b), and back on cot am. The
// cotangent keeps its relative accuracy close to the separatrix, where the angle would not.
template <class S> Jacobi<S> jacobi(S u, S kc) {
  Jacobi<S> made;
  if (kc == 0) {
    made.sn = tanh(u);
    made.cn = made.dn = 1 / cosh(u);
    return made;
  }
  std::array<S, 64> a, b;
  a[0] = 1;
  b[0] = kc;
  int n = 0;
  while (n < kMaxMeans && magnitude(a[n] - b[n]) > unit_round_off<S>() * a[n] / 4) {
    a[n + 1] = (a[n] + b[n]) / 2;
    b[n + 1] = sqrt(a[n] * b[n]);
    ++n;
  }
  // Rounding may keep the two means an ulp apart.
  if (n == kMaxMeans && !(magnitude(a[n] - b[n]) <= 4 * unit_round_off<S>() * a[n])) {
    made.sn = made.cn = made.dn = not_a_number<S>();
    return made;
  }
  const S whole = pi<S>() / a[n];  // 2 K
  made.halves = floor(u / whole + S(0.5));
  const S angle = a[n] * (u - made.halves * whole), s = sin(angle);
  made.dn = 1;
  if (s != 0) {
    // With phi_n = a_n u, c_n = a_n cot phi_n and d_n = dn at that stage: c_{n-1} = c_n d_n, and
    // d_{n-1} = (b_{n-1} a_{n-1} + q) / (a_{n-1} a_n ...) in Bulirsch's form below.
    S cot = cos(angle) / s, c = a[n] * cot;
    for (int k = n - 1; k >= 0; --k) {
      const S q = cot * c;
      c *= made.dn;
      made.dn = (b[k] + q) / (a[k] + q);
      cot = c / a[k];
    }
    made.sn = (s < 0 ? -1 : 1) / sqrt(cot * cot + 1);
    made.cn = magnitude(cot) / sqrt(cot * cot + 1);
  }
  return made;
}

template Narrow carlson_rc(Narrow, Narrow);
template Wide carlson_rc(Wide, Wide);
template Narrow carlson_rf(Narrow, Narrow, Narrow);
template Wide carlson_rf(Wide, Wide, Wide);
template Narrow carlson_rj(Narrow, Narrow, Narrow, Narrow);
template Wide carlson_rj(Wide, Wide, Wide, Wide);
template Jacobi<Narrow> jacobi(Narrow, Narrow);
template Jacobi<Wide> jacobi(Wide, Wide);

}  // namespace atwood::closed_form
