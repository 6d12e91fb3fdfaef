// The extended truth of mechanisms against what is known of their motions.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "extended/mechanism_path.hpp"
#include "extended/mechanism_truth.hpp"
#include "mechanism/start.hpp"
#include "random_mechanism.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

double magnitude(Wide x) { return std::fabs(static_cast<double>(x)); }

// Kinetic and potential energy of bodies whose inertia is a multiple of the identity.
Wide energy(const Scene& scene, const SampleView& sample) {
  Wide sum = 0;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const BodySample& at = sample.bodies[i];
    for (int k = 0; k < 3; ++k) {
      sum += Wide(body.mass_kg) * at.v_m_per_s[k] * at.v_m_per_s[k] / 2 +
             Wide(body.inertia_kg_m2[0]) * at.w_rad_per_s[k] * at.w_rad_per_s[k] / 2 -
             Wide(body.mass_kg) * Wide(scene.gravity_m_per_s2[k]) * at.p_m[k];
    }
  }
  return sum;
}

}  // namespace

// q'' = -sin q: I + m l^2 = m g l with I = m = l = 1, g = 2. The value was computed in 30 digits with Taylor series for
// a start at pi/2; the nearest double differs by 6.1e-17, and the flow changes the end by at most 10 times that.
TEST_CASE("a pendulum from the horizontal after 10 s") {
  Scenario scenario = mechanism_scenario(10);
  scenario.scene.gravity_m_per_s2 = {0, 0, -2};
  scenario.scene.bodies = {solid("bob", 1, 1)};
  scenario.scene.joints = {hinge(-1, 0, {}, {0, 0, 1}, M_PI / 2, 0)};
  const Truth truth = mechanism_truth(scenario, 2);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  REQUIRE(truth.values.size() == 3);
  CHECK(magnitude(truth.values[2].joints[0].q[0] - parse_wide("-9.4686245325590346589812553992286e-01")) < 1e-15);
  CHECK(magnitude(truth.values[2].joints[0].u[0] - parse_wide("-1.0809554582362732128736401377654e+00")) < 1e-15);
  CHECK(magnitude(truth.bars[2].joints[0].q[0]) < 1e-21);
  // The reaction along the rod is m (g cos q + l q'^2), across it m l q'' + m g sin q = m g sin q / 2.
  const JointSample& end = truth.values[2].joints[0];
  const Wide c = truth.values[2].bodies[0].p_m[2], s = truth.values[2].bodies[0].p_m[0];  // -cos q, -sin q
  const Wide along = -2 * c + end.u[0] * end.u[0], across = -s;
  CHECK(magnitude(end.force_N[0] - (along * -s + across * c)) < 1e-19);
  CHECK(magnitude(end.force_N[2] - (along * -c + across * -s)) < 1e-19);
}

TEST_CASE("energy of a double pendulum is constant to the bars") {
  const Scenario scenario = double_pendulum(2, 2, -1);
  const Truth truth = mechanism_truth(scenario, 4);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(truth.note.empty());
  for (const SampleView sample : truth.values)
    CHECK(magnitude(energy(scenario.scene, sample) - energy(scenario.scene, truth.values[0])) < 1e-24);
}

