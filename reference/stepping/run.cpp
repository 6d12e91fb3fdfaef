#include <algorithm>
#include <chrono>
#include <cmath>

#include "dynamics/contacts.hpp"
#include "dynamics/rates.hpp"
#include "protocol/refusal.hpp"
#include "protocol/timed_passes.hpp"
#include "stepping/stepping.hpp"

namespace atwood::stepping {

namespace {

bool is_velocity_dependent(const Force& force) {
  if (const auto* spring = std::get_if<Spring>(&force)) return spring->damping_N_s_per_m != 0;
  return std::holds_alternative<LinearDrag>(force) || std::holds_alternative<QuadraticDrag>(force) ||
         std::holds_alternative<Lorentz>(force) || std::holds_alternative<RotatingFrame>(force);
}

// What an integration without switches and contacts does not cover.
std::string uncovered(const Scene& scene, double t_end_s) {
  if (const std::string why = dynamics::unsupported(scene); !why.empty()) return why;
  if (!dynamics::switch_times(scene, t_end_s).empty())
    return "forces or releases that switch during the run: the steps are not cut there";
  if (!scene.joints.empty() || !scene.ropes.empty()) return "joints or ropes: this method steps free bodies only";
  if (dynamics::contacts_possible(scene)) return "contacts: there is no location of impacts";
  return "";
}

// (8 (f(+d) - f(-d)) - (f(+2d) - f(-2d))) / 12 d, error d^4 f^(5) / 30. In long double d = 1e-4 gives errors of about
// 1e-16 of f^(5) and 1e-15 of f.
class Differences {
 public:
  Differences(const Scene& scene, double t_end_s)
      : motion_(scene, t_end_s), y_(motion_.size()), sum_(motion_.size()), f_(motion_.size()) {}
  template <class S> void fill(S t_s, const S* y, S* dfdy, S* dfdt) {
    const int n = motion_.size();
    for (int j = 0; j < n; ++j) {
      const long double width = 1e-4L * std::max(1.0L, std::fabs(static_cast<long double>(y[j])));
      begin(y);
      for (const auto& [shift, weight] : kStencil) {
        y_[j] = static_cast<long double>(y[j]) + shift * width;
        add(t_s, weight / (12 * width));
      }
      for (int i = 0; i < n; ++i) dfdy[i * n + j] = static_cast<S>(sum_[i]);
    }
    begin(y);
    for (const auto& [shift, weight] : kStencil) add(t_s + shift * 1e-4L, weight / (12 * 1e-4L));
    for (int i = 0; i < n; ++i) dfdt[i] = static_cast<S>(sum_[i]);
  }

