// Joints and ropes in scenario files: placement against chains worked out by hand, loops, and every refusal.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "scene/driven_closings.hpp"
#include "scene/loop_projection.hpp"
#include "scene/mechanism.hpp"
#include "text.hpp"

using namespace scene_test;
using atwood::Joint;
using atwood::Real3;
using atwood::Scene;
using Catch::Contains;
using Catch::StartsWith;

namespace {

// Two bodies of one kilogram: lines 7 to 14. What follows starts on line 15.
const std::string kBodies = kHead +
                            "[[body]]\nname = \"a\"\nmass_kg = 1\ninertia_kg_m2 = [0.1, 0.1, 0.1]\n"
                            "[[body]]\nname = \"b\"\nmass_kg = 1\ninertia_kg_m2 = [0.1, 0.1, 0.1]\n";
// A hinge from the world to `a`: its keys stand on lines 16 to 20, other keys from line 21 on.
const std::string kHinge =
    "[[joint]]\nname = \"J\"\nkind = \"hinge\"\nbodies = [\"world\", \"a\"]\n"
    "anchors_body_m = [[0, 0, 0], [0, 0.5, 0]]\naxis_body = [0, 0, 1]\n";

void check(const std::string& text, const std::string& start, const std::string& found, const std::string& expected) {
  INFO(text);
  const std::string error = message(text);
  CHECK_THAT(error, StartsWith("t.toml:" + start + ": ") && Contains(found) && Contains("expected " + expected));
}

// A hinge about z; the anchors are on the x axes of the bodies.
std::string hinge(const std::string& name, const std::string& parent, const std::string& child, double at_parent,
                  double at_child, const std::string& more = "") {
  return "[[joint]]\nname = \"" + name + "\"\nkind = \"hinge\"\nbodies = [\"" + parent + "\", \"" + child +
         "\"]\nanchors_body_m = [[" + std::to_string(at_parent) + ", 0, 0], [" + std::to_string(at_child) +
         ", 0, 0]]\naxis_body = [0, 0, 1]\n" + more;
}
std::string rod(const std::string& name) {
  return "[[body]]\nname = \"" + name + "\"\nmass_kg = 1\ninertia_kg_m2 = [0.1, 0.1, 0.1]\n";
}

// A parallelogram of rods of lengths 1 (cranks) and 2 (coupler), with the cranks at 1 rad.
std::string four_bar(const std::string& closing, const std::string& crank = "angle_rad = 1\nrate_rad_per_s = 0.5\n",
                     const std::string& follower = "angle_rad = -1\nrate_rad_per_s = -0.5\n") {
  return kHead + rod("crank") + rod("coupler") + rod("rocker") + hinge("A", "world", "crank", 0, -0.5, crank) +
         hinge("B", "crank", "coupler", 0.5, -1, follower) + hinge("C", "coupler", "rocker", 1, 0.5, crank) +
         hinge("D", "world", "rocker", 2, -0.5, closing);
}

double distance(const Real3& a, const Real3& b) { return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]); }

}  // namespace

TEST_CASE("a chain of hinges stands where its angles put it") {
  const auto scene = read(kBodies + hinge("J", "world", "a", 0, -0.5, "angle_rad = 0.7\nrate_rad_per_s = 2\n") +
                          hinge("K", "a", "b", 0.5, -1.5, "angle_rad = -0.3\nrate_rad_per_s = -5\n"))
                         .scene;
  REQUIRE(scene.joints.size() == 2);
  CHECK(scene.joints[0].parent == -1);
  CHECK(scene.joints[1].parent == 0);
  // x = (cos, sin)(0.7) (1/2), then its end (cos, sin)(0.7), then (cos, sin)(0.4) (3/2) on; rates 2 and 2 - 5 = -3.
  const double c = std::cos(0.7), s = std::sin(0.7), d = std::cos(0.4), t = std::sin(0.4);
  CHECK(distance(scene.bodies[0].position_m, {c / 2, s / 2, 0}) < 1e-15);
  CHECK(distance(scene.bodies[1].position_m, {c + 1.5 * d, s + 1.5 * t, 0}) < 1e-15);
  CHECK(distance(scene.bodies[0].velocity_m_per_s, {-s, c, 0}) < 1e-15);
  CHECK(distance(scene.bodies[1].velocity_m_per_s, {-2 * s + 4.5 * t, 2 * c - 4.5 * d, 0}) < 2e-15);
  CHECK(distance(scene.bodies[1].angular_velocity_body_rad_per_s, {0, 0, -3}) < 1e-15);
  CHECK(std::abs(scene.bodies[1].orientation_wxyz[0] - std::cos(0.2)) < 1e-15);
  CHECK(std::abs(scene.bodies[1].orientation_wxyz[3] - std::sin(0.2)) < 1e-15);
}