// 512 kg that turn at 500 rad/s about their middle axis, which tips over within 0.05 s. The values were computed with
// Taylor series of degree 50 of Euler's equations about the pivot, in 70 digits.
TEST_CASE("a heavy body's fast turn about its middle axis") {
  Scenario scenario = mechanism_scenario(0.15);
  scenario.scene.gravity_m_per_s2 = {0, 0, -9.8125};
  scenario.scene.bodies = {solid("top", 512, 0)};
  scenario.scene.bodies[0].inertia_kg_m2 = {32, 0, 0, 0, 96, 0, 0, 0, 128};
  Joint pivot = hinge(-1, 0, {}, {0, -0.25, 0}, 0, 0);
  pivot.kind = JointKind::ball;
  pivot.coordinates = {1, 0, 0, 0};
  pivot.rates = {0x1p-10, 500, 0x1p-9};
  scenario.scene.joints = {pivot};
  const Truth truth = mechanism_truth(scenario, 1);
  REQUIRE(truth.outcome.status == Status::ok);
  const JointSample &end = truth.values[1].joints[0], &bar = truth.bars[1].joints[0];
  const char* q[] = {"-0.08455888572381316068406209414849144", "-0.1947932969889521911528439029036769",
                     "-0.9598540125293624631720975148040405", "0.1832638560235036188142349228361245"};
  const char* u[] = {"258.0776732960983332041129344941326", "428.2339663406021202550944138577736",
                     "-115.4676323750772594004914870305829"};
  const Wide sign = (end.q[0] < 0) == (parse_wide(q[0]) < 0) ? 1 : -1;
  for (int k = 0; k < 4; ++k) CHECK(magnitude(sign * end.q[k] - parse_wide(q[k])) < magnitude(bar.q[k]));
  for (int k = 0; k < 3; ++k) CHECK(magnitude(end.u[k] - parse_wide(u[k])) < magnitude(bar.u[k]));
  CHECK(magnitude(bar.u[0]) < 1e-15);
  CHECK(truth.condition > 1e4);
}

// With so many rates one of the two runs is in long double: the bars must cover the distance from the motion of the
// spanning tree in quad at a tolerance far below, by methods and coordinates that are not those of the values.
TEST_CASE("the bars of a tree of many joints hold its motion in quad") {
  Scenario scenario = mechanism_scenario(0.5);
  for (int k = 0; k < 13; ++k) {
    scenario.scene.bodies.push_back(solid("link-" + std::to_string(k), 1, 0.02));
    const Joint turning =
        hinge(k - 1, k, {0, 0, k == 0 ? 0 : -0.25}, {0, 0, 0.25}, k == 0 ? -1.5 : 0.2, k == 4 ? 2 : 0);
    scenario.scene.joints.push_back(turning);
  }
  const Truth truth = mechanism_truth(scenario, 2);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(truth.source.find("long double") != std::string::npos);
  const Sample start = mechanism::start_sample(scenario.scene);
  const auto motion = extended::reduced_motion(scenario.scene, 0.5, start);
  const extended::MechanismPath path =
      extended::integrate_mechanism(*motion, start, {scenario.scene, 0.5, 2, 1e-22, 1e-13});
  REQUIRE(path.failure.empty());
  for (int k = 0; k < 13; ++k) {
    const JointSample &value = truth.values[2].joints[k], &bar = truth.bars[2].joints[k];
    const JointSample& other = path.samples[2].joints[k];
    CHECK(magnitude(value.q[0] - other.q[0]) < magnitude(bar.q[0]));
    CHECK(magnitude(value.u[0] - other.u[0]) < magnitude(bar.u[0]));
    for (int axis = 0; axis < 3; ++axis)
      CHECK(magnitude(value.force_N[axis] - other.force_N[axis]) < magnitude(bar.force_N[axis]));
    CHECK(magnitude(bar.q[0]) > 1e-19);
    CHECK(magnitude(bar.q[0]) < 1e-12);
  }
}

// (m1 + m2 + I / r^2) a = (m2 - m1) g.
TEST_CASE("Atwood's machine with a heavy pulley") {
  Scenario scenario = mechanism_scenario(1);
  scenario.scene.bodies = {point_mass("left", 1, {-0.25, 0, 0}), point_mass("right", 2, {0.25, 0, 0})};
  Rope rope;
  rope.name = "rope";
  rope.bodies = {0, 1};
  Pulley pulley;
  pulley.axle_m = {0, 0, 2};
  pulley.axis = {0, 1, 0};
  pulley.radius_m = 0.25;
  pulley.inertia_kg_m2 = 0.0625;  // I / r^2 = 1 kg
  pulley.angle_rad = 0.5;
  rope.over = {pulley};
  scenario.scene.ropes = {rope};
  const Wide g = Wide(9.81);
  for (const bool heavy : {true, false}) {
    scenario.scene.ropes[0].over[0].inertia_kg_m2 = heavy ? 0.0625 : 0;
    const Wide a = g / (heavy ? 4 : 3);
    const Truth truth = mechanism_truth(scenario, 2);
    REQUIRE(truth.outcome.status == Status::ok);
    const SampleView& end = truth.values.back();
    CHECK(magnitude(end.bodies[1].p_m[2] + a / 2) < 1e-29);
    CHECK(magnitude(end.bodies[0].p_m[2] - a / 2) < 1e-29);
    CHECK(magnitude(end.ropes[0].tension_N - (g + a)) < 1e-28);
    CHECK(magnitude(end.ropes[0].pulley_angle_rad[0] - (Wide(0.5) + a / 2 / Wide(0.25))) < 1e-28);
  }
}

