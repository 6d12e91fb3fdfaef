// A body on a hinge or slider under a constant force along the coordinate, whose stops give back a part e of the rate
// (Newton's restitution). Flights are parabolas; after an impact with rate V at a stop that the force pushes against,
// and from which the coordinate does not reach the other stop, the flights take 2 e V / |a|, 2 e^2 V / |a|, ...: all
// end 2 e V / (|a| (1 - e)) after the impact, and the coordinate stays at the stop.
#include <algorithm>

#include "closed_form/mechanism.hpp"

namespace atwood::closed_form {

namespace {

constexpr std::size_t kMaxStopImpacts = 1000000;

template <class S> struct Flight { S t{}, q{}, u{}; };  // from an impact, or the start
template <class S> struct Impact {
  S t{}, before{}, after{};
  bool at_lower = false;
};

template <class S> struct Bouncing {
  S a{}, e{}, lower{}, upper{}, inertia{};
  std::vector<Flight<S>> flights;
  std::vector<Impact<S>> impacts;
  S rest_t{}, rest_q{};
  bool rests = false, rests_at_lower = false;

  // Time until a gap h >= 0 with rate u and acceleration a closes; negative: never. `square`: of the rate there.
  static S closing_time(S h, S u, S a, S square) {
    if (h == 0 && u >= 0) return a < 0 && u > 0 ? -2 * u / a : S(-1);
    if (square < 0) return -1;
    if (u < 0) return 2 * h / (sqrt(square) - u);
    return a < 0 ? -(u + sqrt(square)) / a : S(-1);
  }

  std::string follow(S q0, S u0, S t_end) {
    flights.push_back({0, q0, u0});
    if ((q0 == lower && a < 0 && u0 == 0) || (q0 == upper && a > 0 && u0 == 0)) {
      rests = true;
      rest_q = q0;
      rests_at_lower = q0 == lower;
      return "";
    }
    while (true) {
      const Flight<S> now = flights.back();
      // Elastic stops keep the energy: taken from the start, a return to a stop at which it was at rest has no rate.
      const Flight<S>& from = e == 1 ? flights.front() : now;
      const S low = from.u * from.u + 2 * a * (lower - from.q), high = from.u * from.u + 2 * a * (upper - from.q);
      const S down = closing_time(now.q - lower, now.u, a, low), up = closing_time(upper - now.q, -now.u, -a, high);
      if (down < 0 && up < 0) return "";
      const bool at_lower = up < 0 || (down >= 0 && down < up);
      const S push = at_lower ? a : -a, V = sqrt(larger(S(0), at_lower ? low : high));
      const S t = now.t + (at_lower ? down : up);
      if (!(t <= t_end)) return "";
      if (impacts.size() >= kMaxStopImpacts) return "more than " + std::to_string(kMaxStopImpacts) + " impacts";
      const S back = e * V;
      impacts.push_back({t, -V, back, at_lower});
      flights.push_back({t, at_lower ? lower : upper, at_lower ? back : -back});
      const bool settles = push < 0 && e < 1 && back * back < -2 * push * (upper - lower);
      if (!settles && back > 0) continue;
      if (!settles && push >= 0) {  // without restitution it stops there; a force away from the stop starts it again
        if (push == 0) return "";
        continue;
      }
      const S remaining = -2 * back / (push * (1 - e));
      rests = true;
      rest_t = t + remaining;
      rest_q = at_lower ? lower : upper;
      rests_at_lower = at_lower;
      // Bounces whose times equal the end in double have no events of their own.
      if (back == 0 || remaining < S(0x1p-53) * rest_t) return "";
      rests = false;
    }
  }

  JointState<S> at(S t) const {
    JointState<S> made;
    made.q[0] = rest_q;
    made.locked = rests && t >= rest_t;
    if (made.locked) return made;
    auto after =
        std::upper_bound(flights.begin(), flights.end(), t, [](S time, const Flight<S>& f) { return time < f.t; });
    const Flight<S>& from = *(after - 1);
    const S since = t - from.t;
    made.q[0] = from.q + since * (from.u + a * since / 2);
    made.u[0] = from.u + a * since;
    made.du[0] = a;
    if (from.u == 0 && a == 0) made.du[0] = 0;
    return made;
  }
};

template <class S> std::string build(const Scene& scene, std::size_t index, S t_end, Bouncing<S>& made) {
  const Joint& joint = scene.joints[index];
  S gravity;
  if (const std::string why = single_joint(scene, index, made.inertia, gravity); !why.empty()) return why;
  if (!joint.limits) return "the joint `" + joint.name + "` has no limits";
  made.a = gravity;
  for (const JointForce& force : scene.joint_forces)
    if (const auto* motor = std::get_if<JointTorque>(&force);
        motor != nullptr && motor->joint == static_cast<int>(index))
      made.a += S(motor->torque) * cos(S(motor->phase_rad));
  made.a /= made.inertia;
  made.e = joint.limits->restitution;
  made.lower = joint.limits->lower;
  made.upper = joint.limits->upper;
  const JointState<S> start = initial_joint<S>(joint);
  if (!(made.lower < made.upper && made.lower <= start.q[0] && start.q[0] <= made.upper))
    return "the joint `" + joint.name + "` starts outside its limits";
  if ((start.q[0] == made.lower && start.u[0] < 0) || (start.q[0] == made.upper && start.u[0] > 0))
    return "the joint `" + joint.name + "` starts at a stop with a rate towards it";
  return made.follow(start.q[0], start.u[0], t_end);
}

template <class S>
void add_events(const Scene& scene, std::size_t index, const Bouncing<S>& path, S t_end, Motion<S>& motion) {
  const Joint& joint = scene.joints[index];
  const auto add = [&](EventKind kind, S t, bool at_lower, S before, S after) {
    std::vector<JointState<S>> joints;
    for (const Joint& each : scene.joints) joints.push_back(initial_joint<S>(each));
    joints[index].q[0] = at_lower ? path.lower : path.upper;
    const Pose<S> child = place_bodies(scene, joints)[static_cast<std::size_t>(joint.child)].pose;
    ContactEvent<S> made;
    made.t_s = t;
    made.kind = kind;
    made.body_a = joint.parent;
    made.body_b = joint.child;
    made.x_W = child.p_WB + rotate(child.q_WB, vec<S>(joint.anchors_body_m[1]));
    made.normal_W = S(at_lower ? 1 : -1) * rotate(child.q_WB, unit<S>(joint.axis_body));
    made.impulse_n_N_s = path.inertia * (after - before);
    made.vn_before_m_per_s = before;
    made.vn_after_m_per_s = after;
    motion.events.push_back(made);
  };
  for (const Impact<S>& impact : path.impacts)
    if (impact.before != 0) add(EventKind::impact, impact.t, impact.at_lower, impact.before, impact.after);
  if (path.rests && path.rest_t > 0 && path.rest_t <= t_end)
    add(EventKind::rest, path.rest_t, path.rests_at_lower, 0, 0);
}

template <class S> Motion<S> solve_joint_stop(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> refused;
  refused.refusal = not_a_tree(scene);
  if (refused.refusal.empty() && scene.joints.empty()) refused.refusal = "expected a hinge or slider; found none";
  std::vector<Bouncing<S>> all(scene.joints.size());
  for (std::size_t j = 0; j < all.size() && refused.refusal.empty(); ++j)
    refused.refusal = build(scene, j, S(scenario.t_end_s), all[j]);
  if (!refused.refusal.empty()) return refused;
  Motion<S> motion = move_mechanism<S>(scenario, t_s, [&](S t) {
    std::vector<JointState<S>> joints;
    for (const Bouncing<S>& each : all) joints.push_back(each.at(t));
    return joints;
  });
  for (std::size_t j = 0; j < all.size(); ++j) add_events(scene, j, all[j], S(scenario.t_end_s), motion);
  std::stable_sort(motion.events.begin(), motion.events.end(),
                   [](const ContactEvent<S>& x, const ContactEvent<S>& y) { return x.t_s < y.t_s; });
  return motion;
}

}  // namespace

Solution joint_stop() {
  return {"joint-stop",
          "a hinge or slider under a constant force between stops: geometric series of flights, Newton's restitution",
          feature::uniform_gravity | feature::spin | feature::hinge | feature::slider | feature::joint_torque |
              feature::joint_limits,
          solve_joint_stop<Narrow>, solve_joint_stop<Wide>};
}

}  // namespace atwood::closed_form
