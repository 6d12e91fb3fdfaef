#include "extended/path.hpp"

#include <optional>
#include <type_traits>

#include "dynamics/arithmetic.hpp"

namespace atwood::extended {

namespace {

using dynamics::operator-;
using dynamics::Triple;

constexpr int kMostIdleTouches = 100;
constexpr std::int64_t kMostStepsAtOnce = 16;

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
  double t_end_s;
  std::int64_t samples;
  Grid grid;
  int interval = 0;
  std::unique_ptr<Stepper<S>> stepper;
  S t = 0;
  S longest = 0;  // of a step; 0: no limit
  S decided = 0;  // the last step that had to be halved until it showed what happens in it; 0: none
  std::int64_t most_evaluations = 0;
  int idle_touches = 0;  // in a row: touches at which no pair approaches
  std::vector<S> y;
  DenseStep<S> last;  // with contacts: the last step
  std::int64_t logged_steps = 0;
  Path<S> path;

  PathIntegration(const Scene& scene, double end_s, std::int64_t count, const std::vector<S>& initial,
                  const MakeStepper<S>& make, Grid which)
      : dynamics(scene, end_s), double_dynamics(scene, end_s), impacts(scene, dynamics, double_dynamics, end_s),
        zero_wind(scene, dynamics.layout()), t_end_s(end_s), samples(count), grid(which), y(initial) {
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
  // Whether anything happened.
  bool resolve_contacts() {
    Instant<S> now = impacts.resolve(t, y.data(), interval, path.events);
    const bool changed = !now.impacts.empty() || !now.series.empty();
    log(std::move(now));
    if (const std::vector<S> speeds = impacts.speeds_at_rest(t, y.data(), interval); !speeds.empty())
      stepper->raise_scale(speeds.data());
    return changed;
  }

  bool fail_singular() {
    path.failure =
        "the step size became zero at t = " + format_double(static_cast<double>(t)) + " s: the motion is singular";
    return false;
  }

  S sample_time(std::int64_t k) const { return S(t_end_s) * S(k) / S(samples); }
  std::int64_t sampled() const { return static_cast<std::int64_t>(path.states.size()); }
  void take_sample(const std::vector<S>& state) {
    log_state(sample_time(sampled()), state, sampled(), std::nullopt);
    path.states.push_back(state);
  }

  // One step from `before`, cut at the first zero of the relative wind within it. Empty: failed.
  std::optional<S> smooth_step(const std::vector<S>& before, S limit) {
    const auto step = [&](S most) -> std::optional<S> {
      const S taken = stepper->step(t, y.data(), most);
      if (!(taken > 0)) return fail_singular(), std::nullopt;
      if (impacts.any()) last = stepper->dense();
      return taken;
    };
    const std::optional<S> taken = step(limit);
    if (!taken || !zero_wind.any()) return taken;
    const auto state_at = states_from(before);
    const auto tau = zero_wind.first(before.data(), y.data(), *taken, state_at);
    if (!tau || failed()) return failed() ? std::nullopt : taken;
    if (!tau->located) {
      path.valid_until_failure = true;
      path.failure = "the instant at which the relative wind of a body is zero was not located in the step from t = " +
                     format_double(static_cast<double>(t)) + " s";
      return std::nullopt;
    }
    if (impacts.any()) {  // what follows looks at one whole step
      y = before;
      return step(tau->tau);
    }
    y = state_at(tau->tau);
    return failed() ? std::nullopt : std::optional<S>(tau->tau);
  }
  typename Impacts<S>::StateAt states_from(const std::vector<S>& before) {
    return [this, &before](S tau) {
      std::vector<S> state = before;
      if (!advance(*stepper, t, state.data(), tau)) fail_singular();
      return state;
    };
  }

  // On the free grid, the samples of a step until `reached`, which has an impact known to within `span`: samples within
  // it have the state before the impact, as on the other grid, where the gap is not beyond its round-off there.
  void take_samples(const typename Impacts<S>::StateAt& state_at, S reached, S span) {
    while (grid == Grid::free && sampled() < samples &&
           (sample_time(sampled()) < reached || (span > 0 && sample_time(sampled()) <= reached + span)))
      take_sample(state_at(sample_time(sampled()) - t));
  }

  // One step towards `target`, cut at the first impact or zero of the relative wind within it. False: failed.
  bool step_to(S target) {
    const S left = target - t;
    S limit = longest > 0 && longest < left ? longest : left;
    if (decided > 0 && (decided *= 2) < limit) limit = decided;
    else decided = 0;
    if (most_evaluations > 0 && stepper->evaluations > most_evaluations) {
      path.failure = "the motion takes more than " + std::to_string(most_evaluations) + " evaluations of the rates";
      return false;
    }
    const std::vector<S> before = impacts.any() || zero_wind.any() || grid == Grid::free ? y : std::vector<S>{};
    const auto state_at = states_from(before);
    typename Impacts<S>::Found found;
    typename Impacts<S>::Lift lift;
    std::optional<S> taken;
    for (;;) {
      taken = smooth_step(before, limit);
      if (!taken) return false;
      if (!impacts.any()) break;
      const StepCourse<S> course(last);
      found = impacts.search(course, state_at);
      lift = impacts.find_lift(course, interval, state_at, found.touch ? found.touch->tau : *taken);
      if (failed()) {
        if (const std::optional<S> at = impacts.failed_at()) {
          take_samples(state_at, *at, S(0));
          t = *at;
        }
        return false;
      }
      const bool touches = found.undecided.has_value();
      if (!touches && !lift.undecided) break;
      decided = limit = *taken / 2;
      if (!(limit > S(kShortestSearch) * S(t_end_s))) {
        impacts.end_undecided(t, touches ? *found.undecided : lift.pair, touches ? "touch" : "part");
        return false;
      }
      y = before;
    }
    auto& touch = found.touch;
    if (lift.tau && (!touch || *lift.tau < touch->tau)) {
      touch.reset();
      std::erase_if(found.passages, [&](const auto& passage) { return passage.tau > *lift.tau; });
    } else lift.tau.reset();
    if (touch) impacts.check_located(t, touch->pair, touch->located);
    for (auto& passage : found.passages) {
      impacts.check_located(t, passage.pair, passage.located);
      if (!failed()) log_state(t + passage.tau, passage.y, -1, passage.pair);
    }
    if (failed()) return false;
    const S reached = lift.tau ? t + *lift.tau : touch ? t + touch->tau : *taken == left ? target : t + *taken;
    if (touch) y = state_at(touch->tau);
    take_samples(state_at, reached, touch ? impacts.location_span(touch->pair, y.data()) : S(0));
    if (failed()) return false;
    if (touch) {
      t = reached;
      const bool changed = resolve_contacts();
      idle_touches = changed ? 0 : idle_touches + 1;
      if (idle_touches > kMostIdleTouches) impacts.check_located(t, touch->pair, false);
      return !failed();
    }
    if (lift.tau) {
      y = state_at(*lift.tau);
      log(impacts.release(lift.pair, reached, y.data(), interval, path.events));
    }
    t = reached;
    // Errors are followed from instant to instant, and not over arbitrarily many steps at once.
    if (!failed() && stepper->steps - logged_steps >= kMostStepsAtOnce) log_state(t, y, -1, std::nullopt);
    return !failed();
  }

  bool integrate_to(S target) {
    while (t < target)
      if (!step_to(target)) return false;
    return true;
  }

  // To `target`, switching on the way; a switch at the target itself is passed. False: failed.
  bool pass_switches(S target) {
    const std::vector<double>& switches = dynamics.switch_times();
    while (interval < static_cast<int>(switches.size()) && switches[interval] <= target) {
      const S until = S(switches[interval]);
      if (grid == Grid::free) longest = S(kFreeShare) * (until - t);
      if (!integrate_to(until)) return false;
      log_state(t, y, -1, std::nullopt);
      ++interval;
      resolve_contacts();
      if (failed()) return false;
    }
    if (grid == Grid::free) longest = S(kFreeShare) * (target - t);
    return integrate_to(target);
  }

  void run() {
    path.states.reserve(static_cast<std::size_t>(samples) + 1, y.size());
    take_sample(y);  // the initial state, before impacts at t = 0
    resolve_contacts();
    if (failed()) return;
    while (sampled() <= samples) {
      if (!pass_switches(sample_time(grid == Grid::free ? samples : sampled()))) return;
      take_sample(y);  // of the free grid the last one: the steps have taken the others
    }
  }
};

}  // namespace

template <class S>
Path<S> integrate_path(const Scene& scene, double t_end_s, std::int64_t samples, const std::vector<S>& initial,
                       const MakeStepper<S>& make, Grid grid, std::int64_t most_evaluations) {
  PathIntegration<S> integration(scene, t_end_s, samples, initial, make, grid);
  integration.most_evaluations = most_evaluations;
  integration.run();
  integration.path.end = integration.t;
  integration.path.steps = integration.stepper->steps;
  integration.path.evaluations = integration.stepper->evaluations;
  return std::move(integration.path);
}

template Path<double> integrate_path(const Scene&, double, std::int64_t, const std::vector<double>&,
                                     const MakeStepper<double>&, Grid, std::int64_t);
template Path<Wide> integrate_path(const Scene&, double, std::int64_t, const std::vector<Wide>&,
                                   const MakeStepper<Wide>&, Grid, std::int64_t);

}  // namespace atwood::extended
