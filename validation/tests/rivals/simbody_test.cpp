// Simbody: motion at the order of its integrators, fixed and chosen steps; Hertz's contacts by their own closed forms;
// what it refuses.
#include <catch2/catch.hpp>

#include "mechanism_scenes.hpp"
#include "rivals/vector.hpp"
#include "scenes.hpp"
#include "simbody/simbody.hpp"
#include "validation/tests/catalogued.hpp"

namespace atwood::test {
namespace {

// free-box-complex at t = 10 s: Jacobi's elliptic solution, as the catalogue cites it.
const Real4 kBoxAttitude{0.225164563413958, -0.619927562499452, -0.277029150687195, 0.69874572364031};
const Real3 kBoxRate{2.75584040514685, -3.73596351921622, -3.16180900346752};

const Engine& engine() {
  static const Engine made = simbody_engine();
  return made;
}

Run run_with(const std::string& scheme, const Scene& scene, const Plan& plan, const Settings& overrides = {}) {
  return run(engine(), method(engine(), scheme, overrides), scene, plan);
}

Run run_to(double rtol, const Scene& scene, const Plan& plan) {
  MethodId id = method(engine(), "rk-merson");
  id.rtol = rtol;
  return run(engine(), id, scene, plan);
}

}  // namespace

TEST_CASE("presets print what decides accuracy") {
  REQUIRE(engine().methods.size() == 5);
  for (const auto& info : engine().methods) {
    CHECK_FALSE(info.doc.empty());
    for (const char* name :
         {"scalar", "substeps", "step", "pair_law", "forces", "integrator", "steps", "accuracy", "constraint_tolerance",
          "project_every_step", "sleeping", "linear_damping", "angular_damping"}) {
      CHECK((info.settings.count(name) ? "" : name) == std::string());
    }
    CHECK(info.adaptive == (info.id == "simbody/rk-merson" || info.id == "simbody/cpodes"));
  }
}

TEST_CASE("the tumbling box: order 5 in fixed steps, a tolerance that helps in chosen ones") {
  const auto off = [](const Run& end) {
    REQUIRE(end.outcome.status == Status::ok);
    return angle_between(end.q(0), kBoxAttitude);
  };
  const double coarse = off(run_with("default", free_box_complex(), Plan{10, 1920, 10}));
  const double fine = off(run_with("default", free_box_complex(), Plan{10, 3840, 10}));
  CHECK(std::log2(coarse / fine) == Approx(5).margin(0.3));
  double before = 1;
  for (const double rtol : {1e-6, 1e-8, 1e-10, 1e-12}) {
    const Run end = run_to(rtol, free_box_complex(), Plan{10, 60, 10});
    CHECK(off(end) < 0.1 * before);
    before = off(end);
    CHECK(end.outcome.rate_evaluations > 100);
    for (int k = 0; k < 3; ++k) CHECK(end.w(0, k) == Approx(kBoxRate[k]).margin(1e6 * rtol));
    CHECK(end.p(0, 2) == Approx(8 * 10 - 0.5 * 9.8 * 100).epsilon(1e-12));
    CHECK(static_cast<double>(end.samples[5].t_s) == 5);
    CHECK(static_cast<double>(end.samples[5].bodies[0].p_m[2]) == Approx(8 * 5 - 0.5 * 9.8 * 25).epsilon(1e-9));
  }
  CHECK(before < 1e-7);
  CHECK(off(run_with("chosen", free_box_complex(), Plan{10, 60, 10})) < 1e-5);
}

TEST_CASE("a fixed step pays for its error estimate and goes on whatever it says") {
  const Run loose = run_with("default", free_box_complex(), Plan{10, 60, 10});
  const Run tight = run_with("default", free_box_complex(), Plan{10, 60, 10}, {{"accuracy", 1e-14}});
  REQUIRE(tight.outcome.status == Status::ok);
  CHECK(angle_between(tight.q(0), loose.q(0)) < 1e-9);
  CHECK(loose.outcome.rate_evaluations >= 5 * 60);
  CHECK(loose.outcome.rate_evaluations < 5 * 60 + 10);
  CHECK(angle_between(loose.q(0), kBoxAttitude) > 0.1);
}

TEST_CASE("a thruster pushes and turns at every rate call, and switches when told") {
  Scene scene = empty_scene();
  scene.bodies = {box_body("ship", 2, {1, 1, 1.6})};
  scene.forces.push_back(Thruster{0, {0.5, 0, 0}, {0, 1, 0}, 2, {{0.5, 1.0}}});
  for (const bool chosen : {false, true}) {
    const Run end = chosen ? run_to(1e-9, scene, Plan{2, 20, 20}) : run_with("default", scene, Plan{2, 200, 20});
    REQUIRE(end.outcome.status == Status::ok);
    CHECK_THAT(end.outcome.reason, Catch::Contains("every rate call") && Catch::Contains("thruster"));
    CHECK(static_cast<double>(end.samples[5].bodies[0].w_rad_per_s[2]) == 0);
    CHECK(static_cast<double>(end.samples[10].bodies[0].w_rad_per_s[2]) == Approx(0.5 / 1.6).epsilon(1e-9));
    CHECK(end.w(0, 2) == Approx(0.5 / 1.6).epsilon(1e-9));
  }
}

TEST_CASE("a point mass orbits and never turns; a held one waits") {
  Scene scene = empty_scene();
  Body planet;
  planet.name = "planet";
  planet.mass_kg = 3;
  planet.position_m = {0.4, 0, 0};
  planet.velocity_m_per_s = {0, 2, 0};
  scene.bodies = {planet};
  scene.forces.push_back(Attractor{{0}, {0, 0, 0}, 1});
  const double period = 2 * std::acos(-1.0);  // a = 1
  const Run orbit = run_to(1e-11, scene, Plan{period, 64, 64});
  REQUIRE(orbit.outcome.status == Status::ok);
  CHECK(orbit.p(0, 0) == Approx(0.4).margin(1e-7));
  CHECK(orbit.p(0, 1) == Approx(0).margin(1e-7));
  CHECK(orbit.q(0) == Real4{1, 0, 0, 0});

  scene.forces.clear();
  scene.gravity_m_per_s2 = {0, 0, -10};
  scene.bodies[0].release_s = 0.5;
  const Run held = run_with("default", scene, Plan{1, 100, 10});
  REQUIRE(held.outcome.status == Status::ok);
  CHECK(static_cast<double>(held.samples[5].bodies[0].p_m[1]) == 0);
  CHECK(held.p(0, 1) == Approx(1).epsilon(1e-9));
  CHECK(held.p(0, 2) == Approx(-1.25).epsilon(1e-9));
}

TEST_CASE("an inertia given in other than principal axes describes the same motion") {
  Scene scene = empty_scene();
  scene.bodies = {box_body("top", 1, {0.5, 0.8, 1.0})};
  scene.bodies[0].angular_velocity_body_rad_per_s = {0.3, 1.0, -0.4};
  Scene turned = scene;
  const Real4 turn{std::cos(0.4), 0.6 * std::sin(0.4), 0, 0.8 * std::sin(0.4)};
  const Real33 r = rivals::matrix_of(turn);
  Real33& inertia = turned.bodies[0].inertia_kg_m2;
  inertia = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) inertia[3 * i + j] += r[3 * i + k] * Real3{0.5, 0.8, 1.0}[k] * r[3 * j + k];
  turned.bodies[0].angular_velocity_body_rad_per_s = rivals::times(r, {0.3, 1.0, -0.4});
  turned.bodies[0].orientation_wxyz = rivals::conjugate(turn);
  const Run a = run_to(1e-11, scene, Plan{5, 50, 5}), b = run_to(1e-11, turned, Plan{5, 50, 5});
  REQUIRE(b.outcome.status == Status::ok);
  CHECK(angle_between(rivals::product(b.q(0), turn), a.q(0)) < 1e-8);
}

