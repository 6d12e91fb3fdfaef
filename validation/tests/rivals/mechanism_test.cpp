// What every engine with joints is asked: its samples are joints by the scene's definition, each body obeys Newton's
// and Euler's equations under the reported reactions, and mechanisms with known motions move so.
#include <algorithm>
#include <catch2/catch.hpp>

#include "mechanism_scenes.hpp"
#include "mechanism_under_test.hpp"

namespace atwood::test {
namespace {

const Engine& engine() {
  static const Engine made = engine_under_test();
  return made;
}
Run run_with(const std::string& scheme, const Scene& scene, const Plan& plan) {
  Run result = run(engine(), method(engine(), scheme), scene, plan);
  INFO(scheme << ": " << result.outcome.reason);
  REQUIRE(result.outcome.status == Status::ok);
  return result;
}

double value(Wide x) { return static_cast<double>(x); }
double largest(const M3& m) { return m.cwiseAbs().maxCoeff(); }
double largest(const V3& v) { return v.cwiseAbs().maxCoeff(); }

// Poses and velocities of each placed body are those that its parent's and the joint's coordinates give it.
void check_kinematics(const Scene& scene, const Sample& sample, double tolerance) {
  REQUIRE(sample.joints.size() == scene.joints.size());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    INFO("t = " << static_cast<double>(sample.t_s) << ", " << joint.name);
    const Pose child = pose_of(sample, joint.child);
    const Pose expected = child_pose(joint, pose_of(sample, joint.parent), sample.joints[j].q, sample.joints[j].u);
    CHECK(largest(V3(child.p - expected.p)) < tolerance);
    CHECK(largest(M3(child.r - expected.r)) < tolerance);
    CHECK(largest(V3(child.v - expected.v)) < tolerance);
    CHECK(largest(V3(child.w - expected.w)) < tolerance);
  }
}

// The first sample is the scene's start.
void check_start(const Scene& scene, const Sample& sample, double tolerance = 1e-13) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    INFO(scene.joints[j].name);
    for (int k = 0; k < coordinate_count(scene.joints[j].kind); ++k)
      CHECK(value(sample.joints[j].q[k]) == Approx(scene.joints[j].coordinates[k]).margin(1e-14));
    for (int k = 0; k < rate_count(scene.joints[j].kind); ++k)
      CHECK(value(sample.joints[j].u[k]) == Approx(scene.joints[j].rates[k]).margin(1e-14));
  }
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Pose found = pose_of(sample, i), start = pose_of(scene, i);
    INFO(scene.bodies[static_cast<std::size_t>(i)].name);
    CHECK(largest(V3(found.p - start.p)) + largest(M3(found.r - start.r)) < tolerance);
    CHECK(largest(V3(found.v - start.v)) + largest(V3(found.w - start.w)) < tolerance);
  }
}

// Torque and force that springs and motors put on the child, from the scene's definition.
struct OnChild {
  V3 force = V3::Zero(), torque = V3::Zero();
};
OnChild spring_and_motor(const Scene& scene, int j, const Sample& sample) {
  const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
  const JointSample& state = sample.joints[static_cast<std::size_t>(j)];
  const Pose parent = pose_of(sample, joint.parent), child = pose_of(sample, joint.child);
  OnChild sum;
  for (const JointForce& force : scene.joint_forces) {
    double effort = 0;
    int k = 0;
    if (const auto* spring = std::get_if<JointSpring>(&force); spring && spring->joint == j) {
      k = spring->coordinate;
      if (joint.kind == JointKind::ball) {
        sum.torque -= spring->damping * (child.r * v3(state.u));
        continue;
      }
      effort = -spring->stiffness * (static_cast<double>(state.q[k]) - spring->rest) -
               spring->damping * static_cast<double>(state.u[k]);
    } else if (const auto* motor = std::get_if<JointTorque>(&force); motor && motor->joint == j) {
      k = motor->coordinate;
      effort = motor->torque *
               std::cos(motor->angular_frequency_rad_per_s * static_cast<double>(sample.t_s) + motor->phase_rad);
    } else {
      continue;
    }
    const bool along = joint.kind == JointKind::slider || (joint.kind == JointKind::cylindrical && k == 1);
    V3 axis = child.r * v3(joint.axis_body);
    if (joint.kind == JointKind::universal)
      axis = k == 0 ? V3(parent.r * v3(joint.axes_body[0])) : V3(child.r * v3(joint.axes_body[1]));
    (along ? sum.force : sum.torque) += effort * axis;
  }
  return sum;
}

