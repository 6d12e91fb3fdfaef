#include "fluid/sums.hpp"

#include "fluid/slot_lanes.hpp"

namespace atwood::fluid {
namespace {

// Which terms the pairs have: known when the loop runs, or, for a fluid without heat and of one viscosity, when it is
// compiled.
struct AnyTerms {
  Viscosity viscosity;
  bool has_masses, has_viscosities, conduction, several_fluids, viscous_heat, has_diffusion;  // of each particle
  bool heat_records() const { return conduction || several_fluids; }
};
template <bool by_masses, bool diffusion> struct PlainTerms {
  static constexpr Viscosity viscosity = Viscosity::morris;
  static constexpr bool has_masses = by_masses, has_diffusion = diffusion;
  static constexpr bool has_viscosities = false, conduction = false, several_fluids = false, viscous_heat = false;
  static constexpr bool heat_records() { return false; }
};
template <class S> AnyTerms terms_of(const PairSums<S>& p, const SlotData<S>& data) {
  return {p.viscosity,      data.masses != nullptr, data.viscosities != nullptr, p.conduction,
          p.several_fluids, p.viscous_heat,         p.diffusion != S(0)};
}
bool plain(const AnyTerms& t) {
  return t.viscosity == Viscosity::morris && !t.has_viscosities && !t.heat_records() && !t.viscous_heat;
}

template <int d, class S, class Lanes, class Terms>
ATWOOD_INLINE void block_forces(const PairSums<S>& p, const Terms& terms, const Neighbours<S>& lists,
                                const NeighbourBlock& block, const SlotData<S>& data, int first, const Lanes& lanes,
                                S* sums) {
  using V = typename Lanes::Value;
  using R = Record<d>;
  const auto heat_of_own = [&](int field) ATWOOD_INLINED {
    return lanes.own(data.heat + std::ptrdiff_t(first) * HeatRecord::size + field, HeatRecord::size);
  };
  V own[kRecordSize], pressure_sum[d]{}, viscous_sum[d]{}, density{}, diffusion_sum{}, heat_sum{}, dissipation_sum{};
  read_own_records(lanes, data.records + std::ptrdiff_t(first) * kRecordSize, own);
  const bool extra = terms.heat_records();
  const V n_i = own[R::volume];
  const V mu_i = terms.has_viscosities ? lanes.own(data.viscosities + first, 1) : V{} + data.viscosity;
  const V T_i = extra ? heat_of_own(HeatRecord::temperature) : V{};
  const V k_i = extra ? heat_of_own(HeatRecord::conductivity) : V{};
  const V fluid_i = extra ? heat_of_own(HeatRecord::fluid) : V{};
  const S tiny = p.kernel.support * p.kernel.support * S(1e-30);
  const auto slope = [](auto shape, const V& s) ATWOOD_INLINED { return kernel_slope<decltype(shape)::value, S>(s); };
  const auto add = [&](std::ptrdiff_t j, const V(&x)[d], const V& slope_ij, const S* other) ATWOOD_INLINED {
    V v[d];
    for (int c = 0; c < d; ++c) v[c] = own[R::velocity + c] - other[R::velocity + c];
    V approach = v[0] * x[0];
    for (int c = 1; c < d; ++c) approach = approach + v[c] * x[c];
    V f = slope_ij;
    if (terms.has_masses) f = f * data.masses[j];
    density = density + f * approach;
    const V pressure_factor = f * (own[R::pressure_term] + other[R::pressure_term]);
    for (int c = 0; c < d; ++c) pressure_sum[c] = pressure_sum[c] + pressure_factor * x[c];
    const S n_j = other[R::volume];
    const V per_volume = f * (n_i * n_j);
    if (terms.viscosity != Viscosity::none) {
      const V viscous_weight = terms.has_viscosities ? V(per_volume * (mu_i + data.viscosities[j])) : per_volume;
      if (terms.viscosity == Viscosity::morris) {
        for (int c = 0; c < d; ++c) viscous_sum[c] = viscous_sum[c] + viscous_weight * v[c];
        if (terms.viscous_heat)
          for (int c = 0; c < d; ++c) dissipation_sum = dissipation_sum + viscous_weight * (v[c] * v[c]);
      } else {
        V r2 = x[0] * x[0];
        for (int c = 1; c < d; ++c) r2 = r2 + x[c] * x[c];
        const V least = V{} + tiny, along = viscous_weight * approach / (r2 > least ? r2 : least);
        for (int c = 0; c < d; ++c) viscous_sum[c] = viscous_sum[c] + along * x[c];
        if (terms.viscous_heat) dissipation_sum = dissipation_sum + along * approach;
      }
    }
    const S* const heat = extra ? data.heat + j * HeatRecord::size : nullptr;
    if (terms.conduction) {
      const S k_j = heat[HeatRecord::conductivity];
      const V both = k_i + k_j, mean = S(4) * (k_i * k_j) / (both > V{} ? both : V{} + S(1));
      heat_sum = heat_sum + per_volume * mean * (T_i - heat[HeatRecord::temperature]);
    }
    if (terms.has_diffusion) {
      const V change = f * (n_j - n_i);  // 0 of a lane's own slot
      if (!terms.several_fluids) diffusion_sum = diffusion_sum + change;
      else diffusion_sum = diffusion_sum + (fluid_i == V{} + heat[HeatRecord::fluid] ? change : V{});
    }
  };
  over_pairs<d>(lists, block, p.kernel, data.records, lanes, own, slope, add);
  // Factors that all pairs share.
  const S a = terms.has_masses ? p.kernel.slope_factor : p.kernel.slope_factor * data.mass;
  const S gradient = p.gradients ? a : S(0);
  const S both_mu = terms.has_viscosities ? S(1) : S(2) * data.viscosity;
  const S viscous_factor = a * both_mu * (terms.viscosity == Viscosity::central ? S(d + 2) : S(1));
  const V diffusivity =
      terms.several_fluids ? V(p.diffusion * heat_of_own(HeatRecord::sound_speed)) : V{} + p.diffusion;
  S* const out = sums + std::ptrdiff_t(first) * SumRecord::size;
  for (int c = 0; c < d; ++c)
    lanes.write(V(viscous_factor * viscous_sum[c] - gradient * pressure_sum[c]), out + SumRecord::acceleration + c,
                SumRecord::size);
  lanes.write(V(gradient * density + a * (diffusivity * (diffusion_sum / n_i))), out + SumRecord::density,
              SumRecord::size);
  lanes.write(V(a * heat_sum - S(0.5) * viscous_factor * dissipation_sum), out + SumRecord::heat, SumRecord::size);
}

template <int d, class S, class Lanes>
ATWOOD_INLINE void block_densities(const PairSums<S>& p, const Neighbours<S>& lists, const NeighbourBlock& block,
                                   const S* records, const S* masses, int first, const Lanes& lanes, S* densities) {
  using V = typename Lanes::Value;
  V own[d];  // positions alone: other threads write the pressures of their blocks meanwhile
  for (int c = 0; c < d; ++c) own[c] = lanes.own(records + std::ptrdiff_t(first) * kRecordSize + c, kRecordSize);
  V sum = lanes.own(masses + first, 1) * kernel_value<S>(p.kernel.shape, V{});
  over_pairs<d>(
      lists, block, p.kernel, records, lanes, own,
      [](auto shape, const V& s) ATWOOD_INLINED { return kernel_value<decltype(shape)::value, S>(s); },
      [&](std::ptrdiff_t j, const V(&)[d], const V& w, const S*)
          ATWOOD_INLINED { sum = sum + lanes.other_than(static_cast<int>(j) - first) * masses[j] * w; });
  lanes.write(V(p.kernel.value_factor * sum), densities + first, 1);
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
      if (terms.has_masses && terms.has_diffusion) return run(PlainTerms<true, true>{});
      if (terms.has_masses) return run(PlainTerms<true, false>{});
      if (terms.has_diffusion) return run(PlainTerms<false, true>{});
      return run(PlainTerms<false, false>{});
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
