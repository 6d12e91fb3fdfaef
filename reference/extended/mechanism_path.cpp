#include "extended/mechanism_path.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "dynamics/arithmetic.hpp"
#include "dynamics/certified_end.hpp"
#include "extended/mechanism_ropes.hpp"
#include "extended/mechanism_stop.hpp"

namespace atwood::extended {

namespace {

using dynamics::at_time;
using dynamics::magnitude;

constexpr double kSingular = 1e-10;       // of the smallest scaled pivot: a squared sine of 1e-5
constexpr double kContradiction = 1e-11;  // of the size: redundant constraints that contradict the others by more
constexpr double kShortStep = 1e-15;      // of the run
constexpr int kMaxShortSteps = 40;
constexpr std::int64_t kMaxRateWork = 400'000'000;  // evaluations of the rates, times the size of the state
constexpr double kLargestMassRatio = 1e13;          // rates in double then keep a digit or two
constexpr double kAtStop = 1e-26;                   // of the coordinate's scale: a stop's gap at a located impact

struct Integration {
  MechanismMotion& motion;
  const MechanismRun& run;
  std::unique_ptr<Stepper<Wide>> stepper;
  std::vector<Stop> stops;
  std::vector<Wide> y;
  Wide t = 0;
  double size_m = 1;
  int interval = 0, rank = -1;
  Wide cap = 0;  // largest step; 0: none
  RopeWatch ropes;
  int short_steps = 0;  // in a row
  MechanismPath path;

  Integration(MechanismMotion& of, const Sample& start, const MechanismRun& given)
      : motion(of), run(given), stepper(of.make_stepper(given.tolerance)),
        y(of.initial(start)), ropes{of, static_cast<int>(given.scene.ropes.size()), {}} {
    for (std::size_t j = 0; j < run.scene.joints.size(); ++j) {
      const Joint& joint = run.scene.joints[j];
      for (const auto& anchor : joint.anchors_body_m)
        for (const double x : anchor) size_m = std::max(size_m, std::fabs(x));
      if (!joint.limits) continue;
      stops.push_back({static_cast<int>(j), 1, joint.limits->lower, Wide(joint.limits->restitution)});
      stops.push_back({static_cast<int>(j), -1, joint.limits->upper, Wide(joint.limits->restitution)});
    }
  }

  bool fail(const std::string& why, Wide t_s) {
    if (!path.failure.empty()) return false;
    path.failure = why + at_time(t_s);
    path.valid_until_failure = true;
    path.end_s = t_s;
    return false;
  }
  // The largest mass of a body that moves over the smallest.
  double mass_ratio() const {
    double least = HUGE_VAL, most = 0;
    for (const Body& body : run.scene.bodies) {
      if (body.fixed) continue;
      least = std::min(least, body.mass_kg);
      most = std::max(most, body.mass_kg);
    }
    return most / least;
  }
  bool fail_singular() {
    if (const double ratio = mass_ratio(); ratio > kLargestMassRatio)
      return fail("the bodies' masses differ by a factor of " + format_double(ratio) +
                      ", at which the solution in maximal coordinates is not certified,",
                  t);
    return fail("the mechanism is not certified past a singular configuration, or its motion is singular,", t);
  }
  std::string name(int joint) const { return "joint `" + run.scene.joints[joint].name + "`"; }

  void enter_interval() {
    const std::vector<double>& switches = motion.switch_times();
    const auto k = static_cast<std::size_t>(interval);
    const double from = k == 0 ? 0 : switches[k - 1], to = k == switches.size() ? run.t_end_s : switches[k];
    motion.choice().interval = interval;
    motion.choice().interval_s = from + (to - from) / 2;
  }
  // Chooses the constraints of the next step. False: they have lost rank.
  bool choose() {
    const mechanism::Independence found = motion.choose(t, y.data());
    if (rank < 0) rank = found.rank;
    if (found.rank != rank || found.smallest < kSingular) return fail_singular();
    return true;
  }
  // The choice changes on purpose: a joint comes to rest at a stop or leaves it.
  bool choose_anew() {
    rank = -1;
    return choose();
  }

