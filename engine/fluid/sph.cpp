#include "fluid/sph.hpp"

#include <algorithm>
#include <functional>
#include <limits>

#include "fluid/body_overlaps.hpp"
#include "fluid/corrections.hpp"
#include "fluid/transport.hpp"
#include "fluid/walls.hpp"

namespace atwood::fluid {
namespace {

constexpr int kMinShared = 1000;  // particles
constexpr int kRun =
    64;  // blocks that pass through a step of the work before the next: their records stay in the cache

// Why the equations of docs/fluids.md do not describe this scene; empty: they do.
std::string scene_fault(const Scene& scene, const SphOptions& options) {
  const auto number = [](double x) { return format_double(x); };
  const double support = support_ratio(options.kernel) * options.smoothing * scene.fluids.front().spacing_m;
  for (const Fluid& fluid : scene.fluids) {
    const std::string whose = " of the fluid `" + fluid.name + "`";
    if (fluid.spacing_m != scene.fluids.front().spacing_m)
      return "+sph needs fluids of one spacing; that" + whose + " is " + number(fluid.spacing_m) + " m, another is " +
             number(scene.fluids.front().spacing_m) + " m";
    if (!(fluid.sound_speed_m_per_s > 0)) return "the sound speed" + whose + " is 0; +sph needs one above 0";
    if (!(fluid.density_kg_per_m3 > 0) || !(fluid.spacing_m > 0))
      return "the density and the spacing" + whose + " must be above 0";
    if (fluid.particles.mass_kg.empty()) return "the fluid `" + fluid.name + "` has no particles";
    if (fluid.viscous_heat != scene.fluids.front().viscous_heat)
      return "+sph needs viscous_heat of all fluids or of none; that" + whose + " differs";
  }
  if (std::string why = period_fault(scene, support, "the kernel's support"); !why.empty()) return why;
  if (!scene.fluid_boundaries.empty() && scene.fluids.size() > 1) return "+sph has walls for a single fluid only";
  if (options.corrected && options.summation) return "corrected=true of +sph needs density=continuity";
  if ((options.corrected || options.shift != 0) && !scene.fluid_boundaries.empty())
    return "+sph has walls for corrected=false and shift=0 only";
  return "";
}

}  // namespace

template <class S>
Sph<S>::Sph(const Scene& scene, const SphOptions& asked)
    : scene_(scene), options_(resolved(asked, scene)), unsupported_(scene_fault(scene, options_)) {
  const SphOptions& options = options_;
  if (std::is_same_v<S, float> && unsupported_.empty())
    unsupported_ =
        float_fault(scene, support_ratio(options.kernel) * options.smoothing * scene.fluids.front().spacing_m);
  if (!unsupported_.empty()) return;
  if (!scene.bodies.empty()) {
    bodies_ = std::make_unique<RigidModel<S>>(scene);
    unsupported_ = bodies_->unsupported();
    if (!unsupported_.empty()) return;
  }
  set_ = make_particle_set<S>(scene, !options.summation, bodies_ == nullptr ? 0 : bodies_->state_size());
  const auto has_source = [](const Fluid& fluid) { return !fluid.source.name.empty(); };
  if (std::any_of(scene.fluids.begin(), scene.fluids.end(), has_source))
    for (const Fluid& fluid : scene.fluids) sources_.emplace_back(fluid);
  if (options.threads > 1) team_ = std::make_unique<Team>(options.threads);
  const int d = set_.layout.dimensions;
  const S h = S(options.smoothing) * S(scene.fluids.front().spacing_m);
  sums_.kernel = make_kernel<S>(options.kernel, d, h);
  sums_.viscosity = options.viscosity;
  sums_.lane_by_lane = options.lane_by_lane;
  sums_.gradients = !options.corrected;
  sums_.several_fluids = scene.fluids.size() > 1;
  bool viscous = false;
  for (const FluidLaw<S>& law : set_.laws) {
    viscous = viscous || law.viscosity > S(0);
    sums_.conduction = sums_.conduction || (law.conductivity > S(0) && law.heat_capacity > S(0));
    sums_.viscous_heat = sums_.viscous_heat || law.viscous_heat;
  }
  sums_.diffusion = S(2) * S(options.density_diffusion) * h;
  if (!sums_.several_fluids) sums_.diffusion = sums_.diffusion * set_.laws.front().sound_speed;
  if (!viscous) sums_.viscosity = Viscosity::none;
  if (options.summation) sums_.diffusion = S(0);
  for (const Fluid& fluid : scene.fluids)
    for (const Real3& v : fluid.particles.velocity_m_per_s)
      transport_strength_ = real::max(transport_strength_, norm(narrow3<S>(v)));
  transport_strength_ = S(options.shift) * transport_strength_ * sums_.kernel.support;
  needs_heat_record_ = sums_.conduction || sums_.several_fluids;
  equal_masses_ = scene.fluid_boundaries.empty() &&
                  std::adjacent_find(set_.mass.begin(), set_.mass.end(), std::not_equal_to<>()) == set_.mass.end();
  equal_viscosities_ = !sums_.several_fluids && set_.laws.front().viscosity_decay == S(0);
  for (int c = 0; c < d; ++c) gravity_[c] = S(scene.gravity_m_per_s2[c]);
  lists_ = std::make_unique<Neighbours<S>>(scene.domain, sums_.kernel.support, S(options.skin) * sums_.kernel.support,
                                           S(scene.fluids.front().spacing_m));
  if (!scene.fluid_boundaries.empty()) {
    walls_ = std::make_unique<Walls<S>>(scene, set_, sums_, bodies_.get());
    unsupported_ = walls_->unsupported();
  }
  if (set_.layout.body_scalars > 0 && unsupported_.empty()) {
    overlaps_ = std::make_unique<BodyOverlaps<S>>(scene, *bodies_);
    unsupported_ = overlaps_->unsupported();
  }
  system_.size = set_.layout.size();
  system_.context = this;
  system_.rate_of = rate_of;
  if (bodies_ != nullptr && bodies_->system().project_of != nullptr && set_.layout.body_scalars > 0)
    system_.project_of = project_of;
}

template <class S> Sph<S>::~Sph() = default;

template <class S> template <class Work> void Sph<S>::over_blocks(const Work& work) {
  const int blocks = lists_->blocks();
  const auto in_runs = [&](Share own) {
    for (int first = own.first; first < own.last; first += kRun) work(first, std::min(first + kRun, own.last));
  };
  if (team_ == nullptr || lists_->count() < kMinShared) return in_runs({0, blocks});
  const int parts = std::min(blocks, 4 * team_->size());
  team_->run(parts, [&](int part) { in_runs(share(blocks, part, parts)); });
}

template <class S> void Sph<S>::initial_state(S* y) const {
  initial_particles(set_, scene_, y);
  if (set_.layout.body_scalars > 0) bodies_->initial_state(y + set_.layout.bodies());
}

// ---- records --------------------------------------------------------------------------------------------------------
template <class S> bool Sph<S>::update(S t_s, const S* y) {
  const Layout& at = set_.layout;
  const S* x = y + at.positions();
  int count = at.particles;
  if (walls_ != nullptr) {
    walls_->place(t_s, y + at.bodies());
    count += walls_->count();
    points_.resize(std::size_t(count) * at.dimensions);
    std::copy_n(x, std::size_t(at.particles) * at.dimensions, points_.begin());
    std::copy(walls_->positions().begin(), walls_->positions().end(),
              points_.begin() + std::ptrdiff_t(at.particles) * at.dimensions);
    x = points_.data();
  }
  const std::int64_t builds = lists_->builds();
  if (!lists_->update(x, count, team_.get())) return false;
  if (lists_->builds() != builds) set_masses();
  const std::size_t slots = std::size_t(lists_->blocks()) * kLaneCount;
  records_.resize(slots);
  densities_.resize(slots);
  out_.resize(slots * SumRecord::size);
  if (!equal_viscosities_) viscosities_.resize(slots);
  if (needs_heat_record_) heat_.resize(slots * HeatRecord::size);
  const auto prepare = [&](auto dimensions) {
    constexpr int d = decltype(dimensions)::value;
    over_blocks([&](int first, int last) {
      pack<d>(y, first, last);
      if (!options_.summation) set_pressures<d>(y, first, last);
    });
    if (!options_.summation) return;
    over_blocks([&](int first, int last) {
      const std::vector<S>& masses = walls_ == nullptr ? masses_ : wall_masses_;
      sums_.add_densities(*lists_, d, lanes_of(records_), masses.data(), first, last, densities_.data());
      set_pressures<d>(y, first, last);
    });
  };
  if (at.dimensions == 2) prepare(std::integral_constant<int, 2>{});
  else prepare(std::integral_constant<int, 3>{});
  if (walls_ != nullptr) walls_->extrapolate(*lists_, lanes_of(records_), densities_.data(), y);
  return true;
}

// Positions, velocities and densities of the slots; the points of walls rest here.
template <class S> template <int d> void Sph<S>::pack(const S* y, int first_block, int last_block) {
  const Layout& at = set_.layout;
  const int last = lists_->count() - 1;
  const int* const order = lists_->order().data();
  const S *const x = walls_ == nullptr ? y + at.positions() : points_.data(), *const v = y + at.velocities();
  for (int slot = first_block * kLaneCount; slot < last_block * kLaneCount; ++slot) {
    const std::ptrdiff_t i = order[std::min(slot, last)];
    S* const record = records_[slot].lane;
    const bool fluid = i < at.particles;
    for (int c = 0; c < d; ++c) {
      record[c] = lists_->wrapped(x[i * d + c], c);
      record[d + c] = fluid ? v[i * d + c] : S(0);
    }
    if (!options_.summation) densities_[slot] = fluid ? y[at.densities() + i] : walls_->law().density0;
  }
}

// The points of walls have no mass here.
template <class S> void Sph<S>::set_masses() {
  const int slots = lists_->blocks() * kLaneCount, last_slot = lists_->count() - 1;
  masses_.resize(slots);
  if (options_.summation && walls_ != nullptr) wall_masses_.resize(slots);
  over_blocks([&](int first, int last) {
    for (int slot = first * kLaneCount; slot < last * kLaneCount; ++slot) {
      const int i = lists_->order()[std::min(slot, last_slot)];
      const bool fluid = i < set_.layout.particles;
      masses_[slot] = fluid ? set_.mass[i] : S(0);
      if (!wall_masses_.empty()) wall_masses_[slot] = fluid ? set_.mass[i] : walls_->mass();
    }
  });
}

// What follows from density and temperature.
template <class S> template <int d> void Sph<S>::set_pressures(const S* y, int first_block, int last_block) {
  const int last = lists_->count() - 1;
  for (int slot = first_block * kLaneCount; slot < last_block * kLaneCount; slot += kLaneCount) {
    const S* const densities = &densities_[slot];
    S pressures[kLaneCount];
    if (!sums_.several_fluids) set_.laws.front().pressures(densities, pressures, kLaneCount);
    else
      for (int k = 0; k < kLaneCount; ++k)
        pressures[k] = set_.law(lists_->order()[std::min(slot + k, last)]).pressure(densities[k]);
    S volumes[kLaneCount];
    for (int k = 0; k < kLaneCount; ++k) volumes[k] = S(1) / densities[k];
    for (int k = 0; k < kLaneCount; ++k) pressures[k] = pressures[k] * volumes[k] * volumes[k];
    for (int k = 0; k < kLaneCount; ++k) {
      S* const record = records_[slot + k].lane;
      record[2 * d] = pressures[k];
      record[2 * d + 1] = volumes[k];
    }
  }
  if (!equal_viscosities_ || needs_heat_record_) set_heat_records(y, first_block, last_block);
}

template <class S> void Sph<S>::set_heat_records(const S* y, int first_block, int last_block) {
  const Layout& at = set_.layout;
  const int last = lists_->count() - 1;
  for (int slot = first_block * kLaneCount; slot < last_block * kLaneCount; ++slot) {
    const int i = lists_->order()[std::min(slot, last)];
    if (!equal_viscosities_) viscosities_[slot] = S(0);
    if (i >= at.particles) continue;
    const FluidLaw<S>& law = set_.law(i);
    const S temperature = at.temperature ? y[at.temperatures() + i] : law.temperature0;
    if (!equal_viscosities_) viscosities_[slot] = law.dynamic_viscosity(temperature);
    if (!needs_heat_record_) continue;
    S* const heat = &heat_[std::size_t(slot) * HeatRecord::size];
    heat[HeatRecord::temperature] = temperature;
    heat[HeatRecord::conductivity] = law.conductivity;
    heat[HeatRecord::fluid] = S(set_.fluid_of[i]);
    heat[HeatRecord::sound_speed] = law.sound_speed;
  }
}

template <class S> SlotData<S> Sph<S>::slot_data() const {
  return {records_.front().lane,
          equal_masses_ ? nullptr : masses_.data(),
          equal_viscosities_ ? nullptr : viscosities_.data(),
          needs_heat_record_ ? heat_.data() : nullptr,
          set_.mass.front(),
          set_.laws.front().viscosity};
}

// After update(): what the pairs do to each slot, then finish(first, last) of all blocks.
template <class S> template <class Finish> void Sph<S>::over_sums(const S* y, const Finish& finish) {
  const bool more = options_.corrected || transport_strength_ > S(0);  // sums that need those of all slots
  over_blocks([&](int first, int last) {
    sums_.add_forces(*lists_, set_.layout.dimensions, slot_data(), first, last, out_.data());
    if (walls_ != nullptr)
      walls_->add_forces(*lists_, slot_data().records, densities_.data(), y, first, last, out_.data());
    if (!more) finish(first, last);
  });
  if (!more) return;
  if (options_.corrected) set_corrections();
  if (transport_strength_ > S(0)) set_transport(y);
  over_blocks(finish);
}

template <class S> void Sph<S>::set_corrections() {
  const std::size_t slots = masses_.size();
  pressures_.resize(slots);
  over_blocks([&](int first, int last) {
    for (int slot = first * kLaneCount; slot < std::min(last * kLaneCount, lists_->count()); ++slot)
      pressures_[slot] = set_.law(lists_->order()[slot]).pressure(densities_[slot]);
  });
  const CorrectionData<S> data{*lists_,        sums_.kernel,      set_.layout.dimensions, slot_data().records,
                               masses_.data(), densities_.data(), pressures_.data()};
  over_blocks([&](int first, int last) {
    add_corrected_gradients(data, first * kLaneCount, std::min(last * kLaneCount, lists_->count()), out_.data());
  });
}

template <class S> void Sph<S>::set_transport(const S* y) {
  const Layout& at = set_.layout;
  const std::size_t slots = masses_.size();
  transport_.resize(slots * TransportRecord::size);
  if (at.temperature) temperatures_.resize(slots), carried_heat_.resize(slots);
  const TransportData<S> data{sums_, *lists_, at.dimensions, slot_data().records, masses_.data(), densities_.data()};
  over_blocks([&](int first, int last) {
    set_transport_velocities(data, transport_strength_, first, last, transport_.data());
    if (!at.temperature) return;
    for (int slot = first * kLaneCount; slot < last * kLaneCount; ++slot)
      temperatures_[slot] = y[at.temperatures() + lists_->order()[std::min(slot, lists_->count() - 1)]];
  });
  const S* const temperatures = at.temperature ? temperatures_.data() : nullptr;
  over_blocks([&](int first, int last) {
    add_transport_fluxes(data, transport_.data(), temperatures, first, last, out_.data(), carried_heat_.data());
  });
}

// ---- rates ----------------------------------------------------------------------------------------------------------
template <class S>
template <int d>
void Sph<S>::rate_of_particles(S t_s, const S* y, S* dydt, int first_slot, int last_slot) const {
  const Layout& at = set_.layout;
  const int last = std::min(last_slot, lists_->count());
  for (int slot = first_slot; slot < last; ++slot) {
    const int i = lists_->order()[slot];
    if (i >= at.particles) continue;
    const FluidLaw<S>& law = set_.law(i);
    const S* const sum = &out_[std::size_t(slot) * SumRecord::size];
    S weight = S(1);
    if (law.expansion != S(0) && at.temperature)
      weight = S(1) - law.expansion * (y[at.temperatures() + i] - law.temperature0);
    for (int c = 0; c < d; ++c) {
      const S carried = transport_strength_ > S(0) ? transport_[std::size_t(slot) * TransportRecord::size + c] : S(0);
      dydt[at.positions() + i * d + c] = y[at.velocities() + i * d + c] + carried;
      dydt[at.velocities() + i * d + c] = sum[SumRecord::acceleration + c] + weight * gravity_[c];
    }
    if (!sources_.empty())
      sources_[set_.fluid_of[i]].add(t_s, y + at.positions() + i * d, dydt + at.velocities() + i * d);
    if (at.density) dydt[at.densities() + i] = sum[SumRecord::density];
    if (!at.temperature) continue;
    S warming = law.heat_capacity > S(0) ? sum[SumRecord::heat] / law.heat_capacity : S(0);
    if (transport_strength_ > S(0)) warming += carried_heat_[slot];
    dydt[at.temperatures() + i] = warming;
  }
}

template <class S> void Sph<S>::rate_of(void* context, S t_s, const S* y, S* dydt) {
  Sph& self = *static_cast<Sph*>(context);
  const Layout& at = self.set_.layout;
  if (!self.update(t_s, y)) {
    std::fill(dydt, dydt + at.size(), S(std::numeric_limits<double>::quiet_NaN()));
    return;
  }
  self.over_sums(y, [&](int first, int last) {
    const int first_slot = first * kLaneCount, last_slot = last * kLaneCount;
    if (at.dimensions == 2) self.template rate_of_particles<2>(t_s, y, dydt, first_slot, last_slot);
    else self.template rate_of_particles<3>(t_s, y, dydt, first_slot, last_slot);
  });
  if (at.body_scalars == 0) return;
  if (self.walls_ != nullptr)
    self.walls_->load_bodies(*self.lists_, self.slot_data().records, self.densities_.data(), y);
  self.bodies_->system().rate_of(self.bodies_.get(), t_s, y + at.bodies(), dydt + at.bodies());
}

template <class S> void Sph<S>::project_of(void* context, S* y) {
  Sph& self = *static_cast<Sph*>(context);
  self.bodies_->normalise(y + self.set_.layout.bodies());
}

template <class S> std::string Sph<S>::not_separable() const {
  if (!options_.summation) return "alternates kicks and drifts; with it +sph requires density=summation";
  if (sums_.viscosity != Viscosity::none)
    return "alternates kicks and drifts; with it +sph requires viscosity=none, or fluids without viscosity";
  if (options_.shift != 0) return "alternates kicks and drifts; with it +sph requires shift=0";
  if (set_.layout.temperature) return "alternates kicks and drifts, which do not step temperatures";
  if (set_.layout.body_scalars > 0)
    return "alternates kicks and drifts, which +sph does not provide with bodies that move";
  return "";
}

template <class S> void Sph<S>::accelerations(S t_s, const S* y, S* acceleration) {
  const Layout& at = set_.layout;
  const int d = at.dimensions;
  ++system_.evaluations;
  if (!update(t_s, y)) {
    std::fill(acceleration, acceleration + std::ptrdiff_t(d) * at.particles,
              S(std::numeric_limits<double>::quiet_NaN()));
    return;
  }
  over_sums(y, [&](int first, int last) {
    for (int slot = first * kLaneCount; slot < std::min(last * kLaneCount, lists_->count()); ++slot) {
      const int i = lists_->order()[slot];
      if (i >= at.particles) continue;
      for (int c = 0; c < d; ++c)
        acceleration[std::ptrdiff_t(i) * d + c] = out_[std::size_t(slot) * SumRecord::size + c] + gravity_[c];
      if (!sources_.empty())
        sources_[set_.fluid_of[i]].add(t_s, y + at.positions() + std::ptrdiff_t(i) * d,
                                       acceleration + std::ptrdiff_t(i) * d);
    }
  });
}

// ---- samples --------------------------------------------------------------------------------------------------------
template <class S> std::vector<S> Sph<S>::densities(const S* y) {
  const Layout& at = set_.layout;
  std::vector<S> found(at.particles, S(std::numeric_limits<double>::quiet_NaN()));
  if (at.density) std::copy_n(y + at.densities(), at.particles, found.begin());
  else if (update(S(0), y))
    for (int i = 0; i < at.particles; ++i) found[i] = densities_[lists_->slot_of()[i]];
  return found;
}

template <class S> S Sph<S>::mean_neighbours(const S* y) {
  const Layout& at = set_.layout;
  if (!update(S(0), y)) return S(0);
  S pairs{};
  for (int slot = 0; slot < lists_->count(); ++slot) {
    if (lists_->order()[slot] >= at.particles) continue;
    const NeighbourBlock block = lists_->block(slot / kLaneCount);
    for (int n = 0; n < block.longest; ++n) {
      if (block.entries[n] == slot) continue;
      S r2{};
      for (int c = 0; c < at.dimensions; ++c) {
        S x = records_[slot].lane[c] - records_[block.entries[n]].lane[c];
        if (lists_->period(c) > S(0)) x = nearest_image(x, lists_->period(c));
        r2 += x * x;
      }
      if (r2 < sums_.kernel.support * sums_.kernel.support) pairs += S(1);
    }
  }
  return pairs / S(at.particles);
}

template <class S> void Sph<S>::write(S t_s, const S* y, Sample& sample) {
  const std::vector<S> density = densities(y);
  write_particles(set_, scene_, y, density.data(), sample);
  if (bodies_ != nullptr) bodies_->write(t_s, y + set_.layout.bodies(), sample);
}

template <class S> std::string Sph<S>::fault(const S* y) const {
  const Layout& at = set_.layout;
  for (int i = 0; i < at.particles; ++i) {
    bool finite = true;
    for (int c = 0; c < at.dimensions; ++c)
      finite = finite && real::is_finite(y[at.positions() + i * at.dimensions + c]) &&
               real::is_finite(y[at.velocities() + i * at.dimensions + c]);
    if (at.density) finite = finite && real::is_finite(y[at.densities() + i]);
    if (at.temperature) finite = finite && real::is_finite(y[at.temperatures() + i]);
    if (!finite) return particle_name(set_, scene_, i) + " is not finite";
    if (at.density && !(y[at.densities() + i] > S(0)))
      return particle_name(set_, scene_, i) + " has a density of " +
             format_double(static_cast<double>(y[at.densities() + i])) + " kg/m^3";
    if (std::string through = went_through(y, i); !through.empty()) return through;
  }
  return "";
}

template <class S> std::string Sph<S>::went_through(const S* y, int particle) const {
  if (walls_ == nullptr) return "";
  const int d = set_.layout.dimensions;
  const S* const x = y + set_.layout.positions() + std::ptrdiff_t(particle) * d;
  const std::string through = walls_->boundary_behind(x);
  if (through.empty()) return "";
  return particle_name(set_, scene_, particle) + " went through the boundary `" + through + "` at " +
         position_text(x, d);
}

template <class S> std::string Sph<S>::lost(S t_s, const S* y) {
  const Layout& at = set_.layout;
  if (walls_ != nullptr && walls_->some_may_be_behind(y + at.positions()))
    for (int i = 0; i < at.particles; ++i)
      if (std::string through = went_through(y, i); !through.empty()) return through;
  return overlaps_ == nullptr ? "" : overlaps_->found(t_s, y + at.bodies());
}

template class Sph<float>;
template class Sph<double>;
template class Sph<long double>;
template class Sph<Quad>;

}  // namespace atwood::fluid
