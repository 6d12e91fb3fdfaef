#include <catch2/catch.hpp>

#include "../closed_form/scenes.hpp"
#include "cvode/cvode.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

Scenario orbit() {
  Scenario given = scenario("kepler", 10);
  given.scene.bodies = {point("planet", 1, {0.4, 0, 0}, {0, 2, 0})};
  given.scene.forces = {Attractor{{0}, {0, 0, 0}, 1}};
  return given;
}

double end_error(const std::string& method) {
  const Scenario given = orbit();
  Sample end;
  const Outcome outcome = cvode_engine().run(parse_method_id(method), given.scene, {10, 100, 10},
                                             {[&](const Sample& s) { end = s; }, {}}, 0);
  REQUIRE(outcome.status == Status::ok);
  CHECK(outcome.steps_taken > 10);
  CHECK(outcome.rate_evaluations > outcome.steps_taken);
  return static_cast<double>(fabsq(end.bodies[0].p_m[0] - closed_form_truth(given, 1).values.back().bodies[0].p_m[0]));
}

}  // namespace

TEST_CASE("A tighter tolerance is nearer the truth, for both families") {
  for (const std::string family : {"cvode/adams", "cvode/bdf"}) {
    const double loose = end_error(family + ":1e-6"), tight = end_error(family + ":1e-11");
    CAPTURE(family, loose, tight);
    CHECK(tight < loose / 100);
    CHECK(loose < 1);
    CHECK(tight < 1e-6);
  }
  CHECK(end_error("cvode/adams") == end_error("cvode/adams:1e-10"));  // the default tolerance is what it says
}

TEST_CASE("The timed pass gives one duration per repeat and observes no samples") {
  const Scenario given = orbit();
  int seen = 0;
  const Outcome outcome = cvode_engine().run(parse_method_id("cvode/adams:1e-8"), given.scene, {10, 100, 10},
                                             {[&](const Sample&) { ++seen; }, {}}, 3);
  CHECK(outcome.busy_ns.size() == 3);
  for (const std::int64_t ns : outcome.busy_ns) CHECK(ns > 0);
  CHECK(seen == 0);
}

TEST_CASE("Requests that CVODE does not cover are refused with a reason") {
  const Scenario given = orbit();
  const auto run = [&](const std::string& method) {
    return cvode_engine().run(parse_method_id(method), given.scene, {10, 100, 10}, {[](const Sample&) {}, {}}, 0);
  };
  CHECK(run("cvode/rk4").status == Status::unsupported);
  CHECK(run("cvode/adams@float").status == Status::unsupported);
  CHECK(run("cvode/adams+penalty").status == Status::unsupported);
  CHECK(run("cvode/adams{colour=3}").reason.find("colour") != std::string::npos);
  const Outcome stopped = run("cvode/adams:1e-10{max_steps=50}");
  CHECK(stopped.status == Status::diverged);
  CHECK(stopped.reason.find("50 steps") != std::string::npos);
  Scenario fall = orbit();  // straight into the centre
  fall.scene.bodies[0].velocity_m_per_s = {0, 0, 0};
  const Outcome lost = cvode_engine().run(parse_method_id("cvode/adams:1e-10"), fall.scene, {10, 100, 10},
                                          {[](const Sample&) {}, {}}, 0);
  CHECK(lost.status != Status::ok);
  CHECK(!lost.reason.empty());
  CHECK(cvode_truth(fall, 10).outcome.status != Status::ok);
}

TEST_CASE("Every setting is printed") {
  const Engine engine = cvode_engine();
  REQUIRE(engine.methods.size() == 2);
  CHECK(engine.version.substr(0, 1) >= "6");
  for (const MethodInfo& method : engine.methods)
    for (const char* key : {"rtol", "atol", "max_order", "max_steps", "nonlinear_solver", "linear_solver"})
      CHECK(method.settings.count(key) == 1);
}

TEST_CASE("A body on a fixed joint stays where it is: there are no unknowns") {
  Scenario given = scenario("fixed", 1);
  given.scene.bodies = {solid("b", 1, {0.1, 0.1, 0.1}, {0, 0, 0})};
  given.scene.joints = {joint("j", JointKind::fixed, -1, 0, {0, 0, 0}, {0, 0, 0})};
  for (const char* method : {"cvode/adams", "cvode/bdf"}) {
    int seen = 0;
    const Outcome outcome =
        cvode_engine().run(parse_method_id(method), given.scene, {1, 16, 4}, {[&](const Sample&) { ++seen; }, {}}, 0);
    INFO(outcome.reason);
    CHECK(outcome.status == Status::ok);
    CHECK(seen == 5);
  }
  const Truth truth = cvode_truth(given, 4);
  REQUIRE(truth.outcome.reason == "");
  REQUIRE(truth.values.size() == 5);
  CHECK(truth.values.back().bodies[0].p_m == std::array<Wide, 3>{});
}
