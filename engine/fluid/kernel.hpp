// Smoothing kernels W(r) in two and three dimensions, with unit integral and compact support.
//
//   W(r) = a w(s),  W'(r) / r = b f(s),  s = r / support,  f(s) = w'(s) / s       a = N / support^d,  b = a / support^2
//
//   cubic        (1-s)^3 - 4 (1/2-s)^3                  B-spline M4; support 2 h
//   quintic      (1-s)^5 - 6 (2/3-s)^5 + 15 (1/3-s)^5   B-spline M6; support 3 h
//   wendland-c2  (1-s)^4 (1 + 4 s)                      support 2 h
//   wendland-c4  (1-s)^6 (1 + 6 s + 35/3 s^2)           support 2 h
//   wendland-c6  (1-s)^8 (1 + 8 s + 25 s^2 + 32 s^3)    support 2 h
//
// where each power is that of the positive part. The gradient of W at x_ij = x_i - x_j with respect to x_i is
// W'(r) / r x_ij; f is finite at s = 0 and 0 for s >= 1.
//
// Sources: Wendland (1995); Dehnen and Aly, MNRAS 425 (2012) 1068, table 1; Morris, Fox, Zhu (1997) for the quintic.
#pragma once

#include <string>

#include "math/scalar.hpp"
#include "math/vector_width.hpp"

namespace atwood::fluid {

enum class KernelShape { cubic, quintic, wendland_c2, wendland_c4, wendland_c6 };

KernelShape kernel_shape(const std::string& name);  // as above; throws std::invalid_argument
// Support over smoothing length h: 2 or 3.
constexpr int support_ratio(KernelShape shape) { return shape == KernelShape::quintic ? 3 : 2; }
// Order in time that the kernel's smoothness permits to any method: the derivatives of the rate jump where two
// particles enter each other's support.
int time_order_ceiling(KernelShape shape);

template <class S> struct Kernel {
  KernelShape shape = KernelShape::wendland_c2;
  int dimensions = 3;
  S support{}, inverse_support{};
  S value_factor{}, slope_factor{};  // a and b above

  S value(S r) const;                // W(r) [1/m^d]
  S slope_over_distance(S r) const;  // W'(r) / r [1/m^(d+2)], <= 0
};
// Certainly beyond the support, before the root is taken: there both values are exact zeros.
template <class S> bool beyond_support(const Kernel<S>& kernel, S r2) {
  return r2 > S(1.01) * kernel.support * kernel.support;
}
// h_m > 0; dimensions 2 or 3.
template <class S> Kernel<S> make_kernel(KernelShape shape, int dimensions, S h_m);

// ---- w(s) and f(s) of a scalar or of a pack (math/pack.hpp) of the scalar S -----------------------------------------
template <class V> ATWOOD_INLINE V positive_part(const V& a) { return a > V{} ? a : V{}; }

template <KernelShape shape, class S, class V> ATWOOD_INLINE V kernel_value(const V& s) {
  const V u = positive_part(V(S(1) - s)), u2 = u * u;
  if constexpr (shape == KernelShape::cubic) {
    const V c = positive_part(V(S(0.5) - s));
    return u2 * u - S(4) * (c * c * c);
  } else if constexpr (shape == KernelShape::quintic) {
    const V c = positive_part(V(S(2) / S(3) - s)), e = positive_part(V(S(1) / S(3) - s)), c2 = c * c, e2 = e * e;
    return u2 * u2 * u - S(6) * (c2 * c2 * c) + S(15) * (e2 * e2 * e);
  } else if constexpr (shape == KernelShape::wendland_c2) {
    return u2 * u2 * (S(1) + S(4) * s);
  } else if constexpr (shape == KernelShape::wendland_c4) {
    return u2 * u2 * u2 * (S(1) + s * (S(6) + S(35) / S(3) * s));
  } else {
    const V u4 = u2 * u2;
    return u4 * u4 * (S(1) + s * (S(8) + s * (S(25) + S(32) * s)));
  }
}

// The splines' inner pieces are written out, so that no small difference is divided by s.
template <KernelShape shape, class S, class V> ATWOOD_INLINE V kernel_slope(const V& s) {
  const V u = positive_part(V(S(1) - s)), u2 = u * u;
  if constexpr (shape == KernelShape::cubic) {
    const V inner = S(9) * s - S(6), safe = s > S(0.5) + V{} ? s : V{} + S(0.5), outer = S(-3) * u2 / safe;
    return s < S(0.5) + V{} ? inner : outer;
  } else if constexpr (shape == KernelShape::quintic) {
    const V c = positive_part(V(S(2) / S(3) - s)), c2 = c * c, third = V{} + S(1) / S(3);
    const V s2 = s * s, inner = s2 * (S(40) - S(50) * s) - S(40) / S(9);
    const V safe = s > third ? s : third, outer = (S(30) * (c2 * c2) - S(5) * (u2 * u2)) / safe;
    return s < third ? inner : outer;
  } else if constexpr (shape == KernelShape::wendland_c2) {
    return S(-20) * (u2 * u);
  } else if constexpr (shape == KernelShape::wendland_c4) {
    return S(-56) / S(3) * (u2 * u2 * u) * (S(1) + S(5) * s);
  } else {
    return S(-22) * (u2 * u2 * u2 * u) * (S(1) + s * (S(7) + S(16) * s));
  }
}

// with(shape) where the shape is known to the compiler.
template <KernelShape shape> using ShapeOf = std::integral_constant<KernelShape, shape>;
template <class With> ATWOOD_INLINE auto of_shape(KernelShape shape, const With& with) {
  switch (shape) {
    case KernelShape::cubic: return with(ShapeOf<KernelShape::cubic>{});
    case KernelShape::quintic: return with(ShapeOf<KernelShape::quintic>{});
    case KernelShape::wendland_c2: return with(ShapeOf<KernelShape::wendland_c2>{});
    case KernelShape::wendland_c4: return with(ShapeOf<KernelShape::wendland_c4>{});
    case KernelShape::wendland_c6: break;
  }
  return with(ShapeOf<KernelShape::wendland_c6>{});
}
// The same of a shape that is known at run time.
template <class S, class V> ATWOOD_INLINE V kernel_value(KernelShape shape, const V& s) {
  return of_shape(
      shape, [&](auto of) __attribute__((always_inline)) { return kernel_value<decltype(of)::value, S>(s); });
}
template <class S, class V> ATWOOD_INLINE V kernel_slope(KernelShape shape, const V& s) {
  return of_shape(
      shape, [&](auto of) __attribute__((always_inline)) { return kernel_slope<decltype(of)::value, S>(s); });
}

}  // namespace atwood::fluid