TEST_CASE("a slider, a cylindrical and a universal joint, and a ball place their child") {
  const std::string body = kHead + rod("a");
  // A quarter turn of the frame about z takes the child's x axis to the world's y.
  const auto slider = read(body +
                           "[[joint]]\nkind = \"slider\"\nbodies = [\"world\", \"a\"]\naxis_body = [1, 0, 0]\n"
                           "frame_wxyz = [0.7071067811865476, 0, 0, 0.7071067811865476]\noffset_m = 3\n"
                           "rate_m_per_s = -2\nanchors_body_m = [[1, 0, 0], [0, 0, 5]]\n")
                          .scene;
  CHECK(distance(slider.bodies[0].position_m, {1, 3, -5}) < 1e-15);
  CHECK(distance(slider.bodies[0].velocity_m_per_s, {0, -2, 0}) < 1e-15);

  // About and along z: the anchor at (0, 0, 2), the centre one metre off along the turned x.
  const auto cylinder = read(body +
                             "[[joint]]\nkind = \"cylindrical\"\nbodies = [\"world\", \"a\"]\naxis_body = [0, 0, 1]\n"
                             "angle_rad = 0.4\noffset_m = 2\nrate_rad_per_s = 3\nrate_m_per_s = 7\n"
                             "anchors_body_m = [[0, 0, 0], [-1, 0, 0]]\n")
                            .scene;
  CHECK(distance(cylinder.bodies[0].position_m, {std::cos(0.4), std::sin(0.4), 2}) < 1e-15);
  CHECK(distance(cylinder.bodies[0].velocity_m_per_s, {-3 * std::sin(0.4), 3 * std::cos(0.4), 7}) < 1e-15);

  // R = R_x(q0) R_y(q1); the body's rate is u0 R_y(-q1) x + u1 y = (u0 cos q1, u1, u0 sin q1).
  const auto universal =
      read(body +
           "[[joint]]\nkind = \"universal\"\nbodies = [\"world\", \"a\"]\naxes_body = [[1, 0, 0], [0, 1, 0]]\n"
           "angle_rad = [0.3, 0.8]\nrate_rad_per_s = [2, -1]\n")
          .scene;
  CHECK(distance(universal.bodies[0].angular_velocity_body_rad_per_s, {2 * std::cos(0.8), -1, 2 * std::sin(0.8)}) <
        1e-15);
  const auto& q = universal.bodies[0].orientation_wxyz;  // (cos, sin x)(0.15) (cos, sin y)(0.4)
  CHECK(std::abs(q[0] - std::cos(0.15) * std::cos(0.4)) < 1e-15);
  CHECK(std::abs(q[1] - std::sin(0.15) * std::cos(0.4)) < 1e-15);
  CHECK(std::abs(q[2] - std::cos(0.15) * std::sin(0.4)) < 1e-15);
  CHECK(std::abs(q[3] - std::sin(0.15) * std::sin(0.4)) < 1e-15);

  // w = (1, 2, 3) in the child's axes, which are a half turn about x from the world's: (1, -2, -3). v = w x (0, 0, 1).
  const auto ball = read(body +
                         "[[joint]]\nkind = \"ball\"\nbodies = [\"world\", \"a\"]\norientation_wxyz = [0, 1, 0, 0]\n"
                         "angular_velocity_body_rad_per_s = [1, 2, 3]\nanchors_body_m = [[0, 0, 0], [0, 0, 1]]\n")
                        .scene;
  CHECK(distance(ball.bodies[0].position_m, {0, 0, 1}) < 1e-15);
  CHECK(distance(ball.bodies[0].velocity_m_per_s, {-2, -1, 0}) < 1e-15);
}

TEST_CASE("velocities of a chain of all kinds are the derivatives of its positions") {
  const auto scene =
      read(kHead + rod("a") + rod("b") + rod("c") + rod("d") + rod("e") + rod("f") +
           "[[joint]]\nkind = \"ball\"\nbodies = [\"world\", \"a\"]\norientation_wxyz = [0.5, 0.5, -0.5, 0.5]\n"
           "angular_velocity_body_rad_per_s = [1, -2, 0.5]\nanchors_body_m = [[1, 2, 3], [0.3, 0.2, -0.1]]\n"
           "[[joint]]\nkind = \"universal\"\nbodies = [\"a\", \"b\"]\naxes_body = [[0.6, 0.8, 0], [0, 0, 1]]\n"
           "angle_rad = [0.3, -1.2]\nrate_rad_per_s = [2, -1]\nanchors_body_m = [[0.1, 0, 0.4], [0.3, 0.2, -0.1]]\n"
           "[[joint]]\nkind = \"cylindrical\"\nbodies = [\"b\", \"c\"]\naxis_body = [0, 0.6, 0.8]\n"
           "angle_rad = 0.9\noffset_m = 0.2\nrate_rad_per_s = 3\nrate_m_per_s = 7\nframe_wxyz = [0.8, 0, 0.6, 0]\n"
           "anchors_body_m = [[0.1, 0, 0.4], [0.3, 0.2, -0.1]]\n"
           "[[joint]]\nkind = \"slider\"\nbodies = [\"c\", \"d\"]\naxis_body = [0.8, 0.6, 0]\nrate_m_per_s = 2\n"
           "offset_m = -0.4\nframe_wxyz = [0.8, 0.6, 0, 0]\nanchors_body_m = [[0.1, 0, 0.4], [0.3, 0.2, -0.1]]\n"
           "[[joint]]\nkind = \"fixed\"\nbodies = [\"d\", \"e\"]\nframe_wxyz = [0.8, 0.6, 0, 0]\n"
           "anchors_body_m = [[0.1, 0, 0.4], [0.3, 0.2, -0.1]]\n"
           "[[joint]]\nkind = \"hinge\"\nbodies = [\"e\", \"f\"]\naxis_body = [0, 0.6, 0.8]\nrate_rad_per_s = -4\n"
           "angle_rad = 2.5\nframe_wxyz = [0.8, 0.6, 0, 0]\nanchors_body_m = [[0.1, 0, 0.4], [0.3, 0.2, -0.1]]\n")
          .scene;
  using namespace atwood;
  using namespace atwood::quad;
  const MechanismStart now = mechanism_start(scene);
  const auto moved = [&](Real h) {
    std::vector<BodyMotion> bodies(scene.bodies.size());
    for (const int j : joints_from_root(scene)) {
      const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
      JointMotion at = now.joints[static_cast<std::size_t>(j)];
      if (joint.kind == JointKind::ball) at.q = product(at.q, exponential(h * at.u));
      else
        for (std::size_t i = 0; i < 2; ++i) at.q[i] += h * at.u[i];
      bodies[static_cast<std::size_t>(joint.child)] = placed_child(joint, at, motion_of(bodies, joint.parent, {}));
    }
    return bodies;
  };
  const Real h = Real(1) / 1000000000;
  const auto later = moved(h), earlier = moved(-h);
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    const Vector v = (1 / (2 * h)) * (later[b].p_m - earlier[b].p_m);
    CHECK(static_cast<double>(norm(v - now.bodies[b].v_m_per_s)) < 1e-13);
    const Quaternion turn_by = product(conjugate(earlier[b].q_wxyz), later[b].q_wxyz);
    const Vector w = (1 / h) * Vector{turn_by[1], turn_by[2], turn_by[3]};
    CHECK(static_cast<double>(norm(w - now.bodies[b].w_rad_per_s)) < 1e-13);
  }
  // And each joint reads its own coordinates and rates back from the poses.
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const JointMotion back = joint_motion(joint, motion_of(now.bodies, joint.parent, {}),
                                          now.bodies[static_cast<std::size_t>(joint.child)], now.joints[j]);
    for (std::size_t i = 0; i < static_cast<std::size_t>(coordinate_count(joint.kind)); ++i)
      CHECK(static_cast<double>(fabsq(back.q[i] - now.joints[j].q[i])) < 1e-30);
    for (std::size_t i = 0; i < static_cast<std::size_t>(rate_count(joint.kind)); ++i)
      CHECK(static_cast<double>(fabsq(back.u[i] - now.joints[j].u[i])) < 1e-30);
  }
}