// m v' and the rate of the spin L = R I w are differences of neighbouring samples; they equal the sum of all forces.
void check_newton_euler(const Scene& scene, const std::vector<Sample>& samples, std::size_t at, double tolerance) {
  const Sample &before = samples[at - 1], &now = samples[at], &after = samples[at + 1];
  const double span_s = static_cast<double>(after.t_s - before.t_s);
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Body& body = scene.bodies[static_cast<std::size_t>(i)];
    if (body.fixed) continue;
    const Pose here = pose_of(now, i), a = pose_of(before, i), b = pose_of(after, i);
    const M3 inertia = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.inertia_kg_m2.data());
    const auto spin = [&](const Pose& pose) { return V3(pose.r * (inertia * (pose.r.transpose() * pose.w))); };
    V3 force = body.mass_kg * v3(scene.gravity_m_per_s2), torque = V3::Zero();
    for (int j = 0; j < static_cast<int>(scene.joints.size()); ++j) {
      const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
      if (joint.parent != i && joint.child != i) continue;
      const JointSample& sample = now.joints[static_cast<std::size_t>(j)];
      const OnChild applied = spring_and_motor(scene, j, now);
      const double sign = joint.child == i ? 1 : -1;
      const Pose child = pose_of(now, joint.child);
      const V3 anchor = child.p + child.r * v3(joint.anchors_body_m[1]);
      const V3 f = sign * (v3(sample.force_N) + applied.force);
      force += f;
      torque += (anchor - here.p).cross(f) + sign * (v3(sample.torque_N_m) + applied.torque);
    }
    INFO("t = " << static_cast<double>(now.t_s) << ", " << body.name);
    CHECK(largest(V3(body.mass_kg * (b.v - a.v) / span_s - force)) < tolerance);
    CHECK(largest(V3((spin(b) - spin(a)) / span_s - torque)) < tolerance);
    CHECK(largest(V3((b.p - a.p) / span_s - here.v)) < tolerance);
    CHECK(
        largest(M3((b.r - a.r) / span_s * here.r.transpose() -
                   (M3() << 0, -here.w[2], here.w[1], here.w[2], 0, -here.w[0], -here.w[1], here.w[0], 0).finished())) <
        tolerance);
  }
}

// A reaction has no power along a free rate.
void check_workless(const Scene& scene, const Sample& sample) {
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const Pose parent = pose_of(sample, joint.parent), child = pose_of(sample, joint.child);
    const V3 f = v3(sample.joints[j].force_N), t = v3(sample.joints[j].torque_N_m),
             axis = child.r * v3(joint.axis_body);
    INFO(joint.name);
    if (joint.kind == JointKind::hinge || joint.kind == JointKind::cylindrical) CHECK(std::abs(t.dot(axis)) < 1e-10);
    if (joint.kind == JointKind::slider || joint.kind == JointKind::cylindrical) CHECK(std::abs(f.dot(axis)) < 1e-10);
    if (joint.kind == JointKind::ball) CHECK(t.norm() < 1e-10);
    if (joint.kind == JointKind::universal) {
      CHECK(std::abs(t.dot(parent.r * v3(joint.axes_body[0]))) < 1e-10);
      CHECK(std::abs(t.dot(child.r * v3(joint.axes_body[1]))) < 1e-10);
    }
  }
}

// theta'' of the two-link arm, from Lagrange's equations with absolute angles a = q0, b = q0 + q1 from the downward
// vertical (rotation about +y turns -z towards -x: x = -l sin a).
std::array<double, 2> arm_accelerations(const std::array<double, 2>& q, const std::array<double, 2>& u) {
  const double m1 = 1.2, m2 = 0.8, i1 = 0.1, i2 = 0.04, c1 = 0.5, l = 1.0, c2 = 0.4, g = 9.81;
  const double a = q[0], b = q[0] + q[1], du = u[0], dv = u[0] + u[1];
  const double m11 = i1 + m1 * c1 * c1 + m2 * l * l, m22 = i2 + m2 * c2 * c2, k = m2 * l * c2;
  const double m12 = k * std::cos(a - b);
  const double f1 = -k * std::sin(a - b) * dv * dv - (m1 * c1 + m2 * l) * g * std::sin(a);
  const double f2 = k * std::sin(a - b) * du * du - m2 * c2 * g * std::sin(b);
  const double det = m11 * m22 - m12 * m12;
  const double aa = (m22 * f1 - m12 * f2) / det, bb = (m11 * f2 - m12 * f1) / det;
  return {aa, bb - aa};
}

