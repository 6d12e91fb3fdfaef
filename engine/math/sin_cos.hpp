// Sine and cosine together, of one number or of a pack of them, with the same bits: the rates of several states at once
// are those of each (math/system.hpp). Of doubles they err by less than 0.8 units in the last place.
//
// x = n pi/2 + r with |r| <= pi/4: pi/2 in three parts, of which n times the first two is exact up to |x| = 2^19, so
// that r = high + low has 100 bits. On [0, (pi/4)^2], with z = r^2, best approximations in the sense of Chebyshev:
//   sin r = r + r z S(z)      cos r = 1 - z / 2 + z^2 C(z)
// and n mod 4 exchanges them and sets their signs. Beyond 2^19, and of other scalars: the C library's.
#pragma once

#include <cstdint>

#include "math/pack.hpp"

namespace atwood::real {

namespace trigonometry {

inline constexpr double kMaxArgument = 524288.0;

template <class V> struct BitsOf { using Type = typename Integers<V>::Unsigned; };
template <> struct BitsOf<double> { using Type = std::uint64_t; };
template <class V> using Bits = typename BitsOf<V>::Type;

// |x| < kMaxArgument
template <class V> ATWOOD_INLINE void sin_cos_within(const V& x, V& sine, V& cosine) {
  constexpr double magic = 0x1.8p52;  // added, it leaves the nearest integer in the last bits
  const V shifted = x * 0x1.45f306dc9c883p-1 + magic, n = shifted - magic;
  const V first = x - n * 0x1.921fb54400000p+0, second = n * 0x1.0b4611a600000p-34;
  const V near = first - second, part = near - first;
  const V low = ((first - (near - part)) - (second + part)) - n * 0x1.3198a2e037073p-69;
  const V r = near + low, rest = (near - r) + low;
  const V z = r * r;
  const V S = -0.16666666666666632 +
              z * (0.00833333333332251 +
                   z * (-0.00019841269829862687 +
                        z * (2.7557313705706967e-06 + z * (-2.5050759676250402e-08 + z * 1.5896859392105228e-10))));
  const V C = 0.0416666666666666 +
              z * (-0.0013888888888874183 +
                   z * (2.4801587289507812e-05 +
                        z * (-2.755731435716839e-07 + z * (2.0875723652442864e-09 + z * -1.1359655551814878e-11))));
  const V half = 0.5 * z, up = 1.0 - half;
  const V s = r + (r * z * S + rest * up);
  const V c = up + (((1.0 - up) - half) + (z * z * C - r * rest));
  using B = Bits<V>;
  const B quarter = bits_as<B>(shifted), odd = -(quarter & 1u);
  const B s_bits = bits_as<B>(s), c_bits = bits_as<B>(c), other = (s_bits ^ c_bits) & odd;
  sine = bits_as<V>((s_bits ^ other) ^ ((quarter & 2u) << 62));
  cosine = bits_as<V>((c_bits ^ other) ^ (((quarter + 1u) & 2u) << 62));
}

}  // namespace trigonometry

// The same bits whether x is a scalar or the lane of a pack.
template <class S> ATWOOD_INLINE void same_sin_cos(const S& x, S& sine, S& cosine) { sin_cos(x, sine, cosine); }
ATWOOD_INLINE void same_sin_cos(const double& x, double& sine, double& cosine) {
  if (abs(x) < trigonometry::kMaxArgument) trigonometry::sin_cos_within(x, sine, cosine);
  else sin_cos(x, sine, cosine);
}
ATWOOD_INLINE void same_sin_cos(const FloatPack& x, FloatPack& sine, FloatPack& cosine) {
  for (int k = 0; k < kLaneCount; ++k) {
    float s, c;
    sin_cos(x[k], s, c);
    sine[k] = s;
    cosine[k] = c;
  }
}
// V: a vector of doubles
template <class V> ATWOOD_INLINE void sin_cos_in_lanes(const V& x, V& sine, V& cosine) {
  constexpr int lanes = sizeof(V) / sizeof(double);
  bool within = true;
  for (int k = 0; k < lanes; ++k) within &= abs(x[k]) < trigonometry::kMaxArgument;
  if (within) return trigonometry::sin_cos_within(x, sine, cosine);
  for (int k = 0; k < lanes; ++k) {
    double s, c;
    same_sin_cos(x[k], s, c);
    sine[k] = s;
    cosine[k] = c;
  }
}
ATWOOD_INLINE void same_sin_cos(const DoublePack& x, DoublePack& sine, DoublePack& cosine) {
  sin_cos_in_lanes(x, sine, cosine);
}
ATWOOD_INLINE void same_sin_cos(const FourDoubles& x, FourDoubles& sine, FourDoubles& cosine) {
  sin_cos_in_lanes(x, sine, cosine);
}
ATWOOD_INLINE void same_sin_cos(const TwoDoubles& x, TwoDoubles& sine, TwoDoubles& cosine) {
  sin_cos_in_lanes(x, sine, cosine);
}
template <class V> ATWOOD_INLINE void same_sin_cos(const Halves<V>& x, Halves<V>& sine, Halves<V>& cosine) {
  same_sin_cos(x.low, sine.low, cosine.low);
  same_sin_cos(x.high, sine.high, cosine.high);
}

}  // namespace atwood::real