  // Moves a state onto the constraints. False: one that is not finite, or constraints that are not satisfied together.
  bool project(Wide t_s, Wide* state) {
    const Wide residual = motion.project(t_s, state);
    if (!std::all_of(state, state + y.size(), [](Wide x) { return x - x == 0; })) return fail_singular();
    if (!(residual <= Wide(kContradiction) * size_m))
      return fail("the constraints contradict one another by " + format_double(static_cast<double>(residual)), t);
    path.residual = std::max(path.residual, residual);
    return true;
  }

  std::optional<std::vector<Wide>> state_at(const std::vector<Wide>& from, Wide tau) {
    std::vector<Wide> state = from;
    if (!advance(*stepper, t, state.data(), tau) || !project(t + tau, state.data())) return std::nullopt;
    return state;
  }

  bool is_locked(int joint) {
    const auto& locks = motion.choice().locks;
    return std::any_of(locks.begin(), locks.end(), [&](const auto& lock) { return lock.joint == joint; });
  }

  // ---- stops ----
  struct Hit {
    Wide tau = 0;
    const Stop* stop = nullptr;
    std::vector<Wide> state;
  };

  // The first instant at which the gap of `stop` falls to zero in the step from `before` to y. False: failed.
  bool find_hit(const Stop& stop, const std::vector<Wide>& before, Wide taken, std::optional<Hit>& first) {
    const auto at0 = motion.coordinate(before.data(), stop.joint), at1 = motion.coordinate(y.data(), stop.joint);
    const Wide scale = 1 + magnitude(Wide(stop.limit)), tiny = Wide(kAtStop) * scale;
    const Hermite cubic{stop.gap(at0), stop.gap(at1), stop.speed(at0) * taken, stop.speed(at1) * taken};
    if (cubic.g0 <= tiny && stop.speed(at0) < -tiny) {  // the step before ended on the stop
      first = Hit{0, &stop, before};
      return true;
    }
    Wide least = cubic.g1, least_x = 1, most = 0, most_x = 0;
    constexpr int parts = 64;
    for (int k = 1; k < parts; ++k) {
      const Wide x = Wide(k) / parts, g = cubic(x);
      if (g > most && g > 0 && (least >= 0 || x < least_x)) most = g, most_x = x;
      if (g < least) least = g, least_x = x;
    }
    if (cubic.g0 > most) most = cubic.g0, most_x = 0;
    if (cubic.g1 >= 0 && least > Wide(0.05) * std::max(most, cubic.g1)) return true;
    // The bracket: a positive gap before, a negative one after.
    Wide low = 0, high = taken;
    if (!(cubic.g0 > tiny)) {  // it leaves the stop: the bracket begins at the top of its flight
      low = most_x * taken;
      for (int tries = 0;; ++tries) {
        if (tries > 40 || !(low > 0))
          return cubic.g1 >= -tiny
                     ? true
                     : fail(name(stop.joint) + " is at its stop, and neither its rate nor the force there " +
                                "decides whether it stays",
                            t);
        const auto state = state_at(before, low);
        if (!state) return fail_singular();
        if (stop.gap(motion.coordinate(state->data(), stop.joint)) > tiny) break;
        low /= 2;
      }
    }
    if (cubic.g1 >= 0) {
      if (least_x >= 1 || least_x * taken <= low) return true;
      const auto state = state_at(before, least_x * taken);
      if (!state) return fail_singular();
      const Wide g = stop.gap(motion.coordinate(state->data(), stop.joint));
      if (g > Wide(1e-9) * scale) return true;
      if (g >= 0) return fail(name(stop.joint) + " grazes its stop", t + least_x * taken);
      high = least_x * taken;
    }
    return locate(stop, before, low, high, tiny, first);
  }

  // Newton's method in the bracket.
  bool locate(const Stop& stop, const std::vector<Wide>& before, Wide low, Wide high, Wide tiny,
              std::optional<Hit>& first) {
    if (first && low >= first->tau) return true;
    Wide tau = (low + high) / 2;
    for (int tries = 0; tries < 200; ++tries) {
      auto state = state_at(before, tau);
      if (!state) return fail_singular();
      const auto qu = motion.coordinate(state->data(), stop.joint);
      const Wide g = stop.gap(qu), r = stop.speed(qu);
      if (magnitude(g) <= Wide(1e-4) * tiny || high - low <= Wide(1e-32) * (t + high)) {
        if (!(magnitude(g) <= tiny)) return fail("the impact of " + name(stop.joint) + " was not located", t + tau);
        if (!(r < 0)) return fail(name(stop.joint) + " grazes its stop", t + tau);
        if (!first || tau < first->tau) first = Hit{tau, &stop, std::move(*state)};
        return true;
      }
      if (g > 0) low = tau;
      else high = tau;
      Wide next = tau - g / r;
      if (!(r < 0) || !(next > low && next < high)) next = low + (high - low) / 2;
      tau = next;
    }
    return fail("the impact of " + name(stop.joint) + " was not located", t + tau);
  }