struct ArmState {
  std::array<double, 2> q{0.9, -1.3}, u{-0.4, 2.1};
};
// Classical Runge-Kutta.
ArmState arm_at(double t_s, int steps) {
  ArmState s;
  const double h = t_s / steps;
  for (int n = 0; n < steps; ++n) {
    std::array<std::array<double, 2>, 4> dq, du;
    for (int stage = 0; stage < 4; ++stage) {
      const double c = stage == 0 ? 0 : stage == 3 ? h : h / 2;
      std::array<double, 2> q = s.q, u = s.u;
      for (int k = 0; stage > 0 && k < 2; ++k) q[k] += c * dq[stage - 1][k], u[k] += c * du[stage - 1][k];
      dq[stage] = u;
      du[stage] = arm_accelerations(q, u);
    }
    for (int k = 0; k < 2; ++k) {
      s.q[k] += h / 6 * (dq[0][k] + 2 * dq[1][k] + 2 * dq[2][k] + dq[3][k]);
      s.u[k] += h / 6 * (du[0][k] + 2 * du[1][k] + 2 * du[2][k] + du[3][k]);
    }
  }
  return s;
}

}  // namespace

TEST_CASE("each kind of joint is the scene's: kinematics, Newton and Euler, reactions without power") {
  const std::vector<std::vector<JointKind>> chains = {{JointKind::hinge, JointKind::slider, JointKind::hinge},
                                                      {JointKind::ball, JointKind::hinge},
                                                      {JointKind::universal, JointKind::fixed, JointKind::hinge},
                                                      {JointKind::cylindrical, JointKind::ball},
                                                      {JointKind::slider, JointKind::universal}};
  int ran = 0;
  for (const auto& kinds : chains) {
    const Scene scene = zoo(kinds);
    for (const Scheme& scheme : schemes_under_test()) {
      const Run result = try_run(engine(), method(engine(), scheme.name), scene, Plan{0.02, 2000, 200});
      if (result.outcome.status == Status::unsupported) {
        CHECK_THAT(result.outcome.reason, Catch::Contains("joint"));
        continue;
      }
      ++ran;
      INFO(scheme.name << ", first joint " << static_cast<int>(kinds[0]) << ": " << result.outcome.reason);
      REQUIRE(result.outcome.status == Status::ok);
      check_start(scene, result.samples.front());
      check_kinematics(scene, result.samples.front(), 1e-14);
      for (const std::size_t at : {1, 100, 199}) {
        check_kinematics(scene, result.samples[at], scheme.kinematics);
        if (!scheme.reactions) continue;
        const double tolerance = scheme.forces_held ? 1e-4 : scheme.accurate ? 1e-5 : 5e-3;
        check_newton_euler(scene, result.samples, at, tolerance);
        check_workless(scene, result.samples[at]);
      }
    }
  }
  CHECK(ran >= static_cast<int>(schemes_under_test().size()) * chains_taken());
}

TEST_CASE("an oblique pendulum swings as its moment about the axis says") {
  const Scene scene = oblique_pendulum();
  const Joint& pivot = scene.joints[0];
  const Body& bob = scene.bodies[0];
  const V3 axis_B = v3(pivot.axis_body), from_pivot = -v3(pivot.anchors_body_m[1]);
  const M3 inertia = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(bob.inertia_kg_m2.data());
  const double moment = axis_B.dot(inertia * axis_B) + bob.mass_kg * axis_B.cross(from_pivot).squaredNorm();
  const M3 frame = quaternion(pivot.frame_wxyz).toRotationMatrix();
  const auto acceleration = [&](double q) {
    const M3 r = frame * turn(axis_B, q);
    return (r * axis_B).dot((r * from_pivot).cross(bob.mass_kg * v3(scene.gravity_m_per_s2))) / moment;
  };
  double q = 0.4, u = 0.7;
  for (int n = 0, steps = 4000; n < steps; ++n) {
    const double h = 1.5 / steps, k1 = acceleration(q), k2 = acceleration(q + h / 2 * u),
                 k3 = acceleration(q + h / 2 * u + h * h / 4 * k1), k4 = acceleration(q + h * u + h * h / 2 * k2);
    q += h * u + h * h / 6 * (k1 + k2 + k3);
    u += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = run_with(scheme.name, scene, Plan{1.5, 6000, 30});
    const JointSample& end = result.samples.back().joints[0];
    INFO(scheme.name);
    CHECK(std::abs(value(end.q[0]) - q) < (scheme.accurate ? scheme.error : 2e-3));
    CHECK(std::abs(value(end.u[0]) - u) < (scheme.accurate ? 10 * scheme.error : 5e-3));
  }
}

