#include "fluid/polynomial_fit.hpp"

#include "fluid/polynomial_basis.hpp"
#include "fluid/registers.hpp"

namespace atwood::fluid {
namespace {

// A lane, or all lanes of a block: how it reads the records of a row of a list.
template <class S> struct OneLane {
  using Value = S;
  int lane;
  ATWOOD_INLINE void read(const S* records, const int* row, S* out) const {
    const S* const at = records + static_cast<std::ptrdiff_t>(row[lane]) * kFitRecord;
    for (int c = 0; c < kFitRecord; ++c) out[c] = at[c];
  }
  ATWOOD_INLINE S read_own(const S* at) const { return at[lane]; }
  template <class Of> ATWOOD_INLINE S gather(const Of& of) const { return of(lane); }
  ATWOOD_INLINE S root_of(S a) const { return real::sqrt(a); }
  template <class Write> ATWOOD_INLINE void each(S value, const Write& write) const { write(lane, value); }
};
// Four lanes in one register of AVX2, from `lane` on: with all eight in two registers each, half of the values of a fit
// are moved to memory and back.
template <VectorWidth width> struct HalfLanes {
  using Value = RegisterOf<double>::Type;
  int lane;
  // Four records of eight numbers, transposed by halves.
  ATWOOD_INLINE void read(const double* records, const int* row, Value* out) const {
    for (int h = 0; h < kFitRecord; h += 4) {
      Value of[4];
      for (int k = 0; k < 4; ++k)
        __builtin_memcpy(&of[k], records + static_cast<std::ptrdiff_t>(row[lane + k]) * kFitRecord + h, sizeof(Value));
      const Value ab_even = __builtin_shufflevector(of[0], of[1], 0, 4, 2, 6);
      const Value ab_odd = __builtin_shufflevector(of[0], of[1], 1, 5, 3, 7);
      const Value ce_even = __builtin_shufflevector(of[2], of[3], 0, 4, 2, 6);
      const Value ce_odd = __builtin_shufflevector(of[2], of[3], 1, 5, 3, 7);
      out[h] = __builtin_shufflevector(ab_even, ce_even, 0, 1, 4, 5);
      out[h + 1] = __builtin_shufflevector(ab_odd, ce_odd, 0, 1, 4, 5);
      out[h + 2] = __builtin_shufflevector(ab_even, ce_even, 2, 3, 6, 7);
      out[h + 3] = __builtin_shufflevector(ab_odd, ce_odd, 2, 3, 6, 7);
    }
  }
  ATWOOD_INLINE Value read_own(const double* at) const {
    Value own;
    __builtin_memcpy(&own, at + lane, sizeof(own));
    return own;
  }
  template <class Of> ATWOOD_INLINE Value gather(const Of& of) const {
    return Value{of(lane), of(lane + 1), of(lane + 2), of(lane + 3)};
  }
  ATWOOD_INLINE Value root_of(const Value& a) const { return root(WholePack<width>{}, a); }
  template <class Write> ATWOOD_INLINE void each(const Value& value, const Write& write) const {
    for (int k = 0; k < 4; ++k) write(lane + k, value[k]);
  }
};
template <class S, VectorWidth width> struct AllLanes {
  using Value = Pack<S>;
  // Eight records of eight numbers, transposed.
  ATWOOD_INLINE void read(const S* records, const int* row, Value* out) const {
    const auto record = [&](int k)
                            ATWOOD_INLINED { return load(records + static_cast<std::ptrdiff_t>(row[k]) * kFitRecord); };
    if constexpr (width == VectorWidth::v4) {
      Value half[2][4];  // columns c and c + 4 of four rows
      for (int h = 0; h < 2; ++h) {
        const Value a = record(4 * h), b = record(4 * h + 1), c = record(4 * h + 2), e = record(4 * h + 3);
        const Value ab_even = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
        const Value ab_odd = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
        const Value ce_even = __builtin_shufflevector(c, e, 0, 8, 2, 10, 4, 12, 6, 14);
        const Value ce_odd = __builtin_shufflevector(c, e, 1, 9, 3, 11, 5, 13, 7, 15);
        half[h][0] = __builtin_shufflevector(ab_even, ce_even, 0, 1, 8, 9, 4, 5, 12, 13);
        half[h][1] = __builtin_shufflevector(ab_odd, ce_odd, 0, 1, 8, 9, 4, 5, 12, 13);
        half[h][2] = __builtin_shufflevector(ab_even, ce_even, 2, 3, 10, 11, 6, 7, 14, 15);
        half[h][3] = __builtin_shufflevector(ab_odd, ce_odd, 2, 3, 10, 11, 6, 7, 14, 15);
      }
      for (int c = 0; c < 4; ++c) {
        out[c] = __builtin_shufflevector(half[0][c], half[1][c], 0, 1, 2, 3, 8, 9, 10, 11);
        out[c + 4] = __builtin_shufflevector(half[0][c], half[1][c], 4, 5, 6, 7, 12, 13, 14, 15);
      }
    } else {
      for (int c = 0; c < kFitRecord; ++c) {
        const auto of = [&](int k)
                            ATWOOD_INLINED { return records[static_cast<std::ptrdiff_t>(row[k]) * kFitRecord + c]; };
        out[c] = Value{of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)};
      }
    }
  }
  ATWOOD_INLINE Value read_own(const S* at) const { return load(at); }
  template <class Of> ATWOOD_INLINE Value gather(const Of& of) const {
    return Value{of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)};
  }
  ATWOOD_INLINE Value root_of(const Value& a) const { return root(WholePack<width>{}, a); }
  template <class Write> ATWOOD_INLINE void each(const Value& value, const Write& write) const {
    for (int k = 0; k < kLaneCount; ++k) write(k, value[k]);
  }
};

