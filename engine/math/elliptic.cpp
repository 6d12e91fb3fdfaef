#include "math/elliptic.hpp"

#include <limits>

namespace atwood {
namespace {

// R_C(1, 1 + e) = atan(sqrt e) / sqrt e, e >= 0.
template <class S> S carlson_rc_above_one(S e) {
  if (e > S(0.01)) {
    const S root = real::sqrt(e);
    return real::atan2(root, S(1)) / root;
  }
  S sum = S(1), power = S(1);
  for (int k = 3; power > real::epsilon<S>() / S(4); k += 2) {
    power *= e;
    sum += ((k & 2) != 0 ? -power : power) / S(k);
  }
  return sum;
}

// Each duplication divides the deviations from the mean by four: 100 are enough for any finite arguments.
constexpr int kMaxDuplications = 100;

// The series in the deviations from the mean leave out terms of the sixth power and above.
template <class S> bool small_enough(S deviation) {
  const S square = deviation * deviation;
  return square * square * square < real::epsilon<S>() / S(4);
}

}  // namespace

//   R_F(x, y, z) = R_F((x + l) / 4, (y + l) / 4, (z + l) / 4),  l = sqrt(xy) + sqrt(yz) + sqrt(zx)
template <class S> S carlson_rf(S x, S y, S z) {
  for (int i = 0; i < kMaxDuplications; ++i) {
    const S mean = (x + y + z) / S(3);
    const S X = (mean - x) / mean, Y = (mean - y) / mean, Z = -(X + Y);
    if (small_enough(real::max(real::abs(X), real::max(real::abs(Y), real::abs(Z))))) {
      const S e2 = X * Y - Z * Z, e3 = X * Y * Z;
      return (S(1) - e2 / S(10) + e3 / S(14) + e2 * e2 / S(24) - S(3) * e2 * e3 / S(44)) / real::sqrt(mean);
    }
    const S a = real::sqrt(x), b = real::sqrt(y), c = real::sqrt(z);
    const S l = a * b + b * c + c * a;
    x = (x + l) / S(4);
    y = (y + l) / S(4);
    z = (z + l) / S(4);
  }
  return std::numeric_limits<S>::quiet_NaN();
}

//   R_J(x, y, z, p) = R_J of (. + l) / 4, over 4, + 6 / d R_C(1, 1 + e),
//   d = (sqrt p + sqrt x)(sqrt p + sqrt y)(sqrt p + sqrt z),  e = (p - x)(p - y)(p - z) / d^2
template <class S> S carlson_rj(S x, S y, S z, S p) {
  S sum = S(0), scale = S(1), gap = (p - x) * (p - y) * (p - z);
  for (int i = 0; i < kMaxDuplications; ++i) {
    const S mean = (x + y + z + S(2) * p) / S(5);
    const S X = (mean - x) / mean, Y = (mean - y) / mean, Z = (mean - z) / mean, P = -(X + Y + Z) / S(2);
    if (small_enough(real::max(real::max(real::abs(X), real::abs(Y)), real::max(real::abs(Z), real::abs(P))))) {
      const S xyz = X * Y * Z, e2 = X * Y + X * Z + Y * Z - S(3) * P * P, e3 = xyz + S(2) * e2 * P + S(4) * P * P * P;
      const S e4 = (S(2) * xyz + e2 * P + S(3) * P * P * P) * P, e5 = xyz * P * P;
      const S series = S(1) - S(3) * e2 / S(14) + e3 / S(6) + S(9) * e2 * e2 / S(88) - S(3) * e4 / S(22) -
                       S(9) * e2 * e3 / S(52) + S(3) * e5 / S(26);
      return scale * series / (mean * real::sqrt(mean)) + S(6) * sum;
    }
    const S a = real::sqrt(x), b = real::sqrt(y), c = real::sqrt(z), r = real::sqrt(p);
    const S l = a * b + b * c + c * a, d = (r + a) * (r + b) * (r + c);
    sum += scale / d * carlson_rc_above_one(gap / (d * d));
    x = (x + l) / S(4);
    y = (y + l) / S(4);
    z = (z + l) / S(4);
    p = (p + l) / S(4);
    gap /= S(64);
    scale /= S(4);
  }
  return std::numeric_limits<S>::quiet_NaN();
}

// a, b <- (a + b) / 2, sqrt(a b) from 1, k', until they are one number: K = pi / (2 a). NaN after kMaxLevels, which
// only k' = 0 needs: K is then infinite.
template <class S> JacobiFunctions<S>::JacobiFunctions(S complement) {
  a_[0] = S(1);
  b_[0] = real::sqrt(complement);
  bool differ = true;
  for (; differ && levels_ < kMaxLevels - 1; ++levels_) {
    const S a = a_[levels_], b = b_[levels_];
    a_[levels_ + 1] = (a + b) / S(2);
    b_[levels_ + 1] = real::sqrt(a * b);
    differ = (a - b) * (a - b) > real::epsilon<S>() * a * b;
  }
  quarter_ = differ ? std::numeric_limits<S>::quiet_NaN() : real::atan2(S(1), S(0)) / a_[levels_];
}

// Descending Landen (Gauss) transformation, DLMF 22.7(i), from the circular functions of a_N u upwards. Written in
// cs = cn / sn it has no difference to lose digits in:
//   dn_n = (b_n + a_{n+1} cs_{n+1}^2) / (a_n + a_{n+1} cs_{n+1}^2),  cs_n = cs_{n+1} dn_{n+1} a_{n+1} / a_n
template <class S> auto JacobiFunctions<S>::at(S u) const -> Values {
  const S phase = a_[levels_] * u, sine = real::sin(phase);
  if (real::abs(sine) <= real::epsilon<S>()) return {u, S(1), S(1)};
  S cs = real::cos(phase) / sine, dn = S(1);
  for (int n = levels_ - 1; n >= 0; --n) {
    const S x = a_[n + 1] * cs * cs;
    cs *= dn * a_[n + 1] / a_[n];
    dn = (b_[n] + x) / (a_[n] + x);
  }
  const S sn = (sine < S(0) ? S(-1) : S(1)) / real::sqrt(S(1) + cs * cs);
  return {sn, cs * sn, dn};
}

#define ATWOOD_INSTANTIATE(S)           \
  template S carlson_rf<S>(S, S, S);    \
  template S carlson_rj<S>(S, S, S, S); \
  template class JacobiFunctions<S>;
ATWOOD_INSTANTIATE(float)
ATWOOD_INSTANTIATE(double)
ATWOOD_INSTANTIATE(long double)
ATWOOD_INSTANTIATE(Quad)
#undef ATWOOD_INSTANTIATE

}  // namespace atwood