TEST_CASE("angles go on past half a turn") {
  Scene scene = oblique_pendulum();
  scene.gravity_m_per_s2 = {};
  scene.joints[0].rates[0] = 20;
  scene.joints[0].coordinates[0] = -9;
  place(scene);
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = run_with(scheme.name, scene, Plan{2, 4000, 4});
    INFO(scheme.name);
    CHECK(value(result.samples.front().joints[0].q[0]) == Approx(-9).epsilon(1e-12));
    CHECK(value(result.samples.back().joints[0].q[0]) == Approx(31).epsilon(scheme.accurate ? 1e-9 : 1e-3));
  }
}

TEST_CASE("a two-link arm: semi-implicit engines step their recurrence to the last digits, others are accurate") {
  const ArmState exact = arm_at(1, 20000);
  ArmState discrete;
  const int steps = 2000;
  for (int n = 0; n < steps; ++n) {
    const auto a = arm_accelerations(discrete.q, discrete.u);
    for (int k = 0; k < 2; ++k) discrete.u[k] += a[k] / steps, discrete.q[k] += discrete.u[k] / steps;
  }
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = run_with(scheme.name, two_link_arm(), Plan{1, steps, 10});
    const ArmState& expected = scheme.semi_implicit ? discrete : exact;
    const double tolerance = scheme.semi_implicit ? 1e-11 : scheme.accurate ? 1e-9 : 1e-2;
    INFO(scheme.name);
    for (int j = 0; j < 2; ++j) {
      CHECK(std::abs(value(result.samples.back().joints[j].q[0]) - expected.q[j]) < tolerance);
      CHECK(std::abs(value(result.samples.back().joints[j].u[0]) - expected.u[j]) < 10 * tolerance);
    }
  }
}

TEST_CASE("a slider on an incline falls as a body does") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies = {oblique_body("sledge", 2, 0.7)};
  Joint rail = joint_of("rail", JointKind::slider, -1, 0);
  rail.axis_body = unit(0.8, 0.1, -0.6);
  rail.frame_wxyz = unit(0.9, -0.2, 0.3, 0.1);
  rail.anchors_body_m = {{{0.3, 0, 1}, {0, 0.2, -0.1}}};
  rail.coordinates[0] = 0.25;
  rail.rates[0] = -1.5;
  scene.joints = {rail};
  place(scene);
  const double along = (quaternion(rail.frame_wxyz) * v3(rail.axis_body)).dot(v3(scene.gravity_m_per_s2));
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = run_with(scheme.name, scene, Plan{1, 400, 4});
    const double lag = scheme.semi_implicit ? 0.5 * along / 400 : 0;  // of q += h u with the new u
    const JointSample& end = result.samples.back().joints[0];
    INFO(scheme.name);
    CHECK(value(end.q[0]) ==
          Approx(0.25 - 1.5 + 0.5 * along + lag).epsilon(scheme.accurate || lag != 0 ? 1e-11 : 1e-2));
    CHECK(value(end.u[0]) == Approx(-1.5 + along).epsilon(scheme.accurate || lag != 0 ? 1e-11 : 1e-2));
  }
}

// From the base, at rest, over two hinges and a ball to the world: the loop closes at the last link.
static Scene loop(JointKind closing) {
  Scene scene = zoo({JointKind::hinge, JointKind::ball, JointKind::hinge});
  scene.joint_forces.clear();
  scene.bodies[0].velocity_m_per_s = scene.bodies[0].angular_velocity_body_rad_per_s = {};
  for (auto& joint : scene.joints) joint.rates = {};
  place(scene);
  scene.joints.push_back(closing_joint(scene, closing, 3));
  return scene;
}