// The neighbours of a slot, one row each: z = (x_j - x_i) / H, weight, and the differences of the fields.
template <class V> struct Stage {
  int rows;
  V* z;       // d a row
  V* weight;  // 1 a row
  V* field;   // field f of row n at [f * rows + n]
};

template <int d, class S, class Lanes, class V>
ATWOOD_INLINE void stage_neighbours(const PolynomialFits<S>& fits, const Neighbours<S>& lists,
                                    const NeighbourBlock& block, const S* records, const SlotWeight<S>* weights,
                                    const int* own_row, const V& inverse_support, const Lanes& lanes,
                                    const Stage<V>& stage, V* shift_sum, V& depth_factor) {
  V own[kFitRecord], other[kFitRecord];
  lanes.read(records, own_row, own);
  const V per_height = inverse_support + inverse_support;  // 1 / H
  const S per_two_spacings = S(1) / (S(2) * fits.spacing);
  for (int n = 0; n < block.longest; ++n) {
    lanes.read(records, block.entries + n * kLaneCount, other);
    V x[d], r2{};
    for (int c = 0; c < d; ++c) {
      x[c] = other[c] - own[c];
      if (block.wraps && lists.period(c) > S(0)) x[c] = nearest_image(x[c], lists.period(c));
      r2 = r2 + x[c] * x[c];
    }
    const V r = lanes.root_of(r2), w = kernel_value<S>(fits.shape, V(r * inverse_support));
    stage.weight[n] = r2 > V{} ? w : V{};  // a lane's own slot fills its list up
    const V u = positive_part(V(S(1) - r * per_two_spacings));
    V near = u * u * u;
    if (weights != nullptr) {
      const int* const row = block.entries + n * kLaneCount;
      stage.weight[n] = stage.weight[n] * lanes.gather([&](int k) ATWOOD_INLINED { return weights[row[k]].fit; });
      near = near * lanes.gather([&](int k) ATWOOD_INLINED { return weights[row[k]].shift_sum; });
      const V g = positive_part(V(S(1) - r2 * (per_two_spacings * per_two_spacings)));
      depth_factor = depth_factor - depth_factor * g * g * g *
                                        lanes.gather([&](int k) ATWOOD_INLINED { return weights[row[k]].surface; });
    }
    for (int c = 0; c < d; ++c) {
      shift_sum[c] = shift_sum[c] + near * x[c];
      stage.z[n * d + c] = x[c] * per_height;
    }
    for (int f = 0; f < fits.fields; ++f) stage.field[f * stage.rows + n] = other[d + f] - own[d + f];
  }
}