TEST_CASE("a loop that closes is projected to quad's round-off") {
  const auto scenario = read(four_bar("closes_loop = true\n"));
  CHECK(scenario.notes.empty());
  const auto start = atwood::mechanism_start(scenario.scene);
  const auto gap = atwood::joint_gap(scenario.scene, start, 3);
  CHECK(gap.gap < 1e-29);
  CHECK(gap.rate < 1e-29);
  CHECK(scenario.scene.joints[0].coordinates[0] == Approx(1).epsilon(1e-15));
  CHECK(scenario.scene.joints[3].coordinates[0] == Approx(1).epsilon(1e-15));  // from the poses
  CHECK(scenario.scene.joints[3].rates[0] == Approx(0.5).epsilon(1e-15));
}

TEST_CASE("the angle of a closing joint is that of its bodies, and counts whole turns") {
  const std::string crank = "angle_rad = 1\nrate_rad_per_s = 0.5\n", rocker = "angle_rad = -1\nrate_rad_per_s = -0.5\n";
  const auto turned = read(four_bar("closes_loop = true\nangle_rad = 7.283185307179586\n", crank, rocker));
  CHECK(turned.scene.joints[3].coordinates[0] == Approx(1 + 2 * std::acos(-1.0)).epsilon(1e-15));
  const auto wrong = message(four_bar("closes_loop = true\nangle_rad = 0.9\n", crank, rocker));
  CHECK_THAT(wrong, Contains("`angle_rad`") && Contains("is 0.9") && Contains("up to whole turns"));
}

TEST_CASE("an open loop is an error, unless it is to be assembled; held joints stay") {
  const std::string off = "angle_rad = -0.8\nrate_rad_per_s = -0.5\n";
  const std::string crank = "angle_rad = 1\nrate_rad_per_s = 0.5\n";
  const std::string open = message(four_bar("closes_loop = true\n", crank, off));
  CHECK_THAT(open, Contains("the loop of [[joint]] `D` does not close") && Contains("assemble = true"));
  const auto slow = message(four_bar("closes_loop = true\n", crank, "angle_rad = -1\nrate_rad_per_s = -0.4\n"));
  CHECK_THAT(slow, Contains("`D` does not stay closed"));

  const auto held = read(four_bar("closes_loop = true\nassemble = true\nhold = [\"A\"]\n", crank, off));
  CHECK(held.scene.joints[0].coordinates[0] == 1);
  CHECK(held.scene.joints[0].rates[0] == 0.5);
  CHECK(held.scene.joints[1].coordinates[0] == Approx(-1).epsilon(1e-14));  // the parallelogram of this branch
  CHECK(held.scene.joints[2].rates[0] == Approx(0.5).epsilon(1e-14));
  REQUIRE(held.notes.size() == 1);
  CHECK_THAT(held.notes.front(), Contains("moved onto the constraints of `D`") && Contains("joint `B`"));

  // Free: all three move, and the crank by less than where it is held alone.
  const auto moved = read(four_bar("closes_loop = true\nassemble = true\n", crank, off));
  CHECK(std::abs(moved.scene.joints[0].coordinates[0] - 1) > 1e-3);
  CHECK(atwood::joint_gap(moved.scene, atwood::mechanism_start(moved.scene), 3).gap < 1e-29);
}