// Hunt and Crossley 1975: with F = k d^3/2 (1 + c d'), m v dv / (1 + c v) = -k d^3/2 dd, and the same way in and out:
//   c (v_in + v_out) = log((1 + c v_in) / (1 - c v_out));  c = 0: v_out = v_in
TEST_CASE("balls with Hertz contact separate at the speed of the law, with and without damping") {
  for (const double c : {0.0, 0.4}) {
    Scene scene = head_on(0, 1, 3);
    scene.pairs[0].contact_law = ContactLaw::hertz;
    scene.pairs[0].modulus_Pa = 5e5;
    scene.pairs[0].damping_s_per_m = c;
    const Run end = run_with("chosen", scene, Plan{2, 1000, 10});
    INFO(end.outcome.reason);
    REQUIRE(end.outcome.status == Status::ok);
    const double out = end.v(1, 0) - end.v(0, 0);
    if (c > 0) CHECK(c * (1.5 + out) == Approx(std::log((1 + c * 1.5) / (1 - c * out))).epsilon(1e-6));
    else CHECK(out == Approx(1.5).epsilon(1e-8));
    CHECK(end.v(0, 0) + 3 * end.v(1, 0) == Approx(-0.5).epsilon(1e-9));
  }
}

// Up to the deepest overlap d: m v^2 / 2 = 8/15 E R^1/2 d^5/2, and it takes 1.4716 d / v (Landau and Lifshitz, section
// 9).
TEST_CASE("a ball bounces off a slanting plane by Hertz's law") {
  Scene scene = bounce(0, 0.3);
  scene.gravity_m_per_s2 = {0, 0, 0};
  scene.pairs[0].contact_law = ContactLaw::hertz;
  scene.pairs[0].modulus_Pa = 1e5;
  scene.bodies[0].shape = Plane{{0.6, 0, 0.8}, 0.25};
  const Real3 n{0.6, 0, 0.8};
  for (int k = 0; k < 3; ++k) {
    scene.bodies[1].position_m[k] = 0.85 * n[k];  // 0.5 above its touch
    scene.bodies[1].velocity_m_per_s[k] = -n[k];
  }
  scene.bodies[1].velocity_m_per_s[1] = 0.7;  // along the plane
  const double deepest = std::pow(15.0 / (16 * 1e5 * std::sqrt(0.1)), 0.4), half = 1.4716375 * deepest;
  const Run end = run_with("chosen", scene, Plan{0.5 + half, 100, 10});
  INFO(end.outcome.reason);
  REQUIRE(end.outcome.status == Status::ok);
  CHECK(0.6 * end.p(1, 0) + 0.8 * end.p(1, 2) - 0.25 - 0.1 == Approx(-deepest).epsilon(1e-6));
  CHECK(end.v(1, 1) == Approx(0.7).epsilon(1e-9));
  const Run after = run_with("chosen", scene, Plan{1.5, 100, 10});
  CHECK(0.6 * after.v(1, 0) + 0.8 * after.v(1, 2) == Approx(1).epsilon(1e-8));
}

