#include "joint_check.hpp"

#include <algorithm>

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

// What a joint holds still: its parent's side, in world axes.
struct Ground {
  Long3 anchor{};
  Long4 q{1, 0, 0, 0};  // of the joint's frame
};

Ground ground_of(const Scene& scene, const Joint& joint) {
  Ground made;
  made.anchor = widened(joint.anchors_body_m[0]);
  made.q = normalised(joint.frame_wxyz);
  if (joint.parent < 0) return made;
  const Body& parent = scene.bodies[static_cast<std::size_t>(joint.parent)];
  const Long4 q = normalised(parent.orientation_wxyz);
  made.anchor = widened(parent.position_m) + turned(q, made.anchor);
  made.q = product(q, made.q);
  return made;
}

// A child and its joint's sample, with the constraint's wrench: m (a - g) and I w' + w x I w, less what is applied.
struct Moved {
  LongBody body;
  LongJoint joint;
};

void add_wrench(const Scene& scene, const Joint& joint, const Long3& a, const Long3& dw_body,
                const Long3& applied_force, const Long3& applied_torque, Moved& moved) {
  const Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
  const LongBody& at = moved.body;
  const Long3 needed = Long(body.mass_kg) * (a - widened(scene.gravity_m_per_s2));
  const Long3 turns = times(body.inertia_kg_m2, dw_body) + cross(at.w, times(body.inertia_kg_m2, at.w));
  const Long3 arm = turned(at.q, widened(joint.anchors_body_m[1]));
  moved.joint.force = needed - applied_force;
  moved.joint.torque = turned(at.q, turns) - cross(arm, needed) - applied_torque;
}

// ---- one coordinate ------------------------------------------------------------------------------------------------
// c, s: cosine and sine of a hinge's angle. With d the way from the anchor to the centre across the axis at q = 0, the
// moment of gravity about the axis n is m (c n.(d x g) + s n.((n x d) x g)).
struct Coordinate {
  const Scene& scene;
  const Joint& joint;
  int index;
  Ground ground;
  bool turns = false;
  Long3 axis{}, n{};  // of the child, of the world
  Long inertia = 0, gravity_c = 0, gravity_s = 0;
  Long steady = 0;  // of motors with the frequency 0

  Coordinate(const Scene& of, int at) : scene(of), joint(of.joints[static_cast<std::size_t>(at)]), index(at) {
    const Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
    const Long mass = body.mass_kg;
    const Long3 g = widened(scene.gravity_m_per_s2);
    ground = ground_of(scene, joint);
    turns = joint.kind == JointKind::hinge;
    for (const JointForce& force : scene.joint_forces)
      if (const auto* motor = std::get_if<JointTorque>(&force);
          motor != nullptr && motor->joint == index && motor->angular_frequency_rad_per_s == 0)
        steady += motor->torque * cos(Long(motor->phase_rad));
    axis = normalised(widened(joint.axis_body));
    n = turned(ground.q, axis);
    if (!turns) {
      inertia = mass;
      gravity_c = mass * dot(n, g);
      return;
    }
    const Long3 d_body = Long(-1) * widened(joint.anchors_body_m[1]), arm = cross(axis, d_body);
    inertia = dot(axis, times(body.inertia_kg_m2, axis)) + mass * dot(arm, arm);
    const Long3 d = turned(ground.q, d_body - dot(axis, d_body) * axis);
    gravity_c = mass * dot(n, cross(d, g));
    gravity_s = mass * dot(n, cross(cross(n, d), g));
  }
  Long applied(const Long& t, const Long& q, const Long& u) const {
    Long sum = steady;
    for (const JointForce& force : scene.joint_forces) {
      if (const auto* spring = std::get_if<JointSpring>(&force)) {
        if (spring->joint == index) sum -= spring->stiffness * (q - spring->rest) + spring->damping * u;
        continue;
      }
      const auto& motor = std::get<JointTorque>(force);
      if (motor.joint == index && motor.angular_frequency_rad_per_s != 0)
        sum += motor.torque * cos(motor.angular_frequency_rad_per_s * t + motor.phase_rad);
    }
    return sum;
  }
  Long change(const Long& t, const Long& q, const Long& u, const Long& c, const Long& s) const {
    return (gravity_c * c + gravity_s * s + applied(t, q, u)) / inertia;
  }
  // (q, u, c, s)
  void rate(const Long& t, const State& y, State& dydt) const {
    dydt[0] = y[1];
    dydt[1] = turns ? change(t, y[0], y[1], y[2], y[3]) : change(t, y[0], y[1], 1, 0);
    dydt[2] = -y[1] * y[3];
    dydt[3] = y[1] * y[2];
  }
  // At rest at a stop (`held`), the stop's force along the axis is no part of the wrench.
  Moved moved(const Long& t, const Long& q, const Long& u, const Long& du, bool held = false) const {
    Moved made;
    made.joint.q[0] = q;
    made.joint.u[0] = u;
    LongBody& at = made.body;
    at.q = turns ? product(ground.q, quaternion_about(axis, q)) : ground.q;
    const Long3 d = turned(at.q, Long(-1) * widened(joint.anchors_body_m[1]));
    at.p = ground.anchor + d;
    const Long along = applied(t, q, u);
    if (turns) {
      at.v = u * cross(n, d);
      at.w = u * axis;
      const Long3 a = du * cross(n, d) + u * u * cross(n, cross(n, d));
      add_wrench(scene, joint, a, du * axis, {}, along * n, made);
    } else {
      at.p = at.p + q * n;
      at.v = u * n;
      add_wrench(scene, joint, du * n, {}, along * n, {}, made);
    }
    Long3& of = turns ? made.joint.torque : made.joint.force;
    if (held) of = of - dot(of, n) * n;
    return made;
  }
};

