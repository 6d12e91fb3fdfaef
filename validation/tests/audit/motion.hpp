// Motions of the adapters' tests, and the order that an engine's method shows on one.
#pragma once

#include <catch2/catch.hpp>

#include <cmath>
#include <string>

#include "../closed_form/scenes.hpp"
#include "protocol/method.hpp"

namespace atwood::testing {

inline Scenario orbit() {
  Scenario given = scenario("kepler", 2);
  given.scene.bodies = {point("planet", 1, {0.4, 0, 0}, {0, 2, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
  return given;
}

// Not autonomous, and the force depends on the velocity.
inline Scenario driven() {
  Scenario given = scenario("oscillator", 2);
  given.scene.bodies = {point("mass", 2, {1, 0, 0}, {0, 0, 0})};
  given.scene.forces = {Spring{{0}, {0, 0, 0}, 8, 0.8, 0, {}}, Drive{{0}, {3, 0, 0}, 1.3, 0.3}};
  return given;
}

struct Run {
  Outcome outcome;
  Sample end;
};

// Runs the scene and returns its end, whatever the outcome's status: for tests of a refusal.
inline Run try_run(const Engine& engine, const std::string& method, const Scenario& given, std::int64_t steps) {
  Run made;
  made.outcome = engine.run(parse_method_id(method), given.scene, {given.t_end_s, steps, 1},
                            {[&](const Sample& s) { made.end = s; }, {}}, 0);
  return made;
}

// Runs the scene; the test fails here unless the run ended ok.
inline Run run(const Engine& engine, const std::string& method, const Scenario& given, std::int64_t steps) {
  Run made = try_run(engine, method, given, steps);
  INFO(method << " " << steps << ": " << to_string(made.outcome.status) << ", " << made.outcome.reason);
  REQUIRE(made.outcome.status == Status::ok);
  return made;
}

inline double end_error(const Engine& engine, const std::string& method, const Scenario& given, std::int64_t steps) {
  const Run made = run(engine, method, given, steps);
  INFO(method << " " << steps << ": " << made.outcome.reason);
  REQUIRE(made.outcome.status == Status::ok);
  static thread_local std::string known;
  static thread_local Sample exact;
  if (known != given.id) exact = copy_of(closed_form_truth(given, 1).values.back());
  known = given.id;
  Wide sum = 0;
  for (int i = 0; i < 3; ++i) {
    const Wide d = made.end.bodies.at(0).p_m[i] - exact.bodies.at(0).p_m[i];
    sum += d * d;
  }
  return static_cast<double>(sqrtq(sum));
}

inline double order(const Engine& engine, const std::string& method, const Scenario& given, std::int64_t steps) {
  return std::log2(end_error(engine, method, given, steps) / end_error(engine, method, given, 2 * steps));
}

// One step of explicit Euler and one of Heun by the reference's own right-hand side.
inline std::vector<double> heun(const Scenario& given, double h) {
  const dynamics::Dynamics<double> equations(given.scene, given.t_end_s);
  std::vector<double> y = dynamics::pack<double>(given.scene), f0(y.size()), f1(y.size()), predicted(y);
  equations.rate(0, y.data(), f0.data(), 0);
  for (std::size_t i = 0; i < y.size(); ++i) predicted[i] += h * f0[i];
  equations.rate(h, predicted.data(), f1.data(), 0);
  for (std::size_t i = 0; i < y.size(); ++i) y[i] += h / 2 * (f0[i] + f1[i]);
  return y;
}

}  // namespace atwood::testing
