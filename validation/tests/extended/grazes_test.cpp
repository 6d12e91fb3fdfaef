// Grazing contacts and the end of bouncing: undecided outcomes are within the bars, or refused by name.
#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cmath>

#include "billiard.hpp"
#include "closed_form/closed_form.hpp"
#include "cvode/cvode.hpp"
#include "extended/extended.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

double size(Wide x) { return static_cast<double>(fabsq(x)); }

// A ball flies past a fixed one with the least gap `gap_m`; the sum of the radii is 1/2.
Scenario passing(double gap_m, double unit = 1) {
  Scene scene = scenes::empty_scene();
  scene.pairs[0].restitution = 1;
  scene.bodies = {scenes::point("post", 0, {0, 0, 0}, {0, 0, 0}),
                  scenes::point("ball", 1, {-1.0625 * unit, (0.5 + gap_m) * unit, 0}, {unit, 0, 0})};
  scene.bodies[0].fixed = true;
  for (Body& body : scene.bodies) body.shape = Sphere{0.25 * unit};
  return scenes::scenario(scene, 2);
}

// A ball thrown at a ceiling: the top of its parabola is `gap_m` below it.
Scenario thrown(double gap_m) {
  Scene scene = scenes::empty_scene();
  scene.pairs[0].restitution = 1;
  scene.gravity_m_per_s2 = {0, 0, -8};
  scene.bodies = {scenes::point("ceiling", 0, {0, 0, 0}, {0, 0, 0}),
                  scenes::point("ball", 1, {0, 0, -1.25 - gap_m}, {0.5, 0, 4})};  // rises by 1 in 0.5 s
  scene.bodies[0].fixed = true;
  scene.bodies[0].shape = Plane{{0, 0, -1}, 0};
  scene.bodies[1].shape = Sphere{0.25};
  return scenes::scenario(scene, 1.3);
}

bool names_it(const Truth& truth) {
  const std::string& why = truth.outcome.reason;
  return why.find("graze each other at t = ") != std::string::npos ||
         why.find("pass each other at t = ") != std::string::npos ||
         why.find("the runs disagree on the impact of `ceiling` and `ball` at t = ") != std::string::npos;
}

// Within its bars, or refused for the graze, and right up to there.
void judge(const char* kind, const Scenario& given, bool by_flight60) {
  const Truth truth = std::string(kind) == "cvode" ? cvode_truth(given, 16) : extended_truth(given, 16);
  INFO(kind << ": " << truth.outcome.reason);
  if (truth.outcome.status != Status::ok) CHECK(names_it(truth));
  CHECK(truth.values.size() >= 7);
  if (by_flight60) {
    int impacts = 0;
    const auto exact = scenes::fly60(given, 16, impacts);
    CHECK(scenes::worst_ratio(truth, exact) < 1);
    if (truth.outcome.status == Status::ok) CHECK(truth.events.size() == static_cast<std::size_t>(impacts));
    return;
  }
  using scenes::Digits60;
  const Digits60 start = Digits60(given.scene.bodies[1].position_m[2]), top = Digits60(-0.25);
  const Digits60 inside = 16 - 16 * (top - start);  // of 4 t - 4 t^2 = top - start
  for (std::size_t k = 1; k < truth.values.size(); ++k) {
    const Digits60 t = Digits60(given.t_end_s) * k / 16;
    Digits60 z = start + 4 * t - 4 * t * t;
    if (inside > 0) {
      const Digits60 hit = (4 - sqrt(inside)) / 8, speed = 4 - 8 * hit, since = t - hit;
      if (since > 0) z = top - speed * since - 4 * since * since;
    }
    const double error = static_cast<double>(abs(scenes::digits60(truth.values[k].bodies[1].p_m[2]) - z));
    CHECK(error <= size(truth.bars[k].bodies[1].p_m[2]));
  }
}

}  // namespace

TEST_CASE("a ball passes a ball or grazes it, from 1e-5 to 1e-16 of its size: bounded, or refused by name") {
  for (const char* kind : {"extended", "cvode"})
    for (const double unit : {1.0, 1e-18})
      for (int digit = 5; digit <= 16; ++digit)
        for (const double sign : {1.0, -1.0}) {
          INFO("gap " << sign << "e-" << digit << ", unit " << unit);
          judge(kind, passing(sign * std::pow(10.0, -digit), unit), true);
        }
}

TEST_CASE("a ball thrown at a ceiling that it just reaches or does not: bounded, or refused by name") {
  for (const char* kind : {"extended", "cvode"})
    for (int digit = 5; digit <= 16; ++digit)
      for (const double sign : {1.0, -1.0}) {
        INFO("gap " << sign << "e-" << digit);
        judge(kind, thrown(sign * std::pow(10.0, -digit)), false);
      }
}