TEST_CASE("the projection is the least change in the mass metric") {
  // Two sliders along x whose children a third joint ties: M = diag(m1, m2), the constraint x1 = x2. The least change
  // from (0, 1) ends at (m1 0 + m2 1) / (m1 + m2), as momentum does for the rates.
  const std::string text =
      kHead +
      "[[body]]\nname = \"a\"\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\n[[body]]\nname = \"b\"\nmass_kg = 3\n"
      "inertia_kg_m2 = [1, 1, 1]\n"
      "[[joint]]\nname = \"A\"\nkind = \"slider\"\nbodies = [\"world\", \"a\"]\naxis_body = [1, 0, 0]\n"
      "rate_m_per_s = 2\n"
      "[[joint]]\nname = \"B\"\nkind = \"slider\"\nbodies = [\"world\", \"b\"]\naxis_body = [1, 0, 0]\n"
      "offset_m = 1\n"
      "[[joint]]\nname = \"C\"\nkind = \"ball\"\nbodies = [\"a\", \"b\"]\ncloses_loop = true\nassemble = true\n";
  const auto scene = read(text).scene;
  CHECK(scene.joints[0].coordinates[0] == Approx(0.75).epsilon(1e-15));
  CHECK(scene.joints[1].coordinates[0] == Approx(0.75).epsilon(1e-15));
  CHECK(scene.joints[0].rates[0] == Approx(0.5).epsilon(1e-15));
  CHECK(scene.joints[1].rates[0] == Approx(0.5).epsilon(1e-15));
}

TEST_CASE("a singular start does not move, nor do its rates change") {
  // Flat: the rounding of the angles would move it far along the direction that the constraints do not see.
  const auto scene = read(four_bar("closes_loop = true\n", "angle_rad = 3.141592653589793\nrate_rad_per_s = 1.1\n",
                                   "angle_rad = -3.141592653589793\nrate_rad_per_s = -1.1\n"))
                         .scene;
  for (std::size_t j = 0; j < 3; ++j) {
    CHECK(std::abs(std::abs(scene.joints[j].coordinates[0]) - 3.141592653589793) < 1e-15);
    CHECK(std::abs(std::abs(scene.joints[j].rates[0]) - 1.1) < 1e-15);
  }
  CHECK(atwood::joint_gap(scene, atwood::mechanism_start(scene), 3).gap < 1e-29);
}

TEST_CASE("a singular start whose lengths are rounded moves by no more than it must") {
  // Flat, with 0.1 + 0.2 against 0.3: as doubles these differ by 2.8e-17, so that the flat parallelogram does not
  // close, and the nearest one that does is about sqrt(2.8e-17 / 0.1) = 2e-8 away.
  const std::string text = kHead + rod("crank") + rod("coupler") + rod("rocker") +
                           hinge("A", "world", "crank", 0, -0.5, "angle_rad = 3.141592653589793\n") +
                           hinge("B", "crank", "coupler", 0.5, -0.1, "angle_rad = -3.141592653589793\n") +
                           hinge("C", "coupler", "rocker", 0.2, 0.5, "angle_rad = 3.141592653589793\n") +
                           hinge("D", "world", "rocker", 0.3, -0.5, "closes_loop = true\n");
  const auto scene = read(text).scene;
  for (std::size_t j = 0; j < 3; ++j)
    CHECK(std::abs(std::abs(scene.joints[j].coordinates[0]) - 3.141592653589793) < 1e-6);
  CHECK(atwood::joint_gap(scene, atwood::mechanism_start(scene), 3).gap < 1e-29);
}

TEST_CASE("a loop that no configuration closes") {
  const std::string far = hinge("D", "world", "rocker", 7, -0.5, "closes_loop = true\nassemble = true\n");
  std::string text = four_bar("closes_loop = true\n");
  text = text.substr(0, text.find("[[joint]]\nname = \"D\"")) + far;
  CHECK_THAT(message(text), Contains("`D`") && Contains("no configuration near the given one"));
}

TEST_CASE("the order of bodies and joints does not matter") {
  const auto forward = read(kBodies + hinge("J", "world", "a", 0, -0.5, "angle_rad = 0.7\n") +
                            hinge("K", "a", "b", 0.5, -1.5, "angle_rad = -0.3\n"))
                           .scene;
  const auto backward = read(kHead + rod("b") + rod("a") + hinge("K", "a", "b", 0.5, -1.5, "angle_rad = -0.3\n") +
                             hinge("J", "world", "a", 0, -0.5, "angle_rad = 0.7\n"))
                            .scene;
  CHECK(forward.bodies[1].position_m == backward.bodies[0].position_m);
  CHECK(forward.bodies[1].orientation_wxyz == backward.bodies[0].orientation_wxyz);
}

