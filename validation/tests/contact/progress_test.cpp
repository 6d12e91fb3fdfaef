// Long series of impacts, and conventions for impacts of one instant.
#include <catch2/catch.hpp>

#include <array>
#include <cmath>
#include <string>

#include "recorded.hpp"
#include "validation/tests/engine/mechanisms.hpp"

using namespace atwood;
using namespace atwood::recorded;

namespace {

Scene billiard(double ratio, double gap_m) {
  Scene scene = world({0, 0, 0}, 1, 0);
  scene.bodies = {fixed("wall", Plane{{1, 0, 0}, 0}), ball("small", 1, 0.1, {0.1 + gap_m, 0, 0}),
                  ball("large", ratio, 0.1, {0.3 + 2 * gap_m, 0, 0}, {-1, 0, 0})};
  return scene;
}

}  // namespace

// Galperin, Regul. Chaotic Dyn. 8 (2003) 375: 100^k to 1 gives the first k + 1 digits of pi. Every second impact turns
// (sqrt(M) V, sqrt(m) v) by twice atan(sqrt(m / M)), the others turn v round: that fixes the last speeds.
TEST_CASE("Galperin's billiard has as many impacts as pi has, up to 31 415 in one step") {
  const int digits[] = {3, 31, 314, 3141, 31415};
  for (int k = 1; k <= 4; ++k)
    for (const char* method : {"atwood/rk4+event", "atwood/dopri5:1e-10+event"}) {
      const double ratio = std::pow(100., k), turn = 2 * std::atan(1 / std::sqrt(ratio));
      const Recorded it = run(method, billiard(ratio, 1), {40, 1, 1});
      INFO(ratio << " to 1, " << method << " " << it.outcome.reason);
      CHECK(it.count(EventKind::impact) == digits[k]);
      CHECK(it.count(EventKind::impact) == std::ceil(M_PI / (turn / 2)) - 1);
      const double angle = turn * ((it.count(EventKind::impact) + 1) / 2);
      CHECK(it.v(2)[0] == Approx(-std::cos(angle)).epsilon(1e-6));
    }
}

