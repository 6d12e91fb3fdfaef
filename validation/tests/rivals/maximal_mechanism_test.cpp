// Engines whose bodies keep six degrees of freedom and whose joints are constraints: poses that the joints' coordinates
// describe up to a small gap, bodies that obey Newton's and Euler's equations under the reported reactions, known
// motions.
#include <boost/math/special_functions/ellint_1.hpp>
#include <catch2/catch.hpp>
#include <numbers>

#include "mechanism_scenes.hpp"
#include "under_test.hpp"

namespace atwood::test {
namespace {

const Engine& engine() {
  static const Engine made = engine_under_test();
  return made;
}
Run run_with(const Scene& scene, const Plan& plan, const Settings& settings = {}) {
  Run result = run(engine(), method(engine(), "default", settings), scene, plan);
  INFO(result.outcome.reason);
  REQUIRE(to_string(result.outcome.status) == "ok");
  return result;
}
double value(Wide x) { return static_cast<double>(x); }
double largest(const Eigen::MatrixXd& m) { return m.cwiseAbs().maxCoeff(); }

// Positions and attitudes of the children are those that their coordinates give; velocities follow from the rates.
void check_kinematics(const Scene& scene, const Sample& sample, double gap, double gap_rate) {
  REQUIRE(sample.joints.size() == scene.joints.size());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    INFO("t = " << value(sample.t_s) << ", " << joint.name);
    const Pose child = pose_of(sample, joint.child);
    const Pose expected = child_pose(joint, pose_of(sample, joint.parent), sample.joints[j].q, sample.joints[j].u);
    CHECK(largest(child.p - expected.p) < gap);
    CHECK(largest(child.r - expected.r) < gap);
    CHECK(largest(child.v - expected.v) < gap_rate);
    CHECK(largest(child.w - expected.w) < gap_rate);
  }
}

// A step changes momenta by the forces at its beginning: gravity and the reactions that its end reports. The linear
// part is the engines' own step; the angular part has the gyroscopic term, which each steps in its own way.
void check_step(const Scene& scene, const Sample& before, const Sample& after, double angular) {
  const double h_s = value(after.t_s - before.t_s);
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Body& body = scene.bodies[static_cast<std::size_t>(i)];
    if (body.fixed) continue;
    const Pose a = pose_of(before, i), b = pose_of(after, i);
    const M3 inertia = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(body.inertia_kg_m2.data());
    const auto spin = [&](const Pose& pose) { return V3(pose.r * (inertia * (pose.r.transpose() * pose.w))); };
    V3 force = body.mass_kg * v3(scene.gravity_m_per_s2), torque = V3::Zero();
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      const Joint& joint = scene.joints[j];
      if (joint.parent != i && joint.child != i) continue;
      const double sign = joint.child == i ? 1 : -1;
      const Pose child = pose_of(before, joint.child);
      const V3 anchor = child.p + child.r * v3(joint.anchors_body_m[1]);
      const V3 f = sign * v3(after.joints[j].force_N);
      force += f;
      torque += (anchor - a.p).cross(f) + sign * v3(after.joints[j].torque_N_m);
    }
    INFO("t = " << value(before.t_s) << ", " << body.name);
    CHECK(largest(body.mass_kg * (b.v - a.v) / h_s - force) < 1e-8);
    CHECK(largest((spin(b) - spin(a)) / h_s - torque) < angular);
  }
}

// No spring and no motor acts, so that the reactions are all that joints transmit.
Scene free_zoo(const std::vector<JointKind>& kinds) {
  Scene scene = zoo(kinds);
  scene.joint_forces.clear();
  return scene;
}

Settings converged() { return is_bullet(engine()) ? Settings{{"iterations", std::int64_t{100}}} : Settings{}; }

using enum JointKind;
const std::vector<std::vector<JointKind>> kChains{
    {hinge, slider, hinge}, {ball, hinge}, {universal, fixed, hinge}, {cylindrical, ball}, {slider, universal}};

}  // namespace