TEST_CASE("contacts that are not Hertz's alone it refuses, and says why") {
  const auto reason = [](const Scene& scene) {
    const Run refused = try_run(engine(), method(engine(), "chosen"), scene, Plan{1, 100, 10});
    CHECK(to_string(refused.outcome.status) == "unsupported");
    return refused.outcome.reason;
  };
  CHECK_THAT(reason(bounce(0.5, 1)), Catch::Contains("restitution and friction"));
  Scene scene = bounce(0, 1);
  PairLaw& law = scene.pairs[0];
  law.contact_law = ContactLaw::linear;
  law.stiffness_N_per_m = 1000;
  CHECK_THAT(reason(scene), Catch::Contains("found contact_law = \"linear\""));
  law.contact_law = ContactLaw::hertz;
  law.modulus_Pa = 1e5;
  law.friction = 0.1;
  CHECK_THAT(reason(scene), Catch::Contains("creep"));
  law.friction = 0;
  scene.bodies[1].shape = Box{{0.1, 0.1, 0.1}};
  CHECK_THAT(reason(scene), Catch::Contains("`ball`, a box"));
  scene.bodies[1].shape = Sphere{0.1};
  scene.materials.push_back({"soft", 0, 0, 0});
  scene.pairs.push_back({0, 1, 0, 0, 0, ContactLaw::hertz, 0, 0, false, 2e4, 0});
  scene.bodies.push_back(sphere_body("soft", 1, 0.1, {0.5, 0, 1}));
  scene.bodies.back().material = 1;
  CHECK_THAT(reason(scene), Catch::Contains("different modulus"));
  MethodId toleranced = method(engine(), "chosen");
  toleranced.rtol = 1e-6;
  CHECK_THAT(try_run(engine(), toleranced, free_box_complex(), Plan{1, 10, 10}).outcome.reason,
             Catch::Contains("tolerance"));
}