std::vector<Moved> swing(const Coordinate& at, const std::vector<Long>& times_s, int digits) {
  const Long q = at.joint.coordinates[0];
  const State start{q, at.joint.rates[0], cos(q), sin(q)};
  const auto f = [&](const Long& t, const State& y, State& dydt) { at.rate(t, y, dydt); };
  std::vector<Moved> made;
  const std::vector<State> path = solve(f, start, {0, 1, 2, 2}, times_s, digits);
  for (std::size_t k = 0; k < path.size(); ++k) {
    State dydt(4);
    at.rate(times_s[k], path[k], dydt);
    made.push_back(at.moved(times_s[k], path[k][0], path[k][1], dydt[1]));
  }
  return made;
}

// ---- stops --------------------------------------------------------------------------------------------------------

constexpr int kMaxImpacts = 4000;

struct Bounces {
  std::vector<Moved> at;
  std::vector<Long> event_s;
  std::string refused;
};

// Flights of constant acceleration a. They end where the remaining time of the series is lost in a double: the truth
// has no events of its own for these bounces, and the coordinate rests after the last of them. `moved`: relative shift
// of each impact within its flight.
Bounces bounce(const Coordinate& of, const std::vector<Long>& times_s, const Long& moved) {
  Bounces made;
  const JointLimits& stops = *of.joint.limits;
  const Long a = of.change(0, 0, 0, 1, 0), e = stops.restitution, lower = stops.lower, upper = stops.upper;
  Long t = 0, q = of.joint.coordinates[0], u = of.joint.rates[0];
  bool rests = (q == lower && u == 0 && a <= 0) || (q == upper && u == 0 && a >= 0);
  std::size_t sample = 0;
  const Long end = times_s.back();
  for (int impact = 0;; ++impact) {
    // The next time of q = lower on the way down, or of upper on the way up: roots of q + u h + a h^2 / 2 = stop.
    Long flight = 2 * end + 1;
    bool low = false;
    for (const bool down : {true, false}) {
      const Long gap = down ? q - lower : upper - q, out = down ? u : -u, push = down ? a : -a;
      // gap + out h + push h^2 / 2 = 0
      Long h = -1;
      if (gap == 0) {
        if (out > 0 && push < 0) h = -2 * out / push;
      } else {
        const Long square = out * out - 2 * push * gap;
        if (square >= 0 && !(out >= 0 && push >= 0)) h = 2 * gap / (sqrt(square) - out);
      }
      if (rests || h < 0 || h >= flight) continue;
      flight = h;
      low = down;
    }
    while (sample < times_s.size() && (times_s[sample] < t + flight || t + flight > end)) {
      const Long h = times_s[sample] - t;
      made.at.push_back(rests ? of.moved(times_s[sample], q, 0, 0, true)
                              : of.moved(times_s[sample], q + h * (u + a * h / 2), u + a * h, a));
      ++sample;
    }
    if (sample == times_s.size()) return made;
    if (impact >= kMaxImpacts) return made.refused = "more than " + std::to_string(kMaxImpacts) + " impacts", made;
    t += flight * (1 + moved);
    Long before = u + a * flight;
    if (abs(before) < Long("1e-50") * (abs(u) + abs(a) * flight)) before = 0;  // the round-off of 60 digits
    q = low ? lower : upper;
    u = -e * before;
    if (before != 0) made.event_s.push_back(t);
    const Long push = low ? a : -a;
    if (!(push < 0) || e == 1) {
      if (u == 0 && push == 0) rests = true;
      continue;
    }
    const Long left = 2 * abs(u) / (-push * (1 - e));
    if (left > (t + left) * Long(0x1p-53) || u * u >= -2 * push * (upper - lower)) continue;
    rests = true;
    made.event_s.push_back(t + left);
  }
}

