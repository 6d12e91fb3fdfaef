#include "extended/mechanism_path.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "dynamics/arithmetic.hpp"
#include "dynamics/certified_end.hpp"
#include "extended/mechanism_ropes.hpp"
#include "extended/mechanism_stop.hpp"
#include "extended/step_course.hpp"

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
constexpr double kLocation = 1e-4 * kAtStop;        // to which a gap is located
constexpr double kGraze = 1e-20;  // a stop's least gap of which the runs cannot tell whether it is zero

struct Integration {
  MechanismMotion& motion;
  const MechanismRun& run;
  std::unique_ptr<Stepper<Wide>> stepper;
  std::vector<Stop> stops;
  std::vector<Wide> y;
  Wide t = 0;
  double size_m = 1;
  int interval = 0, rank = -1;
  Wide cap = 0;      // largest step; 0: none
  Wide longest = 0;  // of the free grid's steps; 0: no limit
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
  // undecided: a shorter step can tell.
  bool find_hit(const Stop& stop, const StepCourse<Wide>& step, const std::vector<Wide>& before, Wide taken,
                std::optional<Hit>& first, bool& undecided) {
    const auto at0 = motion.coordinate(before.data(), stop.joint), at1 = motion.coordinate(y.data(), stop.joint);
    const Wide scale = 1 + magnitude(Wide(stop.limit)), tiny = Wide(kAtStop) * scale;
    const Wide g0 = stop.gap(at0), g1 = stop.gap(at1);
    if (g0 <= tiny && stop.speed(at0) < -tiny) {  // the step before ended on the stop
      first = Hit{0, &stop, before};
      return true;
    }
    const Course course =
        step.of([&](Wide, const Wide* state) { return stop.gap(motion.coordinate(state, stop.joint)); });
    if (course.is_positive()) return true;
    if (!course.has_slopes(static_cast<double>(stop.speed(at0) * taken), static_cast<double>(stop.speed(at1) * taken),
                           static_cast<double>(Wide(kLocation) * scale))) {
      undecided = true;
      return true;
    }
    for (const Minimum& at : course.minima) {
      if (at.value > course.error) continue;
      if (!course.shows(at)) {
        undecided = true;
        return true;
      }
      if (at.left == 0 && stop.speed(at0) >= -tiny) continue;  // the least gap was earlier
      Hit least;
      if (!find_least(stop, before, at, taken, least, undecided)) return false;
      if (undecided) return true;
      const Wide g = stop.gap(motion.coordinate(least.state.data(), stop.joint));
      if (magnitude(g) <= Wide(kGraze) * scale) return fail(name(stop.joint) + " grazes its stop", t + least.tau);
      if (g > 0) continue;
      const Wide low = Wide(at.left) * taken;
      return at.left > 0 || g0 > tiny ? locate(stop, before, low, least.tau, tiny, first)
                                      : leave_and_locate(stop, before, least.tau / 2, least.tau, g, tiny, first);
    }
    if (g1 >= 0) return true;
    if (g0 > tiny && course.minima.empty()) return locate(stop, before, 0, taken, tiny, first);
    const double top = course.last_maximum > 0 && course.last_maximum < 1 ? course.last_maximum : 0.5;
    return leave_and_locate(stop, before, Wide(top) * taken, taken, g1, tiny, first);
  }