TEST_CASE("resolved scenes with joints, ropes and their forces keep every bit") {
  const std::string text =
      four_bar("closes_loop = true\n") + rod("w") + "position_m = [0.1, 0.2, 0.3]\n" + rod("v") +
      "position_m = [0.5, 0.2, 0.3]\n" +
      "[[rope]]\nbodies = [\"w\", \"v\"]\nover_m = [[0.3, 5, 0.3], { axle_m = [0.45, 5.5, 0.3], radius_m = 0.05, "
      "inertia_kg_m2 = 0.1 }]\n" +
      "[[body]]\nname = \"x\"\nmass_kg = 1\ninertia_kg_m2 = [1, 1, 1]\n"
      "[[joint]]\nname = \"X\"\nkind = \"slider\"\nbodies = [\"world\", \"x\"]\naxis_body = [1, 0, 0]\n"
      "limits_m = [-1, 0.1]\nstop_restitution = 0.3\n"
      "[[force]]\nkind = \"joint-spring\"\njoint = \"A\"\nstiffness_N_m_per_rad = 0.1\nrest_rad = 0.3\n"
      "[[force]]\nkind = \"joint-spring\"\njoint = \"X\"\ndamping_N_s_per_m = 0.7\n"
      "[[force]]\nkind = \"joint-torque\"\njoint = \"C\"\ntorque_N_m = 0.1\nphase_rad = 0.3\non_s = [[0, 1]]\n";
  const auto scenario = read(text);
  REQUIRE(scenario.scene.joint_forces.size() == 3);
  const std::string json = atwood::scenario_to_json(scenario);
  const auto back = atwood::scenario_from_json(json);
  CHECK(atwood::scenario_to_json(back) == json);
  REQUIRE(back.scene.joints.size() == 5);
  CHECK(back.scene.joints[3].closes_loop);
  CHECK(back.scene.joints[4].limits->upper == 0.1);
  CHECK(back.scene.joints[0].coordinates == scenario.scene.joints[0].coordinates);
  CHECK(back.scene.ropes[0].over[1].axis == scenario.scene.ropes[0].over[1].axis);
  CHECK(std::get<atwood::JointSpring>(back.scene.joint_forces[1]).damping == 0.7);
}

TEST_CASE("a pulley's side is the one on which the rope bends around it") {
  const auto rope = [](const std::string& pulley) {
    return read(kHead +
                "[[body]]\nname = \"l\"\nmass_kg = 1\nposition_m = [-0.2, 0, -1]\n[[body]]\nname = \"r\"\n"
                "mass_kg = 1\nposition_m = [0.2, 0, -1]\n[[rope]]\nbodies = [\"l\", \"r\"]\nover_m = [" +
                pulley + "]\n")
        .scene.ropes[0];
  };
  // Up on the left, over the top, down on the right: clockwise seen from -y, that is about +y.
  CHECK(distance(rope("{ axle_m = [0, 0, 0], radius_m = 0.2 }").over[0].axis, {0, 1, 0}) < 1e-15);
  CHECK(distance(rope("{ axle_m = [0, 0, 0], radius_m = 0.1, axis = [0, -1, 0] }").over[0].axis, {0, -1, 0}) < 1e-15);
}

TEST_CASE("a rope that bends around its pulley by more than 315 degrees, or away from it, is refused by name") {
  // Down to the pulley's left side, around it by the angle, and on along the tangent there.
  const auto wound = [](double degrees) {
    const double radius = 0.25, at = (180 + degrees) * std::acos(-1.0) / 180, c = std::cos(at), s = std::sin(at);
    const auto point = [](double x, double y) { return std::to_string(x) + ", " + std::to_string(y) + ", 0"; };
    return kHead + "[[body]]\nname = \"l\"\nmass_kg = 1\nposition_m = [" + point(-radius, 1) +
           "]\n[[body]]\nname = \"r\"\nmass_kg = 1\nposition_m = [" + point(radius * c - s, radius * s + c) +
           "]\n[[rope]]\nname = \"R\"\nbodies = [\"l\", \"r\"]\nover_m = [[-0.25, 0.5, 0], { axle_m = [0, 0, 0], "
           "radius_m = 0.25, axis = [0, 0, 1] }]\n";
  };
  for (const double degrees : {1.0, 90.0, 200.0, 300.0, 314.0, 361.0}) CHECK(message(wound(degrees)) == "no error");
  for (const double degrees : {316.0, 330.0, 359.0, -1.0, -44.0}) {
    const std::string said = message(wound(degrees));
    CAPTURE(degrees, said);
    CHECK(said.find(
              "rope `R` leaves pulley 1, or bends around it by more than 315 degrees; expected a bend of 0 to 315") !=
          std::string::npos);
  }
}