TEST_CASE("each kind of joint is the scene's: kinematics, and momenta that its reaction changes") {
  for (const auto& kinds : kChains) {
    const Scene scene = free_zoo(kinds);
    const Run result = run_with(scene, Plan{0.1, 10000, 10000}, converged());
    INFO("first joint " << static_cast<int>(kinds[0]));
    check_kinematics(scene, result.samples.front(), 1e-14, 1e-13);
    CHECK(std::isnan(value(result.samples.front().joints[0].force_N[0])));
    for (const std::size_t at : {1, 5000, 9999}) {
      check_kinematics(scene, result.samples[at], 1e-8, 1e-3);
      check_step(scene, result.samples[at], result.samples[at + 1], 1e-4);
    }
  }
}

TEST_CASE("springs, dampers and motors act along the coordinates, once a step") {
  // Against the same motions in a step half as long: both converge to one motion, the scene's, in the first order.
  for (const auto& kinds : kChains) {
    const Scene scene = zoo(kinds);
    std::array<Run, 3> runs;
    for (int k = 0; k < 3; ++k) runs[k] = run_with(scene, Plan{0.4, 8000 << k, 4}, converged());
    CHECK_THAT(runs[0].outcome.reason, Catch::Contains("once a step: joint-spring, joint-torque"));
    const auto q = [&](int k, std::size_t j) { return value(runs[k].samples.back().joints[j].q[0]); };
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      if (scene.joints[j].kind == fixed) continue;
      INFO("first joint " << static_cast<int>(kinds[0]) << ", joint " << j);
      CHECK(std::abs(q(0, j) - q(1, j)) < 2e-4);
      CHECK((q(0, j) - q(1, j)) / (q(1, j) - q(2, j)) == Approx(2).epsilon(0.15));
    }
  }
}

TEST_CASE("a sprung wheel oscillates about its rest as a damped oscillator") {
  Scene scene = empty_scene();
  scene.bodies = {box_body("wheel", 1, {0.2, 0.3, 0.4})};
  Joint axle = joint_of("axle", hinge, -1, 0);
  axle.axis_body = {0, 0, 1};
  axle.coordinates[0] = 1.1;
  scene.joints = {axle};
  scene.joint_forces = {JointSpring{0, 0, 6.4, 0.5, 0.08}, JointTorque{0, 0, 0.64, 0, 0, {}}};
  place(scene);
  // w^2 = 6.4 / 0.4 = 16, 2 d = 0.08 / 0.4, rest at 0.5 + 0.64 / 6.4.
  const double d = 0.1, w = std::sqrt(16 - d * d), t = 2;
  const double expected = 0.6 + 0.5 * std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
  const Run result = run_with(scene, Plan{t, 40000, 4});
  CHECK(value(result.samples.back().joints[0].q[0]) == Approx(expected).margin(2e-4));
  CHECK(value(result.samples.back().joints[0].applied[0]) ==
        Approx(-6.4 * (value(result.samples.back().joints[0].q[0]) - 0.5) -
               0.08 * value(result.samples.back().joints[0].u[0]) + 0.64)
            .epsilon(1e-12));
}