TEST_CASE("loops: closed as far as the engine keeps them, Newton and Euler with the closing joint's reaction") {
  using enum JointKind;
  for (const JointKind kind : {fixed, hinge, slider, cylindrical, universal, ball}) {
    const Scene scene = loop(kind);
    const auto taken = closings_taken();
    const bool takes = std::find(taken.begin(), taken.end(), kind) != taken.end();
    for (const Scheme& scheme : schemes_under_test()) {
      const Run result = try_run(engine(), method(engine(), scheme.name), scene, Plan{0.05, 1000, 500});
      INFO(scheme.name << ", closing joint " << static_cast<int>(kind) << ": " << result.outcome.reason);
      CHECK((result.outcome.status == Status::ok) == takes);
      if (!takes) {
        CHECK(to_string(result.outcome.status) == "unsupported");
        CHECK_THAT(result.outcome.reason, Catch::Contains("closing"));
        continue;
      }
      for (const std::size_t at : {1, 250, 499}) {
        check_kinematics(scene, result.samples[at], scheme.gap);
        const bool reports =
            value(result.samples[at].joints[0].force_N[0]) == value(result.samples[at].joints[0].force_N[0]);
        CHECK(reports == reacts_in_loops());
        if (!reports) continue;
        check_newton_euler(scene, result.samples, at, scheme.accurate ? 1e-3 : 2e-2);
      }
      // The loop carries load: without it the base would fall freely.
      CHECK(largest(V3(pose_of(result.samples.back(), 0).v - 0.05 * v3(scene.gravity_m_per_s2))) > 1e-3);
    }
  }
}

TEST_CASE("a prescribed rate is kept, and its torque is a reaction") {
  Scene scene = two_link_arm();
  scene.joints[0].driven_rate = scene.joints[0].rates[0];
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = try_run(engine(), method(engine(), scheme.name), scene, Plan{1, 1000, 1000});
    INFO(scheme.name << ": " << result.outcome.reason);
    if (!drives()) {
      CHECK(to_string(result.outcome.status) == "unsupported");
      CHECK_THAT(result.outcome.reason, Catch::Contains("shoulder"));
      continue;
    }
    REQUIRE(result.outcome.status == Status::ok);
    const JointSample& end = result.samples.back().joints[0];
    CHECK(value(end.u[0]) == Approx(-0.4).epsilon(1e-9));
    CHECK(value(end.q[0]) == Approx(0.9 - 0.4).epsilon(1e-9));
    if (reacts_in_loops()) check_newton_euler(scene, result.samples, 500, scheme.accurate ? 1e-3 : 0.1);
    // The lower link alone: theta'' of its absolute angle under the prescribed motion of its pivot, which turns with
    // -0.4 about the shoulder: (i2 + m2 c2^2) b'' + k cos(a - b) a'' - k sin(a - b) a'^2 + m2 c2 g sin b = 0.
    double a = 0.9, b = -0.4, db = 1.7;
    const double h = 1e-4, moment = 0.04 + 0.8 * 0.16, k = 0.8 * 0.4;
    const auto rate = [&](double t, double x) {
      return (k * std::sin(a - 0.4 * t - x) * 0.16 - 0.8 * 0.4 * 9.81 * std::sin(x)) / moment;
    };
    for (int n = 0; n < 10000; ++n) {
      const double t = n * h, k1 = rate(t, b), k2 = rate(t + h / 2, b + h / 2 * db),
                   k3 = rate(t + h / 2, b + h / 2 * db + h * h / 4 * k1), k4 = rate(t + h, b + h * db + h * h / 2 * k2);
      b += h * db + h * h / 6 * (k1 + k2 + k3);
      db += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
    const double lower = value(end.q[0]) + value(result.samples.back().joints[1].q[0]);
    CHECK(std::abs(lower - b) < (scheme.accurate ? 1e-7 : 2e-2));
  }
}

TEST_CASE("a stop holds a falling pendulum") {
  Scene scene = two_link_arm();
  scene.joints[0].limits = JointLimits{0.5, 2, 0};
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = try_run(engine(), method(engine(), scheme.name), scene, Plan{1, 4000, 4});
    INFO(scheme.name << ": " << result.outcome.reason);
    if (!stops()) {
      CHECK(to_string(result.outcome.status) == "unsupported");
      continue;
    }
    REQUIRE(result.outcome.status == Status::ok);
    for (std::size_t at = 1; at < result.samples.size(); ++at)
      CHECK(value(result.samples[at].joints[0].q[0]) > 0.5 - 0.05);
    Scene bouncing = scene;
    bouncing.joints[0].limits->restitution = 0.5;
    CHECK(try_run(engine(), method(engine(), scheme.name), bouncing, Plan{1, 4000, 4}).outcome.status ==
          Status::unsupported);
  }
}