TEST_CASE("joints that name no tree") {
  REQUIRE(message(kBodies + kHinge) == "no error");
  check(kBodies + "[[joint]]\nkind = \"hinge\"\nbodies = [\"world\", \"c\"]\naxis_body = [0, 0, 1]\n", "17:20",
        "`bodies` in [[joint]] `joint.0` is \"c\"", "the name of a body (a, b)");
  check(kBodies + "[[joint]]\nkind = \"hinge\"\nbodies = [\"a\", \"world\"]\naxis_body = [0, 0, 1]\n", "17:16",
        "is \"world\"", "the name of a body");
  check(kBodies + kHinge + "[[joint]]\nname = \"K\"\nkind = \"ball\"\nbodies = [\"b\", \"a\"]\n", "24:10",
        "joint `K` places the body `a`, which the joint `J` places already", "one placing joint");
  check(
      kBodies +
          "[[joint]]\nname = \"J\"\nkind = \"ball\"\nbodies = [\"b\", \"a\"]\n[[joint]]\nname = \"K\"\nkind = \"ball\"\n"
          "bodies = [\"a\", \"b\"]\n",
      "18:10", "joint `J` is part of a cycle", "a tree");
  check(kBodies + "[[joint]]\nkind = \"ball\"\nbodies = [\"a\", \"a\"]\n", "17:16", "names `a` twice", "two bodies");
  check(kBodies + kHinge + kHinge, "22:8", "the name `J` a second time", "each name once");
  check(kHead + "[[body]]\nname = \"a\"\nfixed = true\n[[joint]]\nkind = \"ball\"\nbodies = [\"world\", \"a\"]\n",
        "12:20", "the child `a` of [[joint]] `joint.0` is fixed", "a body that moves");
  check(kHead + "[[body]]\nname = \"a\"\nmass_kg = 1\n[[joint]]\nkind = \"ball\"\nbodies = [\"world\", \"a\"]\n",
        "12:20", "`a` of [[joint]] `joint.0` is a point mass, whose inertia is 0", "a shape or `inertia_kg_m2`");
  check(kHead + rod("a") + "release_s = 1\n" + kHinge, "15:10", "has a release_s", "a body that moves from the start");
  for (const char* key : {"position_m = [0, 0, 0]", "orientation_wxyz = [1, 0, 0, 0]", "velocity_m_per_s = [0, 0, 0]",
                          "angular_velocity_body_rad_per_s = [0, 0, 0]"}) {
    INFO(key);
    CHECK_THAT(message(kHead + rod("a") + key + "\n" + kHinge),
               StartsWith("t.toml:11:") && Contains("beside the joint `J`, which places it"));
  }
  check(kHead + rod("a") + "[[grid]]\nbody = \"a\"\ncounts = [2, 1, 1]\nspacing_m = [9, 9, 9]\n" + kHinge, "18:20",
        "is \"a\"", "a single body: a grid copies this one");
}

TEST_CASE("axes, frames and starts that a kind does not have") {
  const std::string line21 = kBodies + kHinge;
  check(kBodies + "[[joint]]\nkind = \"hinge\"\nbodies = [\"world\", \"a\"]\n", "15:1", "missing key `axis_body`",
        "the axis");
  check(kBodies + "[[joint]]\nkind = \"hinge\"\nbodies = [\"world\", \"a\"]\naxis_body = [0, 0, 0]\n", "18:13",
        "has length 0", "a vector of length 1");
  check(kBodies + "[[joint]]\nkind = \"hinge\"\nbodies = [\"world\", \"a\"]\naxis_body = [0, 0, 2]\n", "18:13",
        "has length 2", "a vector of length 1");
  check(kBodies +
            "[[joint]]\nkind = \"universal\"\nbodies = [\"world\", \"a\"]\naxes_body = [[1, 0, 0], [0.6, 0.8, 0]]\n",
        "18:13", "a cosine of 0.6", "orthogonal axes");
  check(kBodies + "[[joint]]\nkind = \"ball\"\nbodies = [\"world\", \"a\"]\naxis_body = [0, 0, 1]\n", "18:13",
        "`axis_body` in [[joint]] `joint.0` is given for the kind ball", "it with hinge, slider, cylindrical only");
  check(line21 + "offset_m = 1\n", "21:12", "is given for the kind hinge", "it with slider, cylindrical only");
  check(line21 + "angle_rad = [1, 2]\n", "21:13", "is a list of two", "a number");
  check(line21 + "limits_rad = [2, -2]\n", "21:14", "is [2, -2]", "the smaller value first");
  check(line21 + "limits_rad = [1, 2]\n", "21:14", "starts at 0, outside its limits of 1 to 2", "a start between them");
  check(line21 + "stop_restitution = 0.5\n", "21:20", "without limits", "it beside limits_rad");
  check(line21 + "limits_rad = [-1, 1]\ndriven_rate_rad_per_s = 1\n", "21:14",
        "limits in [[joint]] `J` beside a driven rate", "one of the two");
  check(line21 + "rate_rad_per_s = 2\ndriven_rate_rad_per_s = 1\n", "21:18", "is 2 beside a driven rate of 1",
        "only the driven rate");
  check(line21 + "hold = [\"J\"]\n", "21:8", "without closes_loop", "it with closes_loop");
  check(line21 + "angle = 1\n", "21:1", "unknown key `angle`", "one of name, kind");
  check(kBodies + kHinge + "[[fluid]]\nname = \"w\"\n", "15:1", "beside a fluid", "one of the two");
}

TEST_CASE("held joints of a loop") {
  CHECK_THAT(message(four_bar("closes_loop = true\nhold = [\"E\"]\n")),
             Contains("is \"E\"") && Contains("expected the name of a joint (A, B, C)"));
  CHECK_THAT(message(four_bar("closes_loop = true\nhold = [\"D\"]\n")), Contains("a joint that places a body"));
  CHECK_THAT(message(four_bar("closes_loop = true\nhold = [\"A\", \"B\", \"C\"]\n")),
             Contains("keeps every joint of the loop") && Contains("expected fewer"));
  CHECK_THAT(message(four_bar("closes_loop = true\nrate_rad_per_s = 0.5\n")),
             Contains("is given for a joint that closes a loop") && Contains("expected none"));
}