// M = L L^T; the least pivot of M scaled to a unit diagonal. The diagonal of L is stored inverted.
template <int d, int p, class V, class Lanes>
ATWOOD_INLINE V factor(const V* moments, V (&L)[Basis<d, p>::count][Basis<d, p>::count], const Lanes& lanes) {
  using B = Basis<d, p>;
  using Rows = MonomialRows<d, 2 * p>;
  static constexpr auto index = [] {
    std::array<std::array<int, B::count>, B::count> all{};
    for (int i = 0; i < B::count; ++i)
      for (int j = 0; j < B::count; ++j)
        all[i][j] = Rows::index_of({B::exponents[i][0] + B::exponents[j][0], B::exponents[i][1] + B::exponents[j][1],
                                    B::exponents[i][2] + B::exponents[j][2]});
    return all;
  }();
  V least = V{} + 1;
  for (int i = 0; i < B::count; ++i) {
    const V diagonal = moments[index[i][i]];
    V pivot = diagonal;
    for (int k = 0; k < i; ++k) pivot = pivot - L[i][k] * L[i][k];
    const V scaled = pivot / diagonal;
    least = scaled < least ? scaled : least;
    L[i][i] = V(V{} + 1) / lanes.root_of(pivot);
    for (int j = i + 1; j < B::count; ++j) {
      V sum = moments[index[j][i]];
      for (int k = 0; k < i; ++k) sum = sum - L[j][k] * L[i][k];
      L[j][i] = sum * L[i][i];
    }
  }
  return least;
}

// b = L^-1 b, in place.
template <int n, class V> ATWOOD_INLINE void solve_lower(const V (&L)[n][n], V* b) {
  for (int i = 0; i < n; ++i) {
    V sum = b[i];
    for (int k = 0; k < i; ++k) sum = sum - L[i][k] * b[k];
    b[i] = sum * L[i][i];
  }
}

// sums of MonomialRows<d, q> in the order of the basis of degree p <= q.
template <int d, int p, int q, class V> ATWOOD_INLINE void in_basis(const V* sums, V* out) {
  static constexpr auto index = [] {
    std::array<int, Basis<d, p>::count> all{};
    for (int k = 0; k < Basis<d, p>::count; ++k) all[k] = MonomialRows<d, q>::index_of(Basis<d, p>::exponents[k]);
    return all;
  }();
  for (int k = 0; k < Basis<d, p>::count; ++k) out[k] = sums[index[k]];
}

template <int d, int p, class S, class Lanes>
ATWOOD_INLINE void fit_block(const PolynomialFits<S>& fits, const Neighbours<S>& lists, const NeighbourBlock& block,
                             const S* records, const S* supports, const SlotWeight<S>* weights, int first,
                             const Lanes& lanes, typename Lanes::Value* scratch, Fit<S>* out) {
  using V = typename Lanes::Value;
  using B = Basis<d, p>;
  constexpr int n = B::count, wanted = B::wanted;
  int own_row[kLaneCount];
  for (int k = 0; k < kLaneCount; ++k) own_row[k] = first + k;
  const V inverse_support = V(V{} + 1) / lanes.read_own(supports + first),
          per_height = inverse_support + inverse_support;
  const int rows = block.longest;
  const Stage<V> stage{rows, scratch, scratch + rows * d, scratch + rows * (d + 1)};
  V shift_sum[d]{}, depth_factor = V{} + S(1);
  stage_neighbours<d>(fits, lists, block, records, weights, own_row, inverse_support, lanes, stage, shift_sum,
                      depth_factor);

  V moments[MonomialRows<d, 2 * p>::count], L[n][n], m[n];
  monomial_sums<d, 2 * p>(
      rows, stage.z, [&](int k) ATWOOD_INLINED { return stage.weight[k]; }, moments);
  const V least_pivot = factor<d, p>(moments, L, lanes);
  in_basis<d, p, 2 * p>(moments, m);
  solve_lower<n>(L, m);
  V explained{};
  for (int k = 0; k < n; ++k) explained = explained + m[k] * m[k];
  const V per_weight = V(V{} + 1) / (V(V{} + 1) + moments[0] - explained);

  for (int f = 0; f < fits.fields; ++f) {
    const V* const values = stage.field + f * rows;
    V sums[MonomialRows<d, p>::count], b[n], c[wanted];
    monomial_sums<d, p>(
        rows, stage.z, [&](int k) ATWOOD_INLINED { return V(stage.weight[k] * values[k]); }, sums);
    in_basis<d, p, p>(sums, b);
    solve_lower<n>(L, b);
    V residual = sums[0];
    for (int k = 0; k < n; ++k) residual = residual - m[k] * b[k];
    // L^T c = b from below, as far as the quadratic coefficients.
    for (int i = wanted - 1; i >= 0; --i) {
      V sum = b[n - wanted + i];
      for (int k = i + 1; k < wanted; ++k) sum = sum - L[n - wanted + k][n - wanted + i] * c[k];
      c[i] = sum * L[n - wanted + i][n - wanted + i];
    }
    V squares{};
    for (int axis = 0; axis < d; ++axis) {
      Exponents linear{}, square{};
      linear[axis] = 1;
      square[axis] = 2;
      squares = squares + c[B::index_of(square) - (n - wanted)];
      lanes.each(V(c[B::index_of(linear) - (n - wanted)] * per_height),
                 [&](int k, S value) ATWOOD_INLINED { out[first + k].gradient[f][axis] = value; });
    }
    lanes.each(V((squares + squares) * (per_height * per_height)),
               [&](int k, S value) ATWOOD_INLINED { out[first + k].laplacian[f] = value; });
    lanes.each(V(residual * per_weight), [&](int k, S value) ATWOOD_INLINED { out[first + k].change[f] = value; });
  }
  for (int axis = 0; axis < d; ++axis)
    lanes.each(shift_sum[axis], [&](int k, S value) ATWOOD_INLINED { out[first + k].shift_sum[axis] = value; });
  lanes.each(depth_factor, [&](int k, S value) ATWOOD_INLINED { out[first + k].depth_factor = value; });
  lanes.each(least_pivot, [&](int k, S value) ATWOOD_INLINED { out[first + k].least_pivot = value; });
}

