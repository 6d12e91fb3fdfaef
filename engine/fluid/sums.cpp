#include "fluid/sums.hpp"

#include "math/pack.hpp"

namespace atwood::fluid {
namespace {

// A lane, or all lanes of a block: how it reads numbers of the slots in a row of a list.
template <class S> struct OneLane {
  using Value = S;
  int lane;
  ATWOOD_INLINE S read(const S* at, const int* row, int stride) const {
    return at[static_cast<std::ptrdiff_t>(row[lane]) * stride];
  }
  ATWOOD_INLINE void read_records(const S* records, const int* row, Value* fields) const {
    for (int f = 0; f < kRecordSize; ++f) fields[f] = read(records + f, row, kRecordSize);
  }
  ATWOOD_INLINE S root_of(S a) const { return real::sqrt(a); }
  ATWOOD_INLINE S active(int n, const int* counts) const { return n < counts[lane] ? S(1) : S(0); }
  ATWOOD_INLINE void write(S value, S* at, int stride) const { at[lane * stride] = value; }
};
template <class S, VectorWidth width> struct AllLanes {
  using Value = Pack<S>;
  ATWOOD_INLINE Value read(const S* at, const int* row, int stride) const {
    const auto of = [&](int k) ATWOOD_INLINED { return at[static_cast<std::ptrdiff_t>(row[k]) * stride]; };
    return Value{of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)};
  }
  // Eight records are eight registers: transposed, a register holds one number of all eight. Narrower registers are
  // filled number by number.
  ATWOOD_INLINE void read_records(const S* records, const int* row, Value* fields) const {
    if constexpr (width != VectorWidth::v4) {
      for (int f = 0; f < kRecordSize; ++f) fields[f] = read(records + f, row, kRecordSize);
    } else {
      Value r[8], t[8];
      for (int k = 0; k < 8; ++k) r[k] = load(records + static_cast<std::ptrdiff_t>(row[k]) * kRecordSize);
      for (int k = 0; k < 8; k += 2) {
        t[k] = __builtin_shufflevector(r[k], r[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
        t[k + 1] = __builtin_shufflevector(r[k], r[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
      }
      for (int odd = 0; odd < 2; ++odd) {
        const Value low = __builtin_shufflevector(t[odd], t[2 + odd], 0, 1, 8, 9, 4, 5, 12, 13);
        const Value high = __builtin_shufflevector(t[odd], t[2 + odd], 2, 3, 10, 11, 6, 7, 14, 15);
        const Value low2 = __builtin_shufflevector(t[4 + odd], t[6 + odd], 0, 1, 8, 9, 4, 5, 12, 13);
        const Value high2 = __builtin_shufflevector(t[4 + odd], t[6 + odd], 2, 3, 10, 11, 6, 7, 14, 15);
        fields[odd] = __builtin_shufflevector(low, low2, 0, 1, 2, 3, 8, 9, 10, 11);
        fields[4 + odd] = __builtin_shufflevector(low, low2, 4, 5, 6, 7, 12, 13, 14, 15);
        fields[2 + odd] = __builtin_shufflevector(high, high2, 0, 1, 2, 3, 8, 9, 10, 11);
        fields[6 + odd] = __builtin_shufflevector(high, high2, 4, 5, 6, 7, 12, 13, 14, 15);
      }
    }
  }
  ATWOOD_INLINE Value root_of(const Value& a) const { return root(WholePack<width>{}, a); }
  ATWOOD_INLINE Value active(int n, const int* counts) const {
    Value flags;
    for (int k = 0; k < kLaneCount; ++k) flags[k] = n < counts[k] ? S(1) : S(0);
    return flags;
  }
  ATWOOD_INLINE void write(const Value& value, S* at, int stride) const {
    for (int k = 0; k < kLaneCount; ++k) at[k * stride] = value[k];
  }
};

constexpr int kOwnRow[kLaneCount] = {0, 1, 2, 3, 4, 5, 6, 7};

template <class S, int d> struct Periods {
  S of[d];
  explicit Periods(const Neighbours<S>& lists) {
    for (int c = 0; c < d; ++c) of[c] = lists.period(c);
  }
  template <class V> ATWOOD_INLINE V nearest(const V& difference, int c) const {
    return of[c] == S(0) ? difference : nearest_image(difference, of[c]);
  }
};

template <int d, bool wraps, class S, class Lanes>
ATWOOD_INLINE void block_forces(const PairSums<S>& p, const Periods<S, d>& periods, const NeighbourBlock& block,
                                const SlotData<S>& data, int first, const Lanes& lanes, S* sums) {
  using V = typename Lanes::Value;
  using R = Record<d>;
  const auto heat_of_own = [&](int field) ATWOOD_INLINED {
    return lanes.read(data.heat + std::ptrdiff_t(first) * HeatRecord::size + field, kOwnRow, HeatRecord::size);
  };
  V own[kRecordSize], pressed[d]{}, dragged[d]{}, density{}, diffused{}, conducted{}, dissipated{};
  lanes.read_records(data.records + std::ptrdiff_t(first) * kRecordSize, kOwnRow, own);
  const bool weighed = data.masses != nullptr, thick = data.viscosities != nullptr, extra = data.heat != nullptr;
  const V n_i = own[R::volume], rho_i = V(S(1) / n_i);
  const V mu_i = thick ? lanes.read(data.viscosities + first, kOwnRow, 1) : V{} + data.viscosity;
  const V T_i = extra ? heat_of_own(HeatRecord::temperature) : V{};
  const V k_i = extra ? heat_of_own(HeatRecord::conductivity) : V{};
  const V fluid_i = extra ? heat_of_own(HeatRecord::fluid) : V{};
  const S inverse_support = p.kernel.inverse_support, tiny = p.kernel.support * p.kernel.support * S(1e-30);
  const bool diffuses = p.diffusion != S(0), beyond_pressure = p.viscosity != Viscosity::none || extra || diffuses;
  for (int n = 0; n < block.longest; ++n) {
    const int* const row = block.entries + n * kLaneCount;
    V other[kRecordSize], x[d], v[d], r2{}, approach{};
    lanes.read_records(data.records, row, other);
    for (int c = 0; c < d; ++c) {
      x[c] = own[R::position + c] - other[R::position + c];
      if constexpr (wraps) x[c] = periods.nearest(x[c], c);
      v[c] = own[R::velocity + c] - other[R::velocity + c];
      r2 = r2 + x[c] * x[c];
      approach = approach + v[c] * x[c];
    }
    const V r = lanes.root_of(r2);
    V f = kernel_slope<S>(p.kernel.shape, V(r * inverse_support));
    if (weighed) f = f * lanes.read(data.masses, row, 1);
    density = density + f * approach;
    const V push = f * (own[R::pressure_term] + other[R::pressure_term]);
    for (int c = 0; c < d; ++c) pressed[c] = pressed[c] + push * x[c];
    if (!beyond_pressure) continue;
    const V n_j = other[R::volume], per_volume = f * (n_i * n_j);
    if (p.viscosity != Viscosity::none) {
      const V drag = thick ? V(per_volume * (mu_i + lanes.read(data.viscosities, row, 1))) : per_volume;
      if (p.viscosity == Viscosity::morris) {
        for (int c = 0; c < d; ++c) dragged[c] = dragged[c] + drag * v[c];
        if (p.viscous_heat)
          for (int c = 0; c < d; ++c) dissipated = dissipated + drag * (v[c] * v[c]);
      } else {
        const V least = V{} + tiny, along = drag * approach / (r2 > least ? r2 : least);
        for (int c = 0; c < d; ++c) dragged[c] = dragged[c] + along * x[c];
        if (p.viscous_heat) dissipated = dissipated + along * approach;
      }
    }
    V same = V{} + S(1);
    if (extra) {
      const auto heat_of = [&](int field)
                               ATWOOD_INLINED { return lanes.read(data.heat + field, row, HeatRecord::size); };
      if (p.conduction) {
        const V k_j = heat_of(HeatRecord::conductivity), both = k_i + k_j;
        const V mean = S(4) * (k_i * k_j) / (both > V{} ? both : V{} + S(1));
        conducted = conducted + per_volume * mean * (T_i - heat_of(HeatRecord::temperature));
      }
      same = fluid_i == heat_of(HeatRecord::fluid) ? same : V{};
    }
    if (diffuses) diffused = diffused + same * f * (rho_i * n_j - S(1));
  }
  // Factors that all pairs share.
  const S a = weighed ? p.kernel.slope_factor : p.kernel.slope_factor * data.mass;
  const S gradient = p.gradients ? a : S(0);
  const S both_mu = thick ? S(1) : S(2) * data.viscosity;
  const S drag = a * both_mu * (p.viscosity == Viscosity::central ? S(d + 2) : S(1));
  const V spread = p.several_fluids ? V(p.diffusion * heat_of_own(HeatRecord::sound_speed)) : V{} + p.diffusion;
  S* const out = sums + std::ptrdiff_t(first) * SumRecord::size;
  for (int c = 0; c < d; ++c)
    lanes.write(V(drag * dragged[c] - gradient * pressed[c]), out + SumRecord::acceleration + c, SumRecord::size);
  lanes.write(V(gradient * density + a * (spread * diffused)), out + SumRecord::density, SumRecord::size);
  lanes.write(V(a * conducted - S(0.5) * drag * dissipated), out + SumRecord::heat, SumRecord::size);
}

template <int d, bool wraps, class S, class Lanes>
ATWOOD_INLINE void block_densities(const PairSums<S>& p, const Periods<S, d>& periods, const NeighbourBlock& block,
                                   const S* records, const S* masses, int first, const Lanes& lanes, S* densities) {
  using V = typename Lanes::Value;
  V own[kRecordSize];
  lanes.read_records(records + std::ptrdiff_t(first) * kRecordSize, kOwnRow, own);
  V sum = lanes.read(masses + first, kOwnRow, 1) * kernel_value<S>(p.kernel.shape, V{});
  for (int n = 0; n < block.longest; ++n) {
    const int* const row = block.entries + n * kLaneCount;
    V other[kRecordSize], r2{};
    lanes.read_records(records, row, other);
    for (int c = 0; c < d; ++c) {
      V x = own[c] - other[c];
      if constexpr (wraps) x = periods.nearest(x, c);
      r2 = r2 + x * x;
    }
    const V r = lanes.root_of(r2), m = lanes.active(n, block.counts) * lanes.read(masses, row, 1);
    sum = sum + m * kernel_value<S>(p.kernel.shape, V(r * p.kernel.inverse_support));
  }
  lanes.write(V(p.kernel.value_factor * sum), densities + first, 1);
}

// Packs of eight doubles spill where registers hold four: there the plain target's code is the faster.
template <class S> VectorWidth fitting(VectorWidth width) {
  return width == VectorWidth::v3 && sizeof(S) == 8 ? VectorWidth::narrow : width;
}

// block_of(lanes) for all lanes of a block: at the machine's vector width, or lane after lane.
template <class S, VectorWidth width, class BlockOf>
ATWOOD_INLINE void over_lanes(bool lane_by_lane, const BlockOf& block_of) {
  if constexpr (has_vector_lanes<S>)
    if (!lane_by_lane) return block_of(AllLanes<S, width>{});
  for (int k = 0; k < kLaneCount; ++k) block_of(OneLane<S>{k});
}

template <int d, class S>
void forces_of(const PairSums<S>& p, const Neighbours<S>& lists, const SlotData<S>& data, int first, int last,
               S* sums) {
  const Periods<S, d> periods(lists);
  in_lanes<S>(fitting<S>(p.width), [&](auto width) ATWOOD_INLINED {
    for (int b = first; b < last; ++b) {
      const NeighbourBlock block = lists.block(b);
      over_lanes<S, decltype(width)::value>(p.lane_by_lane, [&](const auto& lanes) ATWOOD_INLINED {
        if (block.wraps) block_forces<d, true>(p, periods, block, data, b * kLaneCount, lanes, sums);
        else block_forces<d, false>(p, periods, block, data, b * kLaneCount, lanes, sums);
      });
    }
  });
}

template <int d, class S>
void densities_of(const PairSums<S>& p, const Neighbours<S>& lists, const S* records, const S* masses, int first,
                  int last, S* densities) {
  const Periods<S, d> periods(lists);
  in_lanes<S>(fitting<S>(p.width), [&](auto width) ATWOOD_INLINED {
    for (int b = first; b < last; ++b) {
      const NeighbourBlock block = lists.block(b);
      over_lanes<S, decltype(width)::value>(p.lane_by_lane, [&](const auto& lanes) ATWOOD_INLINED {
        if (block.wraps) block_densities<d, true>(p, periods, block, records, masses, b * kLaneCount, lanes, densities);
        else block_densities<d, false>(p, periods, block, records, masses, b * kLaneCount, lanes, densities);
      });
    }
  });
}

}  // namespace

template <class S>
void PairSums<S>::add_forces(const Neighbours<S>& lists, int dimensions, const SlotData<S>& data, int first, int last,
                             S* sums) const {
  if (dimensions == 2) forces_of<2>(*this, lists, data, first, last, sums);
  else forces_of<3>(*this, lists, data, first, last, sums);
}

template <class S>
void PairSums<S>::add_densities(const Neighbours<S>& lists, int dimensions, const S* records, const S* masses,
                                int first, int last, S* densities) const {
  if (dimensions == 2) densities_of<2>(*this, lists, records, masses, first, last, densities);
  else densities_of<3>(*this, lists, records, masses, first, last, densities);
}

template struct PairSums<float>;
template struct PairSums<double>;
template struct PairSums<long double>;
template struct PairSums<Quad>;

}  // namespace atwood::fluid