TEST_CASE("two weights on a rope over a point: a = g (m1 - m2) / (m1 + m2), or a refusal") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies = {box_body("heavy", 3, {0.1, 0.1, 0.1}), box_body("light", 2, {0.1, 0.1, 0.1})};
  scene.bodies[0].position_m = {0, 0, -1};
  scene.bodies[1].position_m = {0.4, 0, -1.5};
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  for (const double x : {0.0, 0.4}) {
    Pulley point;
    point.axle_m = {x, 0, 0};
    rope.over.push_back(point);
  }
  scene.ropes = {rope};
  for (const Scheme& scheme : schemes_under_test()) {
    const Run result = try_run(engine(), method(engine(), scheme.name), scene, Plan{0.5, 5000, 5});
    INFO(scheme.name << ": " << result.outcome.reason);
    if (!hangs()) {
      CHECK(to_string(result.outcome.status) == "unsupported");
      CHECK_THAT(result.outcome.reason, Catch::Contains("rope"));
      continue;
    }
    REQUIRE(result.outcome.status == Status::ok);
    CHECK(result.v(0, 2) == Approx(-0.5 * 9.81 / 5).epsilon(0.01));
    CHECK(value(result.samples.back().ropes[0].tension_N) == Approx(2 * 3 * 2 * 9.81 / 5).epsilon(0.01));
    Scene slack = scene;
    slack.bodies[1].velocity_m_per_s = {0, 0, 0};
    slack.gravity_m_per_s2 = {0, 0, 9.81};
    const Run ended = try_run(engine(), method(engine(), scheme.name), slack, Plan{0.5, 5000, 5});
    CHECK(to_string(ended.outcome.status) == "diverged");
    CHECK_THAT(ended.outcome.reason, Catch::Contains("slack"));
  }
}

TEST_CASE("observing a run does not change it") {
  const Scene scene = zoo({JointKind::hinge, JointKind::slider, JointKind::hinge});
  for (const Scheme& scheme : schemes_under_test()) {
    if (scheme.steps_chosen) continue;  // its steps end at samples
    const Run rare = run_with(scheme.name, scene, Plan{0.5, 500, 1}),
              dense = run_with(scheme.name, scene, Plan{0.5, 500, 500});
    INFO(scheme.name);
    for (int j = 0; j < 3; ++j)
      CHECK(value(rare.samples.back().joints[j].q[0]) == value(dense.samples.back().joints[j].q[0]));
  }
}

TEST_CASE("chains of 200 links") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  for (int i = 0; i < 200; ++i) {
    scene.bodies.push_back(box_body("link" + std::to_string(i), 1, {0.1, 0.1, 0.1}));
    Joint joint = joint_of("joint" + std::to_string(i), JointKind::hinge, i - 1, i);
    joint.axis_body = {0, 1, 0};
    joint.anchors_body_m = {{{0, 0, i == 0 ? 0.0 : -0.5}, {0, 0, 0.5}}};
    joint.coordinates[0] = 0.01 * (i % 7);
    scene.joints.push_back(joint);
  }
  place(scene);
  for (const Scheme& scheme : schemes_under_test()) {
    INFO(scheme.name);
    const Run result = run_with(scheme.name, scene, Plan{1e-4, 2, 1});
    check_start(scene, result.samples.front(), 1e-11);  // 200 additions of lengths up to 200 m
    check_kinematics(scene, result.samples.back(), 1e-11);
  }
}

TEST_CASE("the order of bodies and joints in the scene does not matter") {
  const Scene scene = zoo({JointKind::hinge, JointKind::slider, JointKind::hinge});
  Scene shuffled = scene;
  const std::array<int, 4> moved{2, 0, 3, 1};  // where each body goes
  for (int i = 0; i < 4; ++i) shuffled.bodies[moved[i]] = scene.bodies[i];
  for (auto& joint : shuffled.joints) joint.parent = moved[joint.parent], joint.child = moved[joint.child];
  std::swap(shuffled.joints[0], shuffled.joints[2]);
  for (auto& force : shuffled.joint_forces)
    std::visit([](auto& f) { f.joint = f.joint == 0 ? 2 : f.joint == 2 ? 0 : 1; }, force);
  for (const Scheme& scheme : schemes_under_test()) {
    const Run one = run_with(scheme.name, scene, Plan{0.5, 500, 5}),
              other = run_with(scheme.name, shuffled, Plan{0.5, 500, 5});
    INFO(scheme.name);
    for (int j = 0; j < 3; ++j) {
      CHECK(value(one.samples.back().joints[j].q[0]) ==
            Approx(value(other.samples.back().joints[j == 1 ? 1 : 2 - j].q[0])).epsilon(scheme.reordered));
    }
  }
}

}  // namespace atwood::test