TEST_CASE("CPodes steps trees of hinges and refuses what it gets wrong") {
  const Scene arm = two_link_arm();
  MethodId tight = method(engine(), "cpodes");
  tight.rtol = 1e-11;
  const Run adams = run(engine(), tight, arm, Plan{1, 100, 10}), merson = run_to(1e-11, arm, Plan{1, 100, 10});
  INFO(adams.outcome.reason);
  REQUIRE(adams.outcome.status == Status::ok);
  for (int j = 0; j < 2; ++j)
    CHECK(static_cast<double>(adams.samples.back().joints[j].q[0] - merson.samples.back().joints[j].q[0]) ==
          Approx(0).margin(1e-8));
  const auto reason = [&](const Scene& scene) {
    const Run refused = try_run(engine(), tight, scene, Plan{1, 100, 10});
    CHECK(to_string(refused.outcome.status) == "unsupported");
    return refused.outcome.reason;
  };
  CHECK_THAT(reason(zoo({JointKind::hinge})), Catch::Contains("floating body `base`"));
  Scene ball = arm;
  ball.joints[1].kind = JointKind::ball;
  ball.joints[1].coordinates = {1, 0, 0, 0};
  CHECK_THAT(reason(ball), Catch::Contains("ball joint `elbow`"));
  Scene loop = arm;
  loop.joints.push_back(joint_of("closing", JointKind::hinge, -1, 1));
  loop.joints.back().closes_loop = true;
  CHECK_THAT(reason(loop), Catch::Contains("closes one"));
  const Run fixed =
      try_run(engine(), method(engine(), "default", {{"integrator", std::string("CPodes")}}), arm, Plan{1, 10, 1});
  CHECK_THAT(fixed.outcome.reason, Catch::Contains("expected the method simbody/cpodes"));
}

TEST_CASE("every smooth scene promised for rivals runs") {
  for (const char* id : {"ballistic", "projectile-linear-drag", "projectile-quadratic-drag", "free-box-simple",
                         "free-box-complex", "symmetric-top", "dzhanibekov", "thrusters", "force-at-a-point",
                         "force-at-a-point-body", "frame-rate-30", "frame-rate-144", "frame-rate-jitter"}) {
    const Scenario scenario = testing::catalogued(id);
    const Plan plan{scenario.t_end_s, scenario.steps.back(), scenario.samples, scenario.frame_ends_s};
    const Run end = run_with("default", scenario.scene, plan);
    INFO(id << ": " << end.outcome.reason);
    CHECK(to_string(end.outcome.status) == "ok");
    CHECK(end.samples.size() == static_cast<std::size_t>(scenario.samples) + 1);
  }
}

}  // namespace atwood::test
