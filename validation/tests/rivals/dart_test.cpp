// What is DART's own: its law of a bounce, its pyramid, how a pair's law gets there, its detectors, and its ways of
// giving up.
#include <array>
#include <catch2/catch.hpp>
#include <iostream>

#include "dart/dart_world.hpp"
#include "dart/engine.hpp"
#include "dart/surfaces.hpp"
#include "scenes.hpp"

namespace atwood::test {
namespace {

const Engine& engine() {
  static const Engine made = dart_engine();
  return made;
}

Run run_with(const std::string& scheme, const Scene& scene, const Plan& plan, const Settings& overrides = {}) {
  return run(engine(), method(engine(), scheme, overrides), scene, plan);
}

std::string refusal_of(const Scene& scene, const Settings& overrides = {}) {
  const Run refused = try_run(engine(), method(engine(), "default", overrides), scene, Plan{0.1, 10, 1});
  CHECK(to_string(refused.outcome.status) == "unsupported");
  return refused.outcome.reason;
}

}  // namespace

TEST_CASE("a ball leaves the floor with e (v + g h): restitution is of a velocity with the step's gravity in it") {
  for (const std::int64_t rate_hz : {240, 960}) {
    const Run result = run_with("stiff", bounce(0.8, 0.5), Plan{1, rate_hz, 10});
    REQUIRE(result.events.size() == 2);
    for (const Event& impact : result.events) {
      const double v = -static_cast<double>(impact.vn_before_m_per_s),
                   off = static_cast<double>(impact.vn_after_m_per_s);
      CHECK(off == Approx(0.8 * (v + 9.81 / static_cast<double>(rate_hz))).epsilon(1e-6));
    }
  }
}

TEST_CASE("restitution ends at 0.1 m/s, as the settings say") {
  // Weightless, onto a fixed wall at 0.2 m/s: e = 0.6 sends it back, e = 0.4 (0.08 m/s) does not.
  for (const double e : {0.6, 0.4}) {
    Scene scene = bounce(e, 0.05);
    scene.gravity_m_per_s2 = {0, 0, 0};
    scene.bodies[1].velocity_m_per_s = {0, 0, -0.2};
    const Run result = run_with("stiff", scene, Plan{1, 240, 10});
    CHECK(result.v(1, 2) == Approx(e > 0.5 ? 0.12 : 0).margin(1e-8));
  }
}

TEST_CASE("the pyramid stops too soon off its axes; turned along the slip it does not") {
  const double exact = 4 / (2 * 0.4 * 9.81), c = std::sqrt(0.5);
  const auto distance = [&](const std::string& scheme, double cos, double sin) {
    const Run end = run_with(scheme, sliding_box(0.4, cos, sin), Plan{1, 4800, 24});
    REQUIRE(end.outcome.status == Status::ok);
    return std::hypot(end.p(1, 0), end.p(1, 1));
  };
  CHECK(distance("default", 1, 0) == Approx(exact).epsilon(2e-3));
  CHECK(distance("default", c, c) == Approx(exact * c).epsilon(2e-3));  // both axes brake with mu N
  CHECK(distance("stiff", 1, 0) == Approx(exact).epsilon(2e-3));
  CHECK(distance("stiff", c, c) == Approx(exact).epsilon(2e-3));
}

TEST_CASE("each pair has its own law, by a shape for each material") {
  // Box 1 lies on the floor, box 2 on box 1, box 3 on the floor. Materials: floor 0, box 1 is 1, boxes 2 and 3 are 2.
  Scene scene = bounce(0, 0);
  scene.materials.assign(3, Material{});
  scene.pairs = {PairLaw{0, 0, 0, 0.9, 0},  PairLaw{0, 1, 0, 0.4, 0}, PairLaw{1, 1, 0.3, 0.7, 0},
                 PairLaw{0, 2, 0, 0.25, 0}, PairLaw{1, 2, 0, 0.1, 0}, PairLaw{2, 2, 0.5, 0.1, 0}};
  scene.bodies[1] = flat_box("low", {0, 0, 0.05});
  scene.bodies.push_back(flat_box("high", {0, 0, 0.15}));
  scene.bodies.push_back(flat_box("apart", {0, 3, 0.05}));
  for (int i = 1; i < 4; ++i) {
    scene.bodies[i].material = std::min(i, 2);
    if (i != 1) scene.bodies[i].velocity_m_per_s = {1, 0, 0};
  }
  const Run slid = run_with("stiff", scene, Plan{0.15, 300, 10});
  REQUIRE(slid.outcome.status == Status::ok);
  CHECK(slid.v(1, 0) == Approx(0).margin(1e-3));  // 0.1 from above can't move it against 0.4 below
  CHECK(1 - slid.v(2, 0) == Approx(0.1 * 9.81 * 0.15).epsilon(0.03));
  CHECK(1 - slid.v(3, 0) == Approx(0.25 * 9.81 * 0.15).epsilon(0.03));

  // Two pairs of balls that meet head on, far from each other: 2 with 2 (e = 0.5), 0 with 1 (e = 0.9).
  Scene balls = empty_scene();
  balls.materials.assign(3, Material{});
  balls.pairs = scene.pairs;
  balls.pairs[1].restitution = 0.9;
  const std::array<int, 4> material{2, 2, 0, 1};
  for (int i = 0; i < 4; ++i) {
    balls.bodies.push_back(sphere_body("ball" + std::to_string(i), 1, 0.1, {i % 2 * 0.5, i / 2 * 3.0, 0}));
    balls.bodies.back().velocity_m_per_s = {i % 2 ? -1.0 : 1.0, 0, 0};
    balls.bodies.back().material = material[static_cast<std::size_t>(i)];
  }
  const Run parted = run_with("stiff", balls, Plan{0.5, 120, 10});
  REQUIRE(parted.outcome.status == Status::ok);
  CHECK(parted.events.size() == 2);
  CHECK(parted.v(1, 0) - parted.v(0, 0) == Approx(2 * 0.5).epsilon(1e-7));
  CHECK(parted.v(3, 0) - parted.v(2, 0) == Approx(2 * 0.9).epsilon(1e-7));
}

TEST_CASE("two shapes that may touch get the contact law of their pair, for every law") {
  const std::vector<PairLaw> laws{PairLaw{0, 1, 0.3, 0.2, 0}, PairLaw{0, 2, 0.7, 0.6, 0}, PairLaw{1, 2, 0, 0.4, 0},
                                  PairLaw{2, 2, 0.81, 0, 0}};
  for (const auto& law : laws) {
    int met = 0;
    for (const auto& a : dartsim::surfaces_of(law.a, laws)) {
      for (const auto& b : dartsim::surfaces_of(law.b, laws)) {
        if (a.partner != law.b || b.partner != law.a) continue;
        ++met;
        CHECK(a.restitution * b.restitution == Approx(law.restitution).epsilon(4e-16));
        CHECK(std::min(a.friction, b.friction) == law.friction);
      }
    }
    CHECK(met == 1);
  }
}

TEST_CASE("shapes that DART would ignore are refused") {
  CHECK_THAT(refusal_of(bounce(0.001, 1)), Catch::Contains("restitution of 0.001"));
  CHECK_THAT(refusal_of(bounce(0.5, 1, 0.0005)), Catch::Contains("friction coefficient of 0.001"));
}

TEST_CASE("every detector stops a sliding box on a box; what it does not collide it refuses") {
  Scene scene = sliding_box(0.4, 1, 0);
  for (const char* detector : {"fcl", "dart"}) {
    const Settings chosen{{"collision_detector", std::string(detector)}};
    CHECK_THAT(refusal_of(scene, chosen), Catch::Contains("a plane (`floor`)"));
  }
  scene.bodies[0].shape = Box{{3, 3, 0.5}};
  scene.bodies[0].position_m = {0.013, 0.017, -0.5};
  for (const char* detector : {"ode", "fcl", "dart"}) {
    const Run end = run_with("default", scene, Plan{1, 480, 24}, {{"collision_detector", std::string(detector)}});
    INFO(detector << ": " << end.outcome.reason);
    REQUIRE(end.outcome.status == Status::ok);
    CHECK(end.p(1, 0) == Approx(4 / (2 * 0.4 * 9.81)).epsilon(0.02));
    CHECK(end.p(1, 2) == Approx(0.05).margin(1e-3));
  }
  Settings slip{{"collision_detector", std::string("fcl")}, {"friction_direction", std::string("slip")}};
  CHECK_THAT(refusal_of(scene, slip), Catch::Contains("slip requires"));
}

TEST_CASE("a body whose spin diverges ends the run and not the process") {
  const Run lost = try_run(engine(), method(engine(), "default"), free_box_complex(), Plan{100, 300, 10});
  CHECK(to_string(lost.outcome.status) == "not finite");
}

TEST_CASE("the program's output is DART's only while a world is at work") {
  const std::streambuf *errors = std::cerr.rdbuf(), *remarks = std::cout.rdbuf();
  CHECK(run_with("default", bounce(0.5, 0.1), Plan{0.1, 10, 1}).outcome.reason.empty());
  CHECK(std::cerr.rdbuf() == errors);
  CHECK(std::cout.rdbuf() == remarks);
}

}  // namespace atwood::test