  // The least gap between two places of the step, where the joint's rate is zero: false position, the value at the end
  // that stays being halved (Illinois). It ends early beyond the stop, and where the gap cannot close any more.
  bool find_least(const Stop& stop, const std::vector<Wide>& before, const Minimum& at, Wide taken, Hit& least,
                  bool& undecided) {
    const Wide scale = 1 + magnitude(Wide(stop.limit));
    const auto speed_at = [&](Wide tau, Wide& speed) {
      auto state = state_at(before, tau);
      if (!state) return fail_singular();
      least = Hit{tau, &stop, std::move(*state)};
      speed = stop.speed(motion.coordinate(least.state.data(), stop.joint));
      return true;
    };
    Wide low = Wide(at.left) * taken, high = Wide(at.right) * taken, s_low{}, s_high{}, s{};
    if (!speed_at(low, s_low) || !speed_at(high, s_high)) return false;
    undecided = !(s_low < 0 && s_high > 0);
    for (int tries = 0; tries < 200 && !undecided; ++tries) {
      Wide x = low + (high - low) * s_low / (s_low - s_high);
      if (tries % 4 == 3 || !(x > low && x < high)) x = low + (high - low) / 2;
      if (!speed_at(x, s)) return false;
      const Wide g = stop.gap(motion.coordinate(least.state.data(), stop.joint)),
                 left = 4 * magnitude(s) * (high - low);
      if (g < -Wide(kGraze) * scale || g > 64 * left + Wide(kGraze) * scale || left <= Wide(kAtStop) * scale)
        return true;
      if (s < 0) low = x, s_low = s, s_high /= 2;
      else high = x, s_high = s, s_low /= 2;
    }
    return undecided || fail("the least gap of " + name(stop.joint) + " to its stop was not located", t + least.tau);
  }

  // The joint leaves the stop and comes back: the bracket begins where it has left.
  bool leave_and_locate(const Stop& stop, const std::vector<Wide>& before, Wide low, Wide high, Wide gap_high,
                        Wide tiny, std::optional<Hit>& first) {
    for (int tries = 0; tries <= 40 && low > 0; ++tries, low /= 2) {
      const auto state = state_at(before, low);
      if (!state) return fail_singular();
      if (stop.gap(motion.coordinate(state->data(), stop.joint)) > tiny)
        return locate(stop, before, low, high, tiny, first);
    }
    if (gap_high >= -tiny) return true;
    return fail(name(stop.joint) + " is at its stop, and neither its rate nor the force there decides whether it stays",
                t);
  }