 private:
  static constexpr std::pair<long double, long double> kStencil[] = {{1, 8}, {-1, -8}, {2, -1}, {-2, 1}};
  template <class S> void begin(const S* y) {
    std::copy_n(y, y_.size(), y_.begin());
    std::fill(sum_.begin(), sum_.end(), 0);
  }
  void add(long double t_s, long double weight) {
    motion_.rate(t_s, y_.data(), f_.data(), 0);
    for (std::size_t i = 0; i < f_.size(); ++i) sum_[i] += weight * f_[i];
  }
  dynamics::Dynamics<long double> motion_;
  std::vector<long double> y_, sum_, f_;
};

template <class S> struct Integration {
  const Scene& scene;
  const Plan& plan;
  const Observer& observer;
  bool by_tolerance;
  dynamics::Dynamics<S> motion;
  Differences differences;
  Equations<S> equations;
  std::int64_t evaluations = 0, steps = 0;
  std::vector<S> y;
  std::unique_ptr<Stepper<S>> stepper;

  Integration(const Scene& given, const Plan& asked, const Observer& to, bool tolerance, int rate_repeats)
      : scene(given), plan(asked), observer(to), by_tolerance(tolerance), motion(given, asked.t_end_s),
        differences(given, asked.t_end_s), y(dynamics::pack<S>(given)) {
    equations.size = motion.size();
    const int positions = motion.layout().positions;
    if (scene.problem.empty() && 2 * positions == equations.size) equations.positions = positions;
    equations.velocity_dependent = accelerations_depend_on_velocity(scene);
    equations.time_dependent = accelerations_depend_on_time(scene);
    equations.rate = [this, rate_repeats](S t_s, const S* from, S* dydt) {
      ++evaluations;
      for (int k = 0; k < rate_repeats; ++k) motion.rate(t_s, from, dydt, 0);
    };
    equations.jacobian = [this](S t_s, const S* from, S* dfdy, S* dfdt) {
      evaluations += 4 * (equations.size + 1);
      differences.fill(t_s, from, dfdy, dfdt);
    };
  }

  // t = t_end k / n, in the scalar of the run.
  S instant(std::int64_t k, std::int64_t n) const { return k == n ? S(plan.t_end_s) : S(plan.t_end_s) * S(k) / S(n); }

  void take_sample(std::int64_t k) {
    if (!observer.sample) return;
    Sample made = dynamics::unpack<S>(scene, instant(k, plan.samples), y.data());
    made.t_s = Wide(plan.t_end_s) * k / plan.samples;
    observer.sample(made);
  }
  void require_finite(S t_s) const {
    if (std::all_of(y.begin(), y.end(), [](S v) { return std::isfinite(v); })) return;
    throw Failure(Status::not_finite,
                  "the state is not finite at t = " + format_double(static_cast<double>(t_s)) + " s");
  }

  S step_s() const { return S(plan.t_end_s) / S(plan.steps); }
  void prepare(const Maker<S>& make) {
    if (equations.size > 0) stepper = make(equations, y, step_s());
  }
  void go() {
    const S h = step_s();
    take_sample(0);
    if (equations.size == 0) {  // nothing moves
      for (std::int64_t k = 1; k <= plan.samples; ++k) take_sample(k);
      return;
    }
    const std::int64_t stretch = plan.steps / plan.samples;
    for (std::int64_t k = 1; k <= plan.samples; ++k) {
      if (by_tolerance) {
        steps += stepper->advance(instant(k - 1, plan.samples), instant(k, plan.samples), y);
      } else {
        for (std::int64_t i = 0; i < stretch; ++i, ++steps) stepper->step(instant(steps, plan.steps), h, y);
      }
      require_finite(instant(k, plan.samples));
      take_sample(k);
    }
  }
};

// One run; `busy` (null: not timed) receives only the time of the steps.
template <class S>
Outcome run_once(const std::string& engine, Integration<S>& integration, const Maker<S>& make,
                 std::chrono::nanoseconds* busy) {
  using Clock = std::chrono::steady_clock;
  Outcome outcome;
  try {
    integration.prepare(make);
    const Clock::time_point from = Clock::now();
    integration.go();
    if (busy != nullptr) *busy = std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now() - from);
  } catch (const Failure& failure) {
    outcome.status = failure.status;
    outcome.reason = engine + ": " + failure.what();
  }
  outcome.steps_taken = integration.steps;
  outcome.rate_evaluations = integration.evaluations;
  return outcome;
}

}  // namespace

bool accelerations_depend_on_velocity(const Scene& scene) {
  return std::any_of(scene.forces.begin(), scene.forces.end(), is_velocity_dependent);
}

bool accelerations_depend_on_time(const Scene& scene) {
  return std::any_of(scene.forces.begin(), scene.forces.end(),
                     [](const Force& force) { return std::holds_alternative<Drive>(force); });
}

Setting rate_repeats_setting() {
  return {"rate_repeats", std::int64_t(1), {between(1, 1000), "How often each rate is evaluated; it counts once."}};
}
int rate_repeats(const Settings& settings) {
  return static_cast<int>(std::get<std::int64_t>(settings.at("rate_repeats")));
}

template <class S>
Outcome run(const std::string& engine, const Scene& scene, const Plan& plan, const Observer& observer, int repeats,
            bool by_tolerance, const Maker<S>& make, int rate_repeats) {
  if (const std::string why = uncovered(scene, plan.t_end_s); !why.empty()) return refused(engine + ": " + why);
  if (!(plan.t_end_s > 0) || plan.samples < 1 || plan.steps < 1 || plan.steps % plan.samples != 0) {
    return refused(engine + ": nothing to run");
  }
  if (repeats <= 0) {
    Integration<S> integration(scene, plan, observer, by_tolerance, rate_repeats);
    return run_once(engine, integration, make, nullptr);
  }
  const Observer no_observer;
  return timed_passes(repeats, [&](std::chrono::nanoseconds& busy) {
    Integration<S> integration(scene, plan, no_observer, by_tolerance, rate_repeats);
    return run_once(engine, integration, make, &busy);
  });
}

template Outcome run(const std::string&, const Scene&, const Plan&, const Observer&, int, bool, const Maker<double>&,
                     int);
template Outcome run(const std::string&, const Scene&, const Plan&, const Observer&, int, bool,
                     const Maker<long double>&, int);

}  // namespace atwood::stepping
