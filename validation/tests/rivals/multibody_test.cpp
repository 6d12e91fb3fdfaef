// Bullet's multibodies beyond what every engine with joints is asked: the orders that they execute, and the settings
// without which they would simulate something else.
#include <catch2/catch.hpp>
#include <numbers>

#include "bullet/bullet.hpp"
#include "mechanism_scenes.hpp"

namespace atwood::test {
namespace {

double value(Wide x) { return static_cast<double>(x); }

Run run_with(const std::string& scheme, const Scene& scene, const Plan& plan, const Settings& settings = {}) {
  const Engine engine = bullet_engine();
  Run result = run(engine, method(engine, scheme, settings), scene, plan);
  INFO(scheme << ": " << result.outcome.reason);
  REQUIRE(to_string(result.outcome.status) == "ok");
  return result;
}

// From three step counts, each twice the one before, by the last body's attitude.
double executed_order(const std::string& scheme, const Scene& scene, double t_end_s, std::int64_t steps) {
  const int last = static_cast<int>(scene.bodies.size()) - 1;
  std::array<M3, 3> ends;
  for (int k = 0; k < 3; ++k)
    ends[k] = pose_of(run_with(scheme, scene, Plan{t_end_s, steps << k, 1}).samples.back(), last).r;
  return std::log2((ends[0] - ends[1]).norm() / (ends[1] - ends[2]).norm());
}

// A body on a ball joint at the world, turning about all axes.
Scene ball_pendulum() {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  scene.bodies = {oblique_body("bob", 1.5, 0.6)};
  Joint pivot = joint_of("pivot", JointKind::ball, -1, 0);
  pivot.anchors_body_m = {{{0, 0, 0}, {0.1, -0.2, 0.6}}};
  pivot.coordinates = unit(0.7, 0.4, -0.1, 0.3);
  pivot.rates = {2, -1, 4};
  scene.joints = {pivot};
  place(scene);
  return scene;
}

}  // namespace

TEST_CASE("semi-implicit Euler is of order 1; Runge-Kutta of order 4 on hinges, 2 on balls, 1 with a free base") {
  CHECK(executed_order("multibody", two_link_arm(), 0.5, 2000) == Approx(1).margin(0.1));
  CHECK(executed_order("multibody", ball_pendulum(), 0.5, 4000) == Approx(1).margin(0.1));
  CHECK(executed_order("multibody-rk4", oblique_pendulum(), 1, 200) == Approx(4).margin(0.1));
  CHECK(executed_order("multibody-rk4", two_link_arm(), 1, 1600) == Approx(4).margin(0.1));
  CHECK(executed_order("multibody-rk4", ball_pendulum(), 0.5, 200) == Approx(2).margin(0.1));
  CHECK(executed_order("multibody-rk4", free_box_complex(), 0.5, 500) == Approx(1).margin(0.1));
}

TEST_CASE("rates are neither damped nor cut off at 100 rad/s") {
  Scene scene = empty_scene();
  scene.bodies = {box_body("rotor", 1, {0.1, 0.1, 0.2})};
  Joint axle = joint_of("axle", JointKind::hinge, -1, 0);
  axle.axis_body = {0, 0, 1};
  axle.rates[0] = 350;
  scene.joints = {axle};
  place(scene);
  for (const char* scheme : {"multibody", "multibody-rk4"})
    CHECK(value(run_with(scheme, scene, Plan{1, 1000, 1}).samples.back().joints[0].q[0]) == Approx(350).epsilon(1e-12));
  const JointSample damped =
      run_with("multibody", scene, Plan{1, 1000, 1}, {{"angular_damping", 0.04}}).samples.back().joints[0];
  CHECK(value(damped.u[0]) < 349);
  const JointSample cut =
      run_with("multibody", scene, Plan{1, 1000, 1}, {{"max_coordinate_velocity", 100.0}}).samples.back().joints[0];
  CHECK(value(cut.u[0]) <= 100);
}

// Three uniform rods of 1 m and 1 kg: two cranks and the coupler between them. The cranks' angle q from the upward
// vertical obeys q'' = g (1/2 + 1/2 + 1) / (1/3 + 1/3 + 1) sin q, for the coupler moves without turning.
TEST_CASE("a parallelogram that a closing hinge between two links holds moves as one degree of freedom") {
  Scene scene = empty_scene();
  scene.gravity_m_per_s2 = {0, 0, -9.81};
  const double moment = 1.0 / 12;
  for (const char* name : {"left", "coupler", "right"})
    scene.bodies.push_back(box_body(name, 1, {moment, moment, moment}));
  const auto hinge = [](const char* name, int parent, int child, const Real3& a, const Real3& b, double angle) {
    Joint joint = joint_of(name, JointKind::hinge, parent, child);
    joint.axis_body = {0, 1, 0};
    joint.anchors_body_m = {a, b};
    joint.coordinates[0] = angle;
    return joint;
  };
  scene.joints = {hinge("o-left", -1, 0, {0, 0, 0}, {0, 0, -0.5}, 0.8),
                  hinge("left-coupler", 0, 1, {0, 0, 0.5}, {-0.5, 0, 0}, -0.8),
                  hinge("o-right", -1, 2, {1, 0, 0}, {0, 0, -0.5}, 0.8),
                  hinge("coupler-right", 1, 2, {0.5, 0, 0}, {0, 0, 0.5}, 0.8)};
  scene.joints[3].closes_loop = true;
  place(scene);
  double q = 0.8, u = 0;
  const auto rate = [](double x) { return 9.81 * 1.2 * std::sin(x); };
  for (int n = 0; n < 10000; ++n) {
    const double h = 1e-4, k1 = rate(q), k2 = rate(q + h / 2 * u), k3 = rate(q + h / 2 * u + h * h / 4 * k1),
                 k4 = rate(q + h * u + h * h / 2 * k2);
    q += h * u + h * h / 6 * (k1 + k2 + k3);
    u += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
  }
  const Settings converged{{"iterations", std::int64_t{200}}};
  for (const char* scheme : {"multibody", "default"}) {
    const Run result = run_with(scheme, scene, Plan{1, 8000, 8}, converged);
    INFO(scheme);
    CHECK(value(result.samples.back().joints[0].q[0]) == Approx(q).margin(2e-3));
    const Pose coupler = pose_of(result.samples.back(), 1), right = pose_of(result.samples.back(), 2);
    CHECK((coupler.p + coupler.r * V3(0.5, 0, 0) - right.p - right.r * V3(0, 0, 0.5)).norm() < 1e-5);
  }
}

TEST_CASE("what multibodies lack is refused by name") {
  const auto reason = [](const std::string& scheme, const Scene& scene) {
    const Engine engine = bullet_engine();
    const Run result = try_run(engine, method(engine, scheme), scene, Plan{1, 10, 1});
    CHECK(to_string(result.outcome.status) == "unsupported");
    return result.outcome.reason;
  };
  CHECK_THAT(reason("multibody", bounce(0.5, 1)), Catch::Contains("contacts"));
  Scene held = free_box_complex();
  held.bodies[0].release_s = 1;
  CHECK_THAT(reason("multibody", held), Catch::Contains("box"));
  Scene limited = two_link_arm();
  limited.joints[1].limits = JointLimits{-2, 2, 0};
  CHECK_THAT(reason("multibody-rk4", limited), Catch::Contains("elbow") && Catch::Contains("Runge-Kutta"));
  limited.joints[1].limits->restitution = 0.5;
  CHECK_THAT(reason("multibody", limited), Catch::Contains("elbow") && Catch::Contains("restitution"));
  Scene pointed = two_link_arm();
  pointed.bodies[0].inertia_kg_m2 = {};
  CHECK_THAT(reason("multibody", pointed), Catch::Contains("upper"));
}

}  // namespace atwood::test