// A light link, I = 0.01 + 0.1 x 0.1^2 = 0.011 kg m2 about its hinge, with c = 50 N m s: c h = 2 I at h = 0.44 ms.
TEST_CASE("a damper is stable up to c h = 2 I; beyond, the row names it and the bound") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.8};
  scene.bodies = {box_body("link", 0.1, {0.01, 0.01, 0.01})};
  Joint hinge_joint = joint_of("pin", hinge, -1, 0);
  hinge_joint.axis_body = {0, 1, 0};
  hinge_joint.anchors_body_m = {{{0, 0, 0}, {0, 0, 0.1}}};
  hinge_joint.coordinates[0] = 1.5;
  scene.joints = {hinge_joint};
  scene.joint_forces = {JointSpring{0, 0, 0, 0, 50}};
  place(scene);
  const auto after = [&](double h_s, double t_end_s) {
    const auto steps = static_cast<std::int64_t>(std::llround(t_end_s / h_s));
    return try_run(engine(), method(engine(), "default"), scene, Plan{h_s * static_cast<double>(steps), steps, 1});
  };
  const Run within = after(0.43e-3, 0.4);
  CHECK(within.outcome.status == Status::ok);
  CHECK(std::abs(value(within.samples.back().joints[0].u[0])) < 0.01);
  CHECK_THAT(within.outcome.reason, !Catch::Contains("unstable"));
  const Run beyond = after(0.45e-3, 0.4);  // grows by 1.045 a step
  CHECK(to_string(beyond.outcome.status) == "diverged");
  CHECK_THAT(beyond.outcome.reason, Catch::Contains("can only take energy"));
  const Run lost = after(4e-3, 2);
  CHECK(to_string(lost.outcome.status) == "not finite");
  for (const Run* run : {&beyond, &lost})
    CHECK_THAT(run->outcome.reason, Catch::Contains("the damper of the joint `pin` is explicit") &&
                                        Catch::Contains("c h = 2 I: h = 0.00044 s"));
}

TEST_CASE("a pendulum of large swing is at its mirror image after half an elliptic period") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies = {oblique_body("bob", 1.3, 0.8)};
  Joint pivot = joint_of("pivot", hinge, -1, 0);
  pivot.axis_body = unit(0.2, 1, -0.3);
  const V3 axis = v3(pivot.axis_body), down = axis.cross(V3(0, 0, -1)).cross(axis).normalized();
  const V3 reach = -0.7 * down + 0.2 * axis;  // from the centre of mass to the pivot
  pivot.anchors_body_m = {{{0.1, 0.2, 0.3}, {reach[0], reach[1], reach[2]}}};
  pivot.coordinates[0] = 2.2;
  scene.joints = {pivot};
  place(scene);
  const M3 inertia =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(scene.bodies[0].inertia_kg_m2.data());
  const double moment = axis.dot(inertia * axis) + 1.3 * 0.49;
  const double slope = std::sqrt(1 - axis[2] * axis[2]);  // of gravity, across the axis
  const double half_period_s =
      2 * std::sqrt(moment / (1.3 * 9.81 * slope * 0.7)) * boost::math::ellint_1(std::sin(1.1));
  const Run coarse = run_with(scene, Plan{half_period_s, 16000, 4}),
            fine = run_with(scene, Plan{half_period_s, 32000, 4});
  const auto end = [](const Run& run) { return run.samples.back().joints[0]; };
  CHECK(value(end(fine).q[0]) == Approx(-2.2).margin(2e-5));
  CHECK(value(end(fine).u[0]) == Approx(0).margin(5e-4));
  CHECK((value(end(coarse).q[0]) + 2.2) / (value(end(fine).q[0]) + 2.2) == Approx(2).epsilon(0.05));
  CHECK(value(end(coarse).u[0]) / value(end(fine).u[0]) == Approx(2).epsilon(0.05));
}

TEST_CASE("a hanging body pulls with its weight, and turns its joint by its arm") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -10};
  scene.bodies = {box_body("beam", 3, {0.3, 0.3, 0.1})};
  Joint clamp = joint_of("clamp", fixed, -1, 0);
  clamp.anchors_body_m = {{{1, 0, 0}, {-0.5, 0, 0}}};
  scene.joints = {clamp};
  place(scene);
  const JointSample end = run_with(scene, Plan{0.1, 100, 1}, converged()).samples.back().joints[0];
  const V3 force = v3(end.force_N), torque = v3(end.torque_N_m);
  CHECK(largest(force - V3(0, 0, 30)) < 1e-6);
  CHECK(largest(torque - V3(0, -15, 0)) < 1e-6);  // the weight's moment about the anchor is (0.5, 0, 0) x (0, 0, -30)
}