// Most of them within a thousandth of the step.
TEST_CASE("Galperin's billiard has 314 159 impacts in one step") {
  const Recorded it = run("atwood/explicit-euler+event", billiard(1e10, 1), {40, 1, 1});
  INFO(it.outcome.reason);
  CHECK(it.count(EventKind::impact) == 314'159);
  CHECK(it.v(2)[0] == Approx(1).epsilon(1e-9));
}

// ... all of them at one instant, where all touch: one after the other.
TEST_CASE("Galperin's billiard of touching balls has all its impacts at once") {
  const Recorded it = run("atwood/rk4+event", billiard(1e6, 0), {1, 1, 1});
  CHECK(it.count(EventKind::impact) == 3141);
  CHECK(it.v(2)[0] > 0.999);
}

// The same rule by plain sums: the pair that approaches fastest collides, of several the first.
TEST_CASE("a row of touching balls follows the law of each of its impacts, however many there are") {
  constexpr int n = 60;
  constexpr double restitution = 0.5;
  Scene scene = world({0, 0, 0}, restitution, 0);
  for (int i = 0; i < n; ++i)
    scene.bodies.push_back(ball("b" + std::to_string(i), 1, 0.125, {0.25 * i, 0, 0}, {i == 0 ? 1.0 : 0.0, 0, 0}));
  const Recorded it = run("atwood/rk4+event", scene, {1, 1, 1});

  std::array<double, n> v{1};
  int impacts = 0;
  for (double fastest = 1; fastest > 1e-13;) {
    int at = 0;
    fastest = 0;
    for (int i = 0; i + 1 < n; ++i)
      if (v[i] - v[i + 1] > fastest + 1e-14) fastest = v[i] - v[i + 1], at = i;
    const double change = (1 + restitution) / 2 * (v[at] - v[at + 1]);
    v[at] -= change;
    v[at + 1] += change;
    ++impacts;
  }
  double energy = 0, expected = 0;
  for (int i = 0; i < n; ++i) energy += it.v(i)[0] * it.v(i)[0] / 2, expected += v[i] * v[i] / 2;
  CAPTURE(impacts, it.count(EventKind::impact));
  CHECK(impacts > 2000);
  CHECK(energy == Approx(expected).epsilon(1e-9));
}

// +impulse resolves the impacts of a substep one after another: any number that dissipate nothing.
TEST_CASE("+impulse: Galperin's billiard has as many impacts as pi has, in steps of any length") {
  const std::string method = "atwood/symplectic-euler+impulse{substeps=1}";
  const int digits[] = {3, 31, 314, 3141, 31415};
  for (int k = 1; k <= 4; ++k)
    for (const int steps : {1, 7}) {
      const Recorded it = run(method, billiard(std::pow(100., k), 0.001), {0.04, steps, 1});
      INFO(k << ", " << steps << " steps");
      CHECK(it.count(EventKind::impact) == digits[k]);
      CHECK(it.outcome.solvers.at("impact-queue").capped == 0);
    }
}

TEST_CASE("+impulse: impacts that find no end at one instant end the run, those of a collapse are counted") {
  const std::string method = "atwood/symplectic-euler+impulse{substeps=1}";
  const Recorded at_once = try_run(method, billiard(1e8, 0), {1, 1, 1});
  CHECK(at_once.outcome.status == Status::diverged);
  CHECK(at_once.outcome.reason == "10000 impacts or more followed each other without the time advancing at t = 0 s");
  Scene held = billiard(1e8, 0);
  held.bodies[2].release_s = 0.5;
  const Recorded later = try_run(method, held, {1, 4, 1});
  CHECK(later.outcome.status == Status::diverged);
  CHECK(later.outcome.reason.ends_with("at t = 0.5 s"));  // not the end of that step

  Scene collapses = billiard(1e4, 0.001);
  collapses.pairs.front().restitution = 0.5;
  const SolveTally one = run(method, collapses, {0.04, 1, 1}).outcome.solvers.at("impact-queue");
  CHECK(one.capped == 1);
  CHECK(one.iterations_max == 16);  // of two contacts
  CHECK(one.residual_max > 0.1);
}

// Pairs are searched for at the beginning of a step, near each body's path: the small ball rests then, far from the
// wall.
TEST_CASE("+impulse: an impact that sends a body far away within the step is counted") {
  const Recorded it = run("atwood/symplectic-euler+impulse{substeps=1}", billiard(100, 1), {40, 1, 1});
  CHECK(it.count(EventKind::impact) < 31);
  CHECK(it.outcome.solvers.at("impact-queue").capped > 0);
}

TEST_CASE("+impulse: an impact that sends a mechanism far away within the step is counted") {
  const std::string method = "atwood/symplectic-euler+impulse{substeps=1}";
  const auto capped = [&](const Scene& scene) {
    const Recorded it = run(method, scene, {0.02, 1, 1});
    const auto queue = it.outcome.solvers.find("impact-queue");
    return queue == it.outcome.solvers.end() ? 0 : queue->second.capped;
  };
  // A heavy ball hits one on a rail, which passes through the wall at its end.
  const auto rail = [&](double speed) {
    Scene scene = world({0, 0, 0}, 1, 0);
    scene.bodies = {fixed("wall", Plane{{-1, 0, 0}, -3}), ball("bob", 1, 0.1, {0, 0, 0}),
                    ball("heavy", 100, 0.1, {-0.25, 0, 0}, {speed, 0, 0})};
    Joint slider = testing::joint("rail", JointKind::slider, -1, 1, {0, 0, 0}, {0, 0, 0});
    slider.axis_body = {1, 0, 0};
    scene.joints = {slider};
    return testing::placed(scene);
  };
  CHECK(capped(rail(100)) == 1);
  CHECK(capped(rail(1)) == 0);
  // A carriage is thrown back by its stop; the rod across it, hinged at its end, begins to turn: its other end is
  // faster than anything was before. No contact has an impact.
  const auto carriage = [&](double speed) {
    Scene scene = world({0, 0, 0}, 0, 0);
    const Real3 I{0.02, 0.02, 0.01};
    scene.bodies = {fixed("wall", Plane{{-1, 0, 0}, -1.03}), moving("carriage", Shape{}, 100, I, {0, 0, 0}),
                    moving("rod", Capsule{0.05, 0.5}, 1, I, {0, 0, 0})};
    Joint slider = testing::joint("rail", JointKind::slider, -1, 1, {0, 0, 0}, {0, 0, 0});
    slider.axis_body = {1, 0, 0};
    slider.coordinates[0] = -0.01;
    slider.rates[0] = speed;
    slider.limits = JointLimits{-10, 0, 1};
    Joint hinge = testing::joint("pin", JointKind::hinge, 1, 2, {0, 0, 0}, {0, 0, -0.5});
    hinge.axis_body = {0, 1, 0};
    scene.joints = {slider, hinge};
    return testing::placed(scene);
  };
  CHECK(capped(carriage(10)) == 1);
  CHECK(capped(carriage(0.5)) == 0);
}

TEST_CASE("a scene's convention for simultaneous impacts is followed, and a setting may not contradict it") {
  // One ball falls between two that touch each other: one after the other they take what comes, or both at once.
  Scene scene = world({0, 0, 0}, 1, 0);
  const double s = 0.1 * std::sqrt(3.);
  scene.bodies = {ball("left", 1, 0.1, {-0.1, 0, 0}), ball("right", 1, 0.1, {0.1, 0, 0}),
                  ball("falls", 1, 0.1, {0, 0, s}, {0, 0, -1})};
  const Plan plan{0.125, 1, 1};
  const auto speeds = [&](const std::string& method) {
    const Recorded it = run(method, scene, plan);
    return std::array{it.v(0)[2], it.v(1)[2], it.v(2)[2]};
  };
  const auto one_by_one = speeds("atwood/rk4+event"), at_once = speeds("atwood/rk4+event{simultaneous=together}");
  CHECK(at_once[0] == Approx(at_once[1]).epsilon(1e-12));
  CHECK(std::abs(one_by_one[0] - one_by_one[1]) > 0.1);
  scene.simultaneous_impacts = SimultaneousImpacts::together;
  CHECK(speeds("atwood/rk4+event") == at_once);
  CHECK(speeds("atwood/rk4+event{simultaneous=together}") == at_once);
  const Recorded against = try_run("atwood/rk4+event{simultaneous=sequential}", scene, plan);
  CHECK(against.outcome.status == Status::unsupported);
  CHECK(against.outcome.reason.find("simultaneous=sequential contradicts the scene") != std::string::npos);
  scene.simultaneous_impacts = SimultaneousImpacts::sequential;
  CHECK(speeds("atwood/rk4+event") == one_by_one);
  CHECK(try_run("atwood/rk4+event{simultaneous=together}", scene, plan).outcome.status == Status::unsupported);
}

// Ties within round-off go by the scene's order, not by which sum was rounded down: turned anyhow, the same.
TEST_CASE("a tie goes to the first in the scene's order, however the scene is turned") {
  for (int i = 0; i < 60; ++i) {
    const double a = 0.1 * i, b = 0.37 * i, h = 0.1 * std::sqrt(3.);
    const auto at = [&](double x, double z) -> Real3 {  // of the plane that a and b turn
      return {std::cos(a) * x - std::sin(a) * std::sin(b) * z, std::sin(a) * x + std::cos(a) * std::sin(b) * z,
              std::cos(b) * z};
    };
    Scene scene = world({0, 0, 0}, 1, 0);
    scene.bodies = {ball("first", 1, 0.1, at(-0.1, 0)), ball("second", 1, 0.1, at(0.1, 0)),
                    ball("falls", 1, 0.1, at(0, h), at(0, -1))};
    const Recorded it = run("atwood/rk4+event", scene, {0.125, 1, 1});
    INFO(i);
    const auto speed = [&](int body) { return std::hypot(it.v(body)[0], it.v(body)[1], it.v(body)[2]); };
    CHECK(speed(0) > speed(1) + 0.1);
  }
}