template <int d, int p, class S>
void fit_blocks(const PolynomialFits<S>& fits, const Neighbours<S>& lists, const S* records, const S* supports,
                const SlotWeight<S>* weights, int first_block, int last_block, LaneArray<S>& scratch, Fit<S>* out) {
  in_lanes<S>(fits.width, [&](auto width) ATWOOD_INLINED {
    for (int b = first_block; b < last_block; ++b) {
      const NeighbourBlock block = lists.block(b);
      const std::size_t needed = std::size_t(block.longest) * (1 + d + fits.fields);
      if (scratch.size() < needed) scratch.resize(needed + needed / 2);
      constexpr VectorWidth here = decltype(width)::value;
      if constexpr (std::is_same_v<S, double> && here == VectorWidth::v3) {
        if (!fits.lane_by_lane) {
          for (int lane = 0; lane < kLaneCount; lane += 4)
            fit_block<d, p>(fits, lists, block, records, supports, weights, b * kLaneCount, HalfLanes<here>{lane},
                            reinterpret_cast<RegisterOf<double>::Type*>(scratch.data()), out);
          continue;
        }
      } else if constexpr (has_vector_lanes<S>) {
        if (!fits.lane_by_lane) {
          fit_block<d, p>(fits, lists, block, records, supports, weights, b * kLaneCount, AllLanes<S, here>{},
                          reinterpret_cast<Pack<S>*>(scratch.data()), out);
          continue;
        }
      }
      for (int k = 0; k < kLaneCount; ++k)
        fit_block<d, p>(fits, lists, block, records, supports, weights, b * kLaneCount, OneLane<S>{k},
                        lanes_of(scratch), out);
    }
  });
}

}  // namespace

template <class S>
void PolynomialFits<S>::fit(const Neighbours<S>& lists, const S* records, const S* supports,
                            const SlotWeight<S>* weights, int first_block, int last_block, LaneArray<S>& scratch,
                            Fit<S>* out) const {
  const auto run = [&](auto fit_some) {
    fit_some(*this, lists, records, supports, weights, first_block, last_block, scratch, out);
  };
  if (dimensions == 2 && degree == 2) run(fit_blocks<2, 2, S>);
  else if (dimensions == 2) run(fit_blocks<2, 4, S>);
  else if (degree == 2) run(fit_blocks<3, 2, S>);
  else run(fit_blocks<3, 4, S>);
}

template struct PolynomialFits<float>;
template struct PolynomialFits<double>;
template struct PolynomialFits<long double>;
template struct PolynomialFits<Quad>;

}  // namespace atwood::fluid
