// Methods of high precision: executed orders in quad, published values, energy at round-off, switches and retaken
// steps.
#include <catch2/catch.hpp>

#include "step_checks.hpp"
#include "validation/tests/extended/reference_values.hpp"

namespace atwood::testing {
namespace {

double executed_order(const std::string& scheme, const Scene& scene, double t_end_s, std::int64_t steps) {
  const Recorded truth = run(scheme, scene, {t_end_s, 6 * steps, 1}, "quad");
  const Recorded coarse = run(scheme, scene, {t_end_s, steps, 1}, "quad"),
                 fine = run(scheme, scene, {t_end_s, 2 * steps, 1}, "quad");
  return std::log2(end_error(coarse, truth) / end_error(fine, truth));
}

TEST_CASE("the executed order of Radau 15 is 15 in every class of motion") {
  for (const std::string scheme : {"radau15", "ias15"}) {
    INFO(scheme);
    CHECK(executed_order(scheme, kepler(0.3), 3, 24) == Approx(15).margin(0.3));
    CHECK(executed_order(scheme, quadratic_drag(), 2, 12) == Approx(15).margin(0.3));
    CHECK(executed_order(scheme, e_cross_b(), 10, 48) == Approx(15).margin(0.3));
    CHECK(executed_order(scheme, free_box(), 1, 12) == Approx(15).margin(0.3));
    CHECK(executed_order(scheme, thrust_and_drag(), 2, 12) == Approx(15).margin(0.3));
  }
}

TEST_CASE("the executed order of extrapolation is twice its columns") {
  CHECK(executed_order("gbs", kepler(0.3), 3, 30) == Approx(12).margin(0.24));
  CHECK(executed_order("gbs", quadratic_drag(), 2, 16) == Approx(12).margin(0.24));
  CHECK(executed_order("gbs", driven_oscillator(), 3, 10) == Approx(12).margin(0.24));
  CHECK(executed_order("gbs", free_box(), 1, 20) == Approx(12).margin(0.24));
}

// Relative 2-norm of the whole state, against the digits computed in 113 bits.
double pleiades_error(const Recorded& end) {
  double squares = 0, size = 0;
  for (int i = 0; i < 7; ++i)
    for (int c = 0; c < 4; ++c) {
      const double truth = std::stod(reference_values::pleiades.at_end[7 * c + i]);
      const BodySample& body = end.samples.back().bodies[i];
      const double value = static_cast<double>(c < 2 ? body.p_m[c] : body.v_m_per_s[c - 2]);
      squares += (value - truth) * (value - truth);
      size += truth * truth;
    }
  return std::sqrt(squares / size);
}

TEST_CASE("Pleiades to 2e-11 with few evaluations") {
  const Recorded batched = run("radau15", pleiades(), {3, 100, 1}, "", 1e-11);
  CHECK(pleiades_error(batched) < 2e-11);
  CHECK(batched.outcome.rate_evaluations < 5000);
  const Recorded sequential = run("ias15", pleiades(), {3, 40, 1}, "", 2.5e-10);
  CHECK(pleiades_error(sequential) < 2e-11);
  CHECK(sequential.outcome.rate_evaluations <= 2600);
}

// The general sweeps end at a hundredth of the tolerance, which would leave 3e-8 here.
TEST_CASE("the sweeps of gravitating masses leave no error of their own") {
  const Plan plan{62.83185307179586, 480, 1};
  const Recorded truth = run("radau15", kepler(0.6), plan, "quad", 1e-24);
  CHECK(end_error(run("radau15", kepler(0.6), plan, "", 1e-8), truth) < 3e-10);
}

Recorded ten_orbits(double rtol, const std::string& order, std::int64_t samples = 1) {
  MethodId id = method_id("gbs", "", rtol);
  id.overrides["order"] = order;
  return try_run(id, kepler(0.6), {62.83185307179586, 480, samples});
}

TEST_CASE("extrapolation with the order that it chooses reaches an error with fewer evaluations") {
  const Recorded truth = run("radau15", kepler(0.6), {62.83185307179586, 480, 1}, "quad", 1e-24);
  const Recorded chosen = ten_orbits(1e-11, "chosen"), fixed = ten_orbits(1e-12, "fixed");
  CHECK(end_error(chosen, truth) < end_error(fixed, truth));
  CHECK(static_cast<double>(chosen.outcome.rate_evaluations) <
        0.7 * static_cast<double>(fixed.outcome.rate_evaluations));
  const auto evaluations_a_step = [&](double rtol) {
    const Outcome outcome = ten_orbits(rtol, "chosen").outcome;
    return static_cast<double>(outcome.rate_evaluations) / static_cast<double>(outcome.steps_taken);
  };
  CHECK(evaluations_a_step(1e-13) > 2 * evaluations_a_step(1e-4));
}

TEST_CASE("samples change nothing of steps whose order is chosen") {
  const Recorded one = ten_orbits(1e-9, "chosen"), many = ten_orbits(1e-9, "chosen", 48);
  CHECK(one.samples.back().bodies[0].p_m == many.samples.back().bodies[0].p_m);
  CHECK(one.outcome.steps_taken == many.outcome.steps_taken);
}

TEST_CASE("extrapolation refuses a tolerance below round-off") {
  CHECK(ten_orbits(1e-18, "chosen").outcome.status == Status::unsupported);
}

TEST_CASE("energy stays at round-off over a hundred periods") {
  for (const std::string scheme : {"radau15", "ias15"}) {
    const Recorded planet = run(scheme, kepler(0.6), {628.3185307179587, 100, 1}, "", 1e-15);
    const auto energy = [](const BodySample& body) {
      const Wide v2 = body.v_m_per_s[0] * body.v_m_per_s[0] + body.v_m_per_s[1] * body.v_m_per_s[1];
      const double r2 = static_cast<double>(body.p_m[0] * body.p_m[0] + body.p_m[1] * body.p_m[1]);
      return static_cast<double>(v2) / 2 - 1 / std::sqrt(r2);
    };
    CHECK(std::abs(energy(planet.samples.back().bodies[0]) - energy(planet.samples.front().bodies[0])) < 1e-14);
  }
}

TEST_CASE("a thruster that switches inside the run costs no accuracy") {
  Scene scene = thrust_and_drag();
  std::get<Thruster>(scene.forces[0]).on_s = {{0.3, 0.71}, {1.1, 1.7}};
  const Recorded truth = run("radau15", scene, {2, 8, 1}, "quad", 1e-22);
  for (const std::string scheme : {"radau15", "ias15"})
    CHECK(end_error(run(scheme, scene, {2, 8, 1}, "", 1e-13), truth) < 1e-12);
}

TEST_CASE("samples inside steps change nothing of the run, and are as accurate") {
  check_samples_change_nothing("radau15", run("radau15", kepler(0.6), {10, 2000, 50}, "quad"));
}

TEST_CASE("a step taken again with another h is the step of that h") {
  Twins twins("radau15");
  twins.step(0.3);
  twins.check_step(0.1);
}

Outcome by_criterion(const Scene& scene, double t_end_s, const std::string& criterion, double epsilon) {
  MethodId id = method_id("ias15", "", 1e-16);
  id.overrides["criterion"] = criterion;
  id.overrides["epsilon"] = epsilon;
  return try_run(id, scene, {t_end_s, 400, 1}).outcome;
}

// On a unit circle |a| = |j| = |s| = 1, so tau = sqrt(2 / (1 + 1)) = 1 and every step is (5040 epsilon)^(1/7).
TEST_CASE("PRS23 steps on a circle are those of its formula") {
  for (const double epsilon : {1e-9, 1e-7}) {
    const double step_s = std::pow(5040 * epsilon, 1.0 / 7), t_end_s = 200;
    const Outcome outcome = by_criterion(kepler(0), t_end_s, "prs23", epsilon);
    CHECK(outcome.status == Status::ok);
    CHECK(static_cast<double>(outcome.steps_taken) == Approx(t_end_s / step_s).margin(3));
  }
}

TEST_CASE("the published criteria of IAS15 take steps as epsilon^(1/7)") {
  for (const std::string criterion : {"rein-spiegel", "prs23"}) {
    INFO(criterion);
    const auto steps = [&](double epsilon) {
      const Outcome outcome = by_criterion(kepler(0.3), 200, criterion, epsilon);
      CHECK(outcome.status == Status::ok);
      return static_cast<double>(outcome.steps_taken);
    };
    CHECK(steps(1e-9 / 128) / steps(1e-9) == Approx(2).margin(0.05));
  }
}

}  // namespace
}  // namespace atwood::testing