TEST_CASE("angles go on past half a turn") {
  Scene scene = oblique_pendulum();
  scene.gravity_m_per_s2 = {};
  scene.joints[0].rates[0] = 20;
  scene.joints[0].coordinates[0] = -9;
  place(scene);
  const Run result = run_with(scene, Plan{2, 40000, 4}, converged());
  CHECK(value(result.samples.front().joints[0].q[0]) == Approx(-9).epsilon(1e-12));
  CHECK(value(result.samples.back().joints[0].q[0]) == Approx(31).epsilon(1e-3));
}

TEST_CASE("prescribed rates are kept, with the torque as a reaction") {
  for (const double sign : {-1.0, 1.0}) {
    Scene turning = two_link_arm();
    turning.joints[0].driven_rate = turning.joints[0].rates[0] = 0.7 * sign;
    place(turning);
    const Run arm = run_with(turning, Plan{1, 10000, 10000}, converged());
    CHECK(value(arm.samples.back().joints[0].q[0]) == Approx(0.9 + 0.7 * sign).epsilon(1e-6));
    check_step(turning, arm.samples[5000], arm.samples[5001], 1e-3);
    CHECK(std::abs(value(arm.samples[5000].joints[0].torque_N_m[1])) > 0.1);

    Scene sliding = free_zoo({slider});
    sliding.joints[0].driven_rate = sliding.joints[0].rates[0] = 0.4 * sign;
    place(sliding);
    const Run sledge = run_with(sliding, Plan{1, 10000, 10000}, converged());
    CHECK(value(sledge.samples.back().joints[0].q[0]) == Approx(0.3 + 0.4 * sign).epsilon(1e-4));
    check_step(sliding, sledge.samples[5000], sledge.samples[5001], 1e-3);
  }
}

// A wheel under a constant torque of -10 I turns from 1.25 rad to its stop at 0, which it meets at 0.5 s with -5 rad/s.
TEST_CASE("stops give back the rate that they should, at both ends") {
  for (const double side : {1.0, -1.0}) {
    for (const double restitution : {0.0, 0.5}) {
      Scene scene = empty_scene();
      scene.bodies = {box_body("wheel", 1, {0.2, 0.3, 0.4})};
      Joint axle = joint_of("axle", hinge, -1, 0);
      axle.axis_body = {0, 0, 1};
      axle.coordinates[0] = side * 1.25;
      axle.limits = side > 0 ? JointLimits{0, 2, restitution} : JointLimits{-2, 0, restitution};
      scene.joints = {axle};
      scene.joint_forces = {JointTorque{0, 0, -4 * side, 0, 0, {}}};
      place(scene);
      const Run result = run_with(scene, Plan{0.75, 7500, 3});
      INFO("side " << side << ", restitution " << restitution);
      CHECK(value(result.samples[1].joints[0].q[0]) == Approx(side * (1.25 - 5 * 0.0625)).margin(1e-3));
      const double expected = restitution > 0 ? side * (2.5 * 0.25 - 5 * 0.0625) : 0;
      CHECK(value(result.samples.back().joints[0].q[0]) == Approx(expected).margin(5e-3));
    }
  }
}

TEST_CASE("while a stop acts ODE's joints report the whole weight that they carry, and Bullet's nothing") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -10};
  scene.bodies = {box_body("beam", 3, {0.3, 0.3, 0.1}), box_body("lift", 2, {0.1, 0.1, 0.1})};
  Joint clamp = joint_of("clamp", fixed, -1, 0);
  Joint rail = joint_of("rail", slider, 0, 1);
  rail.axis_body = {0, 0, 1};
  rail.limits = JointLimits{0, 9, 0};
  scene.joints = {clamp, rail};
  place(scene);
  const V3 force = v3(run_with(scene, Plan{0.5, 2000, 1}, converged()).samples.back().joints[0].force_N);
  if (is_bullet(engine())) CHECK(std::isnan(force[2]));
  else CHECK(largest(force - V3(0, 0, 50)) < 1e-3);
}