// ---- ball joints ---------------------------------------------------------------------------------------------------
// About the pivot, J w' = d x m R^T g - w x J w with J = I - m [d]^2, body axes; Q' = Q (0, w) / 2.

std::vector<Moved> top(const Scene& scene, const Joint& joint, const std::vector<Long>& times_s, int digits) {
  const Body& body = scene.bodies[static_cast<std::size_t>(joint.child)];
  const Ground ground = ground_of(scene, joint);
  const Long mass = body.mass_kg;
  const Long3 d = Long(-1) * widened(joint.anchors_body_m[1]),
              g = turned_back(ground.q, widened(scene.gravity_m_per_s2));
  std::array<Long3, 3> J{};  // rows
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      J[i][j] = body.inertia_kg_m2[3 * i + j] + mass * ((i == j ? dot(d, d) : Long(0)) - d[i] * d[j]);
  const Long determinant = dot(J[0], cross(J[1], J[2]));
  const std::array<Long3, 3> cofactors{cross(J[1], J[2]), cross(J[2], J[0]), cross(J[0], J[1])};  // columns of J^-1
  const auto change = [&](const Long4& q, const Long3& w) {
    const Long3 Jw{dot(J[0], w), dot(J[1], w), dot(J[2], w)};
    const Long3 moment = mass * cross(d, turned_back(q, g)) - cross(w, Jw);
    return Long(1) / determinant * (moment[0] * cofactors[0] + moment[1] * cofactors[1] + moment[2] * cofactors[2]);
  };
  const auto f = [&](const Long&, const State& y, State& dydt) {
    const Long4 q{y[0], y[1], y[2], y[3]};
    const Long3 w{y[4], y[5], y[6]};
    const Long4 half = product(q, {0, w[0] / 2, w[1] / 2, w[2] / 2});
    const Long3 dw = change(q, w);
    for (std::size_t c = 0; c < 4; ++c) dydt[c] = half[c];
    for (std::size_t c = 0; c < 3; ++c) dydt[4 + c] = dw[c];
  };
  const Long4 q0 = normalised(joint.coordinates);
  State start(q0.begin(), q0.end());
  for (const double u : joint.rates) start.emplace_back(u);
  std::vector<Moved> made;
  for (const State& y : solve(f, start, {0, 0, 0, 0, 1, 1, 1}, times_s, digits)) {
    Moved& now = made.emplace_back();
    now.joint.q = {y[0], y[1], y[2], y[3]};
    now.joint.u = now.body.w = {y[4], y[5], y[6]};
    const Long3& w = now.body.w;
    now.body.q = product(ground.q, now.joint.q);
    const Long3 dw = change(now.joint.q, w);
    now.body.p = ground.anchor + turned(now.body.q, d);
    now.body.v = turned(now.body.q, cross(w, d));
    add_wrench(scene, joint, turned(now.body.q, cross(dw, d) + cross(w, cross(w, d))), dw, {}, {}, now);
    now.joint.torque = {};  // to round-off
  }
  return made;
}

Checked run(const Scenario& scenario, std::int64_t samples, int digits, const Long& moved) {
  const Scene& scene = scenario.scene;
  const std::vector<Long> times_s = sample_times(scenario.t_end_s, samples);
  Checked made = of_starts(scenario, samples);
  made.reactions = true;
  made.joints.assign(times_s.size(), std::vector<LongJoint>(scene.joints.size()));
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    std::vector<Moved> path;
    if (joint.kind == JointKind::ball) {
      path = top(scene, joint, times_s, digits);
    } else if (joint.limits) {
      Bounces all = bounce(Coordinate(scene, static_cast<int>(j)), times_s, moved);
      if (!all.refused.empty()) return {all.refused, {}, {}};
      path = std::move(all.at);
      made.has_events = true;
      made.event_s.insert(made.event_s.end(), all.event_s.begin(), all.event_s.end());
    } else {
      path = swing(Coordinate(scene, static_cast<int>(j)), times_s, digits);
    }
    if (path.empty()) return {"the checker needs more than " + std::to_string(kMaxSteps) + " steps", {}, {}};
    for (std::size_t k = 0; k < times_s.size(); ++k) {
      made.values[k][static_cast<std::size_t>(joint.child)] = path[k].body;
      made.joints[k][j] = path[k].joint;
    }
  }
  std::sort(made.event_s.begin(), made.event_s.end());
  return made;
}

}  // namespace

Checked check_joints(const Scenario& scenario, std::int64_t samples, int digits) {
  Checked made =
      of_two(run(scenario, samples, digits, 0), run(scenario, samples, digits - 4, Long("1e-50")), Long("1e-55"));
  widen_reactions(made, Long("1e-52"));
  return made;
}

}  // namespace atwood::fuzz