TEST_CASE("a driven joint keeps its rate; a loop with nothing left to move is frozen") {
  const auto driven = read(four_bar("closes_loop = true\n", "angle_rad = 1\ndriven_rate_rad_per_s = 0.5\n")).scene;
  CHECK(driven.joints[0].rates[0] == 0.5);
  const auto frozen =
      message(four_bar("closes_loop = true\n", "angle_rad = 1\ndriven_rate_rad_per_s = 0\n", "angle_rad = -1\n"));
  CHECK(frozen == "no error");
}

TEST_CASE("a driven joint that closes a loop changes places with the joint that places its child") {
  const auto given = read(four_bar("closes_loop = true\n"));
  const auto driven = read(four_bar("closes_loop = true\ndriven_rate_rad_per_s = 0.5\n"));
  REQUIRE(driven.scene.joints.size() == 4);
  CHECK_FALSE(driven.scene.joints[3].closes_loop);
  CHECK(driven.scene.joints[2].closes_loop);
  CHECK(driven.scene.joints[3].coordinates[0] == Approx(1).epsilon(1e-15));
  CHECK(driven.scene.joints[3].rates[0] == 0.5);
  for (std::size_t b = 0; b < 3; ++b) {
    CHECK(distance(driven.scene.bodies[b].position_m, given.scene.bodies[b].position_m) < 1e-15);
    CHECK(distance(driven.scene.bodies[b].velocity_m_per_s, given.scene.bodies[b].velocity_m_per_s) < 1e-15);
  }
  REQUIRE(driven.notes.size() == 1);
  CHECK_THAT(driven.notes.front(), StartsWith("t.toml:") && Contains("the joint `D` is driven: it places `rocker`") &&
                                       Contains("`C` closes the loop"));
  // Its rate is taken up by the others.
  const auto assembled = read(four_bar("closes_loop = true\nassemble = true\ndriven_rate_rad_per_s = -0.25\n"));
  CHECK(assembled.scene.joints[3].rates[0] == -0.25);
  CHECK(assembled.scene.joints[0].rates[0] == Approx(-0.25).epsilon(1e-14));
  CHECK(assembled.scene.joints[2].closes_loop);
}

TEST_CASE("a driven joint that closes a loop and cannot change places says why") {
  const auto obstacle = [](Scene scene, const auto& change) {
    change(scene);
    return atwood::obstacle_to_placing(scene, 3);
  };
  Scene scene = read(four_bar("closes_loop = true\n")).scene;
  scene.joints[3].driven_rate = 0.5;
  CHECK(obstacle(scene, [](Scene&) {}).empty());
  CHECK_THAT(obstacle(scene, [](Scene& s) { s.joints[2].driven_rate = 1; }),
             Contains("`rocker` is placed by the joint `C`, which is driven too"));
  CHECK_THAT(obstacle(scene,
                      [](Scene& s) {
                        s.joints[2].limits = atwood::JointLimits{-4, 4, 0};
                      }),
             Contains("`C`, which has limits"));
  CHECK_THAT(obstacle(scene, [](Scene& s) { s.joints[3].hold = {2}; }), Contains("`C`, which `hold` keeps"));
  CHECK_THAT(obstacle(scene, [](Scene& s) { s.joints[3].child = 0, s.joints[3].parent = 2; }),
             Contains("its parent `rocker` hangs on its child `crank`"));
  CHECK_THAT(obstacle(scene, [](Scene& s) { s.bodies[2].inertia_kg_m2 = {}; }),
             Contains("its child `rocker` is a point mass"));
  const Scene kept =
      read(four_bar("closes_loop = true\ndriven_rate_rad_per_s = 0.5\nassemble = true\nhold = [\"C\"]\n")).scene;
  CHECK(kept.joints[3].closes_loop);
}

TEST_CASE("two drives of one freedom are named") {
  for (const char* rate : {"0.5", "0.25"}) {
    std::string text =
        four_bar(std::string("closes_loop = true\nassemble = true\ndriven_rate_rad_per_s = ") + rate + "\n",
                 "angle_rad = 1\nrate_rad_per_s = 0.5\n", "angle_rad = -0.9\n");
    text.insert(text.find("rate_rad_per_s = 0.5"), "driven_");  // of A
    const std::string found = message(text);
    CHECK_THAT(found, Contains("`A`, `D`, which are driven or held") && Contains("expected fewer"));
    CHECK_THAT(found, !Contains("no configuration near the given one"));
  }
  // They agree on where the loop is, and not on how it moves.
  std::string text = four_bar("closes_loop = true\nassemble = true\ndriven_rate_rad_per_s = 0.25\n");
  text.insert(text.find("rate_rad_per_s = 0.5"), "driven_");
  CHECK_THAT(message(text), Contains("`A`, `D`, which are driven or held") && Contains("expected"));
}

