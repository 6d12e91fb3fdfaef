#include "extended/path.hpp"

#include <optional>
#include <type_traits>

#include "dynamics/arithmetic.hpp"

namespace atwood::extended {

namespace {

using dynamics::operator-;
using dynamics::Triple;

template <class S> constexpr double kRoundOff = std::is_same_v<S, Wide> ? 0x1p-112 : 0x1p-52;

// The second derivative of quadratic drag |u| u jumps at zero relative wind, u = 0, which a ball thrown straight up in
// still air reaches at its apex. Steps are cut there, so that the motion is smooth within each.
template <class S> class ZeroWindCrossings {
 public:
  ZeroWindCrossings(const Scene& scene, const dynamics::Layout& layout) {
    for (const Force& force : scene.forces)
      if (const auto* drag = std::get_if<QuadraticDrag>(&force))
        for (const int body : drag->bodies)
          if (layout.slots[body].velocity >= 0)
            winds_.push_back({layout.slots[body].velocity, dynamics::widen<S>(drag->wind_m_per_s)});
  }
  bool any() const { return !winds_.empty(); }

  // First time in (0, taken) at which a relative velocity u is orthogonal to its value at the start of the step. Not
  // `located`: the search ended before the projection was within its round-off.
  struct Zero {
    S tau{};
    bool located = true;
  };
  template <class StateAt>
  std::optional<Zero> first(const S* before, const S* after, S taken, const StateAt& state_at) const {
    std::optional<Zero> found;
    for (const Wind& wind : winds_) {
      const Triple<S> u0 = relative(wind, before), u1 = relative(wind, after);
      const S start = dynamics::dot(u0, u0), end = dynamics::dot(u0, u1);
      if (!(end < 0) || start < S(1e-30) * dynamics::dot(u1, u1)) continue;
      const Zero zero = locate(wind, u0, taken, state_at);
      if (!zero.located) return zero;
      if (zero.tau < taken && (!found || zero.tau < found->tau)) found = zero;
    }
    return found;
  }

 private:
  struct Wind {
    int velocity;
    Triple<S> wind;
  };

  static Triple<S> relative(const Wind& wind, const S* y) { return dynamics::read3(y + wind.velocity) - wind.wind; }

  // Root of u . u0 by the secant method in a bracket. The iterates start on the left: drag decreases towards the root,
  // so that they stay on that side, and no trial step has to cross the kink.
  template <class StateAt> static Zero locate(const Wind& wind, const Triple<S>& u0, S taken, const StateAt& state_at) {
    Triple<S> u = u0;
    const auto projection = [&](S tau) {
      u = relative(wind, state_at(tau).data());
      return dynamics::dot(u0, u);
    };
    const S size = dynamics::dot(u0, u0);
    S low = 0, high = taken, low_value = size, tau = taken / 1024, value = projection(tau);
    S previous = 0, previous_value = low_value;
    for (int tries = 0; tries < 80; ++tries) {
      if (dynamics::magnitude(value) <= S(1e-32) * size || high - low <= S(1e-32) * taken) break;
      if (value > 0) low = tau;
      else high = tau;
      S next = tau - value * (tau - previous) / (value - previous_value);
      if (!(next > low && next < high)) next = low + (high - low) / 2;
      previous = tau;
      previous_value = value;
      tau = next;
      value = projection(tau);
    }
    // u is a difference of velocities, which has their round-off.
    const S square = size + dynamics::dot(u, u) + dynamics::dot(wind.wind, wind.wind);
    return {tau, dynamics::magnitude(value) <= S(64) * S(kRoundOff<S>) * dynamics::sqrt(size * square)};
  }

  std::vector<Wind> winds_;
};

// The state of one integration. The stepper's rate functions read `interval`.
template <class S> struct PathIntegration {
  dynamics::Dynamics<S> dynamics;
  dynamics::Dynamics<double> double_dynamics;
  Impacts<S> impacts;
  ZeroWindCrossings<S> zero_wind;
  int interval = 0;
  std::unique_ptr<Stepper<S>> stepper;
  S t = 0;
  std::vector<S> y;
  std::int64_t logged_steps = 0;
  Path<S> path;

  PathIntegration(const Scene& scene, double t_end_s, const std::vector<S>& initial, const MakeStepper<S>& make)
      : dynamics(scene, t_end_s), double_dynamics(scene, t_end_s), impacts(scene, dynamics, double_dynamics, t_end_s),
        zero_wind(scene, dynamics.layout()), y(initial) {
    stepper =
        make([this](S at, const S* state, S* dydt) { dynamics.rate(at, state, dydt, interval); },
             [this](double at, const double* state, double* dydt) { double_dynamics.rate(at, state, dydt, interval); });
  }
  PathIntegration(const PathIntegration&) = delete;
  PathIntegration& operator=(const PathIntegration&) = delete;

  bool failed() {
    if (path.failure.empty()) {
      path.failure = impacts.failure();
      path.valid_until_failure = impacts.valid_until_failure();
    }
    return !path.failure.empty();
  }

  void log(Instant<S> what) {
    if (!impacts.any()) return;
    what.steps = static_cast<double>(stepper->steps - logged_steps);
    logged_steps = stepper->steps;
    path.instants.push_back(std::move(what));
  }
  void log_state(S at, const std::vector<S>& state, std::int64_t sample, std::optional<dynamics::ContactPair> passage) {
    Instant<S> made;
    made.t = at;
    made.interval = interval;
    made.sample = sample;
    made.passage = passage;
    made.first_event = path.events.size();
    made.after = state;
    log(std::move(made));
  }
  void resolve_contacts() { log(impacts.resolve(t, y.data(), interval, path.events)); }

  bool fail_singular() {
    path.failure =
        "the step size became zero at t = " + format_double(static_cast<double>(t)) + " s: the motion is singular";
    return false;
  }

  // One step towards `target`, cut at the first impact or zero of the relative wind within it. False: failed.
  bool step_to(S target) {
    const S left = target - t;
    std::vector<S> before;
    if (impacts.any() || zero_wind.any()) before = y;
    S taken = stepper->step(t, y.data(), left);
    if (!(taken > 0)) return fail_singular();
    const auto state_at = [&](S tau) {
      std::vector<S> state = before;
      if (!advance(*stepper, t, state.data(), tau)) fail_singular();
      return state;
    };
    if (zero_wind.any())
      if (const auto tau = zero_wind.first(before.data(), y.data(), taken, state_at)) {
        if (!failed() && !tau->located) {
          path.valid_until_failure = true;
          path.failure =
              "the instant at which the relative wind of a body is zero was not located in the step from t = " +
              format_double(static_cast<double>(t)) + " s";
        }
        if (failed()) return false;
        y = state_at(tau->tau);
        taken = tau->tau;
        if (failed()) return false;
      }
    if (impacts.any()) {
      const auto touch = impacts.first_touch(before.data(), y.data(), taken, state_at);
      if (touch) impacts.check_located(t, touch->pair, touch->located);
      if (failed()) return false;
      for (auto& passage : impacts.passages(before.data(), y.data(), taken, touch ? touch->tau : taken, state_at)) {
        impacts.check_located(t, passage.pair, passage.located);
        log_state(t + passage.tau, passage.y, -1, passage.pair);
      }
      if (failed()) return false;
      if (touch) {
        y = state_at(touch->tau);
        t += touch->tau;
        resolve_contacts();
        return !failed();
      }
      impacts.check_held(y.data());
      if (failed()) return false;
    }
    t = taken == left ? target : t + taken;
    return true;
  }

  bool integrate_to(S target) {
    while (t < target)
      if (!step_to(target)) return false;
    return true;
  }

  void run(double t_end_s, std::int64_t samples) {
    const std::vector<double>& switches = dynamics.switch_times();
    path.states.reserve(static_cast<std::size_t>(samples) + 1, y.size());
    path.states.push_back(y);  // the initial state, before impacts at t = 0
    log_state(S(0), y, 0, std::nullopt);
    resolve_contacts();
    if (failed()) return;
    std::size_t next = 0;
    for (std::int64_t k = 1; k <= samples; ++k) {
      const S target = S(t_end_s) * S(k) / S(samples);
      for (; next < switches.size() && switches[next] <= target; ++next) {
        if (!integrate_to(S(switches[next]))) return;
        log_state(t, y, -1, std::nullopt);
        ++interval;
        resolve_contacts();
        if (failed()) return;
      }
      if (!integrate_to(target)) return;
      path.states.push_back(y);
      log_state(t, y, k, std::nullopt);
    }
  }
};

}  // namespace

template <class S>
Path<S> integrate_path(const Scene& scene, double t_end_s, std::int64_t samples, const std::vector<S>& initial,
                       const MakeStepper<S>& make) {
  PathIntegration<S> integration(scene, t_end_s, initial, make);
  integration.run(t_end_s, samples);
  integration.path.end = integration.t;
  integration.path.steps = integration.stepper->steps;
  integration.path.evaluations = integration.stepper->evaluations;
  return std::move(integration.path);
}

template Path<double> integrate_path(const Scene&, double, std::int64_t, const std::vector<double>&,
                                     const MakeStepper<double>&);
template Path<Wide> integrate_path(const Scene&, double, std::int64_t, const std::vector<Wide>&,
                                   const MakeStepper<Wide>&);

}  // namespace atwood::extended
