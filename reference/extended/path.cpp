#include "extended/path.hpp"

#include <optional>

#include "dynamics/arithmetic.hpp"

namespace atwood::extended {

namespace {

using dynamics::operator-;
using dynamics::Triple;

// Quadratic drag |u| u has a kink where the wind stands still, u = 0: a ball thrown straight up meets it at its apex.
// Steps are cut there, or no method of order 20 would see a smooth motion.
template <class S> class Calms {
 public:
  Calms(const Scene& scene, const dynamics::Layout& layout) {
    for (const Force& force : scene.forces)
      if (const auto* drag = std::get_if<QuadraticDrag>(&force))
        for (const int body : drag->bodies)
          if (layout.slots[body].velocity >= 0)
            winds_.push_back({layout.slots[body].velocity, dynamics::widen<S>(drag->wind_m_per_s)});
  }
  bool any() const { return !winds_.empty(); }

  // First instant inside (0, taken) where a relative velocity has turned square to what it was at the start.
  template <class Again> std::optional<S> first(const S* before, const S* after, S taken, const Again& again) const {
    std::optional<S> found;
    for (const Wind& wind : winds_) {
      const Triple<S> u0 = relative(wind, before), u1 = relative(wind, after);
      const S start = dynamics::dot(u0, u0), end = dynamics::dot(u0, u1);
      if (!(end < 0) || start < S(1e-30) * dynamics::dot(u1, u1)) continue;
      const S tau = locate(wind, u0, taken, again);
      if (tau < taken && (!found || tau < *found)) found = tau;
    }
    return found;
  }

 private:
  struct Wind {
    int velocity;
    Triple<S> wind;
  };

  static Triple<S> relative(const Wind& wind, const S* y) { return dynamics::read3(y + wind.velocity) - wind.wind; }

  // Root of u . u0 by secants. A braking body brakes less and less, so they come from the left: across the kink the
  // stepper would have to crawl.
  template <class Again> static S locate(const Wind& wind, const Triple<S>& u0, S taken, const Again& again) {
    const auto turned = [&](S tau) { return dynamics::dot(u0, relative(wind, again(tau).data())); };
    const S size = dynamics::dot(u0, u0);
    S low = 0, high = taken, low_value = size, tau = taken / 1024, value = turned(tau);
    S last = 0, last_value = low_value;
    for (int tries = 0; tries < 80; ++tries) {
      if (dynamics::magnitude(value) <= S(1e-32) * size || high - low <= S(1e-32) * taken) break;
      if (value > 0) low = tau;
      else high = tau;
      S next = tau - value * (tau - last) / (value - last_value);
      if (!(next > low && next < high)) next = low + (high - low) / 2;
      last = tau;
      last_value = value;
      tau = next;
      value = turned(tau);
    }
    return tau;
  }

  std::vector<Wind> winds_;
};

// The walk's moving parts; `interval` is read by the rate functions that the stepper holds.
template <class S> struct Walk {
  dynamics::Dynamics<S> dynamics;
  dynamics::Dynamics<double> narrow;
  Impacts<S> impacts;
  Calms<S> calms;
  int interval = 0;
  std::unique_ptr<Stepper<S>> stepper;
  S t = 0;
  std::vector<S> y;
  std::int64_t logged_steps = 0;
  Path<S> path;

  Walk(const Scene& scene, double t_end_s, const std::vector<S>& initial, const MakeStepper<S>& make)
      : dynamics(scene, t_end_s), narrow(scene, t_end_s), impacts(scene, dynamics, narrow, t_end_s),
        calms(scene, dynamics.layout()), y(initial) {
    stepper = make([this](S at, const S* state, S* dydt) { dynamics.rate(at, state, dydt, interval); },
                   [this](double at, const double* state, double* dydt) { narrow.rate(at, state, dydt, interval); });
  }
  Walk(const Walk&) = delete;
  Walk& operator=(const Walk&) = delete;

  bool failed() {
    if (path.failure.empty()) {
      path.failure = impacts.failure();
      path.branch = impacts.branch();
    }
    return !path.failure.empty();
  }

  void log(Instant<S> what) {
    if (!impacts.any()) return;
    what.steps = static_cast<double>(stepper->steps - logged_steps);
    logged_steps = stepper->steps;
    path.instants.push_back(std::move(what));
  }
  void log_state(S at, const std::vector<S>& state, std::int64_t sample, std::optional<dynamics::ContactPair> passed) {
    Instant<S> made;
    made.t = at;
    made.interval = interval;
    made.sample = sample;
    made.passed = passed;
    made.first_event = path.events.size();
    made.after = state;
    log(std::move(made));
  }
  void settle() { log(impacts.settle(t, y.data(), interval, path.events)); }

  bool singular() {
    path.failure =
        "no step is small enough at t = " + format_double(static_cast<double>(t)) + " s: the motion is singular";
    return false;
  }

  // One step towards `target`, cut at the first touch within it.
  bool step_to(S target) {
    const S left = target - t;
    std::vector<S> before;
    if (impacts.any() || calms.any()) before = y;
    S taken = stepper->step(t, y.data(), left);
    if (!(taken > 0)) return singular();
    const auto again = [&](S tau) {
      std::vector<S> state = before;
      if (!advance(*stepper, t, state.data(), tau)) singular();
      return state;
    };
    if (calms.any())
      if (const auto tau = calms.first(before.data(), y.data(), taken, again)) {
        y = again(*tau);
        taken = *tau;
        if (failed()) return false;
      }
    if (impacts.any()) {
      const auto tau = impacts.first_touch(before.data(), y.data(), taken, again);
      for (auto& passage : impacts.passages(before.data(), y.data(), taken, tau ? *tau : taken, again))
        log_state(t + passage.tau, passage.y, -1, passage.pair);
      if (failed()) return false;
      if (tau) {
        y = again(*tau);
        t += *tau;
        settle();
        return !failed();
      }
      impacts.check_held(y.data());
      if (failed()) return false;
    }
    t = taken == left ? target : t + taken;
    return true;
  }

  bool go_to(S target) {
    while (t < target)
      if (!step_to(target)) return false;
    return true;
  }

  void run(double t_end_s, std::int64_t samples) {
    const std::vector<double>& switches = dynamics.switch_times();
    path.states.push_back(y);  // the scene itself, before what happens at its first instant
    log_state(S(0), y, 0, std::nullopt);
    settle();
    if (failed()) return;
    std::size_t next = 0;
    for (std::int64_t k = 1; k <= samples; ++k) {
      const S target = S(t_end_s) * S(k) / S(samples);
      for (; next < switches.size() && switches[next] <= target; ++next) {
        if (!go_to(S(switches[next]))) return;
        log_state(t, y, -1, std::nullopt);
        ++interval;
        settle();
        if (failed()) return;
      }
      if (!go_to(target)) return;
      path.states.push_back(y);
      log_state(t, y, k, std::nullopt);
    }
  }
};

}  // namespace

template <class S>
Path<S> walk(const Scene& scene, double t_end_s, std::int64_t samples, const std::vector<S>& initial,
             const MakeStepper<S>& make) {
  Walk<S> going(scene, t_end_s, initial, make);
  going.run(t_end_s, samples);
  going.path.end = going.t;
  going.path.steps = going.stepper->steps;
  going.path.evaluations = going.stepper->evaluations;
  return std::move(going.path);
}

template Path<double> walk(const Scene&, double, std::int64_t, const std::vector<double>&, const MakeStepper<double>&);
template Path<Wide> walk(const Scene&, double, std::int64_t, const std::vector<Wide>&, const MakeStepper<Wide>&);

}  // namespace atwood::extended
