// The inner loops of Radau15, one node per lane. RadauTable defines the sums.
#pragma once

#include <cstdint>
#include <limits>

#include "integrators/radau15.hpp"
#include "math/pack.hpp"

namespace atwood::radau {

inline constexpr int kNodes = kRadauNodes;

// When sweeps end: where the change that the next one would make (the last change times the contraction) is below the
// last place, or below a part of the tolerance (a thirtieth of it node by node; a hundredth where all nodes are swept
// at once, whose contraction differs more from one step to the next); where changes among the last places no longer
// shrink; or in failure.
template <class S> struct SweepEnd {
  S enough, contraction, before = S(0), earlier = S(0);  // changes of the last sweep, and of the one before it
  int sweeps = 0;
  SolveEnd ended = SolveEnd::capped;
  S left = S(0);

  ATWOOD_INLINE SweepEnd(S rtol, bool sequential, S last_contraction)
      : enough(real::max(real::epsilon<S>() / S(8), rtol / S(sequential ? 30 : 100))), contraction(last_contraction) {}
  // After a sweep that changed the rates by `now`. `blind`: the first one, without a prediction.
  ATWOOD_INLINE bool reached(S now, bool blind) {
    constexpr int max_sweeps = 60;
    ++sweeps;
    left = now;
    if (!(now < S(1e30f))) return true;
    if (blind) {
      before = now;
      return false;
    }
    if (before > S(1e4f) * real::epsilon<S>()) contraction = real::max(real::min(now / before, S(1)), S(1e-4f));
    if (now * contraction <= enough) {
      ended = SolveEnd::converged;
      left = now * contraction;
      return true;
    }
    if (before > S(0) && now >= before / S(2) && now <= S(256) * real::epsilon<S>()) {
      ended = SolveEnd::stagnated;
      return true;
    }
    if (sweeps > 9 && now > before && now > earlier) return true;  // of alternate sweeps one may grow for a while
    earlier = before;
    before = now;
    return sweeps == max_sweeps;
  }
  SolveReport report() const { return {sweeps, static_cast<double>(left), ended}; }
};

// The largest absolute value in packs; NaN if one is NaN. The sizes of float and double are compared as integers, in
// whose order NaN is above infinity: no branch, and no order of comparisons in which NaN could be lost.
template <class P> struct LargestSize {
  using Bits = typename Integers<P>::Signed;
  Bits most{};

  ATWOOD_INLINE void add(const P& a) { take(bits_as<Bits>(a) & std::numeric_limits<LaneOf<Bits>>::max()); }
  ATWOOD_INLINE void add(const LargestSize& other) { take(other.most); }
  ATWOOD_INLINE LaneOf<P> value() {
    constexpr int lanes = sizeof(P) / sizeof(LaneOf<P>);
    if constexpr (lanes == 8) {
      take(__builtin_shufflevector(most, most, 4, 5, 6, 7, 0, 1, 2, 3));
      take(__builtin_shufflevector(most, most, 2, 3, 0, 1, 6, 7, 4, 5));
      take(__builtin_shufflevector(most, most, 1, 0, 3, 2, 5, 4, 7, 6));
    } else if constexpr (lanes == 4) {
      take(__builtin_shufflevector(most, most, 2, 3, 0, 1));
      take(__builtin_shufflevector(most, most, 1, 0, 3, 2));
    } else {
      take(__builtin_shufflevector(most, most, 1, 0));
    }
    return bits_as<P>(most)[0];
  }

 private:
  ATWOOD_INLINE void take(const Bits& bits) { most = bits > most ? bits : most; }
};
template <class V> struct LargestSize<Halves<V>> {
  LargestSize<V> low, high;

  ATWOOD_INLINE void add(const Halves<V>& a) {
    low.add(a.low);
    high.add(a.high);
  }
  ATWOOD_INLINE void add(const LargestSize& other) {
    low.add(other.low);
    high.add(other.high);
  }
  ATWOOD_INLINE double value() {
    low.add(high);
    return low.value();
  }
};
template <class S> struct LargestSize<WidePack<S>> {
  WidePack<S> most = broadcast(S(0));

  ATWOOD_INLINE void add(const WidePack<S>& a) {
    for (int k = 0; k < kLaneCount; ++k) take(real::abs(a[k]), most.lane[k]);
  }
  ATWOOD_INLINE S value() const {
    S largest = most[0];
    for (int k = 1; k < kLaneCount; ++k) take(most[k], largest);
    return largest;
  }

 private:
  ATWOOD_INLINE static void take(S size, S& largest) {
    if (!(size <= largest) && largest == largest) largest = size;
  }
};

// Eight rows of a table, kept in registers.
template <class P> struct Columns {
  using S = LaneOf<P>;
  P column[kNodes];

  ATWOOD_INLINE Columns(const S (&table)[kNodes][kNodes], S scale) {
    for (int j = 0; j < kNodes; ++j) column[j] = scale * load_as<P>(table[j]);
  }
  // sum_j f_j column_j, added in pairs, which shortens the chain of dependent additions.
  ATWOOD_INLINE P combine(const S* f) const {
    const P s01 = f[0] * column[0] + f[1] * column[1], s23 = f[2] * column[2] + f[3] * column[3];
    const P s45 = f[4] * column[4] + f[5] * column[5], s67 = f[6] * column[6] + f[7] * column[7];
    return (s01 + s23) + (s45 + s67);
  }
};

// In what follows P is the pack of S at the width of the kernel.

// out[i] = base[i] + scale sum_j column_j f_j for the components listed; f of component i at rate[i + shift].
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE void stages(const std::vector<int>& components, int shift, const S (&table)[kNodes][kNodes], S scale,
                          const S* base, const S* rate, S* out) {
  if (components.empty()) return;
  const Columns<P> columns(table, scale);
  for (const int i : components)
    store<S>(load_as<P>(base + i * kNodes) + columns.combine(rate + (i + shift) * kNodes), out + i * kNodes);
}

// The values to which stages add their sums: y, or the straight line y + c h v (v of component i at y[i + shift]).
template <class P, class S = LaneOf<P>> ATWOOD_INLINE void set_base(const std::vector<int>& once, const S* y, S* base) {
  for (const int i : once)
    for (int n = 0; n < kNodes; ++n) base[i * kNodes + n] = y[i];
}
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE void set_base(const std::vector<int>& twice, int shift, const RadauTable<S>& table, S h_s, const S* y,
                            S* base) {
  const P elapsed_s = h_s * load_as<P>(table.c);
  for (const int i : twice) store<S>(y[i] + y[i + shift] * elapsed_s, base + i * kNodes);
}

// The largest weighted change of a rate at any node; NaN if one of them is.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE S change(const std::vector<int>& components, const S* weight, const S* now, const S* before) {
  LargestSize<P> most;
  for (const int i : components) most.add(*weight++ * (load_as<P>(now + i * kNodes) - load_as<P>(before + i * kNodes)));
  return most.value();
}