  void log_event(const Stop& stop, EventKind kind, Wide t_s, Wide impulse, Wide before, Wide after) {
    const Joint& joint = run.scene.joints[stop.joint];
    Event event;
    event.t_s = t_s;
    event.kind = kind;
    event.body_a = joint.parent;
    event.body_b = joint.child;
    const Sample now = motion.sample(t, y.data());
    const BodySample& child = now.bodies[joint.child];
    const dynamics::Triple<Wide> r =
        dynamics::rotate<Wide>(child.q_wxyz, dynamics::widen<Wide>(joint.anchors_body_m[1]));
    const dynamics::Triple<Wide> axis = dynamics::rotate<Wide>(child.q_wxyz, dynamics::widen<Wide>(joint.axis_body));
    for (int k = 0; k < 3; ++k) {
      event.x_m[k] = child.p_m[k] + r[k];
      event.normal[k] = stop.side * axis[k];
    }
    event.impulse_n_N_s = stop.side * impulse;
    event.vn_before_m_per_s = before;
    event.vn_after_m_per_s = after;
    path.events.push_back(event);
  }

  // Whether an impulse along one joint's coordinate moves another.
  bool coupled(int joint, int other) {
    const Wide own = motion.response(t, y.data(), joint, joint), cross = motion.response(t, y.data(), joint, other);
    return magnitude(cross) > Wide(1e-22) * magnitude(own);
  }

  bool check_coupling(const Stop& stop) {
    auto& locks = motion.choice().locks;
    const auto held = locks;
    locks.clear();
    if (!held.empty() && !choose_anew()) return false;
    for (const auto& lock : held)
      if (lock.joint != stop.joint && coupled(stop.joint, lock.joint))
        return fail("an impact of " + name(stop.joint) + " while " + name(lock.joint) +
                        " of the same mechanism rests at its stop is not covered:",
                    t);
    locks = held;
    if (!held.empty() && !choose_anew()) return false;
    for (const Stop& other : stops) {
      if (other.joint == stop.joint || is_locked(other.joint)) continue;
      const auto qu = motion.coordinate(y.data(), other.joint);
      if (magnitude(other.gap(qu)) > Wide(1e-20) * (1 + magnitude(Wide(other.limit)))) continue;
      if (other.speed(qu) < 0 && coupled(stop.joint, other.joint))
        return fail("simultaneous impacts of " + name(stop.joint) + " and " + name(other.joint) + " are not covered:",
                    t);
    }
    return true;
  }

  void lock(const Stop& stop) {
    if (motion.coordinate(y.data(), stop.joint)[1] != 0) motion.impact(t, y.data(), stop.joint, Wide(0));
    motion.choice().locks.push_back({stop.joint, stop.limit});
  }

  // At the stop with speed `before` < 0. False: failed.
  bool strike(const Stop& stop) {
    if (!choose_anew() || !check_coupling(stop)) return false;
    const Wide before = stop.speed(motion.coordinate(y.data(), stop.joint));
    const Wide impulse = motion.impact(t, y.data(), stop.joint, stop.restitution);
    const Wide after = -stop.restitution * before;
    log_event(stop, EventKind::impact, t, impulse, before, after);
    const Wide into = -stop.side * motion.acceleration(t, y.data(), stop.joint);
    if (!(into > 0)) return true;
    cap = after / into;  // half of the flight, so that no step leaps over the next impact
    const Wide span = 2 * after / (into * (1 - stop.restitution));
    if (!(stop.restitution < 1) || span > Wide(run.rest_span_s)) return true;
    lock(stop);
    if (!choose_anew() || !project(t, y.data())) return false;
    log_event(stop, EventKind::rest, t + span, Wide(0), Wide(0), Wide(0));
    return true;
  }

