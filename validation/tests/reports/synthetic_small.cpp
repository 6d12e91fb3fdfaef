#include <limits>

#include "synthetic.hpp"

namespace atwood {

// One level won by us, one by a rival at the truth's bar, one alone; a budget; a rung that ended badly.
static Dominance small_dominance() {
  const Reached ours{"atwood/verner8", "atwood/verner8", 120, 1e-6, 2.5e-5, false, false};
  const Reached next{"atwood/rk4", "atwood/rk4", 960, 1e-6, 1e-4, false, false};
  const Reached rival{"cvode/adams:tol", "cvode/adams:1e-8", 240, 1e-6, 4e-4, false, true};
  Reached at_bar = rival;
  at_bar.error = 1e-13;
  at_bar.at_bar = true;
  at_bar.coarsest = false;
  Reached behind = ours;
  behind.cost = 8e-4;
  Dominance table{"kepler-e0.6", "error-position-max", "m", Cost::seconds, {}, {}, {}};
  table.by_error = {{1e-6, {ours, next, rival}, TimedRatio{4.05, 3.9, 4.2, 15}},
                    {1e-12, {at_bar, behind}, {}},
                    {1e-13, {at_bar}, {}}};
  table.by_budget = {{16.7e-3, {ours, at_bar}, {}}};
  table.stable = {{"atwood/rk4",
                   true,
                   {"atwood/rk4", 240, 10.0 / 240, 1e-4, 1e-15, 2e-5, 960},
                   {{"atwood/rk4", 60, 10.0 / 60, Status::diverged, "its error is as large as the motion"}}},
                  {"a|b/<c>", false, {}, {{"a|b/<c>", 60, 0, Status::unsupported, "no | such <force>"}}}};
  return table;
}

static std::vector<GoalResult> small_goals() {
  const double none = std::numeric_limits<double>::quiet_NaN();
  GoalResult reached{"kepler-10",
                     "Kepler | ten periods",
                     "kepler-10-periods",
                     "error-state-end",
                     "1",
                     2e-10,
                     "evaluations",
                     6000,
                     true,
                     {"atwood/ias15:1e-9", 3840, 1.5e-10, 1e-16, 3.9e-5, 4950, none, true},
                     {"cvode/adams:1e-13", 3840, 4.6e-9, 1e-16, 7.6e-3, 9970, none, false},
                     {},
                     none,
                     none,
                     none,
                     ""};
  reached.ours.last_quarter = 1.7e-10;
  reached.ours.floor = 4.4e-13;
  reached.close = {{"atwood/gbs:1e-11", 3840, 1.1e-10, 1e-16, 4.1e-5, 5400, none, true, 1.2e-10}};
  reached.machine = {40, 7, 5, 2.6, 3.125, 2};
  GoalResult missed{"drag",
                    "Quadratic drag <480>",
                    "projectile-quadratic-drag",
                    "error-position-end",
                    "m",
                    1e-12,
                    "ns_per_step",
                    100,
                    false,
                    {"atwood/rk4", 480, 3e-9, 1e-20, 5e-5, 1920, 104.2, false},
                    {"ode/tuned", 480, 6.5e-2, 1e-20, 9.4e-5, 480, 196, false},
                    {},
                    none,
                    none,
                    none,
                    "the error is 3000 times too large"};
  return {reached, missed};
}

ReportData small_report() {
  ReportData data;
  data.title = "Small | <report> & \"more\"";
  data.command = "atwood report `x`";
  data.provenance = {"0.1.0", "abc123", "g++ 12.2.0", "-O3, -g", "CPU \"A\"", "run-1"};
  Scenario scenario;
  scenario.id = "kepler-e0.6";
  scenario.title = "An ellipse";
  scenario.claim = "Order 4, \"measured\".";
  scenario.source = "Kepler 1609";
  scenario.tags = {"smooth"};
  scenario.t_end_s = 10;
  scenario.steps = {960, 1920};
  scenario.samples = 60;
  scenario.truth = {TruthKind::closed_form, "kepler", ""};
  scenario.invariants = {{"energy"}};
  data.scenarios = {scenario};
  MethodInfo method{
      "atwood/rk4",
      "The classical scheme.",
      "Kutta 1901",
      {{"point-mass", 4}},
      false,
      {{"sleeping", false}, {"iterations", std::int64_t{10}}, {"erp", 0.2}, {"solver", std::string("a|b")}}};
  MethodInfo idle{"atwood/heun", "Ran nowhere.", "", {}, false, {{"idle_setting", true}}};
  MethodInfo impulse{
      "+impulse",    "Impulses | in substeps.",
      "Moreau 1988", {},
      false,         {{"rest_sweeps", std::int64_t{100}}, {"sleeping", false}, {"solver", std::string("auto")}}};
  MethodInfo event{"+event", "Followed nothing here.", "", {}, false, {{"simultaneous", std::string("sequential")}}};
  data.engines = {{"atwood", "0.1.0", "double", {method, idle}, nullptr, false, {impulse, event}},
                  {"fcl", "0.7", "double", {{"fcl/default", "Ran nowhere.", "", {}, false, {}}}, nullptr}};
  data.missing_engines = {{"mujoco", "not built"}};
  data.metrics = {{"error-position-end", "m", "Norm of the difference <at the end>."}};
  Row row{"kepler-e0.6",
          "atwood/rk4",
          960,
          10.0 / 960,
          {},
          {},
          "",
          std::nullopt,
          "error-position-end",
          "m",
          1.2345678901234567e-7,
          1e-15,
          Status::ok,
          "",
          "a1b2",
          data.provenance};
  data.rows.push_back(row);
  row.steps = 1920;
  row.h_s = 10.0 / 1920;
  row.value = 7.7e-9;
  row.body = "planet, \"b\"";
  row.t_s = 0.1;
  data.rows.push_back(row);
  row = {"kepler-e0.6",
         "ode/default{erp=0.1,cfm=0}",
         960,
         10.0 / 960,
         {},
         {},
         "",
         std::nullopt,
         "status",
         "",
         0,
         0,
         Status::crashed,
         "line one\nline \x1b[31m two, \"quoted\" \xff",
         "c3d4",
         data.provenance};
  data.rows.push_back(row);
  row = {"kepler-e0.6",
         "atwood/explicit-euler",
         960,
         10.0 / 960,
         {},
         {},
         "",
         std::nullopt,
         "error-position-end",
         "m",
         std::numeric_limits<double>::quiet_NaN(),
         1e-15,
         Status::not_finite,
         "x is nan",
         "e5",
         data.provenance};
  data.rows.push_back(row);
  row = {"kepler-e0.6",    "atwood/rk4", 0,    0,    {},         {}, "",     std::nullopt,
         "order-position", "1",          3.98, 0.02, Status::ok, "", "a1b2", data.provenance};
  data.rows.push_back(row);
  data.verdicts = {verdict("kepler-e0.6", "atwood/rk4", "order-position", Judgement::pass, 3.98, 3.9, 4.2),
                   verdict("kepler-e0.6", "atwood/heun", "order-position", Judgement::fail, 1.4, 1.9, 2.1),
                   verdict("a <b> & \"c\" | d", "atwood/rk4", "order-position", Judgement::unverifiable, 3.9, 3.9, 4.2),
                   verdict("bounce-*", "atwood/rk4+event", "apex-error", Judgement::not_run, 0, 0, 1e-12)};
  data.verdicts[3].text = "no rows match \x1b[2J this gate";
  data.laws = {{"ballistic", "atwood/explicit-euler", "landing-range-error", "range error = v_x h", 120, 0.125,
                0.12500000000001, "m"}};
  data.bench = {{"kepler-e0.6", "atwood/rk4", 1000, {150.5, 148.25, 171.25}, 171.25, "step/rk4"}};
  data.dominance = {small_dominance()};
  data.goals = small_goals();
  data.notes = {"cvode/adams:tol: it takes a tolerance | and was named without one."};
  data.series = {
      {"kepler-e0.6", "atwood/rk4", 960, {{0, 5, 10}, {0, 1e-8, 1.2345678e-7}, {}, {}, {}, {0, -1e-9, 2e-9}}}};
  return data;
}

}  // namespace atwood
