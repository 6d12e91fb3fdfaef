#include "fluid/run.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>
#include "math/elementary.hpp"

#include "fluid/kick_drift.hpp"
#include "fluid/options.hpp"
#include "fluid/particle_set.hpp"
#include "fluid/spectrum.hpp"
#include "fluid/stability.hpp"
#include "integrators/adaptive.hpp"
#include "integrators/catalogue.hpp"
#include "integrators/runge_kutta.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"
#include "smooth/run.hpp"

namespace atwood::fluid {
namespace {

constexpr const char* kNotFinite = "is not finite";  // the end of what ParticleSystem::fault() says of such a particle

// ---- marching -------------------------------------------------------------------------------------------------------
template <class S> struct March {
  ParticleSystem<S>& particles;
  Stepper<S>& stepper;
  const Plan& plan;
  const Observer* observer;  // null: the timed pass
  Outcome& outcome;
  std::vector<S> y, y_new, inside;
  Sample sample;

  using Clock = std::conditional_t<std::is_same_v<S, float>, double, S>;
  S begin_of(std::int64_t n) const { return S(step_begin_s<Clock>(plan, n)); }
  S time_of_sample(std::int64_t k) const { return S(Clock(plan.t_end_s) * Clock(k) / Clock(plan.samples)); }

  bool fail(Status status, const std::string& what, S t_s) {
    outcome.status = status;
    outcome.reason = what + " at t = " + format_double(static_cast<double>(t_s)) + " s";
    return false;
  }
  // "; it was at [0.5, 0.25] m a step before": the first particle that is not finite.
  std::string place_before(const S* state) const {
    const Layout& at = particles.layout();
    const int d = at.dimensions;
    const auto sound = [&](int from, int count) {
      return std::all_of(state + from, state + from + count, [](const S& x) { return real::is_finite(x); });
    };
    for (int i = 0; i < at.particles; ++i) {
      if (sound(at.positions() + i * d, d) && sound(at.velocities() + i * d, d) &&
          (!at.density || sound(at.densities() + i, 1)) && (!at.temperature || sound(at.temperatures() + i, 1)))
        continue;
      return "; it was at " + position_text(&y[std::size_t(at.positions() + i * d)], d) + " a step before";
    }
    return "";
  }
  // After every step: is the state finite? Sums of all numbers are not, if one is not. Several sums, so that an
  // addition need not wait for the one before.
  bool finite(const S* state, S t_s) {
    constexpr int parts = 8;
    S sums[parts]{}, sum{};
    const int size = particles.layout().size(), whole = size - size % parts;
    for (int i = 0; i < whole; i += parts)
      for (int k = 0; k < parts; ++k) sums[k] += real::abs(state[i + k]);
    for (int i = whole; i < size; ++i) sum += real::abs(state[i]);
    for (const S part : sums) sum += part;
    if (real::is_finite(sum)) return true;
    const std::string fault = particles.fault(state);
    fail(Status::not_finite, fault, t_s);
    if (fault.ends_with(kNotFinite)) outcome.reason += place_before(state);
    return false;
  }
  // After every step: no particle went through a wall, no bodies overlap.
  bool kept(const S* state, S t_s) {
    const std::string lost = particles.lost(t_s, state);
    return lost.empty() || fail(Status::diverged, lost, t_s);
  }
  bool observe(std::int64_t k, const S* state) {
    const S t_s = time_of_sample(k);
    if (const std::string fault = particles.fault(state); !fault.empty()) return fail(Status::diverged, fault, t_s);
    if (observer == nullptr || !observer->sample) return true;
    sample.t_s = Clock(plan.t_end_s) * Clock(k) / Clock(plan.samples);
    particles.write(t_s, state, sample);
    observer->sample(sample);
    return true;
  }
  bool unsolved(S t_s) {
    outcome.status = Status::diverged;
    outcome.reason = unsolved_step(particles.system().solvers, static_cast<double>(t_s));
    return false;
  }

  void restart() {
    outcome = {};
    System<S>& system = particles.system();
    system.evaluations = 0;
    system.solvers = {};
    ++system.epoch;
    y.resize(particles.layout().size());
    y_new = inside = y;
    particles.initial_state(y.data());
  }

  void equal_steps() {
    restart();
    if (!observe(0, y.data())) return;
    const std::int64_t stride = plan.steps / plan.samples;
    const bool equal = plan.frame_ends_s.empty();
    for (std::int64_t n = 0; n < plan.steps; ++n) {
      const S t_s = begin_of(n), h_s = equal ? begin_of(1) : begin_of(n + 1) - t_s;
      if (!stepper.step(t_s, h_s, y.data(), y_new.data())) return void(unsolved(t_s));
      if (!finite(y_new.data(), t_s + h_s) || !kept(y_new.data(), t_s + h_s)) return;
      y.swap(y_new);
      ++outcome.steps_taken;
      if ((n + 1) % stride == 0 && !observe((n + 1) / stride, y.data())) return;
    }
  }

  // The samples that lie inside the step just taken, by its interpolant or by a shorter step.
  bool samples_inside(std::int64_t& k, S t_s, S h_s, S end_s) {
    for (; k < plan.samples && !(time_of_sample(k) > end_s); ++k) {
      const S part_s = time_of_sample(k) - t_s;
      if (stepper.dense_is_accurate()) stepper.dense(part_s / h_s, inside.data());
      else if (!stepper.step(t_s, part_s, y.data(), inside.data())) return unsolved(t_s);
      if (!observe(k, inside.data())) return false;
    }
    return true;
  }

  void by_tolerance(S rtol, S atol, const StepLimits& limits) {
    restart();
    stepper.set_tolerance(rtol, atol);
    StepControl<S> control(stepper.estimate_order(), limits);
    if (!observe(0, y.data())) return;
    const S end_s = S(plan.t_end_s);
    S t_s{}, h_s = begin_of(1);
    std::int64_t k = 1;
    bool solved = true;
    while (t_s < end_s) {
      const bool last = t_s + h_s * S(1.0000001) >= end_s;
      const S step_s = last ? end_s - t_s : h_s;
      if (!(step_s > S(4) * real::epsilon<S>() * t_s)) {
        if (!solved) return void(unsolved(t_s));
        if (!finite(y_new.data(), t_s)) return;
        return void(fail(Status::diverged, "the step size fell below round-off", t_s));
      }
      solved = stepper.step(t_s, step_s, y.data(), y_new.data());
      if (!solved) {
        h_s = step_s / S(4);
        continue;
      }
      typename Stepper<S>::Advice advice{};
      if (stepper.chooses_steps()) advice = stepper.advise(rtol, atol);
      else {
        advice.next_s = control.next_step(step_s, stepper.error_norm(rtol, atol));
        advice.accepted = control.accepted();
      }
      h_s = advice.accepted && last ? real::max(h_s, advice.next_s) : advice.next_s;
      if (!advice.accepted) continue;
      const S reached_s = last ? end_s : t_s + step_s;
      if (!finite(y_new.data(), reached_s)) return;
      if (!kept(y_new.data(), reached_s)) return;
      if (observer != nullptr && !samples_inside(k, t_s, step_s, reached_s)) return;
      y.swap(y_new);
      t_s = reached_s;
      ++outcome.steps_taken;
    }
    observe(plan.samples, y.data());
  }
};

// ---- +sph -----------------------------------------------------------------------------------------------------------
ModeRates mode_rates(const Scene& scene, const SphOptions& options, const Kernel<double>& kernel) {
  ModeRates rates;
  for (const Fluid& fluid : scene.fluids) {
    const FluidLaw<double> law = make_law<double>(fluid);
    double speed = law.sound_speed;
    if (law.tait)
      for (const double density : fluid.particles.density_kg_per_m3)
        speed = std::max(speed, law.sound_speed * real::power(density / law.density0, (law.gamma - 1) / 2));
    rates.sound_speed_m_per_s = std::max(rates.sound_speed_m_per_s, speed);
    const double nu = fluid.viscosity_m2_per_s;
    if (options.viscosity == Viscosity::morris) {
      rates.longitudinal_m2_per_s = std::max(rates.longitudinal_m2_per_s, nu);
      rates.transverse_m2_per_s = std::max(rates.transverse_m2_per_s, nu);
    } else if (options.viscosity == Viscosity::central) {  // mu (lap v + 2 grad div v)
      rates.longitudinal_m2_per_s = std::max(rates.longitudinal_m2_per_s, 3 * nu);
      rates.transverse_m2_per_s = std::max(rates.transverse_m2_per_s, nu);
    }
    if (law.heat_capacity > 0)
      rates.thermal_m2_per_s = std::max(rates.thermal_m2_per_s, law.conductivity / (law.density0 * law.heat_capacity));
    if (!options.summation)
      rates.density_m2_per_s = std::max(rates.density_m2_per_s, options.density_diffusion * law.sound_speed *
                                                                    kernel.support / support_ratio(kernel.shape));
  }
  for (const double g : scene.gravity_m_per_s2) rates.gravity_m_per_s2 += g * g;
  rates.gravity_m_per_s2 = std::sqrt(rates.gravity_m_per_s2);
  return rates;
}

EqualSteps equal_steps_of(const Plan& plan) {
  return {plan.t_end_s / static_cast<double>(plan.steps), plan.steps, plan.samples};
}

Lattice lattice_of(const Scene& scene) {
  const Fluid& fluid = scene.fluids.front();
  return {std::exp2(std::floor(std::log2(fluid.spacing_m)) - 40),
          std::exp2(std::floor(std::log2(fluid.sound_speed_m_per_s)) - 44)};
}

// The start on the lattice.
Scene on_lattice(Scene scene, const Lattice& lattice) {
  for (Fluid& fluid : scene.fluids)
    for (std::size_t i = 0; i < fluid.particles.mass_kg.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        double &x = fluid.particles.position_m[i][c], &v = fluid.particles.velocity_m_per_s[i][c];
        x = fluid::on_lattice(x, lattice.position_m);
        v = fluid::on_lattice(v, lattice.velocity_m_per_s);
      }
  return scene;
}

template <class S>
Outcome run_sph(const MethodId& id, const Scene& asked, const Plan& plan, const Observer& observer, int repeats) {
  const Result<SphRequest> request = sph_request(id);
  if (!request) return refused(request.fault());
  const MethodId own = integrator_part(id);
  Lattice lattice;
  if (request->reversible) {
    if (!is_kick_drift(own.scheme))
      return refused("reversible=true requires a kick-drift method, such as atwood/leapfrog");
    if (!std::is_same_v<S, double>) return refused("reversible=true computes in double");
    lattice = lattice_of(asked);
  }
  const Scene moved = request->reversible ? on_lattice(asked, lattice) : Scene{};
  const Scene& scene = request->reversible ? moved : asked;
  Sph<S> particles(scene, request->options);
  if (!particles.unsupported().empty()) return refused(particles.unsupported());
  const bool compensated = own.overrides.count("compensated") > 0 && std::get<bool>(own.overrides.at("compensated"));
  auto stepper = is_kick_drift(own.scheme) ? make_kick_drift<S>(own.scheme, particles, lattice, compensated)
                                           : make_stepper<S>(own.scheme, particles.system(), own.overrides);
  if (!stepper) return refused(stepper.fault());
  if (auto* sums = dynamic_cast<ExplicitRungeKutta<S>*>(stepper->get())) sums->share_sums(particles.team());
  if (!own.rtol) {
    const double spacing = scene.fluids.front().spacing_m;
    const auto kernel =
        make_kernel<double>(request->options.kernel, scene.domain.dimensions, request->options.smoothing * spacing);
    const std::string why = instability_message(own.scheme, own.overrides, kernel, spacing,
                                                mode_rates(scene, particles.options(), kernel), equal_steps_of(plan));
    if (!why.empty()) return refused(why);
  }
  return march(particles, **stepper, own, plan, observer, repeats);
}

// ---- +polynomial ----------------------------------------------------------------------------------------------------
constexpr int kSpectrumDimension = 40;
constexpr double kRoughSpectrum = 0.05;  // a residual above it is printed beside the bound

// Why equal steps would be unstable at the start of the run; empty: they are not.
std::string unstable_at_start(const MethodId& id, const Scene& scene, const PolynomialOptions& options,
                              const Plan& plan) {
  Polynomial<double> particles(scene, options);
  const Layout& layout = particles.layout();
  std::vector<double> y(layout.size()), scale(layout.size(), 1.0);
  particles.initial_state(y.data());
  const Fluid& fluid = scene.fluids.front();
  for (int i = 0; i < layout.velocities(); ++i) scale[i] = fluid.spacing_m;
  for (int i = layout.velocities(); i < layout.densities(); ++i) scale[i] = fluid.sound_speed_m_per_s;
  for (int i = layout.densities(); i < layout.temperatures(); ++i) scale[i] = fluid.density_kg_per_m3;
  for (int i = layout.nodes(); i < layout.size(); ++i) scale[i] = fluid.spacing_m;
  const Spectrum modes = extremal_eigenvalues(particles.system(), 0, y.data(), scale, kSpectrumDimension);
  if (modes.eigenvalues.empty())
    return "the rates at the start, or the eigenvalues of their derivative, are not finite: no step is known to be stable";
  const std::string why = instability_message(id.scheme, id.overrides, modes.eigenvalues, equal_steps_of(plan));
  const bool rough = modes.residual > kRoughSpectrum;
  return why.empty() || !rough ? why
                               : why + "; estimated to " + format_double(std::round(100 * modes.residual)) + " % of it";
}

template <class S>
Outcome run_polynomial(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer,
                       int repeats) {
  const Result<PolynomialOptions> options = polynomial_request(id);
  if (!options) return refused(options.fault());
  const MethodId own = integrator_part(id);
  Polynomial<S> particles(scene, *options);
  if (!particles.unsupported().empty()) return refused(particles.unsupported());
  if (is_kick_drift(own.scheme))
    return refused("atwood/" + own.scheme + " alternates kicks and drifts, which +polynomial does not provide");
  auto stepper = make_stepper<S>(own.scheme, particles.system(), own.overrides);
  if (!stepper) return refused(stepper.fault());
  if (!own.rtol)
    if (const std::string why = unstable_at_start(own, scene, *options, plan); !why.empty()) return refused(why);
  return march(particles, **stepper, own, plan, observer, repeats);
}

template <class S>
Outcome run_response(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  return id.response == "sph" ? run_sph<S>(id, scene, plan, observer, repeats)
                              : run_polynomial<S>(id, scene, plan, observer, repeats);
}

}  // namespace

template <class S>
Outcome march(ParticleSystem<S>& particles, Stepper<S>& stepper, const MethodId& id, const Plan& plan,
              const Observer& observer, int repeats) {
  Outcome outcome;
  March<S> run{particles, stepper, plan, repeats > 0 ? nullptr : &observer, outcome, {}, {}, {}, {}};
  if (id.rtol)
    if (const auto fault = tolerance_fault(id, stepper)) return refused(*fault);
  const double rtol = id.rtol.value_or(0);
  const StepLimits limits = step_limits(id);
  Outcome made = timed_passes(repeats, whole_pass([&] {
                                if (id.rtol) run.by_tolerance(S(rtol), S(id.atol.value_or(rtol / 100)), limits);
                                else run.equal_steps();
                                return outcome;
                              }));
  made.rate_evaluations = particles.system().evaluations;
  particles.system().solvers.keep_capped();
  made.solvers = named_tallies(particles.system().solvers);
  return made;
}

Outcome run_fluid(const MethodId& id, const Scene& scene, const Plan& plan, const Observer& observer, int repeats) {
  if (find_response(id.response) == nullptr)
    return refused("a scene with fluids needs +sph or +polynomial behind the method's scheme");
  const MethodId own = integrator_part(id);
  if (const auto fault = plan_fault(own, plan)) return refused(*fault);
  if (id.scalar.empty() || id.scalar == "double") return run_response<double>(id, scene, plan, observer, repeats);
  if (id.scalar == "float") return run_response<float>(id, scene, plan, observer, repeats);
  if (id.scalar == "long-double") return run_response<long double>(id, scene, plan, observer, repeats);
  if (id.scalar == "quad") return run_response<Quad>(id, scene, plan, observer, repeats);
  return refused("atwood does not compute in `" + id.scalar + "`; use float, double, long-double or quad");
}

template Outcome march<float>(ParticleSystem<float>&, Stepper<float>&, const MethodId&, const Plan&, const Observer&,
                              int);
template Outcome march<double>(ParticleSystem<double>&, Stepper<double>&, const MethodId&, const Plan&, const Observer&,
                               int);
template Outcome march<long double>(ParticleSystem<long double>&, Stepper<long double>&, const MethodId&, const Plan&,
                                    const Observer&, int);
template Outcome march<Quad>(ParticleSystem<Quad>&, Stepper<Quad>&, const MethodId&, const Plan&, const Observer&, int);

}  // namespace atwood::fluid
