#include "cvode/walk.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/arithmetic.hpp"

namespace atwood::cvode {

namespace {

using dynamics::ContactPair;
using Vector = dynamics::Triple<double>;

constexpr int most_impacts = 20000;
// Flights shorter than this part of the run end a bouncing series: the rest is summed as the geometric series it is.
constexpr double last_flight = 1e-5;

int ball_of(const Scene& scene, const ContactPair& pair) {
  if (std::holds_alternative<Plane>(scene.bodies[pair.a].shape)) return pair.b;
  return std::holds_alternative<Plane>(scene.bodies[pair.b].shape) ? pair.a : -1;
}

Event event_at(double t_s, EventKind kind, const ContactPair& pair, const dynamics::Gap<double>& where) {
  Event event;
  event.t_s = t_s;
  event.kind = kind;
  event.body_a = pair.a;
  event.body_b = pair.b;
  std::copy(where.x_m.begin(), where.x_m.end(), event.x_m.begin());
  std::copy(where.normal.begin(), where.normal.end(), event.normal.begin());
  return event;
}

struct Walk {
  const Scene& scene;
  double t_end_s;
  const Observer& observer;
  dynamics::Dynamics<double> dynamics;
  std::vector<ContactPair> pairs;
  std::vector<bool> resting;
  Solver solver;
  int interval = 0, impacts = 0;
  double t_s = 0;
  std::string failure;

  Walk(const Scene& s, double t_end, Formula formula, const Tolerance& tolerance, const Observer& o)
      : scene(s), t_end_s(t_end), observer(o), dynamics(s, t_end), pairs(dynamics::contact_pairs(s).pairs),
        resting(pairs.size()), solver(s, dynamics, pairs, formula, tolerance) {}

  void tell(const Event& event) const {
    if (observer.event) observer.event(event);
  }
  dynamics::Gap<double> gap(const ContactPair& pair) { return dynamics::gap(scene, dynamics.layout(), pair, solver.y()); }

  // All flights to come take 2 v / (a (1 - e)), a the pull towards the plane. True: the ball now lies on it.
  bool rests(int index) {
    const ContactPair& pair = pairs[static_cast<std::size_t>(index)];
    const int ball = ball_of(scene, pair);
    if (ball < 0 || pair.restitution >= 1) return false;
    const auto now = gap(pair);
    std::vector<double> dydt(static_cast<std::size_t>(dynamics.size()));
    dynamics.rate(t_s, solver.y(), dydt.data(), interval);
    const int at = dynamics.layout().slots[static_cast<std::size_t>(ball)].velocity;
    const double towards_b = dynamics::dot(dynamics::read3(dydt.data() + at), now.normal);
    const double pull = ball == pair.b ? -towards_b : towards_b;
    const double speed = std::fabs(now.rate_m_per_s);
    if (!(pull > 0) || 2 * speed / pull > last_flight * t_end_s) return false;
    const double rest_s = t_s + 2 * speed / (pull * (1 - pair.restitution));
    const double outward = ball == pair.b ? now.rate_m_per_s : -now.rate_m_per_s;
    const double sign = ball == pair.b ? 1 : -1;
    for (int k = 0; k < 3; ++k) solver.y()[at + k] -= sign * outward * now.normal[static_cast<std::size_t>(k)];
    const int plane = ball == pair.b ? pair.a : pair.b;
    dynamics.hold_on_plane(ball, std::get<Plane>(scene.bodies[static_cast<std::size_t>(plane)].shape).normal);
    solver.retire(index);
    resting[static_cast<std::size_t>(index)] = true;
    if (rest_s <= t_end_s) tell(event_at(rest_s, EventKind::rest, pair, now));
    return true;
  }

  bool strike(int index) {
    const ContactPair& pair = pairs[static_cast<std::size_t>(index)];
    if (++impacts > most_impacts) {
      failure = "more than 20000 impacts";
      return false;
    }
    const auto before = gap(pair);
    Event event = event_at(t_s, EventKind::impact, pair, before);
    event.impulse_n_N_s = dynamics::strike(scene, dynamics.layout(), pair, solver.y());
    event.vn_before_m_per_s = before.rate_m_per_s;
    event.vn_after_m_per_s = gap(pair).rate_m_per_s;
    tell(event);
    rests(index);
    solver.start(t_s, interval);
    return true;
  }

  bool go_to(double target_s, double stop_s) {
    while (t_s < target_s) {
      const Reached reached = solver.advance(target_s, stop_s);
      t_s = reached.touched < 0 ? target_s : reached.t_s;
      failure = reached.failure;
      if (!failure.empty()) return false;
      if (reached.touched >= 0 && !strike(reached.touched)) return false;
    }
    return true;
  }

  void sample(std::int64_t k, std::int64_t samples) {
    if (!observer.sample) return;
    Sample out = dynamics::unpack(scene, t_s, static_cast<const double*>(solver.y()));
    out.t_s = Wide(t_end_s) * Wide(k) / Wide(samples);
    observer.sample(out);
  }

  // Balls that lie on a plane from the start.
  void settle_at_start() {
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      const auto now = gap(pairs[i]);
      if (std::fabs(now.gap_m) > 1e-12 || now.rate_m_per_s > 0) continue;
      if (now.rate_m_per_s < 0) strike(static_cast<int>(i));
      else rests(static_cast<int>(i));
    }
    solver.start(0, interval);
  }

  void run(std::int64_t samples) {
    const auto& switches = dynamics.switch_times();
    std::size_t next = 0;
    settle_at_start();
    if (samples > 0) sample(0, samples);
    const std::int64_t targets = std::max<std::int64_t>(samples, 1);
    for (std::int64_t k = 1; k <= targets; ++k) {
      const double target_s = k == targets ? t_end_s : t_end_s * static_cast<double>(k) / static_cast<double>(targets);
      for (; next < switches.size() && switches[next] <= target_s; ++next) {
        if (!go_to(switches[next], switches[next])) return;
        solver.start(t_s, ++interval);
      }
      if (!go_to(target_s, next < switches.size() ? switches[next] : t_end_s)) return;
      if (samples > 0) sample(k, samples);
    }
  }
};

}  // namespace

std::string refusal(const Scene& scene) {
  if (const auto reason = dynamics::unsupported(scene); !reason.empty()) return "cvode: " + reason;
  const auto contacts = dynamics::contact_pairs(scene);
  if (!contacts.unsupported.empty()) return "cvode locates no contact of " + contacts.unsupported;
  for (const auto& pair : contacts.pairs) {
    if (pair.friction > 0) {
      return "cvode's impacts are without friction; `" + scene.bodies[static_cast<std::size_t>(pair.a)].name + "` and `" +
             scene.bodies[static_cast<std::size_t>(pair.b)].name + "` have friction " + format_double(pair.friction);
    }
  }
  return "";
}

Outcome walk(const Scene& scene, double t_end_s, std::int64_t samples, Formula formula, const Tolerance& tolerance,
             const Observer& observer) {
  Outcome outcome;
  Walk going(scene, t_end_s, formula, tolerance, observer);
  going.run(samples);
  outcome.rate_evaluations = going.solver.rate_evaluations();
  outcome.steps_taken = going.solver.steps();
  if (!going.failure.empty()) {
    outcome.status = Status::diverged;
    outcome.reason = going.failure;
  }
  return outcome;
}

}  // namespace atwood::cvode
