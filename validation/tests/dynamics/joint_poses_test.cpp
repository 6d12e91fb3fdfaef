// Joint coordinates, gaps and tilts of poses that are composed by hand from the joints' definitions; ropes over pulleys
// whose lengths follow from right triangles; energies of joints.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "dynamics/arithmetic.hpp"
#include "dynamics/invariants.hpp"
#include "dynamics/joint_energy.hpp"
#include "dynamics/joint_poses.hpp"

using namespace atwood;
using namespace atwood::dynamics;
using Turn = std::array<Wide, 4>;
using Vector = std::array<Wide, 3>;

namespace {

Turn turn_about(const Real3& axis, double angle) {
  const Wide s = sinq(Wide(angle) / 2), c = cosq(Wide(angle) / 2);
  return {c, s * axis[0], s * axis[1], s * axis[2]};
}

Turn operator*(const Turn& a, const Turn& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

constexpr Real3 kAnchorP{0.3, -0.2, 0.5}, kAnchorC{-0.1, 0.4, 0.25};
constexpr Real3 kAxis{0.6, 0, 0.8}, kAcross{0, 1, 0};

// A parent that is neither at the origin nor upright, and turns; F is a turn about the parent's y.
struct Rig {
  Scene scene;
  Sample sample;
  Turn frame = turn_about({0, 1, 0}, 0.7);

  explicit Rig(JointKind kind) {
    scene.bodies.resize(2);
    Joint joint;
    joint.kind = kind;
    joint.parent = 0, joint.child = 1;
    joint.anchors_body_m = {kAnchorP, kAnchorC};
    joint.axis_body = kAxis;
    for (int i = 0; i < 4; ++i) joint.frame_wxyz[i] = static_cast<double>(frame[i]);
    scene.joints = {joint};
    sample.bodies.resize(2);
    sample.bodies[0].p_m = {1, 2, 3};
    sample.bodies[0].q_wxyz = turn_about({0, 0, 1}, 1.1) * turn_about({1, 0, 0}, -0.4);
    sample.bodies[0].v_m_per_s = {0.1, 0.2, -0.3};
    sample.bodies[0].w_rad_per_s = {0.5, -0.7, 0.9};
  }
  // Sets the child's pose: R_child = R_parent relative; its anchor `apart` from the parent's, in the child's axes.
  void place(const Turn& relative, const Vector& apart = {0, 0, 0}) {
    BodySample &p = sample.bodies[0], &c = sample.bodies[1];
    c.q_wxyz = p.q_wxyz * relative;
    c.p_m = p.p_m + rotate(p.q_wxyz, widen<Wide>(kAnchorP)) + rotate(c.q_wxyz, apart - widen<Wide>(kAnchorC));
  }
  // Sets the child's velocity: w_child = R^T w_parent + relative, and the anchors move apart by `apart`, child's axes.
  void move(const Vector& relative, const Vector& apart_rate = {0, 0, 0}, const Vector& apart = {0, 0, 0}) {
    BodySample &p = sample.bodies[0], &c = sample.bodies[1];
    const Vector w_p = rotate(p.q_wxyz, p.w_rad_per_s);
    c.w_rad_per_s = rotate_back(c.q_wxyz, w_p) + relative;
    const Vector w_c = rotate(c.q_wxyz, c.w_rad_per_s);
    const Vector at_p = p.v_m_per_s + cross(w_p, rotate(p.q_wxyz, widen<Wide>(kAnchorP)));
    // d/dt (R_child apart) = R_child apart' + w x R_child apart
    c.v_m_per_s = at_p + rotate(c.q_wxyz, apart_rate) + cross(w_c, rotate(c.q_wxyz, apart)) -
                  cross(w_c, rotate(c.q_wxyz, widen<Wide>(kAnchorC)));
  }
  JointPose read() const { return joint_pose(scene, 0, sample); }
};

bool close(Wide a, double b) { return std::fabs(static_cast<double>(a - Wide(b))) < 1e-15; }

}  // namespace

TEST_CASE("joint poses: a hinge's angle and rate") {
  for (double angle : {-3.0, -0.5, 0.0, 1e-9, 2.0, 3.14}) {
    Rig rig(JointKind::hinge);
    rig.place(rig.frame * turn_about(kAxis, angle));
    rig.move(Wide(2.5) * widen<Wide>(kAxis));
    const JointPose pose = rig.read();
    CHECK(close(pose.q[0], angle));
    CHECK(close(pose.u[0], 2.5));
    CHECK(close(pose.gap_m, 0));
    CHECK(close(pose.tilt_rad, 0));
  }
}

TEST_CASE("joint poses: what a hinge does not allow is gap and tilt") {
  Rig rig(JointKind::hinge);
  rig.place(rig.frame * turn_about(kAxis, 0.8) * turn_about(kAcross, 0.01), {3e-3, 0, 4e-3});
  const JointPose pose = rig.read();
  CHECK(close(pose.gap_m, 5e-3));
  CHECK(close(pose.tilt_rad, 0.01));
  CHECK(close(pose.q[0], 0.8));
}

TEST_CASE("joint poses: sliders and cylindrical joints open along their axis only") {
  Rig rig(JointKind::cylindrical);
  const Vector along = Wide(-0.35) * widen<Wide>(kAxis);
  rig.place(rig.frame * turn_about(kAxis, -1.2), along + Wide(2e-3) * widen<Wide>(kAcross));
  rig.move(Wide(0.75) * widen<Wide>(kAxis), Wide(1.5) * widen<Wide>(kAxis), along);
  const JointPose turned = rig.read();
  CHECK(close(turned.q[0], -1.2));
  CHECK(close(turned.q[1], -0.35));
  CHECK(close(turned.u[0], 0.75));
  CHECK(close(turned.gap_m, 2e-3));

  Rig slider(JointKind::slider);
  slider.place(slider.frame * turn_about(kAcross, 0.02), along);
  slider.move({0, 0, 0}, Wide(1.5) * widen<Wide>(kAxis), along);
  CHECK(close(slider.read().q[0], -0.35));
  CHECK(close(slider.read().u[0], 1.5));
  CHECK(close(slider.read().tilt_rad, 0.02));
  CHECK(close(slider.read().gap_m, 0));

  Rig fixed(JointKind::fixed);
  fixed.place(fixed.frame * turn_about(kAxis, 0.03));
  CHECK(close(fixed.read().tilt_rad, 0.03));
}

TEST_CASE("joint poses: a universal joint's two angles and rates") {
  // The second axis, in the child's axes, is the turn of one that is orthogonal to the first by the frame's inverse.
  Rig rig(JointKind::universal);
  const Real3 first{0, 0, 1};
  const Vector second = rotate_back(rig.frame, Vector{1, 0, 0});
  Real3 a2;
  for (int i = 0; i < 3; ++i) a2[i] = static_cast<double>(second[i]);
  rig.scene.joints[0].axes_body = {first, a2};
  const Turn relative = turn_about(first, 0.9) * rig.frame * turn_about(a2, -2.1);
  rig.place(relative);
  // w_rel in the child's axes: the first axis seen from the child, and the second.
  const Vector w = Wide(0.4) * rotate_back(relative, widen<Wide>(first)) + Wide(-1.3) * widen<Wide>(a2);
  rig.move(w);
  const JointPose pose = rig.read();
  CHECK(close(pose.q[0], 0.9));
  CHECK(close(pose.q[1], -2.1));
  CHECK(close(pose.u[0], 0.4));
  CHECK(close(pose.u[1], -1.3));
  CHECK(close(pose.tilt_rad, 0));
  // Turned about what is orthogonal to both axes, their angle changes by as much.
  rig.place(turn_about(first, 0.9) * turn_about({0, 1, 0}, 0.01) * rig.frame * turn_about(a2, -2.1));
  CHECK(close(rig.read().tilt_rad, 0.01));
}

TEST_CASE("joint poses: a ball's rate is relative, in the child's axes") {
  Rig rig(JointKind::ball);
  const Turn Q = turn_about(kAxis, 2.2);
  rig.place(rig.frame * Q);
  rig.move({1, 2, -3});
  const JointPose pose = rig.read();
  for (int i = 0; i < 4; ++i) CHECK(close(pose.q[i], static_cast<double>(Q[i])));
  CHECK(close(pose.u[0], 1));
  CHECK(close(pose.u[1], 2));
  CHECK(close(pose.u[2], -3));
}

TEST_CASE("joint poses: angles are continued from the sample before, the world is a parent") {
  Scene scene;
  scene.bodies.resize(1);
  Joint joint;
  joint.parent = -1, joint.child = 0;
  joint.axis_body = {0, 0, 1};
  joint.coordinates[0] = 3.0;
  scene.joints = {joint};
  std::vector<JointSample> before = joints_at_start(scene);
  for (double angle = 3.0; angle < 20; angle += 1.5) {
    Sample sample;
    sample.bodies.resize(1);
    sample.bodies[0].q_wxyz = turn_about({0, 0, 1}, angle);
    before = joints_of(scene, sample, before);
    CHECK(static_cast<double>(before[0].q[0]) == Approx(angle).margin(1e-14));
  }
}

namespace {

// Two bodies that hang on a rope over a pulley at the origin; the first at the right, the axis away from the reader, so
// that the rope runs up at the right, over the top to the left, and down: with y up, from +x over +y to -x is positive
// about +z.
Scene atwood_machine(double radius, double inertia) {
  Scene scene;
  scene.gravity_m_per_s2 = {0, -9.75, 0};
  scene.bodies.resize(2);
  scene.bodies[0].mass_kg = 1, scene.bodies[1].mass_kg = 3;
  Pulley pulley;
  pulley.radius_m = radius, pulley.inertia_kg_m2 = inertia;
  Rope rope;
  rope.bodies = {0, 1};
  rope.over = {pulley};
  scene.ropes = {rope};
  return scene;
}

}  // namespace

TEST_CASE("joint poses: the length of a rope over a pulley") {
  const Scene scene = atwood_machine(0.25, 0);
  Sample sample;
  sample.bodies.resize(2);
  sample.bodies[0].p_m = {0.25, -2, 0};
  sample.bodies[1].p_m = {-0.25, -3, 0};
  sample.bodies[0].v_m_per_s = {0, 0.5, 0};
  CHECK(close(rope_length_m(scene, scene.ropes[0], sample), 5 + 0.25 * std::acos(-1.0)));
  CHECK(close(rope_speed_m_per_s(scene, scene.ropes[0], sample), 0.5));

  // A right triangle of legs 0.75 (axle to tangent point) and 1 (straight part) with the hypotenuse 1.25. The rope
  // touches at (0.6, 0.8) of the radius, from where it runs counterclockwise to (-1, 0).
  const Scene wide = atwood_machine(0.75, 0);
  sample.bodies[1].p_m = {-0.75, -2, 0};
  sample.bodies[0].p_m = {1.25, 0, 0};
  const double arc = std::acos(-1.0) - std::acos(0.6);
  CHECK(static_cast<double>(rope_length_m(wide, wide.ropes[0], sample)) == Approx(1 + 2 + 0.75 * arc).margin(1e-14));
  // The straight part points along (-0.8, 0.6): the rope moves with the body's velocity along it.
  sample.bodies[0].v_m_per_s = {1, 2, 0};
  CHECK(close(rope_speed_m_per_s(wide, wide.ropes[0], sample), -0.8 + 1.2));
}

TEST_CASE("joint poses: a rope between two pulleys, open and crossed") {
  // Axles 1 m apart, radii 0.5 and 0.25. Open: the straight part is the root of 1 - 0.25^2, crossed of 1 - 0.75^2.
  Scene scene = atwood_machine(0.5, 0);
  Rope& rope = scene.ropes[0];
  Pulley second;
  second.axle_m = {-1, 0, 0};
  second.radius_m = 0.25;
  rope.over.push_back(second);
  Sample sample;
  sample.bodies.resize(2);
  sample.bodies[0].p_m = {0.5, -2, 0};
  sample.bodies[1].p_m = {-1.25, -3, 0};
  // The open part falls towards the smaller pulley: its normal leans that way from +y by asin(0.25).
  const double tilt = std::asin(0.25);
  const double half = std::acos(-1.0) / 2;
  CHECK(static_cast<double>(rope_length_m(scene, rope, sample)) ==
        Approx(2 + 0.5 * (half + tilt) + std::sqrt(1 - 0.0625) + 0.25 * (half - tilt) + 3).margin(1e-14));

  rope.over[1].axis = {0, 0, -1};  // the rope passes below the second pulley and up at its far side
  sample.bodies[1].p_m = {-1.25, 3, 0};
  const double crossed = std::asin(0.75);
  CHECK(static_cast<double>(rope_length_m(scene, rope, sample)) ==
        Approx(2 + (0.5 + 0.25) * (half + crossed) + std::sqrt(1 - 0.5625) + 3).margin(1e-14));

  // Points instead of pulleys: plain distances.
  rope.over[0].radius_m = rope.over[1].radius_m = 0;
  sample.bodies[0].p_m = {3, 4, 0};
  sample.bodies[1].p_m = {-1, 2, 0};
  CHECK(close(rope_length_m(scene, rope, sample), 5 + 1 + 2));
}

TEST_CASE("energies of joints: springs with whole turns, constant torques, pulleys") {
  Scene scene;
  scene.bodies.resize(1);
  scene.bodies[0].mass_kg = 1;
  Joint joint;
  joint.parent = -1, joint.child = 0;
  joint.axis_body = {0, 0, 1};
  scene.joints = {joint};
  JointSpring spring;
  spring.stiffness = 2, spring.rest = 0.5;
  JointTorque torque;
  torque.torque = 3;
  scene.joint_forces = {spring, torque};
  Sample sample;
  sample.bodies.resize(1);
  sample.bodies[0].q_wxyz = turn_about({0, 0, 1}, 1.5);
  CHECK(static_cast<double>(joint_potential_J(scene, sample)) == Approx(1.0 * 1.0 - 3 * 1.5).margin(1e-14));
  const double turned = 1.5 - 4 * std::acos(-1.0);  // two turns back
  sample.joints = joints_at_start(scene);
  sample.joints[0].q[0] = turned + 0.2;  // a report that is a little off names the turn and nothing else
  CHECK(static_cast<double>(joint_potential_J(scene, sample)) ==
        Approx((turned - 0.5) * (turned - 0.5) - 3 * turned).epsilon(1e-14));
  CHECK(conserves(scene, "energy"));
  CHECK_FALSE(conserves(scene, "momentum"));

  // 1/2 I (s'/r)^2 with s' = 0.5, r = 0.25, I = 3: 6 J.
  const Scene machine = atwood_machine(0.25, 3);
  Sample hanging;
  hanging.bodies.resize(2);
  hanging.bodies[0].p_m = {0.25, -2, 0};
  hanging.bodies[1].p_m = {-0.25, -3, 0};
  hanging.bodies[0].v_m_per_s = {0, 0.5, 0};
  hanging.bodies[1].v_m_per_s = {0, -0.5, 0};
  CHECK(static_cast<double>(energy(machine, hanging).kinetic_J) == Approx(0.125 + 0.375 + 6));
}

TEST_CASE("what joints do to conserved quantities") {
  Scene scene;
  scene.bodies.resize(2);
  scene.bodies[0].mass_kg = scene.bodies[1].mass_kg = 1;
  Joint joint;
  joint.parent = 0, joint.child = 1;
  scene.joints = {joint};
  for (const char* kept : {"energy", "momentum", "angular-momentum", "angular-momentum-center", "center-of-mass"})
    CHECK(conserves(scene, kept));
  SECTION("damping dissipates and keeps momenta") {
    JointSpring damper;
    damper.damping = 1;
    scene.joint_forces = {damper};
    CHECK_FALSE(conserves(scene, "energy"));
    CHECK(conserves(scene, "angular-momentum"));
  }
  SECTION("a torque that oscillates") {
    JointTorque torque;
    torque.torque = 1, torque.angular_frequency_rad_per_s = 2;
    scene.joint_forces = {torque};
    CHECK_FALSE(conserves(scene, "energy"));
  }
  SECTION("a stop that gives back half") {
    scene.joints[0].limits = JointLimits{-1, 1, 0.5};
    CHECK_FALSE(conserves(scene, "energy"));
    scene.joints[0].limits->restitution = 1;
    CHECK(conserves(scene, "energy"));
  }
  SECTION("prescribed motion") {
    scene.joints[0].driven_rate = 2;
    CHECK_FALSE(conserves(scene, "energy"));
  }
  SECTION("a joint to the world, or to a fixed body, holds") {
    scene.joints[0].parent = -1;
    CHECK_FALSE(conserves(scene, "angular-momentum"));
    CHECK(conserves(scene, "energy"));
    scene.joints[0].parent = 0;
    scene.bodies[0].fixed = true;
    CHECK_FALSE(conserves(scene, "momentum"));
  }
  SECTION("a rope over a fixed point") {
    Rope rope;
    rope.bodies = {0, 1};
    scene.ropes = {rope};
    CHECK(conserves(scene, "momentum"));
    scene.ropes[0].over.resize(1);
    CHECK_FALSE(conserves(scene, "momentum"));
  }
}
