// Motion without contacts: frames, units, instants, and the laws that semi-implicit Euler engines obey.
#include <catch2/catch.hpp>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"
#include "under_test.hpp"

namespace atwood::test {
namespace {

// free-box-complex at t = 10 s: Jacobi's elliptic solution, as the catalogue cites it.
const Real4 kBoxAttitude{0.225164563413958, -0.619927562499452, -0.277029150687195, 0.69874572364031};

Scene spinning(const Real3& inertia, const Real3& w_body, const Real4& q) {
  Scene scene = empty_scene();
  Body top = box_body("top", 2, inertia);
  top.angular_velocity_body_rad_per_s = w_body;
  top.orientation_wxyz = q;
  scene.bodies = {top};
  return scene;
}

}  // namespace

TEST_CASE("a profile has the time of every step, and of nothing else") {
  const Engine engine = engine_under_test();
  Profile profile;
  Observer observer;
  observer.profile = &profile;
  const Outcome outcome =
      engine.run(parse_method_id(engine.name + "/default"), free_box_complex(), {1, 60, 1}, observer, 0);
  CHECK(outcome.status == Status::ok);
  CHECK(outcome.steps_taken == 60);
  CHECK(outcome.busy_ns.empty());
  REQUIRE(profile.step_ns.size() == 60);
  for (const std::int64_t ns : profile.step_ns) CHECK(ns > 0);
  CHECK(profile.phase_ns.empty());
}

TEST_CASE("the height is g t h / 2 low, and attitude is poor, on the tumbling box") {
  const Engine engine = engine_under_test();
  for (const auto& scheme : semi_implicit(engine)) {
    for (const int rate_hz : {60, 240}) {
      // In float round-off shows at small steps: 2 % at 240 Hz.
      const double margin = in_float(engine) ? (rate_hz == 60 ? 0.01 : 0.05) : 1e-6;
      const Run result = run(engine, method(engine, scheme), free_box_complex(), Plan{10, 10 * rate_hz, 10});
      REQUIRE(result.outcome.status == Status::ok);
      REQUIRE(result.samples.size() == 11);
      for (int k = 1; k <= 10; ++k) {
        const double t = static_cast<double>(result.samples[k].t_s);
        CHECK(t == Approx(k).epsilon(1e-14));
        const double low = 8 * t - 0.5 * 9.8 * t * t - static_cast<double>(result.samples[k].bodies[0].p_m[2]);
        CHECK(low / (9.8 * t / 2 / rate_hz) == Approx(1).epsilon(margin));
        // Velocity is of the same instant as position.
        const double v = static_cast<double>(result.samples[k].bodies[0].v_m_per_s[2]);
        CHECK(v == Approx(8 - 9.8 * t).epsilon(in_float(engine) ? 1e-4 : 1e-10));
      }
      const double off = angle_between(result.q(0), kBoxAttitude);
      CHECK(off > 0.03);
    }
  }
}

TEST_CASE("attitude converges to the truth where time is short") {
  // At t = 1 s the box has not yet flipped; first order shows: a tenth of the step, about a tenth of the error.
  const Engine engine = engine_under_test();
  const auto end = [&](std::int64_t steps) {
    return run(engine, method(engine, semi_implicit(engine).back()), free_box_complex(), Plan{1, steps, 1}).q(0);
  };
  const Real4 finest = end(64000);
  const double coarse = angle_between(end(200), finest), fine = angle_between(end(2000), finest);
  CHECK(coarse > 1e-5);
  CHECK(fine < 0.15 * coarse + (in_float(engine) ? 2e-3 : 0));
}

TEST_CASE("spin about a principal axis is exact, in any pose") {
  const Engine engine = engine_under_test();
  const Real3 w{0, 0, 0.7};
  const Real4 q0{0.5, 0.5, -0.5, 0.5};
  const Run result = run(engine, method(engine, "default"), spinning({0.6, 0.8, 1.0}, w, q0), Plan{2, 200, 10});
  const Real4 exact = rivals::product(q0, {std::cos(0.7), 0, 0, std::sin(0.7)});
  CHECK(angle_between(result.q(0), exact) < (in_float(engine) ? 1e-4 : 1e-5));
  for (int k = 0; k < 3; ++k) CHECK(result.w(0, k) == Approx(w[k]).margin(in_float(engine) ? 1e-4 : 1e-9));
}

TEST_CASE("a symmetric top precesses at the closed form's rate") {
  // I = (0.04, 0.04, 0.02), w = (1, 0, 5): body rate turns at (I3 - I1) / I1 w3 = -2.5 rad/s about body z.
  const Engine engine = engine_under_test();
  const Run result =
      run(engine, sharpest(engine), spinning({0.04, 0.04, 0.02}, {1, 0, 5}, {1, 0, 0, 0}), Plan{1, 20000, 10});
  CHECK(result.w(0, 0) == Approx(std::cos(2.5)).margin(2e-2));
  CHECK(result.w(0, 1) == Approx(-std::sin(2.5)).margin(2e-2));
  CHECK(result.w(0, 2) == Approx(5).margin(5e-3));
}

TEST_CASE("an inertia given in other than principal axes describes the same motion") {
  const Engine engine = engine_under_test();
  const Real3 moments{0.5, 0.8, 1.0}, w{0.3, 1.0, -0.4};
  const Real4 turn{std::cos(0.4), 0.6 * std::sin(0.4), 0, 0.8 * std::sin(0.4)};  // body axes B from principal axes P
  Scene straight = spinning(moments, w, {1, 0, 0, 0});
  Scene turned = straight;
  const Real33 r = rivals::matrix_of(turn);
  Real33& inertia = turned.bodies[0].inertia_kg_m2;
  inertia = {};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (int k = 0; k < 3; ++k) inertia[3 * i + j] += r[3 * i + k] * moments[k] * r[3 * j + k];
  for (auto [i, j] : {std::pair(1, 3), std::pair(2, 6), std::pair(5, 7)}) inertia[j] = inertia[i];
  turned.bodies[0].angular_velocity_body_rad_per_s = rivals::times(r, w);
  turned.bodies[0].orientation_wxyz = rivals::conjugate(turn);

  const Plan plan{1, 2000, 10};
  const Run a = run(engine, method(engine, "default"), straight, plan);
  const Run b = run(engine, method(engine, "default"), turned, plan);
  REQUIRE(b.outcome.status == Status::ok);
  const double margin = in_float(engine) ? 1e-3 : 1e-9;
  CHECK(angle_between(rivals::product(b.q(0), turn), a.q(0)) < margin);
  const Real3 w_b{b.w(0, 0), b.w(0, 1), b.w(0, 2)};
  const Real3 back = rivals::transposed_times(r, w_b);
  for (int k = 0; k < 3; ++k) CHECK(back[k] == Approx(a.w(0, k)).margin(margin));
}

TEST_CASE("a thruster pushes and turns, and switches when told") {
  // 2 N along body y at (0.5, 0, 0): torque 1 N m about z, on during [0.5, 1).
  const Engine engine = engine_under_test();
  Scene scene = spinning({1, 1, 1.6}, {0, 0, 0}, {1, 0, 0, 0});
  scene.forces.push_back(Thruster{0, {0.5, 0, 0}, {0, 1, 0}, 2, {{0.5, 1.0}}});
  const Run result = run(engine, method(engine, "default"), scene, Plan{2, 2000, 20});
  REQUIRE(result.outcome.status == Status::ok);
  CHECK(static_cast<double>(result.samples[5].bodies[0].w_rad_per_s[2]) == 0);
  CHECK(result.w(0, 2) == Approx(0.5 / 1.6).epsilon(in_float(engine) ? 1e-4 : 1e-9));
  CHECK(std::hypot(result.v(0, 0), result.v(0, 1)) == Approx(0.5).epsilon(2e-3));
}

TEST_CASE("a point mass is pushed and not turned") {
  const Engine engine = engine_under_test();
  Scene scene = empty_scene();
  Body point;
  point.name = "point";
  point.mass_kg = 2;
  scene.bodies = {point};
  scene.forces.push_back(PointForce{0, {1, 0, 0}, {0, 0, 4}, {}});
  const Run result = run(engine, method(engine, "default"), scene, Plan{1, 100, 10});
  CHECK(result.v(0, 2) == Approx(2).epsilon(1e-5));
  CHECK(result.w(0, 1) == 0);
  CHECK(result.q(0) == Real4{1, 0, 0, 0});
}

TEST_CASE("a held body waits for its release, then falls with its velocity") {
  const Engine engine = engine_under_test();
  Scene scene = bounce(bounces(engine) ? 0.5 : 0, 5);
  scene.bodies[1].release_s = 0.5;
  scene.bodies[1].velocity_m_per_s = {1, 0, 0};
  const Run result = run(engine, method(engine, "default"), scene, Plan{1, 1000, 10});
  REQUIRE(result.outcome.status == Status::ok);
  const auto at = [&](int k) { return result.samples[k].bodies[1]; };
  CHECK(static_cast<double>(at(5).p_m[2]) == 5.1);
  CHECK(static_cast<double>(at(5).p_m[0]) == 0);
  CHECK(static_cast<double>(at(10).p_m[0]) == Approx(0.5).epsilon(1e-5));
  const double fallen = 0.5 * 9.81 * 0.25 + 9.81 * 0.5 * 0.001 / 2;
  CHECK(static_cast<double>(at(10).p_m[2]) == Approx(5.1 - fallen).epsilon(1e-5));
}

TEST_CASE("principal axes diagonalise") {
  const Real33 inertia{3, -0.5, 0.2, -0.5, 2, 0.1, 0.2, 0.1, 4};
  const auto axes = rivals::principal_axes(inertia);
  const Real33 r = rivals::matrix_of(axes.q_BP);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      double sum = 0;
      for (int k = 0; k < 3; ++k) sum += r[3 * i + k] * axes.moments_kg_m2[k] * r[3 * j + k];
      CHECK(sum == Approx(inertia[3 * i + j]).margin(1e-14));
    }
}

}  // namespace atwood::test
