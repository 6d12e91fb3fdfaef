#include "arkode/arkode.hpp"

#include <map>

#include "motion.hpp"

using namespace atwood;
using namespace atwood::testing;

namespace {

const Engine& arkode() {
  static const Engine engine = arkode_engine();
  return engine;
}

const MethodInfo& info(const std::string& id) {
  for (const MethodInfo& each : arkode().methods)
    if (each.id == id) return each;
  FAIL("no " << id);
  return arkode().methods.front();
}

}  // namespace

TEST_CASE("Each packaged table is a method that claims the order of its table") {
  std::map<std::string, int> count;
  for (const MethodInfo& each : arkode().methods) {
    ++count[each.id.substr(7, each.id.rfind('/') - 7)];
    const auto q = std::get<std::int64_t>(each.settings.at("table_order"));
    const auto checked = std::get<std::int64_t>(each.settings.at("table_order_by_its_coefficients"));
    CAPTURE(each.id);
    CHECK(each.claimed_order.at("point-mass") == static_cast<double>(q));
    CHECK(checked == std::min<std::int64_t>(q, 6));  // the coefficients are right: what is lost is lost in the stepping
    CHECK_FALSE(each.doc.empty());
    CHECK_FALSE(each.source.empty());
  }
  CHECK(count["erkstep"] == 15);
  CHECK(count["arkstep-explicit"] == 15);
  CHECK(count["arkstep-implicit"] == 23);
  CHECK(count["arkstep-imex"] == 5);
  CHECK(info("arkode/erkstep/VERNER_8_5_6").claimed_order.at("rotation") == 6);
}

TEST_CASE("Settings of the implicit solver are printed") {
  const Settings& settings = info("arkode/arkstep-imex/ARK436L2SA_6_3_4").settings;
  for (const char* key : {"nonlinear_solver", "nonlinear_coefficient", "nonlinear_weights", "linear_solver",
                          "newton_matrix", "split", "sampling"})
    CHECK(settings.contains(key));
  CHECK_FALSE(info("arkode/erkstep/VERNER_8_5_6").settings.contains("linear_solver"));
}

TEST_CASE("A step is taken with the reference's right-hand side") {
  const Scenario given = driven();
  const std::vector<double> y = heun(given, given.t_end_s);
  for (const std::string module : {"erkstep", "arkstep-explicit"}) {
    const Run made = run(arkode(), "arkode/" + module + "/HEUN_EULER_2_1_2", given, 1);
    REQUIRE(made.outcome.status == Status::ok);
    CHECK(made.outcome.steps_taken == 1);
    CHECK(made.outcome.rate_evaluations >= 2);
    for (int i = 0; i < 3; ++i) {
      CHECK(static_cast<double>(made.end.bodies[0].p_m[i]) == Approx(y[i]).epsilon(1e-15).margin(1e-15));
      CHECK(static_cast<double>(made.end.bodies[0].v_m_per_s[i]) == Approx(y[3 + i]).epsilon(1e-15).margin(1e-15));
    }
  }
}

TEST_CASE("Well-known methods show their order through the adapter") {
  for (const Scenario& given : {orbit(), driven()}) {
    const std::int64_t n = given.id == "kepler" ? 800 : 60;
    CAPTURE(given.id);
    CHECK(order(arkode(), "arkode/erkstep/ZONNEVELD_5_3_4", given, n) == Approx(4).margin(0.2));
    CHECK(order(arkode(), "arkode/arkstep-explicit/BOGACKI_SHAMPINE_4_2_3", given, n) == Approx(3).margin(0.2));
    CHECK(order(arkode(), "arkode/arkstep-implicit/SDIRK_2_1_2", given, n) == Approx(2).margin(0.2));
    CHECK(order(arkode(), "arkode/arkstep-implicit/ARK436L2SA_DIRK_6_3_4", given, n) == Approx(4).margin(0.2));
    CHECK(order(arkode(), "arkode/arkstep-imex/ARK324L2SA_4_2_3", given, n) == Approx(3).margin(0.2));
  }
}

TEST_CASE("ERKStep has a lower order than ARKStep with the same table") {
  CHECK(order(arkode(), "arkode/erkstep/SAYFY_ABURUB_6_3_4", driven(), 60) == Approx(2).margin(0.25));
  CHECK(order(arkode(), "arkode/arkstep-explicit/SAYFY_ABURUB_6_3_4", driven(), 60) == Approx(4).margin(0.25));
}

TEST_CASE("A tighter tolerance is nearer the truth, in each module") {
  for (const std::string method : {"erkstep/CASH_KARP_6_4_5", "arkstep-explicit/DORMAND_PRINCE_7_4_5",
                                   "arkstep-implicit/KVAERNO_5_3_4", "arkstep-imex/ARK436L2SA_6_3_4"}) {
    const double loose = end_error(arkode(), "arkode/" + method + ":1e-5", orbit(), 1),
                 tight = end_error(arkode(), "arkode/" + method + ":1e-9", orbit(), 1);
    CAPTURE(method, loose, tight);
    CHECK(tight < loose / 100);
    CHECK(tight < 1e-6);
  }
}

TEST_CASE("Requests that ARKODE does not cover are refused with a reason") {
  const auto why = [&](const std::string& method, const Scenario& given = orbit()) {
    const Run made = try_run(arkode(), method, given, 10);
    CHECK(made.outcome.status == Status::unsupported);
    return made.outcome.reason;
  };
  CHECK(why("arkode/erkstep/RK4").find("no scheme") != std::string::npos);
  CHECK(why("arkode/erkstep/VERNER_8_5_6@float").find("double") != std::string::npos);
  CHECK(why("arkode/erkstep/VERNER_8_5_6+event").find("contacts") != std::string::npos);
  CHECK(why("arkode/erkstep/KNOTH_WOLKE_3_3:1e-6").find("no embedded method") != std::string::npos);
  CHECK(why("arkode/erkstep/VERNER_8_5_6{colour=3}").find("colour") != std::string::npos);
  Scenario bounce = orbit();
  bounce.scene.bodies = {ball("a", 1, 0.1, {0, 0, 0}, {1, 0, 0}), ball("b", 1, 0.1, {1, 0, 0}, {0, 0, 0})};
  bounce.scene.forces.clear();
  CHECK(why("arkode/erkstep/VERNER_8_5_6", bounce).find("contacts") != std::string::npos);
  Scenario late = orbit();
  late.scene.bodies[0].release_s = 0.5;
  CHECK(why("arkode/erkstep/VERNER_8_5_6", late).find("switch") != std::string::npos);
}

TEST_CASE("The timed pass gives one duration per repeat and observes no samples") {
  int seen = 0;
  const Outcome outcome = arkode().run(parse_method_id("arkode/erkstep/CASH_KARP_6_4_5"), orbit().scene, {2, 100, 10},
                                       {[&](const Sample&) { ++seen; }, {}}, 3);
  CHECK(outcome.busy_ns.size() == 3);
  CHECK(seen == 0);
  CHECK(outcome.steps_taken == 100);
}
