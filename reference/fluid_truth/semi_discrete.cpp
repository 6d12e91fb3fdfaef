#include "fluid_truth/semi_discrete.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cvode/solver.hpp"
#include "dynamics/state.hpp"
#include "extended/extrapolation.hpp"
#include "fluid_truth/particles.hpp"
#include "fluid_truth/solution.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

using namespace fluid_truth;

namespace {

constexpr int kMaxExtended = 256, kMaxCvode = 2500;
constexpr double kQuadSeconds = 30;
constexpr double kSafety = 2;

template <class S> using States = std::vector<std::vector<S>>;  // at t_end k / samples

struct Request {
  const Scenario& scenario;
  std::int64_t samples;
  const std::string& response = scenario.truth.response;
  const Scene& scene = scenario.scene;

  template <class S> S time(std::int64_t k) const { return S(scenario.t_end_s) * S(k) / S(samples); }
};

// The scales of a state's components: positions, velocities, densities, temperatures.
std::vector<int> groups_of(const ParticleLayout& layout) {
  std::vector<int> group(static_cast<std::size_t>(layout.size), 0);
  int next = 1;
  for (const int from : {layout.velocity, layout.density, layout.temperature}) {
    if (from < 0) continue;
    std::fill(group.begin() + from, group.end(), next);
    ++next;
  }
  return group;
}

[[noreturn]] void fail(double t) {
  throw std::invalid_argument("the integration failed after t = " + format_double(t) +
                              " s: the rate is not finite there, or the fit of a neighbourhood is singular");
}

template <class S> States<S> by_extrapolation(const Request& request, double tolerance) {
  const auto system = fluid_system<S>(request.scene, request.response);
  const ParticleLayout& layout = system->data.layout;
  extended::Extrapolation<S> stepper(
      layout.size, groups_of(layout), [&](S t, const S* y, S* dydt) { system->rate(t, y, dydt); }, S(tolerance));
  States<S> made{initial_state<S>(request.scene, layout)};
  for (std::int64_t k = 1; k <= request.samples; ++k) {
    std::vector<S> y = made.back();
    const S from = request.time<S>(k - 1);
    if (!extended::advance(stepper, from, y.data(), request.time<S>(k) - from)) fail(static_cast<double>(from));
    made.push_back(std::move(y));
  }
  return made;
}

States<double> by_cvode(const Request& request, cvode::Family family, double rtol) {
  const auto system = fluid_system<double>(request.scene, request.response);
  const ParticleLayout& layout = system->data.layout;
  States<double> made{initial_state<double>(request.scene, layout)};
  const std::vector<int> group = groups_of(layout);
  std::vector<double> largest(5, 0.0), atol;
  for (int i = 0; i < layout.size; ++i) largest[group[i]] = std::fmax(largest[group[i]], std::fabs(made[0][i]));
  for (const int g : group) atol.push_back(rtol * (largest[g] > 0 ? largest[g] : system->data.largest_sound_speed));
  cvode::Options options;
  options.family = family;
  options.newton = false;
  options.rtol = rtol;
  options.max_order = family == cvode::Family::adams ? 12 : 5;
  cvode::Solver solver(options, atol, [&](double t, const double* y, double* dydt) { system->rate(t, y, dydt); });
  solver.start(0, made[0], request.scenario.t_end_s, 0, {});
  double t = 0;
  for (std::int64_t k = 1; k <= request.samples; ++k) {
    std::vector<double> y = made.back();
    if (solver.advance(request.time<double>(k), t, y) == cvode::Stop::failed)
      throw std::invalid_argument(solver.failure());
    made.push_back(std::move(y));
  }
  return made;
}

// One step of the classical Runge-Kutta method after the other.
class RungeKutta {
 public:
  explicit RungeKutta(FluidSystem<double>& system)
      : system_(system), size_(static_cast<std::size_t>(system.data.layout.size)), k1_(size_), k2_(size_), k3_(size_),
        k4_(size_), at_(size_) {}
  void step(double t, double h, std::vector<double>& y) {
    const auto stage = [&](double along, const std::vector<double>& from, double time, std::vector<double>& to) {
      for (std::size_t i = 0; i < size_; ++i) at_[i] = y[i] + along * from[i];
      system_.rate(time, at_.data(), to.data());
    };
    system_.rate(t, y.data(), k1_.data());
    stage(h / 2, k1_, t + h / 2, k2_);
    stage(h / 2, k2_, t + h / 2, k3_);
    stage(h, k3_, t + h, k4_);
    for (std::size_t i = 0; i < size_; ++i) y[i] += h / 6 * (k1_[i] + 2 * (k2_[i] + k3_[i]) + k4_[i]);
  }

