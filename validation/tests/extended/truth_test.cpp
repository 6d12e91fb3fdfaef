// The door to every kind of truth: dispatch, published values, and closed forms certified by the extended solve.
#include "truth/truth.hpp"

#include <quadmath.h>

#include <catch2/catch.hpp>
#include <cstdio>
#include <fstream>

#include "extended/extended.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

struct File {
  std::string path = "truth_test_values.csv";
  explicit File(const std::string& text) { std::ofstream(path) << text; }
  ~File() { std::remove(path.c_str()); }
};

Scenario with_values(const File& file) {
  Scenario scenario = scenes::kepler(0.6, 10);
  scenario.truth.kind = TruthKind::values;
  scenario.truth.file = file.path;
  return scenario;
}

// Largest |a - b| / (bars of both), positions and velocities.
double disagreement(const Truth& a, const Truth& b) {
  double worst = 0;
  REQUIRE(a.values.size() == b.values.size());
  for (std::size_t k = 1; k < a.values.size(); ++k)
    for (std::size_t i = 0; i < a.values[k].bodies.size(); ++i)
      for (int axis = 0; axis < 3; ++axis) {
        const auto ratio = [&](Wide u, Wide v, Wide bar) {
          worst = std::max(worst, static_cast<double>(fabsq(u - v) / (bar + Wide(1e-33))));
        };
        ratio(a.values[k].bodies[i].p_m[axis], b.values[k].bodies[i].p_m[axis],
              a.bars[k].bodies[i].p_m[axis] + b.bars[k].bodies[i].p_m[axis]);
        ratio(a.values[k].bodies[i].v_m_per_s[axis], b.values[k].bodies[i].v_m_per_s[axis],
              a.bars[k].bodies[i].v_m_per_s[axis] + b.bars[k].bodies[i].v_m_per_s[axis]);
      }
  return worst;
}

}  // namespace

TEST_CASE("each kind of truth is solved by its own solver, and none is unsupported") {
  Scenario scenario = scenes::kepler(0.6, 10);
  CHECK(solve_truth(scenario, 4).source == "extended: GBS 24 and Gauss 20 in quad");
  scenario.truth.kind = TruthKind::cvode;
  CHECK(solve_truth(scenario, 4).source.rfind("cvode: ", 0) == 0);
  scenario.truth.kind = TruthKind::none;
  const Truth none = solve_truth(scenario, 4);
  CHECK(none.outcome.status == Status::unsupported);
  CHECK(none.outcome.reason == "no truth: the scenario names none");
}

TEST_CASE("closed form and extended solve agree within their bars on Kepler's orbit") {
  Scenario scenario = scenes::kepler(0.6, 10);
  const Truth extended = solve_truth(scenario, 16);
  scenario.truth.kind = TruthKind::closed_form;
  scenario.truth.solution = "kepler";
  const Truth closed = solve_truth(scenario, 16);
  REQUIRE(closed.outcome.reason == "");
  CHECK(disagreement(closed, extended) < 1);
}

TEST_CASE("published values are read with their bars and source") {
  const File file(
      "# source: Kepler's equation\n# a remark\n"
      "t_s,body,px_m,py_m,px_m_bar,py_m_bar,remark\n"
      "10,planet,-1.53502359190981369430580688531817,-0.28,1e-30,0.5,x\n");
  const Truth truth = solve_truth(with_values(file), 1);
  REQUIRE(truth.outcome.reason == "");
  CHECK(truth.source == "values: Kepler's equation");
  REQUIRE(truth.values.size() == 2);
  CHECK(truth.values[1].bodies[0].p_m[0] == strtoflt128("-1.53502359190981369430580688531817", nullptr));
  CHECK(truth.bars[1].bodies[0].p_m[1] == Wide(0.5));
  CHECK(truth.values[0].bodies[0].p_m[0] == Wide(1 - 0.6));
  CHECK(truth.bars[0].bodies[0].p_m[0] == 0);
}

TEST_CASE("missing published values are refused by name") {
  const File file("t_s,body,px_m,px_m_bar\n10,planet,1,0\n");
  const Truth truth = solve_truth(with_values(file), 2);
  CHECK(truth.outcome.status == Status::unsupported);
  CHECK(truth.outcome.reason == "`truth_test_values.csv` has no row of `planet` at t = 5 s");
  const File bare("t_s,body,px_m\n10,planet,1\n");
  CHECK(solve_truth(with_values(bare), 1).outcome.reason == "`truth_test_values.csv` has px_m and no px_m_bar");
}

TEST_CASE("bars are below 1e-20 where the conditioning allows, and a motion past the reach of quad says from when on") {
  for (const Scenario& scenario :
       {scenes::pleiades(), scenes::figure_eight(), scenes::henon_heiles(10), scenes::lorenz(10)}) {
    INFO(scenario.id);
    const Truth truth = solve_truth(scenario, 4);
    REQUIRE(truth.outcome.status == Status::ok);
    CHECK(truth.note.empty());
    CHECK(truth.condition > 1);
    for (const SampleView bar : truth.bars)
      for (const BodySample& body : bar.bodies)
        for (const Wide value : body.p_m) CHECK(value < Wide(1e-18));  // coordinates up to 40
  }
  const Truth chaotic = solve_truth(scenes::lorenz(120), 60);  // grows as exp(0.9 t): 1e33 times at about t = 84
  CHECK(chaotic.note.rfind("not bounded after t = ", 0) == 0);
  const double last_s = std::stod(chaotic.note.substr(22));
  CHECK(last_s > 60);
  CHECK(last_s < 84);
}
