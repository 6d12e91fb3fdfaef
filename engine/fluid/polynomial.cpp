#include "fluid/polynomial.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "protocol/sample.hpp"
#include "scene/fluid_surface.hpp"

namespace atwood::fluid {
namespace {

constexpr int kMinShared = 500;  // particles

// Not known (PolynomialSurface says why): no.
bool has_free_surface(const Scene& scene) {
  if (scene.fluids.size() != 1 || !(scene.fluids.front().spacing_m > 0)) return false;
  try {
    return !surface_points(scene).empty();
  } catch (const std::invalid_argument&) {
    return false;
  }
}

// Why the equations of docs/fluids.md do not describe this scene; empty: they do.
std::string scene_fault(const Scene& scene, const PolynomialOptions& options) {
  const auto number = [](double x) { return format_double(x); };
  if (options.degree != 2 && options.degree != 4)
    return "+polynomial fits polynomials of degree 2 or 4, not " + std::to_string(options.degree);
  if (!(options.smoothing > 0)) return "+polynomial needs a smoothing above 0, not " + number(options.smoothing);
  const Fluid& fluid = scene.fluids.front();
  const std::string whose = " of the fluid `" + fluid.name + "`";
  if (scene.fluids.size() > 1)
    return "+polynomial differentiates across particles of one fluid; this scene has several";
  if (!(fluid.sound_speed_m_per_s > 0)) return "the sound speed" + whose + " is 0; +polynomial needs one above 0";
  if (!(fluid.density_kg_per_m3 > 0) || !(fluid.spacing_m > 0))
    return "the density and the spacing" + whose + " must be above 0";
  if (fluid.particles.mass_kg.empty()) return "the fluid `" + fluid.name + "` has no particles";
  const bool open = has_free_surface(scene);
  if (open && options.degree != 2)
    return "+polynomial has free surfaces with degree=2 only; the fluid `" + fluid.name + "` has one";
  const double widening = scene.fluid_boundaries.empty() && !open ? 1 : 1 + kWidening;
  const double support = widening * support_ratio(options.kernel) * options.smoothing * fluid.spacing_m;
  if (std::string why = period_fault(scene, support, "the support of the fits"); !why.empty()) return why;
  return "";
}

// U of docs/fluids.md [m/s].
double shift_speed(const Scene& scene, const PolynomialOptions& options) {
  if (options.shift_speed_m_per_s > 0) return options.shift_speed_m_per_s;
  double most2 = 0, sound = 0;
  for (const Fluid& fluid : scene.fluids) {
    sound = std::max(sound, fluid.sound_speed_m_per_s);
    for (const auto& v : fluid.particles.velocity_m_per_s)
      most2 = std::max(most2, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  }
  return most2 > 0 ? std::sqrt(most2) : sound / 20;
}

// Between walls that shear the fluid the filter of a periodic domain leaves modes of degree 4 that grow.
constexpr double kFilterBetweenWalls = 0.3;

PolynomialOptions resolved_for(const Scene& scene, PolynomialOptions options) {
  const bool open = has_free_surface(scene);
  if (options.filter < 0 && options.degree == 4 && !open && !scene.fluid_boundaries.empty())
    options.filter = kFilterBetweenWalls;
  return resolved(options, open);
}

template <class S> S nan() { return S(std::numeric_limits<double>::quiet_NaN()); }

}  // namespace

PolynomialOptions resolved(PolynomialOptions options, bool free_surface) {
  if (options.smoothing == 0) options.smoothing = free_surface ? 1.75 : options.degree == 2 ? 1.5 : 1.55;
  if (options.filter < 0) options.filter = free_surface ? 1 : options.degree == 2 ? 0.005 : 0.1;
  if (options.shift < 0) options.shift = free_surface ? 0 : 1;
  return options;
}

template <class S>
Polynomial<S>::Polynomial(const Scene& scene, const PolynomialOptions& options)
    : scene_(scene), options_(resolved_for(scene, options)), unsupported_(scene_fault(scene, options_)) {
  if (std::is_same_v<S, float> && unsupported_.empty())
    unsupported_ =
        float_fault(scene, support_ratio(options_.kernel) * options_.smoothing * scene.fluids.front().spacing_m);
  if (!unsupported_.empty()) return;
  if (!scene.bodies.empty()) {
    bodies_ = std::make_unique<RigidModel<S>>(scene);
    unsupported_ = bodies_->unsupported();
    if (!unsupported_.empty()) return;
  }
  set_ = make_particle_set<S>(scene, true, 0);
  source_ = BodyAcceleration<S>(scene.fluids.front());
  team_ = std::make_unique<Team>(std::max(1, options_.threads));
  const int d = set_.layout.dimensions;
  const S spacing = S(scene.fluids.front().spacing_m);
  support_ = S(support_ratio(options_.kernel)) * S(options_.smoothing) * spacing;
  fits_.shape = options_.kernel;
  fits_.dimensions = d;
  fits_.degree = options_.degree;
  fits_.fields = set_.layout.temperature ? d + 2 : d + 1;
  fits_.spacing = spacing;
  fits_.lane_by_lane = options_.lane_by_lane;
  for (const FluidLaw<S>& law : set_.laws) filter_rate_.push_back(S(options_.filter) * law.sound_speed / spacing);
  // u = 3 A U R_s sum D^d (-F) x_ij with -F = 20 b (1 - s)^3, x_ij = -(x_j - x_i).
  S volume = S(1);
  for (int c = 0; c < d; ++c) volume = volume * spacing;
  const Kernel<S> near = make_kernel<S>(KernelShape::wendland_c2, d, spacing);
  shift_factor_ =
      S(-60) * S(options_.shift) * S(shift_speed(scene, options_)) * near.support * volume * near.slope_factor;
  for (int c = 0; c < d; ++c) gravity_[c] = S(scene.gravity_m_per_s2[c]);
  S support = std::max(support_, near.support);
  if (!scene.fluid_boundaries.empty()) {
    walls_ = std::make_unique<PolynomialWalls<S>>(scene, set_, options_.kernel, options_.degree, support_);
    unsupported_ = walls_->unsupported();
    support = std::max(support, walls_->widest_support());
  }
  surface_ = std::make_unique<PolynomialSurface<S>>(scene, set_, options_.kernel, support_);
  if (!surface_->unsupported().empty()) unsupported_ = surface_->unsupported();
  if (surface_->count() == 0) surface_.reset();
  if (surface_ != nullptr) {
    support = std::max(support, surface_->support());
    set_.layout.surface_nodes = surface_->count();
  }
  lists_ = std::make_unique<Neighbours<S>>(scene.domain, support, S(options_.skin) * support);
  system_.size = set_.layout.size();
  system_.context = this;
  system_.rate_of = rate_of;
}

template <class S> bool Polynomial<S>::update(const S* y) {
  const Layout& at = set_.layout;
  const S* x = y + at.positions();
  int count = at.particles;
  if (walls_ != nullptr || surface_ != nullptr) {
    points_.assign(x, x + std::ptrdiff_t(at.particles) * at.dimensions);
    if (walls_ != nullptr) points_.insert(points_.end(), walls_->positions().begin(), walls_->positions().end());
    points_.insert(points_.end(), y + at.nodes(), y + at.size());
    count = static_cast<int>(points_.size()) / at.dimensions;
    x = points_.data();
  }
  return lists_->update(x, count, team_.get());
}

// ---- records --------------------------------------------------------------------------------------------------------
template <class S> void Polynomial<S>::pack(const S* y, int first_block, int last_block) {
  const Layout& at = set_.layout;
  const int d = at.dimensions, count = lists_->count();
  for (int slot = first_block * kLaneCount; slot < last_block * kLaneCount; ++slot) {
    const int i = lists_->order()[std::min(slot, count - 1)];
    S* const record = &records_[std::size_t(slot) * kFitRecord];
    supports_[slot] = support_;
    if (!points_.empty()) {
      const S* const x = &points_[std::size_t(i) * d];
      if (walls_ != nullptr) supports_[slot] = walls_->support_at(x);
      weights_[slot] = {S(1), S(1), S(0)};
      if (i >= at.particles) {
        for (int c = 0; c < d; ++c) record[c] = lists_->wrapped(x[c], c);
        continue;
      }
    }
    for (int c = 0; c < d; ++c) {
      record[c] = lists_->wrapped(y[at.positions() + std::ptrdiff_t(i) * d + c], c);
      record[d + c] = y[at.velocities() + std::ptrdiff_t(i) * d + c];
    }
    record[2 * d] = y[at.densities() + i];
    if (at.temperature) record[2 * d + 1] = y[at.temperatures() + i];
  }
}

// ---- rates ----------------------------------------------------------------------------------------------------------
template <class S> bool Polynomial<S>::holds_a_particle(int block) const {
  const int first = block * kLaneCount, last = std::min(first + kLaneCount, lists_->count());
  return std::any_of(lists_->order().begin() + first, lists_->order().begin() + last,
                     [&](int point) { return point < set_.layout.particles; });
}

template <class S>
void Polynomial<S>::rate_of_particles(S t_s, const S* y, S* dydt, int first_slot, int last_slot, int& singular) const {
  const Layout& at = set_.layout;
  const std::ptrdiff_t d = at.dimensions;
  const int density = static_cast<int>(d), temperature = density + 1, last = std::min(last_slot, lists_->count());
  const S least = S(least_pivot(options_.degree));
  for (int slot = first_slot; slot < last; ++slot) {
    const int i = lists_->order()[slot];
    if (i >= at.particles) continue;
    const Fit<S>& fit = fits_of_[slot];
    if (!(fit.least_pivot >= least)) singular = slot;
    const FluidLaw<S>& law = set_.law(i);
    const S filter = filter_rate_[set_.fluid_of[i]];
    const S rho = y[at.densities() + i];
    const S T = at.temperature ? y[at.temperatures() + i] : law.temperature0;
    const S mu = at.temperature ? law.dynamic_viscosity(T) : law.viscosity;
    const S* const v = y + at.velocities() + i * d;

    S u[3]{}, divergence{}, gradient2{};
    for (int c = 0; c < d; ++c) {
      u[c] = shift_factor_ * fit.depth_factor * fit.shift_sum[c];
      divergence += fit.gradient[c][c];
    }
    const auto along_u = [&](int f) {  // (u . grad) f
      S sum{};
      for (int c = 0; c < d; ++c) sum += u[c] * fit.gradient[f][c];
      return sum;
    };
    const S push = law.pressure_slope(rho) / rho;
    const S weight = at.temperature ? S(1) - law.expansion * (T - law.temperature0) : S(1);
    for (int a = 0; a < d; ++a) {
      S diffused = fit.laplacian[a];
      for (int c = 0; c < d; ++c) {
        gradient2 += fit.gradient[a][c] * fit.gradient[a][c];
        if (at.temperature) diffused -= law.viscosity_decay * fit.gradient[temperature][c] * fit.gradient[a][c];
      }
      dydt[at.positions() + i * d + a] = v[a] + u[a];
      dydt[at.velocities() + i * d + a] = -push * fit.gradient[density][a] + mu / rho * diffused + along_u(a) +
                                          filter * fit.change[a] + weight * gravity_[a];
    }
    if (source_.acts()) source_.add(t_s, y + at.positions() + i * d, dydt + at.velocities() + i * d);
    dydt[at.densities() + i] = -rho * divergence + along_u(density) + filter * fit.change[density];
    if (at.temperature) {
      S& rate = dydt[at.temperatures() + i];
      rate = along_u(temperature) + filter * fit.change[temperature];
      if (law.heat_capacity > S(0)) {
        const S heat = law.conductivity * fit.laplacian[temperature] + (law.viscous_heat ? mu * gradient2 : S(0));
        rate += heat / (rho * law.heat_capacity);
      }
    }
  }
}

template <class S> void Polynomial<S>::rate_of(void* context, S t_s, const S* y, S* dydt) {
  Polynomial& self = *static_cast<Polynomial*>(context);
  const Layout& at = self.set_.layout;
  if (!self.update(y)) {
    std::fill(dydt, dydt + at.size(), nan<S>());
    return;  // the reason of an earlier rate of the step stays
  }
  self.faulty_ = -1;
  const int blocks = self.lists_->blocks(), slots = blocks * kLaneCount;
  self.records_.resize(std::size_t(slots) * kFitRecord);
  self.supports_.resize(slots);
  const bool all_count = self.walls_ == nullptr && self.surface_ == nullptr;
  if (!all_count) self.weights_.resize(slots);
  self.fits_of_.resize(slots);
  const int threads = self.team_->size();
  const int parts = threads == 1 || at.particles < kMinShared ? 1 : std::min(blocks, 4 * threads);
  self.scratch_.resize(std::max<std::size_t>(self.scratch_.size(), parts));
  self.singular_.assign(parts, -1);
  const auto blocks_of = [&](int part) { return share(blocks, part, parts); };
  self.team_->run(parts, [&](int part) {
    const Share own = blocks_of(part);
    self.pack(y, own.first, own.last);
  });
  if (self.walls_ != nullptr) self.walls_->fill(*self.lists_, self.records_.data(), self.weights_.data());
  if (self.surface_ != nullptr) {
    const int first = self.lists_->count() - self.surface_->count();
    if (!self.surface_->fill(*self.lists_, first, self.records_.data(), self.weights_.data(), dydt + at.nodes())) {
      std::fill(dydt, dydt + at.size(), nan<S>());
      return;
    }
  }
  const SlotWeight<S>* const weights = all_count ? nullptr : self.weights_.data();
  self.team_->run(parts, [&](int part) {
    const Share own = blocks_of(part);
    for (int b = own.first; b < own.last; ++b)
      if (all_count || self.holds_a_particle(b))
        self.fits_.fit(*self.lists_, self.records_.data(), self.supports_.data(), weights, b, b + 1,
                       self.scratch_[part], self.fits_of_.data());
    self.rate_of_particles(t_s, y, dydt, own.first * kLaneCount, own.last * kLaneCount, self.singular_[part]);
  });
  for (const int slot : self.singular_) {
    if (slot < 0) continue;
    if (self.faulty_ < 0) {
      self.faulty_ = self.lists_->order()[slot];
      self.faulty_pivot_ = self.fits_of_[slot].least_pivot;
    }
    std::fill(dydt, dydt + at.size(), nan<S>());
    return;
  }
}

template <class S> void Polynomial<S>::initial_state(S* y) const {
  initial_particles(set_, scene_, y);
  if (surface_ != nullptr) std::copy(surface_->start().begin(), surface_->start().end(), y + set_.layout.nodes());
}

// ---- samples --------------------------------------------------------------------------------------------------------
template <class S> void Polynomial<S>::write(S t_s, const S* y, Sample& sample) {
  write_particles(set_, scene_, y, y + set_.layout.densities(), sample);
  if (bodies_ != nullptr) bodies_->write(t_s, y + set_.layout.bodies(), sample);
}

template <class S> std::string Polynomial<S>::fault(const S* y) const {
  const Layout& at = set_.layout;
  if (faulty_ >= 0) {
    const double pivot = static_cast<double>(faulty_pivot_);
    return "the neighbourhood of " + particle_name(set_, scene_, faulty_) +
           " does not determine a polynomial of degree " + std::to_string(options_.degree) +
           ": the condition of its fit is " + (pivot > 0 ? "about " + format_double(1 / pivot) : "beyond round-off") +
           ", at most " + format_double(1 / least_pivot(options_.degree)) + " is accepted";
  }
  if (surface_ != nullptr)
    if (std::string why = surface_->fault(y + at.nodes()); !why.empty()) return why;
  for (int i = 0; i < at.particles; ++i) {
    bool finite = real::is_finite(y[at.densities() + i]);
    for (int c = 0; c < at.dimensions; ++c)
      finite = finite && real::is_finite(y[at.positions() + i * at.dimensions + c]) &&
               real::is_finite(y[at.velocities() + i * at.dimensions + c]);
    if (at.temperature) finite = finite && real::is_finite(y[at.temperatures() + i]);
    if (!finite) return particle_name(set_, scene_, i) + " is not finite";
    if (!(y[at.densities() + i] > S(0)))
      return particle_name(set_, scene_, i) + " has a density of " +
             format_double(static_cast<double>(y[at.densities() + i])) + " kg/m^3";
    if (std::string through = went_through(y, i); !through.empty()) return through;
  }
  return "";
}

template <class S> std::string Polynomial<S>::went_through(const S* y, int particle) const {
  if (walls_ == nullptr) return "";
  const int d = set_.layout.dimensions;
  const S* const x = y + set_.layout.positions() + std::ptrdiff_t(particle) * d;
  const std::string* const through = walls_->boundary_behind(x);
  if (through == nullptr) return "";
  return particle_name(set_, scene_, particle) + " went through the boundary `" + *through + "` at " +
         position_text(x, d);
}

template <class S> std::string Polynomial<S>::lost(S, const S* y) {
  if (walls_ == nullptr) return "";
  const Layout& at = set_.layout;
  for (int i = 0; i < at.particles; ++i)
    if (walls_->boundary_behind(y + at.positions() + std::ptrdiff_t(i) * at.dimensions) != nullptr)
      return went_through(y, i);
  return "";
}

template <class S> S Polynomial<S>::mean_neighbours(const S* y) {
  const Layout& at = set_.layout;
  if (!update(y)) return S(0);
  const std::ptrdiff_t d = at.dimensions;
  S pairs{};
  for (int slot = 0; slot < lists_->count(); ++slot) {
    if (lists_->order()[slot] >= at.particles) continue;
    const NeighbourBlock block = lists_->block(slot / kLaneCount);
    const int lane = slot % kLaneCount;
    for (int n = 0; n < block.counts[lane]; ++n) {
      const int other = block.entries[n * kLaneCount + lane];
      if (lists_->order()[other] >= at.particles) continue;
      S r2{};
      for (int c = 0; c < d; ++c) {
        S x = lists_->wrapped(y[at.positions() + lists_->order()[slot] * d + c], c) -
              lists_->wrapped(y[at.positions() + lists_->order()[other] * d + c], c);
        if (lists_->period(c) > S(0)) x = nearest_image(x, lists_->period(c));
        r2 += x * x;
      }
      if (r2 < support_ * support_) pairs += S(1);
    }
  }
  return pairs / S(at.particles);
}

template class Polynomial<float>;
template class Polynomial<double>;
template class Polynomial<long double>;
template class Polynomial<Quad>;

}  // namespace atwood::fluid
