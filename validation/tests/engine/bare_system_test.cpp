// Steppers of a bare system of equations: y' = f(t, y) without a model of bodies.
#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <string>
#include <vector>

#include "integrators/catalogue.hpp"
#include "rigid/bare_problems.hpp"

namespace atwood::testing {
namespace {

// x' = v, v' = -x, from (1, 0): x = cos t, v = -sin t.
template <class S> void oscillator_rate(void*, S, const S* y, S* dydt) {
  dydt[0] = y[1];
  dydt[1] = -y[0];
}

template <class S> System<S> oscillator_system() {
  System<S> system;
  system.size = 2;
  system.rate_of = oscillator_rate<S>;
  return system;
}

std::string scheme_of(const MethodInfo& info) { return info.id.substr(info.id.find('/') + 1); }

template <class S> std::vector<S> march(Stepper<S>& stepper, std::vector<S> y, S h_s, int steps) {
  std::vector<S> y_new(y.size());
  for (int n = 0; n < steps; ++n) {
    REQUIRE(stepper.step(S(n) * h_s, h_s, y.data(), y_new.data()));
    y.swap(y_new);
  }
  return y;
}

// Of the oscillator at t = 1.
double end_error(const std::string& scheme, int steps) {
  System<double> system = oscillator_system<double>();
  const auto stepper = make_stepper(scheme, system);
  INFO(scheme << ": " << (stepper ? "" : stepper.fault().reason));
  REQUIRE(stepper);
  const std::vector<double> y = march<double>(**stepper, {1, 0}, 1.0 / steps, steps);
  CHECK(system.evaluations > 0);
  return std::hypot(y[0] - std::cos(1.0), y[1] + std::sin(1.0));
}

std::set<std::string> refused_schemes() {
  std::set<std::string> refused;
  System<double> system = oscillator_system<double>();
  for (const MethodInfo& info : integrator_catalogue())
    if (!make_stepper(scheme_of(info), system)) refused.insert(scheme_of(info));
  return refused;
}

TEST_CASE("methods that need bodies, positions, an energy or a series refuse a bare system by name") {
  const std::set<std::string> expected{"dprkn6",
                                       "dprkn12",
                                       "blanes-moan-rkn4",
                                       "blanes-moan-rkn6",
                                       "symplectic-euler",
                                       "leapfrog",
                                       "velocity-verlet",
                                       "leapfrog-kdk",
                                       "leapfrog-dkd",
                                       "forest-ruth",
                                       "pefrl",
                                       "mclachlan4",
                                       "suzuki4",
                                       "suzuki6",
                                       "suzuki8",
                                       "yoshida4",
                                       "yoshida6",
                                       "yoshida8",
                                       "blanes-moan4",
                                       "blanes-moan6",
                                       "kahan-li8",
                                       "boris",
                                       "boris4",
                                       "boris6",
                                       "rkmk4",
                                       "lie4",
                                       "free-top2",
                                       "free-top4",
                                       "free-top6",
                                       "moser-veselov",
                                       "jacobi2",
                                       "jacobi4",
                                       "discrete-gradient",
                                       "average-vector-field",
                                       "implicit-midpoint-so3",
                                       "projected-rk4",
                                       "rattle",
                                       "rattle4",
                                       "rattle6",
                                       "baumgarte",
                                       "relaxation-rk4",
                                       "taylor"};
  CHECK(refused_schemes() == expected);
  System<double> system = oscillator_system<double>();
  for (const std::string& scheme : expected) {
    const auto stepper = make_stepper(scheme, system);
    REQUIRE(!stepper);
    INFO(stepper.fault().reason);
    CHECK_THAT(stepper.fault().reason, Catch::StartsWith("atwood/" + scheme + " ") &&
                                           Catch::EndsWith("; this problem is a system of equations without bodies"));
  }
}

TEST_CASE("every other method steps a bare oscillator with its order") {
  const std::set<std::string> refused = refused_schemes();
  int stepped = 0, measured = 0;
  for (const MethodInfo& info : integrator_catalogue()) {
    const std::string scheme = scheme_of(info);
    if (refused.count(scheme) > 0) continue;
    ++stepped;
    const double order = info.claimed_order.at("velocity-dependent");
    const double coarse = end_error(scheme, 16), fine = end_error(scheme, 32);
    CAPTURE(scheme, order, coarse, fine);
    CHECK(fine < 2e-2);
    if (fine < 1e-13) continue;  // round-off
    ++measured;
    CHECK(std::log2(coarse / fine) == Approx(order).margin(0.6));
  }
  CHECK(stepped + static_cast<int>(refused.size()) == static_cast<int>(integrator_catalogue().size()));
  CHECK(stepped >= 45);
  CHECK(measured >= 35);
}

// Lorenz's equations once through the model of a scene and once as a bare system: the same arithmetic.
template <class S> void compare_with_model() {
  Scene scene;
  scene.problem = "lorenz";
  scene.bodies.resize(1);
  int compared = 0;
  for (const MethodInfo& info : integrator_catalogue()) {
    const std::string scheme = scheme_of(info);
    System<S> system;
    system.size = 3;
    system.rate_of = bare_problem_rate<S>("lorenz");
    RigidModel<S> model(scene);
    const auto bare = make_stepper(scheme, system), modelled = make_stepper(scheme, model);
    if (!bare) continue;
    INFO(scheme);
    REQUIRE(modelled);
    const std::vector<S> start{S(1), S(0.5), S(2)};
    CHECK(march<S>(**bare, start, S(0.01), 30) == march<S>(**modelled, start, S(0.01), 30));
    CHECK(system.evaluations == model.system().evaluations);
    ++compared;
  }
  CHECK(compared >= 45);
}

TEST_CASE("a bare system and the model of the same equations give the same bits") {
  compare_with_model<double>();
  compare_with_model<float>();
}

TEST_CASE("unknown schemes and settings out of range are the input's fault") {
  System<double> system = oscillator_system<double>();
  for (const auto& [scheme, settings] : std::vector<std::pair<std::string, Settings>>{
           {"rk5", {}}, {"gbs", {{"columns", std::int64_t(1)}}}, {"rk4", {{"columns", std::int64_t(2)}}}}) {
    INFO(scheme);
    const auto stepper = make_stepper(scheme, system, settings);
    REQUIRE(!stepper);
  }
}

}  // namespace
}  // namespace atwood::testing
