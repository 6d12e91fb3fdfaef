// Diffusion in one dimension between two walls or in a period, by two formulas that share nothing: eigenfunctions for
// late times, images for early ones. H. S. Carslaw and J. C. Jaeger, Conduction of Heat in Solids, 2nd ed. (1959), 3.3
// to 3.8 and 2.4; for the flow between plates J. P. Morris, P. J. Fox and Y. Zhu, J. Comput. Phys. 136 (1997) 214.
#pragma once

#include "fluid_truth/number.hpp"

namespace atwood::fluid_truth {

// w_t = D w_ss + q on 0 < s < L, w = low at s = 0, w = high at s = L, w = start at t = 0.
template <class S> struct Slab { S L{}, D{}, q{}, low{}, high{}, start{}; };

template <class S> struct SlabValue {
  S w{}, neglected{};  // a bound of the terms that are left out
};

// w - start = steady(s) - sum_n C_n sin(n pi s / L) exp(-n^2 lambda), lambda = pi^2 D t / L^2,
//   steady = a + (b - a) s / L + q s (L - s) / (2 D),   a = low - start, b = high - start
//   C_n    = 2 (a - b (-1)^n) / (n pi) + 2 q L^2 (1 - (-1)^n) / (D n^3 pi^3)
// |C_n| falls, so that the terms after N are at most (bound of C_{N+1}) exp(-(N+1)^2 lambda) / (1 - exp(-(2N+3)
// lambda)).
template <class S> SlabValue<S> slab_by_eigenfunctions(const Slab<S>& of, S s, S t, int terms) {
  const S a = of.low - of.start, b = of.high - of.start, lambda = pi<S>() * pi<S>() * of.D * t / (of.L * of.L);
  const S forced = 2 * of.q * of.L * of.L / (of.D * pi<S>() * pi<S>() * pi<S>());
  S w = of.start + a + (b - a) * s / of.L + of.q * s * (of.L - s) / (2 * of.D);
  for (int n = 1; n <= terms; ++n) {
    const S sign = n % 2 == 0 ? 1 : -1, m = n;
    w -= (2 * (a - sign * b) / (m * pi<S>()) + forced * (1 - sign) / (m * m * m)) * sin(m * pi<S>() * s / of.L) *
         exp(-m * m * lambda);
  }
  const S m = terms + 1;
  const S next = 2 * (magnitude(a) + magnitude(b)) / (m * pi<S>()) + 2 * magnitude(forced) / (m * m * m);
  return {w, next * exp(-m * m * lambda) / (-expm1(-(2 * m + 1) * lambda))};
}

// The second repeated integral of erfc.
template <class S> S second_integral_of_erfc(S z) {
  return ((1 + 2 * z * z) * erfc(z) - 2 * z * exp(-z * z) / sqrt(pi<S>())) / 4;
}

// The walls' values enter from both sides and are reflected with the opposite sign; the source q t is held at zero at
// the walls by 4 q t i^2erfc, reflected likewise. With r = 2 sqrt(D t):
//   a:  sum_k erfc((2 k L + s) / r) - erfc((2 (k + 1) L - s) / r)          b: the same of L - s
//   q:  q t (1 - 4 sum_k (-1)^k (i^2erfc((k L + s) / r) + i^2erfc(((k + 1) L - s) / r)))
// The terms from the K-th on are at most 4 erfc(K L / r) in each sum, because erfc more than halves from k to k + 1.
template <class S> SlabValue<S> slab_by_images(const Slab<S>& of, S s, S t, int images) {
  const S a = of.low - of.start, b = of.high - of.start, r = 2 * sqrt(of.D * t), L = of.L;
  S from_low = 0, from_high = 0, held = 0;
  for (int k = 0; k < images; ++k) {
    const S m = k, sign = k % 2 == 0 ? 1 : -1;
    from_low += erfc((2 * m * L + s) / r) - erfc((2 * (m + 1) * L - s) / r);
    from_high += erfc((2 * m * L + (L - s)) / r) - erfc(((2 * m + 1) * L + s) / r);
    held += sign * (second_integral_of_erfc((m * L + s) / r) + second_integral_of_erfc(((m + 1) * L - s) / r));
  }
  const S last = 4 * erfc(S(images) * L / r);
  return {of.start + a * from_low + b * from_high + of.q * t * (1 - 4 * held),
          (magnitude(a) + magnitude(b) + 4 * magnitude(of.q) * t) * last};
}

template <class S> SlabValue<S> slab_at(const Slab<S>& of, S s, S t) {
  if (s <= 0) return {of.low, S(0)};
  if (s >= of.L) return {of.high, S(0)};
  if (!(of.D * t > 0)) return {of.start + of.q * t, S(0)};
  const S lambda = pi<S>() * pi<S>() * of.D * t / (of.L * of.L);
  return lambda > 1 ? slab_by_eigenfunctions(of, s, t, 12) : slab_by_images(of, s, t, 8);
}

// w_t = D w_ss on 0 < s < L, -w_s = slope at s = 0, w_s = 0 at s = L, w = 0 at t = 0.
template <class S> struct HeatedSlab { S L{}, D{}, slope{}; };

// slope (D t / L + (3 (L - s)^2 - L^2) / (6 L) - 2 L / pi^2 sum_n cos(n pi s / L) exp(-n^2 lambda) / n^2)
template <class S> SlabValue<S> heated_by_eigenfunctions(const HeatedSlab<S>& of, S s, S t, int terms) {
  const S L = of.L, lambda = pi<S>() * pi<S>() * of.D * t / (L * L), factor = 2 * L / (pi<S>() * pi<S>());
  S w = of.D * t / L + (3 * (L - s) * (L - s) - L * L) / (6 * L);
  for (int n = 1; n <= terms; ++n) {
    const S m = n;
    w -= factor * cos(m * pi<S>() * s / L) * exp(-m * m * lambda) / (m * m);
  }
  const S m = terms + 1;
  return {of.slope * w,
          magnitude(of.slope) * factor * exp(-m * m * lambda) / (m * m) / (-expm1(-(2 * m + 1) * lambda))};
}

// slope r sum_k ierfc((2 k L + s) / r) + ierfc((2 (k + 1) L - s) / r), r = 2 sqrt(D t); the images have the same sign.
template <class S> SlabValue<S> heated_by_images(const HeatedSlab<S>& of, S s, S t, int images) {
  const S r = 2 * sqrt(of.D * t);
  const auto ierfc = [](S z) { return exp(-z * z) / sqrt(pi<S>()) - z * erfc(z); };
  S w = 0;
  for (int k = 0; k < images; ++k) w += ierfc((2 * S(k) * of.L + s) / r) + ierfc((2 * S(k + 1) * of.L - s) / r);
  // ierfc more than halves from one image to the next.
  return {of.slope * r * w, magnitude(of.slope) * r * 4 * ierfc(2 * S(images) * of.L / r)};
}

template <class S> SlabValue<S> heated_slab_at(const HeatedSlab<S>& of, S s, S t) {
  if (!(of.D * t > 0)) return {S(0), S(0)};
  s = s < 0 ? S(0) : s > of.L ? of.L : s;
  const S lambda = pi<S>() * pi<S>() * of.D * t / (of.L * of.L);
  return lambda > 1 ? heated_by_eigenfunctions(of, s, t, 12) : heated_by_images(of, s, t, 8);
}

// w_t = D w_ss in the period P, w = height where |x - centre| < width / 2 (mod P) and 0 elsewhere at t = 0.
template <class S> struct PeriodicStep { S P{}, D{}, centre{}, width{}, height{}; };

// height (width / P + sum_n 2 / (n pi) sin(n pi width / P) cos(2 n pi (x - centre) / P) exp(-n^2 lambda)),
// lambda = 4 pi^2 D t / P^2
template <class S> SlabValue<S> step_by_eigenfunctions(const PeriodicStep<S>& of, S x, S t, int terms) {
  const S lambda = 4 * pi<S>() * pi<S>() * of.D * t / (of.P * of.P), turn = pi<S>() / of.P;
  S w = of.width / of.P;
  for (int n = 1; n <= terms; ++n) {
    const S m = n;
    w += 2 / (m * pi<S>()) * sin(m * turn * of.width) * cos(2 * m * turn * (x - of.centre)) * exp(-m * m * lambda);
  }
  const S m = terms + 1;
  return {of.height * w,
          magnitude(of.height) * 2 / (m * pi<S>()) * exp(-m * m * lambda) / (-expm1(-(2 * m + 1) * lambda))};
}

// height / 2 sum_k erf((y + width/2 - k P) / r) - erf((y - width/2 - k P) / r), y = x - centre brought to [-P/2, P/2]
template <class S> SlabValue<S> step_by_images(const PeriodicStep<S>& of, S x, S t, int images) {
  S y = x - of.centre;
  y -= of.P * floor(y / of.P + S(0.5));
  const S r = 2 * sqrt(of.D * t);
  S w = 0;
  for (int k = -images; k <= images; ++k)
    w += erf((y + of.width / 2 - S(k) * of.P) / r) - erf((y - of.width / 2 - S(k) * of.P) / r);
  return {of.height * w / 2, magnitude(of.height) * 4 * erfc(S(images) * of.P / r)};
}

template <class S> SlabValue<S> step_at(const PeriodicStep<S>& of, S x, S t) {
  if (!(of.D * t > 0)) {
    S y = x - of.centre;
    y -= of.P * floor(y / of.P + S(0.5));
    return {magnitude(y) < of.width / 2 ? of.height : S(0), S(0)};
  }
  const S lambda = 4 * pi<S>() * pi<S>() * of.D * t / (of.P * of.P);
  return lambda > 1 ? step_by_eigenfunctions(of, x, t, 12) : step_by_images(of, x, t, 8);
}

}  // namespace atwood::fluid_truth