TEST_CASE("ropes that are none") {
  const std::string bodies = kHead +
                             "[[body]]\nname = \"l\"\nmass_kg = 1\nposition_m = [-0.2, 0, -1]\n"
                             "[[body]]\nname = \"r\"\nmass_kg = 1\nposition_m = [0.2, 0, -1]\n"
                             "[[body]]\nname = \"m\"\nmass_kg = 1\nposition_m = [0.2, 1, -1]\n"
                             "[[body]]\nname = \"f\"\nfixed = true\n[[body]]\nname = \"g\"\nfixed = true\n";
  const std::string rope = "[[rope]]\nbodies = [\"l\", \"r\"]\n";  // lines 25 and 26
  REQUIRE(message(bodies + rope) == "no error");
  check(bodies + "[[rope]]\nbodies = [\"l\", \"l\"]\n", "26:10", "one body twice", "two bodies");
  check(bodies + "[[rope]]\nbodies = [\"f\", \"g\"]\n", "26:10", "both bodies of [[rope]] `rope.0` are fixed",
        "one that moves");
  check(bodies + "[[rope]]\nbodies = [\"l\", \"world\"]\n", "26:16", "is \"world\"", "the name of a body");
  check(bodies + rope + "points_body_m = [[0, 0, 1], [0, 0, 0]]\n", "27:17",
        "holds the point mass `l` beside its centre", "[0, 0, 0]");
  check(bodies + rope + "over_m = [[-0.2, 0, -1]]\n", "27:10", "has no length between its first end and pulley 0",
        "points apart");
  check(bodies + rope + "over_m = [{ axle_m = [0, 0, 0], radius_m = 3 }]\n", "27:10",
        "reaches as far as they are apart", "a larger distance");
  check(bodies + rope + "over_m = [{ axle_m = [0, 0, 0], radius_m = 0.1, axis = [1, 0, 0] }]\n", "27:10",
        "leaves the plane of a pulley", "both in the plane");
  check(bodies + rope + "over_m = [{ axle_m = [0, 0, -1], radius_m = 0.1 }]\n", "27:10", "undetermined", "`axis`");
  check(bodies + rope + "over_m = [{ axle_m = [0, 0, 0], inertia_kg_m2 = 1 }]\n", "27:10", "an inertia and no radius",
        "a radius above 0");
  check(bodies + rope + "[[rope]]\nbodies = [\"r\", \"m\"]\n[[rope]]\nbodies = [\"m\", \"l\"]\n", "30:10",
        "closes a cycle of ropes", "ropes that make no cycle");
  check(kHead +
            "[[body]]\nname = \"l\"\nmass_kg = 1\nvelocity_m_per_s = [1, 0, 0]\n[[body]]\nname = \"r\"\nmass_kg = 1\n"
            "position_m = [1, 0, 0]\n[[rope]]\nbodies = [\"l\", \"r\"]\n",
        "16:10", "changes its length at a rate", "velocities that keep it");
}

TEST_CASE("forces along joints") {
  const std::string spring = kBodies + kHinge + "[[force]]\nkind = \"joint-spring\"\n";  // lines 21 and 22
  check(spring + "joint = \"K\"\nstiffness_N_m_per_rad = 1\n", "23:9", "is \"K\"", "the name of a joint (J)");
  check(spring + "joint = \"J\"\nstiffness_N_per_m = 1\n", "24:21", "is given for an angle of the joint `J`",
        "radians");
  check(spring + "joint = \"J\"\n", "21:1", "neither a stiffness nor a damping", "stiffness_N_m_per_rad");
  check(spring + "joint = \"J\"\nstiffness_N_m_per_rad = -1\n", "24:25", "is -1", "a number of at least 0");
  check(spring + "joint = \"J\"\ncoordinate = 1\nstiffness_N_m_per_rad = 1\n", "24:14", "a hinge",
        "it with cylindrical and universal");
  check(kBodies + kHinge +
            "driven_rate_rad_per_s = 1\n[[force]]\nkind = \"joint-torque\"\njoint = \"J\"\ntorque_N_m = 1\n",
        "24:9", "whose motion is prescribed", "a joint without a driven rate");
  check(kBodies + kHinge + "[[force]]\nkind = \"joint-torque\"\njoint = \"J\"\n", "21:1", "missing key `torque_N_m`",
        "its size");
  check(kBodies + kHinge + "[[force]]\nkind = \"joint-sprint\"\n", "22:8", "is \"joint-sprint\"", "one of gravity");
  CHECK_THAT(message(kBodies + kHinge + "[[force]]\nkind = \"joint-sprint\"\n"),
             Contains("(did you mean joint-spring?)"));
  check(
      kBodies +
          "[[joint]]\nname = \"J\"\nkind = \"ball\"\nbodies = [\"world\", \"a\"]\n[[force]]\nkind = \"joint-spring\"\n"
          "joint = \"J\"\nstiffness_N_m_per_rad = 1\n",
      "22:25", "the ball joint `J`, which has no angle", "only damping_N_m_s_per_rad");
}

TEST_CASE("resolved scenes that no file makes are refused as well") {
  const std::string json = atwood::scene_to_json(read(kBodies + kHinge).scene);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = json;
    REQUIRE(text.find(from) != std::string::npos);
    text.replace(text.find(from), from.size(), to);
    try {
      atwood::scene_from_json(text);
    } catch (const atwood::InputError& error) {
      return std::string(error.what());
    }
    return std::string("no error");
  };
  CHECK_THAT(changed("\"coordinates\":[0]", "\"coordinates\":[0,1]"), Contains("is a list of 2; expected 1 numbers"));
  CHECK_THAT(changed("\"rates\":[0]", "\"rates\":[]"), Contains("is a list of 0"));
  CHECK_THAT(changed("[\"world\",\"a\"]", "[\"world\",\"z\"]"), Contains("is \"z\""));
  CHECK_THAT(changed("[\"world\",\"a\"]", "[\"a\",\"a\"]"), Contains("twice"));
  CHECK_THAT(changed("\"axis_body\":[0,0,1]", "\"axis_body\":[0,0,2]"), Contains("has length 2"));
}
