// Our methods with the reference's rate compared with odeint's: the same equations, counts and results.
#include "benchmarks/same_rate/same_rate.hpp"
#include "odeint/odeint.hpp"

#include "motion.hpp"
#include "simulation.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

Scenario top() {
  Scenario given = scenario("free-rigid-body", 2);
  given.scene.bodies = {solid("top", 1, {1, 2, 3}, {0.1, 1, 0.2})};
  return given;
}

double apart(const Run& a, const Run& b) {
  double most = 0;
  for (std::size_t i = 0; i < a.end.bodies.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const BodySample &x = a.end.bodies[i], &y = b.end.bodies[i];
      most = std::max(most, std::fabs(static_cast<double>(x.p_m[k] - y.p_m[k])));
      most = std::max(most, std::fabs(static_cast<double>(x.v_m_per_s[k] - y.v_m_per_s[k])));
      most = std::max(most, std::fabs(static_cast<double>(x.w_rad_per_s[k] - y.w_rad_per_s[k])));
    }
  return most;
}

}  // namespace

TEST_CASE("a method of the engine and its same-rate form make equally many evaluations and end in the same state") {
  const Engine ours = same_rate_engine(), odeint = odeint_engine();
  for (const Scenario& given : {orbit(), driven(), top()})
    for (const auto& [own, other] :
         {std::pair{"rk4", "runge_kutta4"}, {"explicit-euler", "euler"}, {"dopri5", "runge_kutta_dopri5"}}) {
      const Run a = run(ours, std::string("atwood-same-rate/") + own, given, 480);
      const Run b = run(odeint, std::string("odeint/") + other, given, 480);
      CAPTURE(given.id, own, a.outcome.reason);
      REQUIRE(a.outcome.status == Status::ok);
      CHECK(std::abs(a.outcome.rate_evaluations - b.outcome.rate_evaluations) <=
            1);  // first same as last: one to begin with
      CHECK(apart(a, b) < 1e-11);
    }
}

TEST_CASE("every method that is offered solves the reference's equations, with equal steps and with a tolerance") {
  const Engine ours = same_rate_engine(), native = atwood_engine();
  CHECK(ours.methods.size() >= 30);
  for (const MethodInfo& info : ours.methods) {
    const std::string scheme = info.id.substr(info.id.find('/'));
    for (const Scenario& given : {driven(), top()}) {
      CAPTURE(info.id, given.id);
      const Run made = run(ours, info.id, given, 480), own = run(native, "atwood" + scheme, given, 480);
      REQUIRE(made.outcome.status == Status::ok);
      CHECK(apart(made, own) <
            1e-6);  // quaternions are not normalised here: the difference is of the method's own error
      if (!info.adaptive) continue;
      const Run adaptive = run(ours, info.id + ":1e-9", given, 480);
      REQUIRE(adaptive.outcome.status == Status::ok);
      CHECK(apart(adaptive, run(native, "atwood/dop853:1e-12", given, 480)) < 1e-5);
    }
  }
}

TEST_CASE("evaluating each rate several times changes neither the result nor the counts") {
  for (const auto& [engine, method] : {std::pair{same_rate_engine(), std::string("atwood-same-rate/rk4")},
                                       {odeint_engine(), std::string("odeint/runge_kutta4")}}) {
    const Run once = run(engine, method, top(), 60), often = run(engine, method + "{rate_repeats=8}", top(), 60);
    CHECK(often.outcome.rate_evaluations == once.outcome.rate_evaluations);
    CHECK(apart(once, often) == 0);
    for (const char* wrong : {"0", "1001", "2.5"})
      CHECK(try_run(engine, method + "{rate_repeats=" + wrong + "}", top(), 60).outcome.reason.find("rate_repeats") !=
            std::string::npos);
  }
}

TEST_CASE("scenes that need more than a rate function are refused by name") {
  const Engine ours = same_rate_engine();
  for (const char* method :
       {"velocity-verlet", "radau15", "taylor", "rkmk4", "rk4+event", "rk4@quad", "rk4:1e-6", "rk4{step=1}", "none"}) {
    const Run made = try_run(ours, std::string("atwood-same-rate/") + method, orbit(), 60);
    CAPTURE(method);
    CHECK(made.outcome.status == Status::unsupported);
    CHECK_FALSE(made.outcome.reason.empty());
  }
}

TEST_CASE("the timed pass gives one duration per repeat") {
  const Engine ours = same_rate_engine();
  const Scenario given = orbit();
  const Outcome timed = ours.run(parse_method_id("atwood-same-rate/rk4"), given.scene, {given.t_end_s, 480, 1}, {}, 5);
  REQUIRE(timed.status == Status::ok);
  CHECK(timed.busy_ns.size() == 5);
}
