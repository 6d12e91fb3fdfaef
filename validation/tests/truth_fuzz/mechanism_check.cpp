#include "mechanism_check.hpp"

#include "extrapolation.hpp"

namespace atwood::fuzz {
namespace {

constexpr const char* kRelativeOwn = "1e-52";  // of formulas without cancellation to speak of

const Long3 x_axis{1, 0, 0}, y_axis{0, 1, 0}, z_axis{0, 0, 1};

// The world's side of the mechanism may be a fixed body.
struct Frame {
  Long3 p{};
  Long4 q{1, 0, 0, 0};
};
Frame frame_of(const Scene& scene, const Joint& motor) {
  if (motor.parent < 0) return {};
  const Body& body = scene.bodies[static_cast<std::size_t>(motor.parent)];
  return {widened(body.position_m), normalised(body.orientation_wxyz)};
}
// A motion relative to the frame, v and p in its axes.
LongBody placed(const Frame& frame, const LongBody& in) {
  return {frame.p + turned(frame.q, in.p), product(frame.q, in.q), turned(frame.q, in.v), in.w};
}

Checked with_own(Checked made) {
  set_own(made, made, Long(kRelativeOwn));
  // The angles of some joints cancel: their errors are those of numbers of size 1.
  widen_bodies(made, Long(kRelativeOwn));
  for (auto& row : made.joints_own)
    for (LongJoint& own : row)
      for (std::size_t c = 0; c < 2; ++c) {
        own.q[c] += Long(kRelativeOwn);
        own.u[c] += Long(kRelativeOwn);
      }
  return made;
}

// A body that turns about z, with `on_body` of it at the point `at` that moves at `speed`.
LongBody in_plane(const Long3& at, const Long3& speed, const Long& angle, const Long& rate, const Long3& on_body) {
  LongBody made;
  made.q = quaternion_about(z_axis, angle);
  const Long3 back = turned(made.q, Long(-1) * on_body);
  made.p = at + back;
  made.v = speed + cross(rate * z_axis, back);
  made.w = {0, 0, rate};
  return made;
}

}  // namespace

Checked check_slider_crank(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const Joint &motor = scene.joints[0], &pin = scene.joints[1], &rail = scene.joints[2], &wrist = scene.joints[3];
  const Frame frame = frame_of(scene, motor);
  const Long W = *motor.driven_rate, flip = pin.axis_body[2];
  const Long3 crank_arm = at_anchor(pin, 0) - at_anchor(motor, 1), rod_arm = at_anchor(wrist, 0) - at_anchor(pin, 1);
  const Long L = sqrt(rod_arm[0] * rod_arm[0] + rod_arm[1] * rod_arm[1]);
  const Long3 base = at_anchor(rail, 0) - at_anchor(rail, 1) + at_anchor(wrist, 1);  // of the rod's end, at offset 0
  const Long lean = atan2(rod_arm[1], rod_arm[0]);                                   // of the arm in the rod
  Checked made = of_starts(scenario, samples);
  made.joints.assign(made.values.size(), std::vector<LongJoint>(4));
  // Where the rod starts, by its doubles.
  const bool ahead = cos(Long(motor.coordinates[0]) + flip * pin.coordinates[0] + lean) > 0;
  for (std::size_t k = 0; k < made.values.size(); ++k) {
    const Long t = Long(scenario.t_end_s) * static_cast<int>(k) / samples, a = motor.coordinates[0] + W * t;
    const Long3 A = at_anchor(motor, 0) + turned(quaternion_about(z_axis, a), crank_arm);
    const Long3 dA = cross(W * z_axis, turned(quaternion_about(z_axis, a), crank_arm));
    const Long high = base[1] - A[1], wide = (ahead ? 1 : -1) * sqrt(L * L - high * high);
    const Long dx = dA[0] + high * dA[1] / wide;
    const Long3 B{A[0] + wide, base[1], A[2]};
    const Long turn = atan2(ahead ? high : Long(-high), abs(wide)) + (ahead ? Long(0) : acos(Long(-1)));
    const Long turn_rate = (wide * -dA[1] - high * (dx - dA[0])) / (L * L);
    const Long phi = turn - lean;
    auto& bodies = made.values[k];
    bodies[static_cast<std::size_t>(motor.child)] =
        placed(frame, in_plane(at_anchor(motor, 0), {}, a, W, at_anchor(motor, 1)));
    bodies[static_cast<std::size_t>(pin.child)] = placed(frame, in_plane(A, dA, phi, turn_rate, at_anchor(pin, 1)));
    LongBody piston;
    piston.p = {B[0] - at_anchor(wrist, 1)[0], at_anchor(rail, 0)[1] - at_anchor(rail, 1)[1],
                at_anchor(rail, 0)[2] - at_anchor(rail, 1)[2]};
    piston.v = {dx, 0, 0};
    bodies[static_cast<std::size_t>(rail.child)] = placed(frame, piston);
    auto& joints = made.joints[k];
    joints[0] = {{a}, {W}};
    joints[1] = {{flip * (phi - a)}, {flip * (turn_rate - W)}};
    joints[2] = {{B[0] - base[0]}, {dx}};
    joints[3] = {{-phi}, {-turn_rate}};
  }
  return with_own(std::move(made));
}

Checked check_hooke_shaft(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const Joint &motor = scene.joints[0], &bearing = scene.joints[1], &joint = scene.joints[2];
  const Frame frame = frame_of(scene, motor);
  const Long4 tilt = normalised(bearing.frame_wxyz);
  const Long3 n2 = turned(tilt, z_axis);  // (0, -sin beta, cos beta)
  const Long W = *motor.driven_rate, sine = -n2[1], cosine = n2[2], half_turn = acos(Long(-1));
  const Long way = cosine > 0 ? 1 : -1;
  Checked made = of_starts(scenario, samples);
  made.joints.assign(made.values.size(), std::vector<LongJoint>(3));
  for (std::size_t k = 0; k < made.values.size(); ++k) {
    const Long t = Long(scenario.t_end_s) * static_cast<int>(k) / samples, a = motor.coordinates[0] + W * t;
    const Long ca = cos(a), sa = sin(a);
    // The pins (ca, sa, 0) and R_x(beta) (-sin b, cos b, 0): -ca sin b + cosine sa cos b = 0.
    Long b = atan2(Long(cosine * sa), ca);
    b += 2 * half_turn * round((way * a - b) / (2 * half_turn));
    const Long cb = cos(b), sb = sin(b);
    const Long rate = W * (sa * sb + cosine * ca * cb) / (ca * cb + cosine * sa * sb);
    LongBody first, second;
    first.q = quaternion_about(z_axis, a);
    first.w = {0, 0, W};
    const Long3 back1 = turned(first.q, Long(-1) * at_anchor(motor, 1));
    first.p = at_anchor(motor, 0) + back1;
    first.v = cross(W * z_axis, back1);
    const Long4 second_q = product(tilt, quaternion_about(z_axis, b));
    second.w = {0, 0, rate};
    const Long3 back2 = turned(second_q, Long(-1) * at_anchor(bearing, 1));
    second.p = at_anchor(bearing, 0) + back2;
    second.v = cross(rate * n2, back2);
    // R_x(q0) R_y(q1): the second axis seen from the first shaft is (sin q1, -sin q0 cos q1, cos q0 cos q1).
    const Long q0 = cosine > 0
                        ? Long(atan2(Long(sine * ca), cosine))
                        : Long((sine > 0 ? half_turn : Long(-half_turn)) - atan2(Long(sine * ca), Long(-cosine)));
    const Long q1 = asin(-sine * sa);
    second.q = joint.closes_loop
                   ? second_q
                   : product(first.q, product(quaternion_about(x_axis, q0), quaternion_about(y_axis, q1)));
    const Long3 relative = rate * n2 - W * z_axis;
    made.values[k][static_cast<std::size_t>(motor.child)] = placed(frame, first);
    made.values[k][static_cast<std::size_t>(bearing.child)] = placed(frame, second);
    made.joints[k][0] = {{a}, {W}};
    made.joints[k][1] = {{b}, {rate}};
    made.joints[k][2] = {{q0, q1}, {dot(relative, turned(first.q, x_axis)), dot(relative, turned(second_q, y_axis))}};
  }
  return with_own(std::move(made));
}

// ---- a bead on a turning rod --------------------------------------------------------------------------------------

namespace {

Checked turn_rod(const Scenario& scenario, std::int64_t samples, int digits) {
  const Scene& scene = scenario.scene;
  const Joint &motor = scene.joints[0], &bore = scene.joints[1];
  const Body &rod = scene.bodies[static_cast<std::size_t>(motor.child)],
             &bead = scene.bodies[static_cast<std::size_t>(bore.child)];
  const Frame frame = frame_of(scene, motor);
  const Long4 base = product(frame.q, normalised(motor.frame_wxyz)), bore_q = normalised(bore.frame_wxyz);
  // In the rod's axes: the axis n, the bore's direction d, and the ways c and e from the hinge to the bead's centre at
  // offset 0 and to the rod's centre.
  const Long W = *motor.driven_rate, start_angle = motor.coordinates[0];
  const Long3 n = normalised(widened(motor.axis_body)), d = turned(bore_q, normalised(widened(bore.axis_body)));
  const Long3 c = at_anchor(bore, 0) - at_anchor(motor, 1) - turned(bore_q, at_anchor(bore, 1)),
              e = Long(-1) * at_anchor(motor, 1), w = W * n;
  const Long3 g = turned_back(base, widened(scene.gravity_m_per_s2));  // in the rod's axes at the angle 0
  const Long3 g_along = dot(g, n) * n, g_across = g - g_along, g_side = cross(n, g);
  const auto pull = [&](const Long& cosine, const Long& sine) {  // in the rod's axes
    return g_along + cosine * g_across - sine * g_side;
  };
  const auto inward = [&](const Long3& r) { return cross(w, cross(w, r)); };
  const auto change = [&](const State& y) { return dot(d, pull(y[2], y[3]) - inward(c + y[0] * d)); };
  const auto f = [&](const Long&, const State& y, State& dydt) {
    dydt[0] = y[1];
    dydt[1] = change(y);
    dydt[2] = -W * y[3];
    dydt[3] = W * y[2];
  };
  const std::vector<Long> times_s = sample_times(scenario.t_end_s, samples);
  const std::vector<State> path =
      solve(f, {bore.coordinates[0], bore.rates[0], cos(start_angle), sin(start_angle)}, {0, 1, 2, 2}, times_s, digits);
  if (path.empty()) return {"the checker needs more than " + std::to_string(kMaxSteps) + " steps", {}, {}};
  const Long3 hinge = frame.p + turned(frame.q, at_anchor(motor, 0));
  Checked made = of_starts(scenario, samples);
  made.reactions = true;
  made.joints.assign(path.size(), std::vector<LongJoint>(2));
  for (std::size_t k = 0; k < path.size(); ++k) {
    const State& y = path[k];
    const Long angle = start_angle + W * times_s[k];
    const Long4 q = product(base, quaternion_about(n, angle));
    const Long3 r = c + y[0] * d, g_now = pull(y[2], y[3]);
    LongBody &rod_at = made.values[k][static_cast<std::size_t>(motor.child)],
             &bead_at = made.values[k][static_cast<std::size_t>(bore.child)];
    rod_at = {hinge + turned(q, e), q, turned(q, cross(w, e)), w};
    bead_at = {hinge + turned(q, r), product(q, bore_q), turned(q, y[1] * d + cross(w, r)), turned_back(bore_q, w)};
    // Wrenches in the rod's axes: Newton's and Euler's equations of the bead, then of the rod.
    const Long3 a = change(y) * d + Long(2) * y[1] * cross(w, d) + inward(r);
    const Long3 bead_force = Long(bead.mass_kg) * (a - g_now);
    const Long3 w_bead = bead_at.w, bead_arm = turned(bore_q, at_anchor(bore, 1));  // centre to anchor
    const Long3 bead_turns = turned(bore_q, cross(w_bead, times(bead.inertia_kg_m2, w_bead)));
    const Long3 bead_torque = bead_turns - cross(bead_arm, bead_force);
    const Long3 rod_force = Long(rod.mass_kg) * (inward(e) - g_now) + bead_force;
    const Long3 rod_turns = cross(w, times(rod.inertia_kg_m2, w));
    const Long3 rod_torque = rod_turns + cross(r + bead_arm - e, bead_force) + bead_torque + cross(e, rod_force);
    auto& joints = made.joints[k];
    joints[0] = {{angle}, {W}, turned(q, rod_force), turned(q, rod_torque)};
    joints[1] = {{y[0]}, {y[1]}, turned(q, bead_force), turned(q, bead_torque)};
  }
  return made;
}

}  // namespace

Checked check_turning_rod(const Scenario& scenario, std::int64_t samples, int digits) {
  return of_two(turn_rod(scenario, samples, digits), turn_rod(scenario, samples, digits - 4), Long("1e-55"));
}

// ---- four-bars in a row -------------------------------------------------------------------------------------------

namespace {

// The solution of as many independent equations as there are unknowns: rows hold the coefficients and the right side.
std::vector<Long> eliminated(std::vector<std::vector<Long>> rows, std::size_t unknowns) {
  for (std::size_t c = 0; c < unknowns; ++c) {
    std::size_t pivot = c;
    for (std::size_t r = c; r < rows.size(); ++r)
      if (abs(rows[r][c]) > abs(rows[pivot][c])) pivot = r;
    std::swap(rows[c], rows[pivot]);
    for (std::size_t r = 0; r < rows.size(); ++r) {
      if (r == c || rows[r][c] == 0) continue;
      const Long factor = rows[r][c] / rows[c][c];
      for (std::size_t k = c; k <= unknowns; ++k) rows[r][k] -= factor * rows[c][k];
    }
  }
  std::vector<Long> made(unknowns);
  for (std::size_t c = 0; c < unknowns; ++c) made[c] = rows[c][unknowns] / rows[c][c];
  return made;
}

// A body of a plane mechanism, in world axes.
struct InPlane {
  LongBody at;
  Long3 a{};
  Long turns = 0;  // angular acceleration
};

// Forces of all joints on their children, across z.
std::vector<Long3> plane_forces(const Scene& scene, const std::vector<InPlane>& bodies) {
  const std::size_t unknowns = 2 * scene.joints.size();
  std::vector<std::vector<Long>> rows;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const std::size_t first = rows.size();
    rows.resize(first + 3, std::vector<Long>(unknowns + 1));
    const Long3 needed = Long(body.mass_kg) * (bodies[i].a - widened(scene.gravity_m_per_s2));
    rows[first][unknowns] = needed[0];
    rows[first + 1][unknowns] = needed[1];
    rows[first + 2][unknowns] = body.inertia_kg_m2[8] * bodies[i].turns;
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const bool child = joint.child == static_cast<int>(i);
      if (!child && joint.parent != static_cast<int>(i)) continue;
      const Long way = child ? 1 : -1;
      const Long3 arm = turned(bodies[i].at.q, at_anchor(joint, child ? 1 : 0));
      rows[first][2 * j] = rows[first + 1][2 * j + 1] = way;
      rows[first + 2][2 * j] = -way * arm[1];
      rows[first + 2][2 * j + 1] = way * arm[0];
    }
  }
  const std::vector<Long> solved = eliminated(std::move(rows), unknowns);
  std::vector<Long3> made;
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    made.push_back({solved[2 * j], solved[2 * j + 1], std::numeric_limits<Long>::quiet_NaN()});
  return made;
}

