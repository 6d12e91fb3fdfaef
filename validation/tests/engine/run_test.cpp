// Runs: catalogue, samples, tolerances, switches, what is refused and how a run ends badly.
#include <catch2/catch.hpp>

#include "scenes.hpp"

namespace atwood::testing {
namespace {

const char* const schemes[] = {"explicit-euler",  "symplectic-euler", "implicit-euler", "midpoint", "heun", "rk4",
                               "velocity-verlet", "leapfrog",         "rkf45",          "dopri5"};

double worst_error(const Recorded& run, const Recorded& truth) {
  double worst = 0;
  for (std::size_t k = 0; k < truth.samples.size(); ++k)
    worst = std::max(worst, distance(run.samples.at(k).bodies[0].p_m, truth.samples[k].bodies[0].p_m));
  return worst;
}

TEST_CASE("every method has a doc, a source and a claim per class of motion") {
  const Engine engine = atwood_engine();
  CHECK(engine.methods.size() >= std::size(schemes));
  for (const char* scheme : schemes) {
    const MethodInfo* info = find_integrator(scheme);
    REQUIRE(info != nullptr);
    CHECK(info->doc.size() > 60);
    CHECK(info->source.size() > 20);
    for (const char* motion : {"point-mass", "velocity-dependent", "rotation"})
      CHECK(info->claimed_order.count(motion) == 1);
    CHECK(info->adaptive == (std::string(scheme) == "rkf45" || std::string(scheme) == "dopri5"));
    CHECK(info->settings.count("scalar") == 1);
  }
}

TEST_CASE("every setting of every method and response is declared: meaning, and a range that holds its default") {
  const Engine engine = atwood_engine();
  int settings = 0;
  for (const auto* list : {&engine.methods, &engine.responses}) {
    for (const MethodInfo& info : *list) {
      CHECK(info.rules.size() == info.settings.size());
      for (const auto& [name, standard] : info.settings) {
        INFO(info.id << " " << name);
        REQUIRE(info.rules.contains(name));
        CHECK(info.rules.at(name).doc.size() > 10);
        CHECK(checked_value(info.id, name, standard, &info.rules.at(name), standard));
        ++settings;
      }
    }
  }
  CHECK(settings > 200);
}

TEST_CASE("samples are at t_end k / samples, the first is the scene, evaluations are counted") {
  const std::map<std::string, int> stages{
      {"explicit-euler", 1}, {"symplectic-euler", 1}, {"midpoint", 2}, {"heun", 2}, {"rk4", 4}, {"leapfrog", 1},
      {"rkf45", 6}};
  for (const auto& [scheme, evaluations] : stages) {
    const Recorded r = run(scheme, kepler(0.3), {3, 60, 12});
    REQUIRE(r.samples.size() == 13);
    for (int k = 0; k <= 12; ++k) CHECK(static_cast<double>(r.samples[k].t_s) == 3.0 * k / 12);
    CHECK(static_cast<double>(r.samples[0].bodies[0].p_m[0]) == 1 - 0.3);
    CHECK(r.outcome.steps_taken == 60);
    CHECK(r.outcome.rate_evaluations == 60 * evaluations);
  }
  CHECK(run("dopri5", kepler(0.3), {3, 60, 12}).outcome.rate_evaluations == 60 * 6 + 1);  // the last stage is shared
  CHECK(run("velocity-verlet", kepler(0.3), {3, 60, 12}).outcome.rate_evaluations == 60 + 1);  // the last kick's too
}

TEST_CASE("the timed pass observes nothing and times every repeat") {
  MethodId id;
  id.scheme = "rk4";
  int seen = 0;
  Observer observer;
  observer.sample = [&](const Sample&) { ++seen; };
  const Outcome outcome = atwood_engine().run(id, kepler(0.3), {3, 600, 12}, observer, 4);
  CHECK(seen == 0);
  REQUIRE(outcome.busy_ns.size() == 4);
  for (const std::int64_t ns : outcome.busy_ns) CHECK(ns > 0);
  CHECK(outcome.rate_evaluations == 2400);
}

TEST_CASE("each scalar reaches its own precision, and only that") {
  const Recorded truth = run("dopri5", kepler(0.3), {3, 24000, 1}, "quad");
  const auto error = [&](const std::string& scalar) {
    return worst_error(run("dopri5", kepler(0.3), {3, 12000, 1}, scalar), truth);
  };
  const double f = error("float"), d = error("double"), ld = error("long-double"), q = error("quad");
  CHECK((f > 1e-8 && f < 1e-3));
  CHECK((d > 1e-17 && d < 1e-12));
  CHECK(ld < d / 8);
  CHECK(q < ld / 8);
  CHECK(worst_error(run("dopri5", kepler(0.3), {3, 3000, 1}), run("dopri5", kepler(0.3), {3, 3000, 1}, "double")) == 0);
}

TEST_CASE("adaptive error is proportional to the tolerance, at dense samples too") {
  const Recorded truth = run("dopri5", kepler(0.6), {10, 20000, 40}, "quad");
  for (const char* scheme : {"rkf45", "dopri5", "verner6", "verner8"}) {
    double before = 0;
    for (const double rtol : {1e-5, 1e-7, 1e-9, 1e-11}) {
      const Recorded r = run(scheme, kepler(0.6), {10, 100, 40}, "", rtol);
      REQUIRE(r.samples.size() == 41);
      const double error = worst_error(r, truth);
      INFO(scheme << " rtol " << rtol << " error " << error);
      CHECK(error < 2000 * rtol);
      if (before > 0) CHECK(std::log10(before / error) / 2 == Approx(1).margin(0.35));
      before = error;
      CHECK(r.outcome.steps_taken * 5 < r.outcome.rate_evaluations);
    }
  }
}

TEST_CASE("adaptive samples do not move the steps") {
  for (const char* scheme : {"dopri5", "dop853", "verner6", "verner8", "verner9"}) {
    INFO(scheme);
    const Recorded few = run(scheme, kepler(0.6), {10, 100, 1}, "", 1e-8);
    const Recorded many = run(scheme, kepler(0.6), {10, 100, 1000}, "", 1e-8);
    CHECK(few.outcome.steps_taken == many.outcome.steps_taken);
    CHECK(distance(few.samples.back().bodies[0].p_m, many.samples.back().bodies[0].p_m) == 0);
    // The stages of dense output are evaluated once a step, however many samples lie in it: at most six.
    CHECK(many.outcome.rate_evaluations - few.outcome.rate_evaluations <= 6 * few.outcome.steps_taken);
  }
}

// Constant thrust along body x through the centre, on in [0.5, 1) and [1.5, 1.75): v = F/m times the time it was on. A
// stage that looked at its own instant would miss by a part of a step.
TEST_CASE("a step uses the force of its own interval") {
  Scene scene = empty_scene();
  scene.bodies.push_back(box({1, 1, 1}, {0, 0, 0}));
  scene.bodies[0].mass_kg = 2;
  scene.bodies[0].velocity_m_per_s = {0, 0, 0};
  scene.forces.push_back(Thruster{0, {0, 0, 0}, {1, 0, 0}, 3, {{0.5, 1}, {1.5, 1.75}}});
  for (const char* scheme : schemes) {
    INFO(scheme);
    CHECK(static_cast<double>(run(scheme, scene, {2, 16, 1}).samples.at(1).bodies[0].v_m_per_s[0]) ==
          Approx(1.125).epsilon(1e-14));
  }
  // p = 1/2 a t^2 on the pieces: exact for order 2.
  const double p = 1.5 * (0.125 + 0.5 * 1) + 1.5 * (0.25 * 0.25 / 2 + 0.25 * 0.25);
  for (const char* scheme : {"midpoint", "heun", "rk4", "velocity-verlet", "leapfrog", "rkf45", "dopri5"})
    CHECK(static_cast<double>(run(scheme, scene, {2, 16, 1}).samples.at(1).bodies[0].p_m[0]) ==
          Approx(p).epsilon(1e-14));
  for (const char* scheme : {"rkf45", "dopri5"})
    CHECK(static_cast<double>(run(scheme, scene, {2, 3, 1}, "", 1e-6).samples.at(1).bodies[0].p_m[0]) ==
          Approx(p).epsilon(1e-13));
}

TEST_CASE("a held body stays in place until its release; a fixed one never moves") {
  Scene scene = ballistic();
  scene.bodies[0].release_s = 1;
  scene.bodies.push_back(point("post", 0, {5, 5, 5}, {0, 0, 0}));
  scene.bodies[1].fixed = true;
  for (const double rtol : {0.0, 1e-9})
    for (const char* scheme : {"rk4", "dopri5", "velocity-verlet"}) {
      if (rtol > 0 && std::string(scheme) != "dopri5") continue;
      const Recorded r = run(scheme, scene, {2, 64, 4}, "", rtol);
      CHECK(distance(r.samples.at(1).bodies[0].p_m, {0, 0, 0}) == 0);
      CHECK(distance(r.samples.at(2).bodies[0].v_m_per_s, {7.5, 0, 7.5}) == 0);
      CHECK(distance(r.samples.at(4).bodies[0].p_m, {7.5, 0, 7.5 - 4.9}) < 1e-12);
      CHECK(distance(r.samples.at(4).bodies[1].p_m, {5, 5, 5}) == 0);
    }
}

TEST_CASE("a run that diverges reports it with the time") {
  Scene stiff = oscillator();
  std::get<Spring>(stiff.forces[0]).stiffness_N_per_m = 1e6;
  const Recorded grown = try_run("explicit-euler", stiff, {10, 100, 100});
  CHECK(grown.outcome.status == Status::diverged);
  CHECK(grown.outcome.reason.find("t = ") != std::string::npos);
  CHECK(grown.samples.size() < 100);

  Scene collapsed = kepler(0);
  collapsed.bodies[0].position_m = {0, 0, 0};
  const Recorded nan = try_run("rk4", collapsed, {1, 10, 10});
  CHECK(nan.outcome.status == Status::not_finite);
  CHECK(nan.outcome.reason.find("t = 0.1 s") != std::string::npos);
  CHECK(nan.samples.size() == 1);
  CHECK(try_run("dopri5", collapsed, {1, 10, 10}, "", 1e-6).outcome.status == Status::not_finite);
}

void check_refused(const Recorded& r, const std::string& words) {
  INFO(r.outcome.reason);
  CHECK(r.outcome.status == Status::unsupported);
  CHECK(r.outcome.reason.find(words) != std::string::npos);
  CHECK(r.samples.empty());
}

TEST_CASE("scenes that the engine does not support are refused by name") {
  Scene lorenz = empty_scene();
  lorenz.problem = "lorenz";
  lorenz.bodies.push_back(point("lorenz", 1, {1, 0, 0}, {0, 0, 0}));
  for (const char* scheme : {"symplectic-euler", "velocity-verlet", "leapfrog"})
    check_refused(try_run(scheme, lorenz, {1, 10, 1}), "system of equations without bodies");
  lorenz.problem = "rossler";
  check_refused(try_run("rk4", lorenz, {1, 10, 1}), "rossler");

  Scene touching = ballistic();
  touching.bodies[0].shape = Sphere{0.5};
  run("rk4", touching, {1, 10, 1});  // a single body touches nothing
  touching.bodies.push_back(point("ground", 0, {0, 0, -2}, {0, 0, 0}));
  touching.bodies[1].fixed = true;
  touching.bodies[1].shape = Plane{{0, 0, 1}, -2};
  check_refused(try_run("rk4", touching, {1, 10, 1}),
                "atwood/rk4 has no contact response; use +impulse, +event or +penalty");

  check_refused(try_run("rk4", ballistic(), {1, 10, 1}, "", 1e-6), "found a tolerance");
  check_refused(try_run("rk5", ballistic(), {1, 10, 1}), "rk5");
  check_refused(try_run("rk4", ballistic(), {1, 10, 1}, "half"), "half");
  check_refused(try_run("rk4", ballistic(), {1, 10, 3}), "divide");

  Scene potential = ballistic();
  potential.forces.push_back(Potential{{0}, "morse", {}});
  check_refused(try_run("rk4", potential, {1, 10, 1}), "morse");
  Scene turning = free_box();
  turning.forces.push_back(RotatingFrame{{0, 0, 1}});
  check_refused(try_run("rk4", turning, {1, 10, 1}), "point masses");

  MethodId id;
  id.scheme = "rk4";
  id.overrides["erp"] = 0.1;
  CHECK(atwood_engine().run(id, ballistic(), {1, 10, 1}, {}, 0).reason.find("erp") != std::string::npos);
}

// Cubic Hermite: exact on the parabola of free flight; 4th-order small on Kepler.
TEST_CASE("dense output of the last step agrees with a shorter step") {
  for (const char* scheme : schemes) {
    INFO(scheme);
    RigidModel<double> model(kepler(0.6));
    const auto stepper = stepper_of(scheme, model);
    std::vector<double> y(6), y_new(6), dense(6), shorter(6);
    model.initial_state(y.data());
    double gap[2];
    for (int k = 0; k < 2; ++k) {
      const double h = 0.04 / (1 << k);
      REQUIRE(stepper->step(0, h, y.data(), y_new.data()));
      stepper->dense(0, dense.data());
      CHECK(dense == y);
      stepper->dense(1, dense.data());
      for (int i = 0; i < 6; ++i) CHECK(dense[i] == Approx(y_new[i]).epsilon(1e-15).margin(1e-16));
      stepper->dense(0.5, dense.data());
      REQUIRE(stepper->step(0, h / 2, y.data(), shorter.data()));
      gap[k] = 0;
      for (int i = 0; i < 6; ++i) gap[k] = std::max(gap[k], std::fabs(dense[i] - shorter[i]));
    }
    const double claimed = find_integrator(scheme)->claimed_order.at("point-mass");
    CHECK(std::log2(gap[0] / gap[1]) > std::min(claimed + 1, 4.0) - 0.3);
    CHECK(gap[0] > 0);
  }
}

}  // namespace
}  // namespace atwood::testing
