// The inner loops of Radau15, one node per lane. RadauTable defines the sums.
#pragma once

#include "integrators/radau15.hpp"
#include "math/pack.hpp"

namespace atwood::radau {

inline constexpr int kNodes = kRadauNodes;

// Eight rows of a table, kept in registers.
template <class S> struct Columns {
  Pack<S> column[kNodes];

  ATWOOD_INLINE Columns(const S (&table)[kNodes][kNodes], S scale) {
    for (int j = 0; j < kNodes; ++j) column[j] = scale * load(table[j]);
  }
  // sum_j f_j column_j, added in pairs, which shortens the chain of dependent additions.
  ATWOOD_INLINE Pack<S> combine(const S* f) const {
    const Pack<S> s01 = f[0] * column[0] + f[1] * column[1], s23 = f[2] * column[2] + f[3] * column[3];
    const Pack<S> s45 = f[4] * column[4] + f[5] * column[5], s67 = f[6] * column[6] + f[7] * column[7];
    return (s01 + s23) + (s45 + s67);
  }
};

// out[i] = base[i] + scale sum_j column_j f_j for the components listed; f of component i at rate[i + shift].
template <class S>
ATWOOD_INLINE void stages(const std::vector<int>& components, int shift, const S (&table)[kNodes][kNodes], S scale,
                          const S* base, const S* rate, S* out) {
  if (components.empty()) return;
  const Columns<S> columns(table, scale);
  for (const int i : components)
    store<S>(load(base + i * kNodes) + columns.combine(rate + (i + shift) * kNodes), out + i * kNodes);
}

// The values to which stages add their sums: y, or the straight line y + c h v (v of component i at y[i + shift]).
template <class S> ATWOOD_INLINE void set_base(const std::vector<int>& once, const S* y, S* base) {
  for (const int i : once) store<S>(broadcast(y[i]), base + i * kNodes);
}
template <class S>
ATWOOD_INLINE void set_base(const std::vector<int>& twice, int shift, const RadauTable<S>& table, S h_s, const S* y,
                            S* base) {
  const Pack<S> elapsed_s = h_s * load(table.c);
  for (const int i : twice) store<S>(broadcast(y[i]) + y[i + shift] * elapsed_s, base + i * kNodes);
}

// The largest weighted change of a rate at any node; NaN if one of them is.
template <class S>
ATWOOD_INLINE S change(const std::vector<int>& components, const S* weight, const S* now, const S* before) {
  Pack<S> most = broadcast(S(0));
  for (const int i : components)
    most = larger_size<S>(*weight++ * (load(now + i * kNodes) - load(before + i * kNodes)), most);
  return largest_lane<S>(most);
}

// The polynomial through the rates of `from`, at tau = offset + ratio c of its step, plus `weight` times its last
// error.
template <class S>
ATWOOD_INLINE void extrapolate(const std::vector<int>& components, const RadauTable<S>& table, S offset, S ratio,
                               S weight, const S* from, const S* prediction_error, S* out) {
  const Pack<S> tau = offset + ratio * load(table.c);
  const Columns<S> powers(table.power, S(1));
  for (const int i : components) {
    alignas(sizeof(Pack<S>)) S coefficient[kNodes];
    store<S>(powers.combine(from + i * kNodes), coefficient);
    Pack<S> sum = broadcast(coefficient[kNodes - 1]);
    for (int p = kNodes - 2; p >= 0; --p) sum = coefficient[p] + tau * sum;
    store<S>(sum + weight * load(prediction_error + i * kNodes), out + i * kNodes);
  }
}

// miss = now - guess.
template <class S>
ATWOOD_INLINE void differences(const std::vector<int>& components, const S* now, const S* guess, S* prediction_error) {
  for (const int i : components)
    store<S>(load(now + i * kNodes) - load(guess + i * kNodes), prediction_error + i * kNodes);
}

// Largest rate of components first..last at any node.
template <class S> ATWOOD_INLINE S largest(const std::vector<int>& components, int first, int last, const S* rate) {
  Pack<S> most = broadcast(S(0));
  for (int r = first; r < last; ++r) most = larger_size<S>(load(rate + components[r] * kNodes), most);
  return largest_lane<S>(most);
}

// For each component: sum b F, sum b2 F and the last coefficient of the rates' polynomial, stored in this order.
template <class S>
ATWOOD_INLINE void sum_ends(const std::vector<int>& components, const RadauTable<S>& table, const S* rate, S* ends) {
  const Columns<S> columns(table.ends, S(1));
  for (const int i : components) store<S>(columns.combine(rate + i * kNodes), ends + i * kNodes);
}

// The rates of node n changed from those in `rate`: corrects those of the later nodes by Newton's term of node n.
template <class S>
ATWOOD_INLINE S shift_later_nodes(const std::vector<int>& components, const S* weight, const RadauTable<S>& table,
                                  int n, const S* node_rate, S* rate) {
  const Pack<S> term = load(table.newton[n]);
  S most = S(0);
  for (const int i : components) {
    S* f = rate + i * kNodes;
    const S rise = node_rate[i] - f[n];
    store<S>(load(f) + rise * term, f);
    f[n] = node_rate[i];
    const S size = *weight++ * real::abs(rise);
    most = size <= most ? most : size;
  }
  return most;
}

}  // namespace atwood::radau
