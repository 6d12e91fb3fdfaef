#include "fluid/sums.hpp"

#include "fluid/registers.hpp"

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
  ATWOOD_INLINE int longest(const int* counts) const { return counts[lane]; }
  ATWOOD_INLINE void write(S value, S* at, int stride) const { at[lane * stride] = value; }
};
// The lanes from `first` on, as many as a register of the machine holds.
template <class S, VectorWidth width> struct RegisterLanes {
  using Value = Register<S, width>;
  static constexpr int count = sizeof(Value) / sizeof(S);
  int first;
  template <class Of> ATWOOD_INLINE static Value each(const Of& of) {
    if constexpr (count == 4) return Value{of(0), of(1), of(2), of(3)};
    else return Value{of(0), of(1), of(2), of(3), of(4), of(5), of(6), of(7)};
  }
  ATWOOD_INLINE Value read(const S* at, const int* row, int stride) const {
    return each([&](int k) ATWOOD_INLINED { return at[static_cast<std::ptrdiff_t>(row[first + k]) * stride]; });
  }
  // Two numbers of every record at a time, then one from the other.
  ATWOOD_INLINE void read_records(const S* records, const int* row, Value* fields) const {
    const S* at[count];
    for (int k = 0; k < count; ++k) at[k] = records + static_cast<std::ptrdiff_t>(row[first + k]) * kRecordSize;
    if constexpr (std::is_same_v<S, float> || width == VectorWidth::narrow) {
      for (int f = 0; f < kRecordSize; ++f) fields[f] = each([&](int k) ATWOOD_INLINED { return at[k][f]; });
    } else {
      for (int f = 0; f < kRecordSize; f += 2) {
        const auto two = [&](int k) ATWOOD_INLINED { return join_pairs<width>(at[k] + f, at[k + 2] + f); };
        if constexpr (count == 4) {
          const Value a = two(0), b = two(1);
          fields[f] = __builtin_shufflevector(a, b, 0, 4, 2, 6);
          fields[f + 1] = __builtin_shufflevector(a, b, 1, 5, 3, 7);
        } else {
          const Value a = __builtin_shufflevector(two(0), two(4), 0, 1, 2, 3, 4, 5, 6, 7);
          const Value b = __builtin_shufflevector(two(1), two(5), 0, 1, 2, 3, 4, 5, 6, 7);
          fields[f] = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
          fields[f + 1] = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
        }
      }
    }
  }
  ATWOOD_INLINE Value root_of(const Value& a) const { return square_root(WholePack<width>{}, a); }
  ATWOOD_INLINE Value active(int n, const int* counts) const {
    return each([&](int k) ATWOOD_INLINED { return n < counts[first + k] ? S(1) : S(0); });
  }
  ATWOOD_INLINE int longest(const int* counts) const {
    int most = 0;
    for (int k = 0; k < count; ++k) most = counts[first + k] > most ? counts[first + k] : most;
    return most;
  }
  ATWOOD_INLINE void write(const Value& value, S* at, int stride) const {
    for (int k = 0; k < count; ++k) at[(first + k) * stride] = value[k];
  }
};

constexpr int kOwnRow[kLaneCount] = {0, 1, 2, 3, 4, 5, 6, 7};

// Differences of coordinates by the nearest image, along the axes whose period the pairs of a block may lie across.
template <int d, class V> struct NearestImages {
  unsigned wrapping;
  V half[d], whole[d];
  template <class S> ATWOOD_INLINE NearestImages(const Neighbours<S>& lists, unsigned axes) : wrapping(axes) {
    for (int c = 0; c < d; ++c) half[c] = V{} + S(0.5) * lists.period(c), whole[c] = V{} + lists.period(c);
  }
  ATWOOD_INLINE V operator()(const V& difference, int c) const {
    return (wrapping >> c & 1) == 0 ? difference : nearest_image(difference, half[c], whole[c]);
  }
};

// Which terms the pairs have: known when the loop runs, or, for the plainest fluid, when it is compiled.
struct AnyTerms {
  KernelShape shape;
  Viscosity viscosity;
  bool weighed, thick, conduction, several_fluids, viscous_heat, diffuses;  // weighed: by masses; thick: by viscosities
  bool heat_records() const { return conduction || several_fluids; }
};
template <KernelShape of> struct PlainTerms {
  static constexpr KernelShape shape = of;
  static constexpr Viscosity viscosity = Viscosity::morris;
  static constexpr bool weighed = false, thick = false, conduction = false, several_fluids = false,
                        viscous_heat = false, diffuses = false;
  static constexpr bool heat_records() { return false; }
};
template <class S> AnyTerms terms_of(const PairSums<S>& p, const SlotData<S>& data) {
  return {p.kernel.shape, p.viscosity,      data.masses != nullptr, data.viscosities != nullptr,
          p.conduction,   p.several_fluids, p.viscous_heat,         p.diffusion != S(0)};
}
bool plain(const AnyTerms& t) {
  return t.viscosity == Viscosity::morris && !t.weighed && !t.thick && !t.heat_records() && !t.viscous_heat &&
         !t.diffuses;
}