  // Joints that start at a stop, or have just left it by a switch of forces.
  bool hold_at_stops() {
    for (const Stop& stop : stops) {
      if (is_locked(stop.joint)) continue;
      const auto qu = motion.coordinate(y.data(), stop.joint);
      const Wide scale = 1 + magnitude(Wide(stop.limit)), g = stop.gap(qu);
      if (g < -Wide(1e-15) * scale) return fail(name(stop.joint) + " is beyond its limits", t);
      if (g > Wide(kAtStop) * scale) continue;
      const Wide speed = stop.speed(qu);
      if (speed < 0 && !strike(stop)) return false;
      if (speed == 0 && stop.side * motion.acceleration(t, y.data(), stop.joint) < 0) {
        lock(stop);
        if (!choose_anew()) return false;
        log_event(stop, EventKind::rest, t, Wide(0), Wide(0), Wide(0));
      }
    }
    return true;
  }

  // The force [N] or torque [N m] with which the stop would have to pull; negative: it presses.
  Wide pulling_force_at(const mechanism::StepChoice::Lock& lock, const Wide* state, Wide t_s) {
    const Joint& joint = run.scene.joints[lock.joint];
    const int side = lock.coordinate == joint.limits->lower ? 1 : -1;
    return -side * motion.stop_force(t_s, state, lock.joint);
  }
  bool release() {
    auto& locks = motion.choice().locks;
    for (std::size_t k = 0; k < locks.size(); ++k)
      if (pulling_force_at(locks[k], y.data(), t) > 0) {
        for (const Stop& stop : stops)
          if (stop.joint == locks[k].joint && stop.limit == locks[k].coordinate)
            log_event(stop, EventKind::separate, t, Wide(0), Wide(0), Wide(0));
        locks.erase(locks.begin() + static_cast<std::ptrdiff_t>(k));
        if (!choose_anew()) return false;
        return release();
      }
    return true;
  }

  // The first instant of the step at which `value` is positive, to 31 digits; nothing: it is not positive at the step's
  // end. False position, the value at the end that stays being halved. located: false after 100 evaluations, or where a
  // part of the step failed.
  struct Crossing {
    std::optional<Wide> tau;
    bool located = true;
  };
  template <class Value> Crossing first_positive(const std::vector<Wide>& before, Wide taken, const Value& value) {
    const Wide at_end = value(y.data(), t + taken);
    if (!(at_end > 0)) return {};
    Wide low = 0, high = taken, f_low = value(before.data(), t), f_high = at_end;
    if (!(f_low < 0)) return {Wide(0)};
    for (int tries = 0; high - low > Wide(1e-31) * (t + high); ++tries) {
      if (tries == 100) return {high, false};
      Wide x = high - f_high * (high - low) / (f_high - f_low);
      if (!(x > low && x < high)) x = low + (high - low) / 2;
      const auto state = state_at(before, x);
      if (!state) return {high, false};
      const Wide f = value(state->data(), t + x);
      if (f > 0) {
        high = x, f_high = f;
        f_low /= 2;
      } else {
        low = x, f_low = f;
        f_high /= 2;
      }
      if (f == 0) break;
    }
    return {high};
  }