  // All runs locate an impact by the same gap, whose round-off they share: on the free grid it is located as late as
  // that round-off allows, so that the runs' difference has what an error of the location makes of the motion.
  bool shift_location(const std::vector<Wide>& before, Hit& hit) {
    const Wide speed = magnitude(hit.stop->speed(motion.coordinate(hit.state.data(), hit.stop->joint)));
    if (run.grid != Grid::free || !(hit.tau > 0) || !(speed > 0)) return true;
    hit.tau += Wide(kLocation) * (1 + magnitude(Wide(hit.stop->limit))) / speed;
    auto state = state_at(before, hit.tau);
    if (!state) return fail_singular();
    hit.state = std::move(*state);
    return true;
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
  // `leaving`: the joint whose stop's force has just been found to fall to zero; -1: none.
  bool release(int leaving = -1) {
    auto& locks = motion.choice().locks;
    for (std::size_t k = 0; k < locks.size(); ++k)
      if (locks[k].joint == leaving || pulling_force_at(locks[k], y.data(), t) > 0) {
        for (const Stop& stop : stops)
          if (stop.joint == locks[k].joint && stop.limit == locks[k].coordinate)
            log_event(stop, EventKind::separate, t, Wide(0), Wide(0), Wide(0));
        locks.erase(locks.begin() + static_cast<std::ptrdiff_t>(k));
        if (!choose_anew()) return false;
        return release();
      }
    return true;
  }

  // Where a switching function first falls below zero in the step from `before`; what: what happens there. False:
  // failed. undecided: a shorter step can tell.
  template <class Value>
  bool find_fall(const StepCourse<Wide>& step, const std::vector<Wide>& before, const Value& value,
                 const std::string& what, std::optional<Wide>& tau, bool& undecided) {
    const Fall<Wide> fall = first_fall<Wide>(step, value, [&](Wide at) -> std::optional<Wide> {
      const auto state = state_at(before, at);
      if (!state) return std::nullopt;
      return value(t + at, state->data());
    });
    undecided = undecided || fall.undecided;
    if (!fall.located) return fail("the instant was not located at which " + what, t);
    if (fall.grazes) return fail("it is not decided within round-off whether " + what, t + *fall.grazes);
    tau = fall.tau;
    return true;
  }

  // ---- the step ----
  bool check_ropes(const StepCourse<Wide>& step, const std::vector<Wide>& before, Wide taken, bool& undecided) {
    if (run.scene.ropes.empty()) return true;
    if (motion.off_plane(y.data()) > Wide(1e-12) * size_m) return fail("a rope leaves the plane of its pulley", t);
    std::optional<Wide> earliest;
    std::string why;
    const auto compare = [&](const std::optional<Wide>& tau, const std::string& what) {
      if (tau && (!earliest || *tau < *earliest)) earliest = tau, why = what;
    };
    for (std::size_t k = 0; k < run.scene.ropes.size(); ++k) {
      const std::string rope = "rope `" + run.scene.ropes[k].name + "`";
      const int index = static_cast<int>(k);
      const auto covered = [&](Wide, const Wide* state) { return -ropes.uncovered(state, index); };
      const auto pulling = [&](Wide t_s, const Wide* state) { return motion.sample(t_s, state).ropes[k].tension_N; };
      if (ropes.reaches_pulley(y.data(), index)) compare({taken}, rope + ": an end reaches its pulley");
      std::optional<Wide> leaves, slack;
      if (!find_fall(step, before, covered, rope + " leaves its pulley", leaves, undecided) ||
          !find_fall(step, before, pulling, rope + " is slack", slack, undecided))
        return false;
      compare(leaves, rope + " leaves its pulley");
      compare(slack, rope + " is slack");
    }
    return earliest && !undecided ? fail(why, t + *earliest) : true;
  }

  // What happens first in a step.
  struct Happening {
    std::optional<Hit> hit;
    std::optional<Wide> leaves;  // a joint leaves its stop, before anything hits one
    int leaving = -1;
    bool undecided = false;
  };
  bool find_happening(const StepCourse<Wide>& step, const std::vector<Wide>& before, Wide taken, Happening& found) {
    if (!check_ropes(step, before, taken, found.undecided)) return false;
    for (const Stop& stop : stops)
      if (!found.undecided && !is_locked(stop.joint) &&
          !find_hit(stop, step, before, taken, found.hit, found.undecided))
        return false;
    for (const auto& lock : motion.choice().locks) {
      const auto pressing = [&](Wide t_s, const Wide* state) { return -pulling_force_at(lock, state, t_s); };
      std::optional<Wide> tau;
      if (!find_fall(step, before, pressing, name(lock.joint) + " leaves its stop", tau, found.undecided)) return false;
      if (tau && (!found.leaves || *tau < *found.leaves)) found.leaves = tau, found.leaving = lock.joint;
    }
    if (found.leaves && found.hit && found.hit->tau <= *found.leaves) found.leaves.reset();
    return true;
  }

  // One step of at most `limit` onto the constraints. 0: failed. Negative: y is as before, and the next step is
  // shorter.
  Wide constrained_step(Wide limit, const std::vector<Wide>& before, std::optional<StepCourse<Wide>>& course) {
    const Wide taken = stepper->step(t, y.data(), limit);
    if (!(taken > 0)) return fail_singular();
    if (!stops.empty() || !run.scene.ropes.empty()) course.emplace(stepper->dense());
    // Steps that shrink towards a singularity would go on until the clock has no digit left.
    short_steps = taken < limit && taken < Wide(kShortStep) * run.t_end_s ? short_steps + 1 : 0;
    if (short_steps > kMaxShortSteps) return fail_singular();
    if (stepper->evaluations > kMaxRateWork / std::max<std::int64_t>(1, motion.size()))
      return fail("the truth has taken the " + std::to_string(stepper->evaluations) +
                      " evaluations of the rates that it is limited to",
                  t);
    if (!project(t + taken, y.data())) return 0;
    if (!motion.turned_over(t + taken, y.data())) return taken;
    y = before;
    cap = taken / 4;
    if (cap > Wide(1e-9) * run.t_end_s) return -1;
    return fail_singular();
  }

  Wide sample_time(std::int64_t k) const { return Wide(run.t_end_s) * Wide(k) / Wide(run.samples); }
  std::int64_t sampled() const { return static_cast<std::int64_t>(path.samples.size()); }

  // The samples of the free grid that lie inside a step, until `reached`.
  bool take_samples(const std::vector<Wide>& before, Wide reached) {
    while (run.grid == Grid::free && sampled() < run.samples && sample_time(sampled()) < reached) {
      const Wide at = sample_time(sampled());
      const auto state = state_at(before, at - t);
      if (!state) return fail_singular();
      path.samples.push_back(motion.sample(at, state->data()));
    }
    return true;
  }

  bool step_to(Wide target) {
    if (!choose()) return false;
    const std::vector<Wide> before = y;
    const Wide left = target - t, turn = motion.longest_step(y.data());
    Wide limit = cap > 0 && cap < left ? cap : left;
    for (const Wide most : {turn, longest})
      if (most > 0 && most < limit) limit = most;
    limit = ropes.limit(y.data(), limit);
    Happening found;
    Wide taken = 0;
    for (;;) {
      std::optional<StepCourse<Wide>> course;
      taken = constrained_step(limit, before, course);
      if (taken < 0) return true;
      if (!(taken > 0)) return false;
      found = {};
      if (course && !find_happening(*course, before, taken, found)) return take_samples(before, path.end_s) && false;
      if (!found.undecided) break;
      cap = limit = taken / 2;
      if (!(limit > Wide(kShortestSearch) * run.t_end_s))
        return fail("whether a joint reaches or leaves a stop or a rope is slack is not decided", t);
      y = before;
    }
    cap *= 2;
    const Wide reached = found.leaves    ? t + *found.leaves
                         : found.hit     ? t + found.hit->tau
                         : taken == left ? target
                                         : t + taken;
    if (!take_samples(before, reached)) return false;
    if (found.leaves) {
      const auto state = state_at(before, *found.leaves);
      if (!state) return fail_singular();
      y = *state;
      t = reached;
      return release(found.leaving);
    }
    if (found.hit) {
      if (!shift_location(before, *found.hit)) return false;
      y = std::move(found.hit->state);
      t += found.hit->tau;
      return strike(*found.hit->stop);
    }
    t = reached;
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
    enter_interval();
    if (!choose() || !project(t, y.data())) return;
    if (!take_sample() || !hold_at_stops()) return;
    ropes.begin(y.data());
    for (std::size_t k = 0; k < run.scene.ropes.size(); ++k) {
      const std::string rope = "rope `" + run.scene.ropes[k].name + "`";
      if (path.samples[0].ropes[k].tension_N < 0) return void(fail(rope + " is slack", t));
      if (ropes.uncovered(y.data(), static_cast<int>(k)) > 0) return void(fail(rope + " leaves its pulley", t));
    }
    while (sampled() <= run.samples) {
      if (!pass_switches(sample_time(run.grid == Grid::free ? run.samples : sampled())) || !take_sample()) return;
    }
  }

  // To `target`, switching on the way; a switch at the target itself is passed. False: failed.
  bool pass_switches(Wide target) {
    const std::vector<double>& switches = motion.switch_times();
    const bool free = run.grid == Grid::free;
    while (interval < static_cast<int>(switches.size()) && switches[interval] <= target) {
      const Wide until = Wide(switches[interval]);
      if (free) longest = Wide(kFreeShare) * (until - t);
      if (!integrate_to(until)) return false;
      ++interval;
      enter_interval();
      if (!release() || !hold_at_stops()) return false;
    }
    if (free) longest = Wide(kFreeShare) * (target - t);
    return integrate_to(target);
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