template <int d, class S, class Lanes, class Terms>
ATWOOD_INLINE void block_forces(const PairSums<S>& p, const Terms& terms, const Neighbours<S>& lists,
                                const NeighbourBlock& block, const SlotData<S>& data, int first, const Lanes& lanes,
                                S* sums) {
  using V = typename Lanes::Value;
  using R = Record<d>;
  const NearestImages<d, V> nearest(lists, block.wraps);
  const auto heat_of_own = [&](int field) ATWOOD_INLINED {
    return lanes.read(data.heat + std::ptrdiff_t(first) * HeatRecord::size + field, kOwnRow, HeatRecord::size);
  };
  V own[kRecordSize], pressed[d]{}, dragged[d]{}, density{}, diffused{}, conducted{}, dissipated{};
  lanes.read_records(data.records + std::ptrdiff_t(first) * kRecordSize, kOwnRow, own);
  const bool extra = terms.heat_records();
  const V n_i = own[R::volume];
  const V mu_i = terms.thick ? lanes.read(data.viscosities + first, kOwnRow, 1) : V{} + data.viscosity;
  const V T_i = extra ? heat_of_own(HeatRecord::temperature) : V{};
  const V k_i = extra ? heat_of_own(HeatRecord::conductivity) : V{};
  const V fluid_i = extra ? heat_of_own(HeatRecord::fluid) : V{};
  const S inverse_support = p.kernel.inverse_support, tiny = p.kernel.support * p.kernel.support * S(1e-30);
  for (int n = 0, rows = lanes.longest(block.counts); n < rows; ++n) {
    const int* const row = block.entries + n * kLaneCount;
    V other[kRecordSize], x[d], v[d];
    lanes.read_records(data.records, row, other);
    for (int c = 0; c < d; ++c) {
      x[c] = nearest(V(own[R::position + c] - other[R::position + c]), c);
      v[c] = own[R::velocity + c] - other[R::velocity + c];
    }
    V r2 = x[0] * x[0], approach = v[0] * x[0];
    for (int c = 1; c < d; ++c) {
      r2 = r2 + x[c] * x[c];
      approach = approach + v[c] * x[c];
    }
    const V r = lanes.root_of(r2);
    V f = kernel_slope<S>(terms.shape, V(r * inverse_support));
    if (terms.weighed) f = f * lanes.read(data.masses, row, 1);
    density = density + f * approach;
    const V push = f * (own[R::pressure_term] + other[R::pressure_term]);
    for (int c = 0; c < d; ++c) pressed[c] = pressed[c] + push * x[c];
    const V n_j = other[R::volume], per_volume = f * (n_i * n_j);
    if (terms.viscosity != Viscosity::none) {
      const V drag = terms.thick ? V(per_volume * (mu_i + lanes.read(data.viscosities, row, 1))) : per_volume;
      if (terms.viscosity == Viscosity::morris) {
        for (int c = 0; c < d; ++c) dragged[c] = dragged[c] + drag * v[c];
        if (terms.viscous_heat)
          for (int c = 0; c < d; ++c) dissipated = dissipated + drag * (v[c] * v[c]);
      } else {
        const V least = V{} + tiny, along = drag * approach / (r2 > least ? r2 : least);
        for (int c = 0; c < d; ++c) dragged[c] = dragged[c] + along * x[c];
        if (terms.viscous_heat) dissipated = dissipated + along * approach;
      }
    }
    const auto heat_of = [&](int field) ATWOOD_INLINED { return lanes.read(data.heat + field, row, HeatRecord::size); };
    if (terms.conduction) {
      const V k_j = heat_of(HeatRecord::conductivity), both = k_i + k_j;
      const V mean = S(4) * (k_i * k_j) / (both > V{} ? both : V{} + S(1));
      conducted = conducted + per_volume * mean * (T_i - heat_of(HeatRecord::temperature));
    }
    if (terms.diffuses) {
      const V change = f * (n_j - n_i);  // 0 of a lane's own slot
      if (!terms.several_fluids) diffused = diffused + change;
      else diffused = diffused + (fluid_i == heat_of(HeatRecord::fluid) ? change : V{});
    }
  }
  // Factors that all pairs share.
  const S a = terms.weighed ? p.kernel.slope_factor : p.kernel.slope_factor * data.mass;
  const S gradient = p.gradients ? a : S(0);
  const S both_mu = terms.thick ? S(1) : S(2) * data.viscosity;
  const S drag = a * both_mu * (terms.viscosity == Viscosity::central ? S(d + 2) : S(1));
  const V spread = terms.several_fluids ? V(p.diffusion * heat_of_own(HeatRecord::sound_speed)) : V{} + p.diffusion;
  S* const out = sums + std::ptrdiff_t(first) * SumRecord::size;
  for (int c = 0; c < d; ++c)
    lanes.write(V(drag * dragged[c] - gradient * pressed[c]), out + SumRecord::acceleration + c, SumRecord::size);
  lanes.write(V(gradient * density + a * (spread * (diffused / n_i))), out + SumRecord::density, SumRecord::size);
  lanes.write(V(a * conducted - S(0.5) * drag * dissipated), out + SumRecord::heat, SumRecord::size);
}

