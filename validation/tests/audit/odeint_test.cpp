#include "odeint/odeint.hpp"

#include "motion.hpp"
#include "stepping/stepping.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

const Engine& odeint() {
  static const Engine engine = odeint_engine();
  return engine;
}

const MethodInfo& info(const std::string& id) {
  for (const MethodInfo& each : odeint().methods)
    if (each.id == id) return each;
  FAIL("no " << id);
  return odeint().methods.front();
}

std::string why(const std::string& method, const Scenario& given) {
  const Run made = try_run(odeint(), method, given, 10);
  CHECK(made.outcome.status == Status::unsupported);
  return made.outcome.reason;
}

}  // namespace

TEST_CASE("Claims are the stepper's own order()") {
  CHECK(info("odeint/runge_kutta4").claimed_order.at("rotation") == 4);
  CHECK(info("odeint/adams_bashforth7").claimed_order.at("point-mass") == 7);
  CHECK(info("odeint/velocity_verlet").claimed_order.at("point-mass") == 1);  // it does answer 1
  CHECK(info("odeint/adams_moulton3").claimed_order.at("point-mass") == 4);
  CHECK_FALSE(info("odeint/symplectic_euler").claimed_order.contains("velocity-dependent"));
  CHECK(info("odeint/bulirsch_stoer").claimed_order.empty());
  for (const MethodInfo& each : odeint().methods) {
    CAPTURE(each.id);
    CHECK_FALSE(each.doc.empty());
    CHECK(each.settings.contains("stepper"));
    CHECK(each.settings.contains("claim"));
    CHECK(each.settings.contains("sampling"));
  }
}

TEST_CASE("A step is taken with the reference's right-hand side") {
  const Scenario given = driven();
  const dynamics::Dynamics<double> equations(given.scene, given.t_end_s);
  std::vector<double> y = dynamics::pack<double>(given.scene), f(y.size());
  equations.rate(0, y.data(), f.data(), 0);
  const Run made = run(odeint(), "odeint/euler", given, 1);
  for (int i = 0; i < 3; ++i) {
    CHECK(static_cast<double>(made.end.bodies.at(0).p_m[i]) == y[i] + given.t_end_s * f[i]);
    CHECK(static_cast<double>(made.end.bodies.at(0).v_m_per_s[i]) == y[3 + i] + given.t_end_s * f[3 + i]);
  }
}

TEST_CASE("Well-known methods show their order, out of place and in place, in both scalars") {
  for (const Scenario& given : {orbit(), driven()}) {
    const std::int64_t n = given.id == "kepler" ? 800 : 60;
    CAPTURE(given.id);
    for (const std::string suffix : {"", "{in_place=true}", "@long-double", "@long-double{in_place=true}"}) {
      CHECK(order(odeint(), "odeint/runge_kutta4" + suffix, given, n) == Approx(4).margin(0.2));
      CHECK(order(odeint(), "odeint/modified_midpoint" + suffix, given, n) == Approx(2).margin(0.2));
    }
    CHECK(order(odeint(), "odeint/adams_bashforth3@long-double", given, n) == Approx(3).margin(0.3));
    CHECK(order(odeint(), "odeint/runge_kutta_dopri5@long-double", given, n) == Approx(5).margin(0.3));
  }
  CHECK(order(odeint(), "odeint/symplectic_rkn_sb3a_mclachlan", orbit(), 200) == Approx(4).margin(0.2));
  CHECK(order(odeint(), "odeint/rosenbrock4", orbit(), 400) == Approx(4).margin(0.3));
}

TEST_CASE("Equal methods in place and out of place give equal bits; the others are findings") {
  const auto x = [&](const std::string& method) {
    return static_cast<double>(run(odeint(), method, driven(), 60).end.bodies.at(0).p_m[0]);
  };
  for (const std::string method : {"odeint/runge_kutta4", "odeint/runge_kutta_dopri5",
                                   "odeint/adams_bashforth_moulton4", "odeint/velocity_verlet"})
    CHECK(x(method) == x(method + "{in_place=true}"));
  CHECK(x("odeint/extrapolation_stepper4") != x("odeint/extrapolation_stepper4{in_place=true}"));
}