Checked swing_four_bar(const Scenario& scenario, std::int64_t samples, int digits) {
  const Scene& scene = scenario.scene;
  const std::size_t couplings = (scene.joints.size() - 1) / 3, bars = couplings + 1;
  const auto way = [](const Joint& joint) { return Long(joint.axis_body[2]); };
  const Long3 bar = at_anchor(scene.joints[bars], 0) - at_anchor(scene.joints[0], 1),
              g = widened(scene.gravity_m_per_s2);
  const Long3 across{bar[0], bar[1], 0};
  Long inertia = 0;
  Long3 first_moment{};
  for (std::size_t k = 0; k < bars; ++k) {
    const Joint& foot = scene.joints[k];
    const Body& body = scene.bodies[static_cast<std::size_t>(foot.child)];
    const Long3 arm{-Long(foot.anchors_body_m[1][0]), -Long(foot.anchors_body_m[1][1]), 0};
    inertia += body.inertia_kg_m2[8] + body.mass_kg * dot(arm, arm);
    first_moment = first_moment + Long(body.mass_kg) * arm;
  }
  for (std::size_t k = 0; k < couplings; ++k) {
    const Long mass = scene.bodies[static_cast<std::size_t>(scene.joints[bars + k].child)].mass_kg;
    inertia += mass * dot(across, across);
    first_moment = first_moment + mass * across;
  }
  const Long pull_c = dot(z_axis, cross(first_moment, g)), pull_s = dot(z_axis, cross(cross(z_axis, first_moment), g));
  const auto change = [&](const Long& c, const Long& s) { return Long((pull_c * c + pull_s * s) / inertia); };
  const auto f = [&](const Long&, const State& y, State& dydt) {
    dydt = {y[1], change(y[2], y[3]), -y[1] * y[3], y[1] * y[2]};
  };
  const Joint& first = scene.joints[0];
  const Long angle = way(first) * first.coordinates[0];
  const std::vector<Long> times_s = sample_times(scenario.t_end_s, samples);
  const std::vector<State> path =
      solve(f, {angle, way(first) * first.rates[0], cos(angle), sin(angle)}, {0, 1, 2, 2}, times_s, digits);
  if (path.empty()) return {"the checker needs more than " + std::to_string(kMaxSteps) + " steps", {}, {}};
  Checked made = of_starts(scenario, samples);
  made.reactions = true;
  made.joints.assign(path.size(), std::vector<LongJoint>(scene.joints.size()));
  for (std::size_t k = 0; k < path.size(); ++k) {
    const State& y = path[k];
    const Long du = change(y[2], y[3]);
    std::vector<InPlane> bodies(scene.bodies.size());
    for (std::size_t b = 0; b < bars; ++b) {
      const Joint& foot = scene.joints[b];
      InPlane& of = bodies[static_cast<std::size_t>(foot.child)];
      of.at = in_plane(at_anchor(foot, 0), {}, y[0], y[1], at_anchor(foot, 1));
      const Long3 arm = of.at.p - at_anchor(foot, 0);
      of.turns = du;
      of.a = cross(du * z_axis, arm) + cross(y[1] * z_axis, cross(y[1] * z_axis, arm));
    }
    const Long3 tip = turned(quaternion_about(z_axis, y[0]), across);
    for (std::size_t c = 0; c < couplings; ++c) {
      const Joint& left = scene.joints[bars + c];
      InPlane& of = bodies[static_cast<std::size_t>(left.child)];
      const LongBody& upright = bodies[static_cast<std::size_t>(left.parent)].at;
      of.at.p = upright.p + turned(upright.q, at_anchor(left, 0)) - at_anchor(left, 1);
      of.at.v = cross(y[1] * z_axis, tip);
      of.a = cross(du * z_axis, tip) + cross(y[1] * z_axis, cross(y[1] * z_axis, tip));
    }
    for (std::size_t i = 0; i < bodies.size(); ++i) made.values[k][i] = bodies[i].at;
    const std::vector<Long3> forces = plane_forces(scene, bodies);
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      const Long turn = way(joint) * (j >= bars && j < bars + couplings ? -1 : 1);
      LongJoint& now = made.joints[k][j];
      now.q[0] = turn * y[0];
      now.u[0] = turn * y[1];
      now.force = forces[j];
      now.torque[0] = now.torque[1] = std::numeric_limits<Long>::quiet_NaN();
    }
  }
  return made;
}

}  // namespace