  // ---- the step ----
  bool check_ropes(const std::vector<Wide>& before, Wide taken) {
    if (run.scene.ropes.empty()) return true;
    if (motion.off_plane(y.data()) > Wide(1e-12) * size_m) return fail("a rope leaves the plane of its pulley", t);
    std::optional<Wide> earliest;
    std::string why;
    const auto compare = [&](const Crossing& found, const std::string& what) {
      if (!found.located) return fail("the instant was not located at which " + what, t);
      if (found.tau && (!earliest || *found.tau < *earliest)) earliest = found.tau, why = what;
      return true;
    };
    for (std::size_t k = 0; k < run.scene.ropes.size(); ++k) {
      const std::string rope = "rope `" + run.scene.ropes[k].name + "`";
      const int index = static_cast<int>(k);
      const auto uncovered = [&](const Wide* state, Wide) { return ropes.uncovered(state, index); };
      const auto pushing = [&](const Wide* state, Wide t_s) { return -motion.sample(t_s, state).ropes[k].tension_N; };
      if (ropes.reaches_pulley(y.data(), index)) compare({taken}, rope + ": an end reaches its pulley");
      if (!compare(first_positive(before, taken, uncovered), rope + " leaves its pulley") ||
          !compare(first_positive(before, taken, pushing), rope + " is slack"))
        return false;
    }
    return earliest ? fail(why, t + *earliest) : true;
  }
  bool step_to(Wide target) {
    if (!choose()) return false;
    const std::vector<Wide> before = y;
    const Wide left = target - t, longest = motion.longest_step(y.data());
    Wide limit = cap > 0 && cap < left ? cap : left;
    if (longest > 0 && longest < limit) limit = longest;
    limit = ropes.limit(y.data(), limit);
    Wide taken = stepper->step(t, y.data(), limit);
    if (!(taken > 0)) return fail_singular();
    // Steps that shrink towards a singularity would go on until the clock has no digit left.
    short_steps = taken < limit && taken < Wide(kShortStep) * run.t_end_s ? short_steps + 1 : 0;
    if (short_steps > kMaxShortSteps) return fail_singular();
    if (stepper->evaluations > kMaxRateWork / std::max<std::int64_t>(1, motion.size()))
      return fail("the truth has taken the " + std::to_string(stepper->evaluations) +
                      " evaluations of the rates that it is limited to",
                  t);
    if (!project(t + taken, y.data())) return false;
    if (motion.turned_over(t + taken, y.data())) {
      y = before;
      cap = taken / 4;
      return cap > Wide(1e-9) * run.t_end_s ? true : fail_singular();
    }
    cap *= 2;
    if (!check_ropes(before, taken)) return false;
    std::optional<Hit> hit;
    for (const Stop& stop : stops)
      if (!is_locked(stop.joint) && !find_hit(stop, before, taken, hit)) return false;
    // A joint leaves its stop before anything hits one.
    std::optional<Wide> leaves;
    for (const auto& lock : motion.choice().locks) {
      const Crossing found = first_positive(
          before, taken, [&](const Wide* state, Wide t_s) { return pulling_force_at(lock, state, t_s); });
      if (!found.located)
        return fail("the instant was not located at which " + name(lock.joint) + " leaves its stop", t);
      if (found.tau && (!leaves || *found.tau < *leaves)) leaves = found.tau;
    }
    if (leaves && (!hit || *leaves < hit->tau)) {
      const auto state = state_at(before, *leaves);
      if (!state) return fail_singular();
      y = *state;
      t += *leaves;
      return release();
    }
    if (hit) {
      y = std::move(hit->state);
      t += hit->tau;
      return strike(*hit->stop);
    }
    t = taken == left ? target : t + taken;
    return true;
  }

  bool integrate_to(Wide target) {
    while (t < target)
      if (!step_to(target)) return false;
    return true;
  }

  bool take_sample() {
    if (!choose()) return false;
    path.samples.push_back(motion.sample(t, y.data()));
    return true;
  }

  void go() {
    const std::vector<double>& switches = motion.switch_times();
    enter_interval();
    if (!choose() || !project(t, y.data())) return;
    if (!take_sample() || !hold_at_stops()) return;
    ropes.begin(y.data());
    for (std::size_t k = 0; k < run.scene.ropes.size(); ++k) {
      const std::string rope = "rope `" + run.scene.ropes[k].name + "`";
      if (path.samples[0].ropes[k].tension_N < 0) return void(fail(rope + " is slack", t));
      if (ropes.uncovered(y.data(), static_cast<int>(k)) > 0) return void(fail(rope + " leaves its pulley", t));
    }
    for (std::int64_t k = 1; k <= run.samples; ++k) {
      const Wide target = Wide(run.t_end_s) * Wide(k) / Wide(run.samples);
      for (; interval < static_cast<int>(switches.size()) && switches[interval] <= target;) {
        if (!integrate_to(Wide(switches[interval]))) return;
        ++interval;
        enter_interval();
        if (!release() || !hold_at_stops()) return;
      }
      if (!integrate_to(target) || !take_sample()) return;
    }
  }
};

}  // namespace

MechanismPath integrate_mechanism(MechanismMotion& motion, const Sample& start, const MechanismRun& run) {
  Integration integration(motion, start, run);
  integration.go();
  if (integration.path.failure.empty()) integration.path.end_s = integration.t;
  integration.path.steps = integration.stepper->steps;
  integration.path.evaluations = integration.stepper->evaluations;
  return std::move(integration.path);
}

}  // namespace atwood::extended