// The polynomial through one component's rates `from` at tau.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE P polynomial(const Columns<P>& powers, const P& tau, const S* from) {
  alignas(sizeof(P)) S coefficient[kNodes];
  store<S>(powers.combine(from), coefficient);
  P sum = coefficient[kNodes - 2] + coefficient[kNodes - 1] * tau;
  for (int p = kNodes - 3; p >= 0; --p) sum = coefficient[p] + tau * sum;
  return sum;
}

// The error of that polynomial, of degree 7 through the rates at c_k of a step of length h, is to leading order
// h^8 f^(8) prod_k (tau - c_k) / 8!. So the error of a prediction follows from the last one, lane by lane:
//   weight = (h / h_before)^8 prod_k (tau - c_k) / prod_k (tau_before - c_k)
// at most 1: beyond, a longer extrapolation leaves the range of the leading order.
template <class S>
ATWOOD_INLINE void weigh_last_error(const RadauTable<S>& table, S ratio, const RadauExtrapolation<S>& before,
                                    RadauExtrapolation<S>& now, S* weight) {
  const S g2 = before.growth * before.growth, g4 = g2 * g2, g8 = g4 * g4;
  now.growth = ratio;
  ATWOOD_INDEPENDENT
  for (int n = 0; n < kNodes; ++n) {
    const S tau = S(1) + ratio * table.c[n];
    S product = S(1);
    for (int k = 0; k < kNodes; ++k) product *= tau - table.c[k];
    const S full = g8 * product / before.product[n];  // before it is written: `now` may be `before`
    now.product[n] = product;
    weight[n] = full < S(1) ? full : S(1);
  }
}

// The polynomial through the rates of `from`, at tau = offset + ratio c of its step, plus `weight` times its last
// error.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE void extrapolate(const std::vector<int>& components, const RadauTable<S>& table, S offset, S ratio,
                               const S* weight, const S* from, const S* prediction_error, S* out) {
  const P tau = offset + ratio * load_as<P>(table.c), weights = load_as<P>(weight);
  const Columns<P> powers(table.power, S(1));
  for (const int i : components)
    store<S>(polynomial<P>(powers, tau, from + i * kNodes) + weights * load_as<P>(prediction_error + i * kNodes),
             out + i * kNodes);
}

// miss = now - guess.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE void differences(const std::vector<int>& components, const S* now, const S* guess, S* prediction_error) {
  for (const int i : components)
    store<S>(load_as<P>(now + i * kNodes) - load_as<P>(guess + i * kNodes), prediction_error + i * kNodes);
}

// Largest rate of components first..last at any node.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE S largest(const std::vector<int>& components, int first, int last, const S* rate) {
  LargestSize<P> most;
  for (int r = first; r < last; ++r) most.add(load_as<P>(rate + components[r] * kNodes));
  return most.value();
}

// For each component: sum b F, sum b2 F and the last coefficient of the rates' polynomial, stored in this order.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE void sum_ends(const std::vector<int>& components, const RadauTable<S>& table, const S* rate, S* ends) {
  const Columns<P> columns(table.ends, S(1));
  for (const int i : components) store<S>(columns.combine(rate + i * kNodes), ends + i * kNodes);
}

// The rates of node n changed from those in `rate`: corrects those of the later nodes by Newton's term of node n.
template <class P, class S = LaneOf<P>>
ATWOOD_INLINE S shift_later_nodes(const std::vector<int>& components, const S* weight, const RadauTable<S>& table,
                                  int n, const S* node_rate, S* rate) {
  const P term = load_as<P>(table.newton[n]);
  S most = S(0);
  for (const int i : components) {
    S* f = rate + i * kNodes;
    const S rise = node_rate[i] - f[n];
    store<S>(load_as<P>(f) + rise * term, f);
    f[n] = node_rate[i];
    const S size = *weight++ * real::abs(rise);
    most = size <= most ? most : size;
  }
  return most;
}

}  // namespace atwood::radau
