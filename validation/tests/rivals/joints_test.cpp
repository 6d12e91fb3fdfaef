// Coordinates from poses and the wrenches of joint forces, which adapters of engines in maximal coordinates use.
#include "rivals/joints.hpp"

#include <catch2/catch.hpp>

#include "mechanism_scenes.hpp"
#include "rivals/explicit_dampers.hpp"

namespace atwood::test {
namespace {

Joint parentless(JointKind kind) {
  Joint joint = joint_of("joint", kind, -1, 0);
  joint.anchors_body_m = {{{0.3, -0.2, 1}, {0.1, 0.4, -0.2}}};
  joint.axis_body = unit(0.2, -0.7, 0.4);
  joint.frame_wxyz = unit(0.4, -0.5, 0.2, 0.6);
  joint.axes_body[1] = unit(0.3, 0.5, -0.8);
  const V3 second = quaternion(joint.frame_wxyz) * v3(joint.axes_body[1]);
  const V3 first = second.cross(V3(0.1, 0.9, 0.2)).normalized();
  joint.axes_body[0] = {first[0], first[1], first[2]};
  return joint;
}

rivals::Motion motion(const Pose& pose) {
  const Eigen::Quaterniond q(pose.r);
  const V3 w = pose.r.transpose() * pose.w;
  return {{pose.p[0], pose.p[1], pose.p[2]},
          {q.w(), q.x(), q.y(), q.z()},
          {pose.v[0], pose.v[1], pose.v[2]},
          {w[0], w[1], w[2]}};
}

Pose moving_parent() {
  Pose pose;
  pose.p = V3(0.3, 0.2, -0.7);
  pose.r = turn(V3(1, -2, 0.5).normalized(), 2.3);
  pose.v = V3(-0.4, 1.2, 0.6);
  pose.w = V3(0.7, -1.1, 0.4);
  return pose;
}

const std::vector<JointKind> kKinds = {JointKind::hinge,     JointKind::slider, JointKind::cylindrical,
                                       JointKind::universal, JointKind::ball,   JointKind::fixed};

}  // namespace

TEST_CASE("the poses that coordinates and rates give return them") {
  const Pose parent = moving_parent();
  for (const JointKind kind : kKinds) {
    const Joint joint = parentless(kind);
    for (const double angle : {-3.0, -1.2, 0.0, 0.4, 2.9}) {
      rivals::JointState state;
      state.q = {angle, 0.6 - angle, 0, 0};
      if (kind == JointKind::ball) state.q = unit(angle, 0.4, -0.7, 0.2);
      state.u = {0.3, -1.4, 2.2};
      const Pose child = child_pose(joint, parent, state.q, state.u);
      rivals::JointState found = rivals::state_from_motions(joint, motion(parent), motion(child));
      INFO("kind " << static_cast<int>(kind) << ", angle " << angle);
      rivals::continue_coordinates(kind, state, found);
      for (int k = 0; k < coordinate_count(kind); ++k) CHECK(found.q[k] == Approx(state.q[k]).margin(1e-13));
      for (int k = 0; k < rate_count(kind); ++k) CHECK(found.u[k] == Approx(state.u[k]).margin(1e-13));
    }
  }
}

TEST_CASE("coordinates are continued over whole turns, and a quaternion keeps its sign") {
  rivals::JointState last{{13.0, -0.2, 0, 0}, {}}, now{{13.1 - 4 * M_PI, 0.1, 0, 0}, {}};
  rivals::continue_coordinates(JointKind::cylindrical, last, now);
  CHECK(now.q[0] == Approx(13.1));
  CHECK(now.q[1] == 0.1);  // an offset has no turns
  last.q = {0.6, 0, 0.8, 0};
  now.q = {-0.59, 0, -0.81, 0};
  rivals::continue_coordinates(JointKind::ball, last, now);
  CHECK(now.q[0] == 0.59);
}

// Power of the wrenches on both bodies is effort times rate, for every motion: this determines the wrenches up to
// forces of constraint, and the internal force has no resultant.
TEST_CASE("joint forces as wrenches have the power of effort times rate, and no resultant") {
  const Pose parent = moving_parent();
  for (const JointKind kind : kKinds) {
    Scene scene = empty_scene();
    scene.bodies = {oblique_body("child", 1, 0.2), oblique_body("parent", 1, 0.5)};
    Joint joint = parentless(kind);
    joint.parent = 1;
    scene.joints = {joint};
    rivals::JointState state{{0.7, -0.4, 0, 0}, {0.3, -1.4, 2.2}};
    if (kind == JointKind::ball) state.q = unit(0.5, 0.4, -0.7, 0.2);
    const Pose child = child_pose(joint, parent, state.q, state.u);
    std::vector<rivals::Wrench> wrenches(2);
    const std::vector<Real3> efforts = {{1.5, -0.8, kind == JointKind::ball ? 0.6 : 0}};
    rivals::add_joint_wrenches(scene, {motion(child), motion(parent)}, efforts, wrenches);
    double power = 0, expected = 0;
    V3 force = V3::Zero(), torque = V3::Zero();
    for (int i = 0; i < 2; ++i) {
      const Pose& pose = i == 0 ? child : parent;
      power += v3(wrenches[i].force_N).dot(pose.v) + v3(wrenches[i].torque_N_m).dot(pose.w);
      force += v3(wrenches[i].force_N);
      torque += v3(wrenches[i].torque_N_m) + pose.p.cross(v3(wrenches[i].force_N));
    }
    for (int k = 0; k < rate_count(kind); ++k) expected += efforts[0][k] * state.u[k];
    INFO("kind " << static_cast<int>(kind));
    CHECK(power == Approx(expected).margin(1e-13));
    CHECK(force.norm() < 1e-13);
    CHECK(torque.norm() < 1e-13);
  }
}

TEST_CASE("springs and motors along a coordinate") {
  Scene scene = empty_scene();
  scene.bodies = {oblique_body("child", 1, 0.2)};
  scene.joints = {parentless(JointKind::cylindrical)};
  scene.joint_forces = {JointSpring{0, 1, 3, 0.5, 0.2}, JointSpring{0, 1, 1, 0.1, 0},
                        JointTorque{0, 0, 2, 4, 0.3, {{1, 2}}}};
  const std::vector<rivals::JointState> states = {{{0.2, 0.9, 0, 0}, {0.1, -0.6, 0}}};
  const auto on = rivals::joint_efforts(scene, 1.25, 1.25, states), off = rivals::joint_efforts(scene, 2, 2, states);
  CHECK(on[0][0] == Approx(2 * std::cos(4 * 1.25 + 0.3)));
  CHECK(on[0][1] == Approx(-3 * 0.4 + 0.2 * 0.6 - 1 * 0.8));
  CHECK(off[0][0] == 0);
  const rivals::PassiveForce sum = rivals::passive_force(scene, 0, 1);
  CHECK(sum.stiffness * (0.9 - sum.rest) == Approx(3 * 0.4 + 1 * 0.8));
  CHECK(sum.damping == Approx(0.2));
}

TEST_CASE("bodies stand after their parents, and point masses that turn are found") {
  Scene scene = zoo({JointKind::slider, JointKind::hinge, JointKind::fixed});
  for (auto& joint : scene.joints) joint.parent = 3 - joint.parent, joint.child = 3 - joint.child;
  CHECK(rivals::parents_first(scene) == std::vector<int>{3, 2, 1, 0});
  CHECK(rivals::turning_point_mass(scene) == -1);
  scene.bodies[0].inertia_kg_m2 = {};
  CHECK(rivals::turning_point_mass(scene) == 0);
  scene.joints = {joint_of("rail", JointKind::slider, -1, 0)};
  CHECK(rivals::turning_point_mass(scene) == -1);
}

TEST_CASE("the largest step of an explicit damper is 2 I / c, with the inertia that joints leave to it") {
  const auto largest_s = [](const Scene& scene) { return rivals::explicit_dampers(scene, true, true)->largest_step_s; };
  Scene scene = empty_scene();
  scene.bodies = {box_body("a", 2, {0.1, 0.2, 0.3}), box_body("b", 3, {0.4, 0.5, 0.6})};
  scene.bodies[1].position_m = {0, 0.7, 0};
  CHECK_FALSE(rivals::explicit_dampers(scene, true, true));
  scene.forces = {LinearDrag{{0}, 5, {}, 0}};
  CHECK(largest_s(scene) == Approx(2 * 2 / 5.0));
  CHECK_FALSE(rivals::explicit_dampers(scene, true, false));
  scene.forces = {LinearDrag{{0}, 0, {}, 5}};
  CHECK(largest_s(scene) == Approx(2 * 0.1 / 5));
  scene.forces = {Spring{{0, 1}, {}, 0, 5, 1, {}}};  // the reduced mass
  CHECK(largest_s(scene) == Approx(2 * (2 * 3 / 5.0) / 5));
  scene.forces.clear();

  // b turns about z at (0, 0.7, 0) on a, which is free: without forces on the pair the relative turn has the inertia of
  // two wheels on an axle, where both centres of mass lie on it.
  Joint axle = joint_of("axle", JointKind::hinge, 0, 1);
  axle.axis_body = {0, 0, 1};
  axle.anchors_body_m = {{{0, 0, 0.7}, {0, 0, 0}}};
  scene.joints = {axle};
  scene.joint_forces = {JointSpring{0, 0, 1, 0, 5}};
  place(scene);
  CHECK(largest_s(scene) == Approx(2 * (0.3 * 0.6 / 0.9) / 5));
  scene.bodies[0].fixed = true;  // a pendulum of b: I + m r^2
  scene.joints[0].anchors_body_m[1] = {0.2, 0, 0};
  place(scene);
  CHECK(largest_s(scene) == Approx(2 * (0.6 + 3 * 0.04) / 5));
  CHECK(rivals::explicit_dampers(scene, true, true)->stiffest == "the damper of the joint `axle`");
  CHECK_FALSE(rivals::explicit_dampers(scene, false, true));

  // Two dampers on one axle: c1 and c2 act together; held at both ends of a loop no rate is left.
  scene.joint_forces.push_back(JointSpring{0, 0, 0, 0, 3});
  CHECK(largest_s(scene) == Approx(2 * (0.6 + 3 * 0.04) / 8));
  Joint weld = scene.joints[0];
  weld.kind = JointKind::fixed;
  weld.closes_loop = true;
  scene.joints.push_back(weld);
  CHECK_FALSE(rivals::explicit_dampers(scene, true, true));
}

// Two wheels in a row, each with a damper to the one before: C and I of the rates u1, u1 + u2 give the bound by hand.
TEST_CASE("dampers that act on each other are bound together") {
  Scene scene = empty_scene();
  scene.bodies = {box_body("first", 1, {1, 1, 1}), box_body("second", 1, {1, 1, 1})};
  Joint one = joint_of("one", JointKind::hinge, -1, 0), two = joint_of("two", JointKind::hinge, 0, 1);
  one.axis_body = two.axis_body = {0, 0, 1};
  scene.joints = {one, two};
  scene.joint_forces = {JointSpring{0, 0, 0, 0, 1}, JointSpring{1, 0, 0, 0, 1}};
  place(scene);
  // w1' = -w1 + (w2 - w1), w2' = -(w2 - w1): eigenvalues (3 +- sqrt 5) / 2.
  CHECK(rivals::explicit_dampers(scene, true, true)->largest_step_s == Approx(2 / ((3 + std::sqrt(5.0)) / 2)));
}

}  // namespace atwood::test