TEST_CASE("a slider's stop holds it; its bounce is exact or refused") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -10};
  scene.bodies = {oblique_body("lift", 2, 0.7)};
  Joint rail = joint_of("rail", slider, -1, 0);
  rail.axis_body = {0, 0, 1};
  rail.coordinates[0] = 1.25;
  rail.limits = JointLimits{0, 9, 0};
  scene.joints = {rail};
  place(scene);
  CHECK(value(run_with(scene, Plan{1, 8000, 4}).samples.back().joints[0].q[0]) == Approx(0).margin(1e-3));
  scene.joints[0].limits->restitution = 0.5;
  const Run bounce = try_run(engine(), method(engine(), "default"), scene, Plan{0.75, 7500, 3});
  if (is_bullet(engine())) {
    CHECK(to_string(bounce.outcome.status) == "unsupported");
    CHECK_THAT(bounce.outcome.reason, Catch::Contains("rail"));
  } else {
    CHECK(value(bounce.samples.back().joints[0].q[0]) == Approx(2.5 * 0.25 - 5 * 0.0625).margin(5e-3));
  }
}

TEST_CASE("closing joints of every kind hold their loop, under reactions that obey Newton and Euler") {
  for (const JointKind kind : {fixed, hinge, slider, cylindrical, universal, ball}) {
    Scene scene = free_zoo({hinge, ball, hinge});
    scene.bodies[0].velocity_m_per_s = scene.bodies[0].angular_velocity_body_rad_per_s = {};
    for (auto& joint : scene.joints) joint.rates = {};
    place(scene);
    scene.joints.push_back(closing_joint(scene, kind, 3));
    const Run result = run_with(scene, Plan{0.05, 5000, 5000}, converged());
    INFO("closing joint " << static_cast<int>(kind));
    for (const std::size_t n : {1, 2500, 4999}) {
      check_kinematics(scene, result.samples[n], 1e-7, 1e-3);
      check_step(scene, result.samples[n], result.samples[n + 1], 1e-3);
    }
    const V3 fall = pose_of(result.samples.back(), 0).v - 0.05 * v3(scene.gravity_m_per_s2);
    CHECK(largest(fall) > 1e-3);  // without the loop the base would fall freely
  }
}

TEST_CASE("what the engine lacks is refused by name") {
  const auto reason = [](const Scene& scene, const Settings& settings = {}) {
    const Run result = try_run(engine(), method(engine(), "default", settings), scene, Plan{1, 10, 1});
    CHECK(to_string(result.outcome.status) == "unsupported");
    return result.outcome.reason;
  };
  Scene roped = free_zoo({hinge});
  Rope rope;
  rope.name = "halyard";
  rope.bodies = {0, 1};
  roped.ropes = {rope};
  CHECK_THAT(reason(roped), Catch::Contains("rope") && Catch::Contains("halyard"));
  Scene pointed = two_link_arm();
  pointed.bodies[1].inertia_kg_m2 = {};
  CHECK_THAT(reason(pointed), Catch::Contains("inertia") && Catch::Contains("lower"));
  Scene wide = two_link_arm();
  wide.joints[1].limits = JointLimits{-4, 4, 0};
  CHECK_THAT(reason(wide), Catch::Contains("elbow"));
  Scene both = two_link_arm();
  both.joints[1].limits = JointLimits{-2, 1, 0};
  both.joints[1].driven_rate = 1;
  CHECK_THAT(reason(both), Catch::Contains("elbow") && Catch::Contains("driven"));
  if (engine().name != "ode") return;
  Scene looped = two_link_arm();
  Joint closing = joint_of("closing", ball, -1, 1);
  closing.closes_loop = true;
  closing.coordinates = {1, 0, 0, 0};
  const Real3 p = looped.bodies[1].position_m;
  closing.anchors_body_m[0] = {p[0], p[1], p[2]};
  looped.joints.push_back(closing);
  CHECK_THAT(reason(looped, {{"cfm", 0.0}}), Catch::Contains("cfm") && Catch::Contains("closing"));
}

}  // namespace atwood::test