Checked check_four_bar(const Scenario& scenario, std::int64_t samples, int digits) {
  Checked made =
      of_two(swing_four_bar(scenario, samples, digits), swing_four_bar(scenario, samples, digits - 4), Long("1e-50"));
  widen_reactions(made, Long("1e-48"));
  return made;
}

// ---- ropes --------------------------------------------------------------------------------------------------------

Checked check_atwood_machine(const Scenario& scenario, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const Long3 gravity = widened(scene.gravity_m_per_s2);
  const Long g = sqrt(dot(gravity, gravity));
  const Long3 up = Long(-1) / g * gravity;
  Checked made = of_starts(scenario, samples);
  made.ropes.resize(made.values.size());
  for (const Rope& rope : scene.ropes) {
    const Body &first = scene.bodies[static_cast<std::size_t>(rope.bodies[0])],
               &second = scene.bodies[static_cast<std::size_t>(rope.bodies[1])];
    // What the second body's weight lacks when the first one rises with the acceleration a: linear in a.
    const auto lacks = [&](const Long& a) {
      Long tension = first.mass_kg * (g + a);
      for (const Pulley& pulley : rope.over)
        if (pulley.radius_m > 0) {
          const Long turns = a / pulley.radius_m;
          tension += pulley.inertia_kg_m2 * turns / pulley.radius_m;
        }
      return Long(tension - second.mass_kg * (g - a));
    };
    const Long still = lacks(0), a = -still / (lacks(1) - still), u0 = dot(widened(first.velocity_m_per_s), up);
    for (std::size_t k = 0; k < made.values.size(); ++k) {
      const Long t = Long(scenario.t_end_s) * static_cast<int>(k) / samples, s = u0 * t + a * t * t / 2, u = u0 + a * t;
      for (const int which : {0, 1}) {
        LongBody& body = made.values[k][static_cast<std::size_t>(rope.bodies[static_cast<std::size_t>(which)])];
        const Long side = which == 0 ? 1 : -1;
        body.p = body.p + side * s * up;
        body.v = side * u * up;
      }
      LongRope& state = made.ropes[k].emplace_back();
      state.tension = first.mass_kg * (g + a);
      for (const Pulley& pulley : rope.over)
        state.angles.push_back(pulley.angle_rad + (pulley.radius_m > 0 ? Long(s / pulley.radius_m) : Long(0)));
    }
  }
  set_own(made, made, Long(kRelativeOwn));
  return made;
}

}  // namespace atwood::fuzz