TEST_CASE("The findings of the audit in odeint are in the library and not in the adapter") {
  CHECK(order(odeint(), "odeint/adams_bashforth4{in_place=true}", driven(), 480) == Approx(1).margin(0.25));
  CHECK(order(odeint(), "odeint/rosenbrock4", driven(), 480) == Approx(1).margin(0.25));
  CHECK(order(odeint(), "odeint/adams_moulton2", driven(), 480) == Approx(2).margin(0.25));
  CHECK(order(odeint(), "odeint/velocity_verlet", orbit(), 480) == Approx(2).margin(0.25));
}

TEST_CASE("A tighter tolerance is nearer the truth, in each form that takes one") {
  for (const MethodInfo& each : odeint().methods) {
    if (!each.adaptive) continue;
    const double loose = end_error(odeint(), each.id + ":1e-4", orbit(), 20),
                 tight = end_error(odeint(), each.id + ":1e-9", orbit(), 20);
    CAPTURE(each.id, loose, tight);
    CHECK(tight < loose / 100);
    CHECK(tight < 1e-6);
  }
}

TEST_CASE("Requests that odeint does not cover are refused with a reason") {
  CHECK(why("odeint/rk4", orbit()).find("no stepper") != std::string::npos);
  CHECK(why("odeint/runge_kutta4@quad", orbit()).find("long-double") != std::string::npos);
  CHECK(why("odeint/runge_kutta4:1e-6", orbit()).find("no error control") != std::string::npos);
  CHECK(why("odeint/runge_kutta4{colour=3}", orbit()).find("in_place") != std::string::npos);
  CHECK(why("odeint/symplectic_euler", driven()).find("velocities") != std::string::npos);
  Scenario undamped = driven();
  std::get<Spring>(undamped.scene.forces[0]).damping_N_s_per_m = 0;
  CHECK(why("odeint/symplectic_euler", undamped).find("time") != std::string::npos);
  Scenario top = orbit();
  top.scene.bodies = {solid("top", 1, {1, 2, 3}, {0.1, 1, 0.2})};
  top.scene.forces.clear();
  CHECK(why("odeint/velocity_verlet", top).find("positions and velocities only") != std::string::npos);
}

TEST_CASE("A Newton iteration that does not end is stopped and reported") {
  Scenario given = orbit();
  given.t_end_s = 20;
  const Run made = try_run(odeint(), "odeint/implicit_euler", given, 40);
  CHECK(made.outcome.status != Status::ok);
  CHECK(made.outcome.reason.find("odeint: ") == 0);
}

TEST_CASE("The Jacobian that implicit steppers are given is that of the equations") {
  const Scenario given = orbit();
  std::vector<double> J(36), dfdt(6), y;
  stepping::run<double>("x", given.scene, {2, 1, 1}, {}, 0, false,
                        [&](const stepping::Equations<double>& equations, const std::vector<double>& start, double) {
                          y = start;
                          equations.jacobian(0, y.data(), J.data(), dfdt.data());
                          throw stepping::Failure(Status::unsupported, "seen");
                          return std::unique_ptr<stepping::Stepper<double>>();
                        });
  const double r3 = 0.4 * 0.4 * 0.4;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      CHECK(J[i * 6 + 3 + j] == Approx(i == j ? 1 : 0).margin(1e-12));
      CHECK(J[(3 + i) * 6 + j] == Approx(i != j ? 0 : i == 0 ? 2 / r3 : -1 / r3).margin(1e-9));
    }
  for (const double rate : dfdt) CHECK(std::fabs(rate) < 1e-12);
}