TEST_CASE("a rope that is slack ends the truth") {
  Scenario scenario = mechanism_scenario(3);
  scenario.scene.bodies = {point_mass("bob", 1, {0.6, 0, -0.8})};
  scenario.scene.bodies[0].velocity_m_per_s = {3.2, 0, 2.4};  // 4 m/s: it leaves the circle above the horizontal
  Body fixed = point_mass("pivot", 0, {0, 0, 0});
  fixed.fixed = true;
  scenario.scene.bodies.push_back(fixed);
  Rope rope;
  rope.name = "string";
  rope.bodies = {1, 0};
  scenario.scene.ropes = {rope};
  const Truth truth = mechanism_truth(scenario, 300);
  REQUIRE(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason.find("`string` is slack at t = ") != std::string::npos);
  // T = m (v^2 / l + g cos a) with cos a downwards, v^2 = 16 - 2 g (z + 0.8): zero at 16 - 1.6 g = 3 g z.
  const double z = (16 - 1.6 * 9.81) / (3 * 9.81);
  REQUIRE(truth.values.size() > 2);
  CHECK(std::fabs(static_cast<double>(truth.values.back().bodies[0].p_m[2]) - z) < 0.05);
}

namespace {

// Without gravity, from rest at this angle, pressed against its stop at 0 by -2 cos(w t) N m. 1 kg m^2 about the hinge.
Scenario door(double t_end_s, double angle_rad, double restitution, double w_rad_per_s) {
  Scenario scenario = mechanism_scenario(t_end_s);
  scenario.scene.gravity_m_per_s2 = {0, 0, 0};
  scenario.scene.bodies = {solid("door", 2, 0.5)};
  Joint joint = hinge(-1, 0, {}, {0, 0, 0.5}, angle_rad, 0);
  joint.limits = JointLimits{0, 2, restitution};
  scenario.scene.joints = {joint};
  scenario.scene.joint_forces = {JointTorque{0, 0, -2, w_rad_per_s, 0, {}}};
  return scenario;
}

}  // namespace

// A rod that falls on a stop: each bounce takes e times the one before, and the series ends.
TEST_CASE("a joint's bounces at its stop come to rest") {
  const Scenario scenario = door(4, 1, 0.5, 0);
  const Truth truth = mechanism_truth(scenario, 8);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  REQUIRE(truth.events.size() > 20);
  // q = 1 - t^2: impacts at 1, 1 + 1, 1 + 1 + 1/2, ...; at rest from 3 on.
  Wide t = 1, flight = 1;
  for (const Event& event : truth.events) {
    if (event.kind == EventKind::rest) break;
    CHECK(magnitude(event.t_s - t) < 1e-20);
    t += flight;
    flight /= 2;
  }
  CHECK(truth.events.back().kind == EventKind::rest);
  CHECK(magnitude(truth.events.back().t_s - 3) < 1e-20);
  CHECK(magnitude(truth.events[0].vn_before_m_per_s + 2) < 1e-24);
  CHECK(magnitude(truth.events[0].impulse_n_N_s - 3) < 1e-24);
  CHECK(magnitude(truth.values[3].joints[0].q[0] - Wide(0.25)) < 1e-24);  // t = 1.5: the middle of the first flight
  CHECK(magnitude(truth.values[8].joints[0].q[0]) < 1e-24);
  CHECK(magnitude(truth.values[8].joints[0].u[0]) < 1e-24);
  CHECK(truth.values[3].joints[0].stop[0] == 0);
  CHECK(magnitude(truth.values[8].joints[0].stop[0] - 2) < 1e-24);  // against the motor's -2 N m
  CHECK(magnitude(truth.values[8].joints[0].torque_N_m[1]) < 1e-24);
}