// On a spring that pulls alike in every direction: the ball stands still where it is closest.
TEST_CASE("a ball that turns back at a ceiling, at rest there: bounded, or refused by name") {
  using scenes::Digits60;
  for (const std::int64_t samples : {2, 16})
    for (int digit = 9; digit <= 15; ++digit)
      for (const auto& [kind, sign] :
           {std::pair{"extended", 1.0}, {"extended", -1.0}, {"cvode", 1.0}, {"cvode", -1.0}}) {
        Scene scene = scenes::empty_scene();
        scene.pairs[0].restitution = 0.5;
        const double offset_m = 1.25 - sign * std::pow(10.0, -digit);
        scene.bodies = {scenes::point("ceiling", 0, {0, 0, 0}, {0, 0, 0}),
                        scenes::point("ball", 1, {0, 0, 0}, {1, 0, 3})};
        scene.bodies[0].fixed = true;
        scene.bodies[0].shape = Plane{{0, 0, -1}, -offset_m};
        scene.bodies[1].shape = Sphere{0.25};
        scene.bodies[1].inertia_kg_m2 = {0.025, 0, 0, 0, 0.025, 0, 0, 0, 0.025};
        scene.forces = {Spring{{1}, {0, 0, 0}, 9, 0, 0, {}}};
        const Scenario given = scenes::scenario(scene, 1);
        const Truth truth = std::string(kind) == "cvode" ? cvode_truth(given, samples) : extended_truth(given, samples);
        INFO(kind << " at " << sign << "e-" << digit << ": " << truth.outcome.reason);
        if (truth.outcome.status != Status::ok) CHECK(names_it(truth));
        CHECK(static_cast<std::int64_t>(truth.values.size()) > samples / 2);
        const Digits60 top = Digits60(offset_m) - Digits60(0.25);  // z = sin 3 t up to there
        for (std::size_t k = 1; k < truth.values.size(); ++k) {
          const Digits60 t = Digits60(k) / samples;
          Digits60 z = sin(3 * t);
          if (top < 1) {
            const Digits60 hit = asin(top) / 3, since = t - hit, speed = cos(3 * hit) * 3 / 2;
            if (since > 0) z = top * cos(3 * since) - speed / 3 * sin(3 * since);
          }
          const double error = static_cast<double>(abs(scenes::digits60(truth.values[k].bodies[1].p_m[2]) - z));
          CHECK(error <= size(truth.bars[k].bodies[1].p_m[2]));
        }
      }
}

TEST_CASE("a graze to the last digit ends every truth") {
  for (const char* kind : {"extended", "cvode"})
    for (const Scenario& given : {passing(0), thrown(0)}) {
      const Truth truth = std::string(kind) == "cvode" ? cvode_truth(given, 16) : extended_truth(given, 16);
      CHECK(truth.outcome.status == Status::unsupported);
      CHECK(names_it(truth));
    }
}

TEST_CASE("coarse grazes are followed: quad resolves 1e-9") {
  CHECK(extended_truth(passing(-1e-9), 16).events.size() == 1);
  CHECK(extended_truth(passing(1e-9), 16).events.empty());
  CHECK(extended_truth(thrown(-1e-9), 16).outcome.status == Status::ok);
}

// m v' = -m g - c v (air at rest), Newton's restitution: v and z between impacts in closed form, each impact by
// Newton's iteration, sixty digits; the bounces to come are summed until they add nothing.
TEST_CASE("the time of rest lies within its bar, in air that changes every flight") {
  using scenes::Digits60;
  for (const double e : {0.5, 0.9, 0.98}) {
    Scenario given = scenes::bounce(e, 0.001, false, 2);
    given.scene.forces = {LinearDrag{{1}, 0.4, {0, 0, 0}, 0}};
    const Truth truth = extended_truth(given, 16);
    INFO("restitution " << e << ": " << truth.outcome.reason);
    REQUIRE(truth.outcome.status == Status::ok);
    REQUIRE(truth.events.back().kind == EventKind::rest);
    const Digits60 k = Digits60(0.4) / Digits60(0.5), g = Digits60(9.81), limit = g / k;
    const auto fall = [&](const Digits60& v0, const Digits60& t) -> Digits60 {  // height above its start
      return (v0 + limit) * -expm1(-k * t) / k - limit * t;
    };
    Digits60 t = 0, v = 0, at = sqrt(2 * (Digits60(0.126) - Digits60(0.125)) / g);
    const Digits60 height = Digits60(given.scene.bodies[1].position_m[2]) - Digits60(0.125);
    for (int impact = 0; impact < 20000; ++impact) {
      const Digits60 drop = impact == 0 ? height : Digits60(0);
      if (impact > 0) at = 2 * v / g;
      for (int tries = 0; tries < 60; ++tries) {
        const Digits60 speed = (v + limit) * exp(-k * at) - limit, off = drop + fall(v, at);
        const Digits60 step = off / speed;
        at -= step;
        if (abs(step) < Digits60("1e-56") * at) break;
      }
      t += at;
      v = -Digits60(e) * ((v + limit) * exp(-k * at) - limit);
      if (v < Digits60("1e-38")) break;
    }
    const Digits60 rest = t + 2 * v / (g * (1 - Digits60(e)));
    const double error = static_cast<double>(abs(scenes::digits60(truth.events.back().t_s) - rest));
    INFO("error " << error << ", bar " << truth.event_bar_s.back());
    CHECK(error <= truth.event_bar_s.back());
    CHECK(truth.event_bar_s.back() < (e > 0.95 ? 1e-13 : 1e-16));
  }
}