 private:
  FluidSystem<double>& system_;
  std::size_t size_;
  std::vector<double> k1_, k2_, k3_, k4_, at_;
};

States<double> by_runge_kutta(const Request& request, std::int64_t steps_a_sample) {
  const auto system = fluid_system<double>(request.scene, request.response);
  RungeKutta stepper(*system);
  States<double> made{initial_state<double>(request.scene, system->data.layout)};
  const double h = request.scenario.t_end_s / static_cast<double>(request.samples * steps_a_sample);
  for (std::int64_t s = 0; s < request.samples; ++s) {
    std::vector<double> y = made.back();
    for (std::int64_t n = 0; n < steps_a_sample; ++n)
      stepper.step(h * static_cast<double>(s * steps_a_sample + n), h, y);
    if (!std::all_of(y.begin(), y.end(), [](double v) { return std::isfinite(v); })) fail(request.time<double>(s));
    made.push_back(std::move(y));
  }
  return made;
}

// Adams, Bashforth and Moulton of order 6 with equal steps, PECE, by backward differences; started by Runge-Kutta at an
// eighth of the step. E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I (1993), III.1.
States<double> by_equal_adams(const Request& request, std::int64_t steps_a_sample) {
  constexpr int order = 6, finer = 8;
  constexpr double predict[order] = {1, 1. / 2, 5. / 12, 3. / 8, 251. / 720, 95. / 288};
  constexpr double correct[order] = {1, -1. / 2, -1. / 12, -1. / 24, -19. / 720, -3. / 160};
  const auto system = fluid_system<double>(request.scene, request.response);
  const std::size_t size = static_cast<std::size_t>(system->data.layout.size);
  const double h = request.scenario.t_end_s / static_cast<double>(request.samples * steps_a_sample);
  std::vector<double> y = initial_state<double>(request.scene, system->data.layout), next(size);
  // differences[j]: the j-th backward difference of the rate at the last step; fresh: the same at the next one.
  std::vector<std::vector<double>> differences(order, std::vector<double>(size)), fresh = differences;
  const auto take_rate = [&](std::int64_t n, const std::vector<double>& at) {
    system->rate(h * static_cast<double>(n), at.data(), fresh[0].data());
    for (int j = 1; j < order; ++j)
      for (std::size_t i = 0; i < size; ++i) fresh[j][i] = fresh[j - 1][i] - differences[j - 1][i];
  };
  States<double> made{y};
  take_rate(0, y);
  differences.swap(fresh);
  RungeKutta start(*system);
  for (std::int64_t n = 1; n <= request.samples * steps_a_sample; ++n) {
    if (n < order) {
      for (int part = 0; part < finer; ++part)
        start.step(h * (static_cast<double>(n - 1) + static_cast<double>(part) / finer), h / finer, y);
    } else {
      next = y;
      for (int j = 0; j < order; ++j)
        for (std::size_t i = 0; i < size; ++i) next[i] += h * predict[j] * differences[j][i];
      take_rate(n, next);
      for (int j = 0; j < order; ++j)
        for (std::size_t i = 0; i < size; ++i) y[i] += h * correct[j] * fresh[j][i];
    }
    take_rate(n, y);
    differences.swap(fresh);
    if (n % steps_a_sample != 0) continue;
    if (!std::all_of(y.begin(), y.end(), [](double v) { return std::isfinite(v); }))
      fail(request.time<double>(n / steps_a_sample - 1));
    made.push_back(y);
  }
  return made;
}

// ---- samples and bars ---------------------------------------------------------------------------------------------
// Of one run at one sample: velocities, densities, ... of every particle, in S.
template <class S> std::vector<ParticleSample> particles_of(FluidSystem<S>& system, const std::vector<S>& y) {
  const ParticleLayout& layout = system.data.layout;
  const std::vector<S> rho = system.densities(y.data());
  std::vector<ParticleSample> made;
  for (int i = 0; i < layout.count; ++i) {
    ParticleSample& at = made.emplace_back();
    for (int a = 0; a < layout.d; ++a) {
      at.p_m[a] = y[layout.d * i + a];
      at.v_m_per_s[a] = y[layout.velocity + layout.d * i + a];
    }
    at.density_kg_per_m3 = rho[i];
    at.pressure_Pa = system.data.laws[system.data.fluid[i]].pressure(rho[i]);
    at.temperature_K =
        layout.temperature >= 0 ? Wide(y[layout.temperature + i]) : Wide(system.data.fixed_temperature[i]);
  }
  return made;
}

// Largest difference and size so far of the five kinds of values.
struct Spread {
  Wide difference[5] = {}, scale[5] = {};
  void include(const ParticleSample& a, const ParticleSample& b) {
    for (int i = 0; i < 3; ++i) one(0, a.p_m[i], b.p_m[i]), one(1, a.v_m_per_s[i], b.v_m_per_s[i]);
    one(2, a.density_kg_per_m3, b.density_kg_per_m3);
    one(3, a.pressure_Pa, b.pressure_Pa);
    one(4, a.temperature_K, b.temperature_K);
  }
  void one(int kind, Wide a, Wide b) {
    difference[kind] = larger(difference[kind], magnitude(a - b));
    scale[kind] = larger(scale[kind], magnitude(a));
  }
  ParticleSample bar(Wide unit) const {
    const auto of = [&](int kind) { return kSafety * difference[kind] + 64 * unit * scale[kind]; };
    return {{of(0), of(0), of(0)}, {of(1), of(1), of(1)}, of(2), of(3), of(4)};
  }
};

// The first run gives the values, the others the bars.
template <class S> void fill(const Request& request, const std::vector<States<S>>& runs, Wide unit, Truth& truth) {
  const auto system = fluid_system<S>(request.scene, request.response);
  Spread spread;
  const std::vector<Wide> none;
  for (std::int64_t k = 0; k <= request.samples; ++k) {
    const Wide t = request.time<Wide>(k);
    Sample value = dynamics::unpack<Wide>(request.scene, t, none.data());
    Sample bar = dynamics::unpack_bars<Wide>(request.scene, t, none.data());
    value.particles = particles_of(*system, runs[0][k]);
    for (std::size_t other = 1; other < runs.size(); ++other) {
      const auto theirs = particles_of(*system, runs[other][k]);
      for (std::size_t i = 0; i < theirs.size(); ++i) spread.include(value.particles[i], theirs[i]);
    }
    bar.particles.assign(value.particles.size(), k == 0 ? ParticleSample{} : spread.bar(unit));
    truth.values.push_back(std::move(value));
    truth.bars.push_back(std::move(bar));
  }
}

// Where two particles enter each other's support, the rate has as many continuous derivatives as the kernel. Steps of a
// high order shrink there to tolerance^(1/order), so that with the less smooth kernels a tolerance far below the errors
// to be measured costs hours. Of extrapolation in long double; `quad`: quad is worth its time.
struct Tolerances {
  double fine, coarse;
  bool quad;
};
Tolerances tolerances_for(const std::string& response) {
  if (word(parse_response(response), "kernel", "") == "wendland-c6") return {1e-17, 1e-15, true};
  return {1e-18, 1e-16, false};
}

// Work of quad: evaluations of the rate (some 100 in the time in which sound crosses a spacing, at the tolerances
// below) times particles times 40 neighbours times the work for one: 4 microseconds, with the fits of +polynomial 20.
bool quad_is_affordable(const Request& request, const ParticleData<double>& data) {
  const double crossings = request.scenario.t_end_s * (data.largest_sound_speed + data.largest_speed) / data.spacing;
  const double each_s = parse_response(request.response).name == "sph" ? 4e-6 : 2e-5;
  return 100 * crossings * data.layout.count * 40 * each_s <= kQuadSeconds;
}

// `each` steps in the time in which sound crosses a spacing.
std::int64_t steps_a_sample(const Request& request, const ParticleData<double>& data, double each) {
  const double crossings = request.scenario.t_end_s * (data.largest_sound_speed + data.largest_speed) / data.spacing;
  return static_cast<std::int64_t>(std::ceil(each * crossings / static_cast<double>(request.samples))) + 1;
}

void by_ladder(const Request& request, const ParticleData<double>& data, Truth& truth) {
  const std::int64_t steps = steps_a_sample(request, data, 4);
  std::vector<States<double>> runs{by_runge_kutta(request, 4 * steps), by_runge_kutta(request, 2 * steps)};
  fill(request, runs, 0x1p-53, truth);
  Truth coarse;
  fill(request, std::vector<States<double>>{by_runge_kutta(request, steps), runs[1]}, 0x1p-53, coarse);
  const Wide fine = truth.bars.back().particles[0].v_m_per_s[0], rough = coarse.bars.back().particles[0].v_m_per_s[0];
  truth.source =
      "semi-discrete: RK4 with " + std::to_string(4 * steps * request.samples) + " steps, half and a quarter of them";
  if (8 * fine > rough)
    truth.note = "differences between the ladder's steps fall by " + format_double(static_cast<double>(rough / fine)) +
                 ", less than 8: the bars are estimates";
}

void solve(const Request& request, Truth& truth) {
  const auto data = fluid_system<double>(request.scene, request.response)->data;
  require(data.layout.node_count == 0, "a free surface of +polynomial is not covered");
  if (data.layout.count > kMaxCvode) {
    by_ladder(request, data, truth);
  } else if (data.layout.count > kMaxExtended) {
    // A second method whose steps do not come from CVODE: a wrong estimate of its error shows.
    fill<double>(
        request,
        {by_cvode(request, cvode::Family::adams, 1e-12), by_equal_adams(request, steps_a_sample(request, data, 20))},
        0x1p-53, truth);
    truth.source = "semi-discrete: CVODE Adams at 1e-12, and Adams of order 6 with equal steps";
  } else if (tolerances_for(request.response).quad && quad_is_affordable(request, data)) {
    fill<Wide>(request, {by_extrapolation<Wide>(request, 1e-23), by_extrapolation<Wide>(request, 1e-21)}, 0x1p-113,
               truth);
    truth.source = "semi-discrete: extrapolation in quad at 1e-23 and 1e-21";
  } else {
    const auto [fine, coarse, quad] = tolerances_for(request.response);
    fill<Narrow>(request, {by_extrapolation<Narrow>(request, fine), by_extrapolation<Narrow>(request, coarse)}, 0x1p-64,
                 truth);
    truth.source =
        "semi-discrete: extrapolation in long double at " + format_double(fine) + " and " + format_double(coarse);
  }
}

}  // namespace

Truth semi_discrete_truth(const Scenario& scenario, std::int64_t samples) {
  Truth truth;
  const auto refuse = [&](const std::string& why) {
    truth = {};
    truth.source = "semi-discrete";
    truth.outcome = refused("semi-discrete: " + why);
  };
  try {
    require(samples >= 1 && scenario.t_end_s > 0, "expected t_end_s > 0 and at least 1 sample");
    solve({scenario, samples}, truth);
  } catch (const Refused& refusal) {
    refuse(refusal.why);
  } catch (const std::exception& error) {
    refuse(error.what());
  }
  return truth;
}

}  // namespace atwood