// Pressed against its stop from rest by -2 cos(t), which pulls it off at pi / 2.
TEST_CASE("a joint that rests at its stop leaves it: the stop's force, and the events") {
  const Scenario scenario = door(2, 0, 0, 1);
  const Truth truth = mechanism_truth(scenario, 4);
  INFO(truth.outcome.reason);
  REQUIRE(truth.outcome.status == Status::ok);
  REQUIRE(truth.events.size() == 2);
  CHECK(truth.events[0].kind == EventKind::rest);
  CHECK(truth.events[0].t_s == 0);
  CHECK(truth.events[1].kind == EventKind::separate);
  CHECK(magnitude(truth.events[1].t_s - 2 * atanq(1)) < 1e-24);
  CHECK(magnitude(truth.values[2].joints[0].stop[0] - 2 * cosq(1)) < 1e-24);
  CHECK(magnitude(truth.bars[2].joints[0].stop[0]) < 1e-20);  // both formulations have it
  CHECK(truth.values[4].joints[0].stop[0] == 0);
}

// Both start from the same coordinates, those of an assembled four-bar rounded to double; each projects them along its
// own tree, by their rounding.
TEST_CASE("a loop's motion does not depend on the joint that closes it") {
  const Sample assembled = mechanism::start_sample(four_bar(1, 0).scene);
  const std::vector<Joint> joints = four_bar(1, 0).scene.joints;
  std::vector<Truth> truths;
  for (const int cut : {0, 1}) {
    Scenario scenario = four_bar(0.5, cut);
    for (Joint& joint : scenario.scene.joints)
      for (std::size_t j = 0; j < joints.size(); ++j)
        if (joints[j].name == joint.name) {
          joint.coordinates[0] = static_cast<double>(assembled.joints[j].q[0]);
          joint.rates[0] = static_cast<double>(assembled.joints[j].u[0]);
        }
    truths.push_back(mechanism_truth(scenario, 2));
    const Truth& truth = truths.back();
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(magnitude(energy(scenario.scene, truth.values[2]) - energy(scenario.scene, truth.values[0])) < 1e-23);
    for (const JointSample& joint : truth.values[2].joints) CHECK(joint.not_unique == 0b101010u);
  }
  for (int body = 0; body < 3; ++body)
    for (int k = 0; k < 3; ++k) {
      const BodySample &one = truths[0].values[2].bodies[body], &other = truths[1].values[2].bodies[body];
      CHECK(magnitude(one.p_m[k] - other.p_m[k]) < 1e-14);
      CHECK(magnitude(one.v_m_per_s[k] - other.v_m_per_s[k]) < 1e-13);
    }
}

TEST_CASE("a parallelogram that becomes flat ends the truth") {
  Scenario scenario = mechanism_scenario(2);
  scenario.scene.bodies = {solid("left", 1, 0.02), solid("bar", 2, 0.2), solid("right", 1, 0.02)};
  Joint closing = hinge(1, 2, {0.5, 0, 0}, {0, 0, 0.5}, 0.7, 1);
  closing.closes_loop = true;
  scenario.scene.joints = {hinge(-1, 0, {}, {0, 0, -0.5}, 0.7, 1), hinge(0, 1, {0, 0, 0.5}, {-0.5, 0, 0}, -0.7, -1),
                           hinge(-1, 2, {1, 0, 0}, {0, 0, -0.5}, 0.7, 1), closing};
  const Truth truth = mechanism_truth(scenario, 20);
  REQUIRE(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason.find("singular") != std::string::npos);
  REQUIRE(truth.values.size() > 2);
  CHECK(static_cast<double>(truth.values.back().joints[0].q[0]) < M_PI / 2);
  CHECK(truth.values.back().joints[0].not_unique == 0b101010u);
}