TEST_CASE("head-on with a sideways velocity: the bars hold the location of the impact") {
  for (const double sideways : {0.0, 0.25, -1.1}) {
    Scenario given = passing(0);
    given.scene.bodies[1].position_m = {-1.7, 0, 0};
    given.scene.bodies[1].velocity_m_per_s = {1.3, 0, sideways * 0.01};
    const Truth truth = extended_truth(given, 16);
    int impacts = 0;
    const auto exact = scenes::fly60(given, 16, impacts);
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(impacts == 1);
    CHECK(scenes::worst_ratio(truth, exact) < 1);
    CHECK(size(truth.bars.back().bodies[1].p_m[0]) < 1e-28);
  }
}

TEST_CASE("a velocity at the instant of an impact has the jump as its bar") {
  Scenario given = passing(0);
  given.scene.bodies[1].position_m = {-1.5, 0, 0};  // touches at t = 1: sample 8 of 16
  const Truth truth = extended_truth(given, 16);
  REQUIRE(truth.outcome.status == Status::ok);
  CHECK(size(truth.bars[8].bodies[1].v_m_per_s[0]) >= 2);
  CHECK(size(truth.bars[8].bodies[1].p_m[0]) < 1e-28);
  CHECK(size(truth.bars[7].bodies[1].v_m_per_s[0]) < 1e-28);
  CHECK(size(truth.bars[9].bodies[1].v_m_per_s[0]) < 1e-28);
}

TEST_CASE("bounces too low to be located: beside the instant of rest the bars hold the closed form") {
  struct Case {
    double radius_m, gap_m, restitution;
  };
  int answered = 0;
  for (const Case& c : {Case{1.125, 1e-10, 0.5}, {100, 1e-7, 0.3}, {0.125, 1e-12, 0.6}, {1.125, 1e-9, 0.8}})
    for (const double beside : {-1e-9, -1e-11, -1e-12, 1e-11, 1e-9}) {
      Scenario given = scenes::bounce(c.restitution, 0, false, 1);
      Body& ball = given.scene.bodies[1];
      ball.shape = Sphere{c.radius_m};
      ball.position_m[2] = c.radius_m + c.gap_m;
      const double fall_s = std::sqrt(2 * (ball.position_m[2] - c.radius_m) / 9.81);
      given.t_end_s = fall_s * (1 + c.restitution) / (1 - c.restitution) * (1 + beside);
      const Truth tested = extended_truth(given, 16);
      given.truth = {TruthKind::closed_form, "bounce", ""};
      const Truth exact = closed_form_truth(given, 16);
      INFO("radius " << c.radius_m << ", gap " << c.gap_m << ", " << beside << ": " << tested.outcome.reason);
      if (tested.outcome.status != Status::ok || exact.outcome.status != Status::ok) continue;
      ++answered;
      for (std::size_t k = 0; k <= 16; ++k) {
        const BodySample &a = tested.values[k].bodies[1], &b = exact.values[k].bodies[1];
        const BodySample &of_a = tested.bars[k].bodies[1], &of_b = exact.bars[k].bodies[1];
        CHECK(size(a.p_m[2] - b.p_m[2]) <= size(of_a.p_m[2]) + size(of_b.p_m[2]));
        CHECK(size(a.v_m_per_s[2] - b.v_m_per_s[2]) <= size(of_a.v_m_per_s[2]) + size(of_b.v_m_per_s[2]));
      }
    }
  CHECK(answered >= 10);
}