template <int d, class S, class Lanes>
ATWOOD_INLINE void block_densities(const PairSums<S>& p, const Neighbours<S>& lists, const NeighbourBlock& block,
                                   const S* records, const S* masses, int first, const Lanes& lanes, S* densities) {
  using V = typename Lanes::Value;
  const NearestImages<d, V> nearest(lists, block.wraps);
  V own[kRecordSize];
  lanes.read_records(records + std::ptrdiff_t(first) * kRecordSize, kOwnRow, own);
  V sum = lanes.read(masses + first, kOwnRow, 1) * kernel_value<S>(p.kernel.shape, V{});
  for (int n = 0, rows = lanes.longest(block.counts); n < rows; ++n) {
    const int* const row = block.entries + n * kLaneCount;
    V other[kRecordSize], r2{};
    lanes.read_records(records, row, other);
    for (int c = 0; c < d; ++c) {
      const V x = nearest(V(own[c] - other[c]), c);
      r2 = r2 + x * x;
    }
    const V r = lanes.root_of(r2), m = lanes.active(n, block.counts) * lanes.read(masses, row, 1);
    sum = sum + m * kernel_value<S>(p.kernel.shape, V(r * p.kernel.inverse_support));
  }
  lanes.write(V(p.kernel.value_factor * sum), densities + first, 1);
}

// block_of(lanes) for all lanes of a block: a register at a time, or lane after lane.
template <class S, VectorWidth width, class BlockOf>
ATWOOD_INLINE void over_lanes(bool lane_by_lane, const BlockOf& block_of) {
  if constexpr (has_vector_lanes<S>) {
    if (!lane_by_lane) {
      using Lanes = RegisterLanes<S, width>;
      for (int k = 0; k < kLaneCount; k += Lanes::count) block_of(Lanes{k});
      return;
    }
  }
  for (int k = 0; k < kLaneCount; ++k) block_of(OneLane<S>{k});
}

template <int d, class S, class Terms>
void forces_with(const Terms& terms, const PairSums<S>& p, const Neighbours<S>& lists, const SlotData<S>& data,
                 int first, int last, S* sums) {
  in_lanes<S>(p.width, [&](auto width) ATWOOD_INLINED {
    for (int b = first; b < last; ++b) {
      const NeighbourBlock block = lists.block(b);
      over_lanes<S, decltype(width)::value>(p.lane_by_lane, [&](const auto& lanes) ATWOOD_INLINED {
        block_forces<d>(p, terms, lists, block, data, b * kLaneCount, lanes, sums);
      });
    }
  });
}

template <int d, class S>
void forces_of(const PairSums<S>& p, const Neighbours<S>& lists, const SlotData<S>& data, int first, int last,
               S* sums) {
  const AnyTerms terms = terms_of(p, data);
  const auto run = [&](const auto& known) { forces_with<d>(known, p, lists, data, first, last, sums); };
  if constexpr (has_vector_lanes<S>) {
    if (plain(terms) && !p.lane_by_lane) {
      switch (terms.shape) {
        case KernelShape::cubic: return run(PlainTerms<KernelShape::cubic>{});
        case KernelShape::quintic: return run(PlainTerms<KernelShape::quintic>{});
        case KernelShape::wendland_c2: return run(PlainTerms<KernelShape::wendland_c2>{});
        case KernelShape::wendland_c4: return run(PlainTerms<KernelShape::wendland_c4>{});
        case KernelShape::wendland_c6: return run(PlainTerms<KernelShape::wendland_c6>{});
      }
    }
  }
  run(terms);
}

template <int d, class S>
void densities_of(const PairSums<S>& p, const Neighbours<S>& lists, const S* records, const S* masses, int first,
                  int last, S* densities) {
  in_lanes<S>(p.width, [&](auto width) ATWOOD_INLINED {
    for (int b = first; b < last; ++b) {
      const NeighbourBlock block = lists.block(b);
      over_lanes<S, decltype(width)::value>(p.lane_by_lane, [&](const auto& lanes) ATWOOD_INLINED {
        block_densities<d>(p, lists, block, records, masses, b * kLaneCount, lanes, densities);
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
