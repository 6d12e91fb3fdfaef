// Work and precision on ladders whose answers are known by hand.
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>

#include "validation/metrics/work_precision.hpp"

using namespace atwood;

namespace {

const double nan_value = std::numeric_limits<double>::quiet_NaN();

void add(std::vector<Row>& rows, const std::string& method, std::int64_t steps, const std::string& metric, double value,
         double bar = 0) {
  Row row;
  row.scenario = "s";
  row.method = method;
  row.steps = steps;
  row.h_s = 1.0 / static_cast<double>(steps);
  row.metric = metric;
  row.value = value;
  row.truth_bar = bar;
  rows.push_back(row);
}

// A rung: an error, seconds, evaluations; NaN leaves a figure out.
void rung(std::vector<Row>& rows, const std::string& method, std::int64_t steps, double error, double seconds,
          double evaluations, double bar = 0) {
  add(rows, method, steps, "error-position-max", error, bar);
  if (!std::isnan(seconds)) add(rows, method, steps, "run-time", seconds);
  if (!std::isnan(evaluations)) add(rows, method, steps, "rate-evaluations", evaluations);
}

void failure(std::vector<Row>& rows, const std::string& method, std::int64_t steps, Status status,
             const std::string& reason) {
  add(rows, method, steps, "status", 0);
  rows.back().status = status;
  rows.back().reason = reason;
}

WorkCurve only(const std::vector<Row>& rows) {
  const auto curves = work_curves(rows, "s", "error-position-max");
  REQUIRE(curves.size() == 1);
  return curves.front();
}

}  // namespace

TEST_CASE("a method that is timed under WebAssembly alone has errors, no seconds, and no rank by time") {
  std::vector<Row> rows;
  rung(rows, "native/m", 10, 1e-3, 1e-3, nan_value);
  rung(rows, "node/m", 10, 1e-4, nan_value, 20);
  add(rows, "node/m", 10, "run-time-wasm", 1e-6);
  const auto curves = work_curves(rows, "s", "error-position-max");
  REQUIRE(curves.size() == 2);
  CHECK_FALSE(curves[0].under_wasm);
  CHECK(curves[1].under_wasm);
  CHECK(std::isnan(curves[1].points.at(0).seconds));
  const Contest contest = contest_of_error(curves, 1e-2, Cost::seconds);
  REQUIRE(contest.ranked.size() == 1);
  CHECK(contest.ranked[0].family == "native/m");
}

TEST_CASE("times of several hosts are never ranked together") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-3, 1e-3, 40);
  rung(rows, "b/m", 10, 1e-3, 2e-3, 20);
  CHECK(contest_of_error(work_curves(rows, "s", "error-position-max"), 1e-2, Cost::seconds).ranked.size() == 2);
  for (Row& row : rows) {
    if (row.metric != "run-time") continue;
    Provenance from;
    from.host = "of " + row.method;
    row.provenance = from;
  }
  const auto curves = work_curves(rows, "s", "error-position-max");
  for (const WorkCurve& curve : curves) CHECK(std::isnan(curve.points.at(0).seconds));
  CHECK(contest_of_error(curves, 1e-2, Cost::seconds).ranked.empty());
  CHECK(contest_of_error(curves, 1e-2, Cost::evaluations).ranked.at(0).family == "b/m");
  for (const Dominance& table : find_dominance(rows)) CHECK(table.cost == Cost::evaluations);
}

TEST_CASE("every figure of a run makes a point: a cost, energies in joules, counts and exponents are no motion") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-3, 2e-3, 4000);
  add(rows, "a/m", 10, "size-position", 1);
  for (const char* metric : {"energy-change-max", "growth-exponent-energy", "momentum-error"})
    add(rows, "a/m", 10, metric, 7.5);
  for (const Row& row : std::vector<Row>(rows)) {
    const auto curves = work_curves(rows, "s", row.metric);
    INFO(row.metric);
    REQUIRE(curves.size() == 1);
    REQUIRE(curves[0].points.size() == 1);
    CHECK(curves[0].points[0].error == row.value);
    CHECK(curves[0].points[0].seconds == 2e-3);
    CHECK(curves[0].points[0].evaluations == 4000);
  }
  add(rows, "a/m", 10, "energy-max", 7.5);  // of the motion's energy: it has nothing in common with the motion
  CHECK(work_curves(rows, "s", "energy-max").at(0).points.empty());
  CHECK(is_of_ladder("order-position-rms"));
  CHECK_FALSE(is_of_ladder("error-position-rms"));
}

TEST_CASE("families: tolerances are rungs of one ladder, all else stays in the name") {
  CHECK(method_family("cvode/adams:1e-10") == "cvode/adams:tol");
  CHECK(method_family("atwood/dopri5:1e-8,1e-11@quad") == "atwood/dopri5:tol@quad");
  CHECK(method_family("atwood/dopri5:1e-8+event{safety=0.8}") == "atwood/dopri5:tol+event{safety=0.8}");
  CHECK(method_family("atwood/rk4@float") == "atwood/rk4@float");
  CHECK(method_family("x/y{file=a:b}") == "x/y{file=a:b}");
  CHECK(engine_of("bullet64/tuned") == "bullet64");
}

TEST_CASE("what an error costs: the cheapest measured rung that reaches it, and nothing between rungs or beyond them") {
  std::vector<Row> rows;  // error = 1e-2 (n / 10)^-2, a microsecond a step
  for (const std::int64_t n : {1000, 10, 100})
    rung(rows, "a/m", n, 1e-2 * std::pow(static_cast<double>(n) / 10, -2), 1e-6 * static_cast<double>(n),
         2.0 * static_cast<double>(n));
  const WorkCurve curve = only(rows);
  REQUIRE(curve.points.size() == 3);
  CHECK(curve.points[0].steps == 10);  // sorted, whatever the order of the rows
  CHECK(curve.points[2].steps == 1000);

  const auto at_5 = cheapest(curve, 1e-5, Cost::seconds);
  REQUIRE(at_5);
  CHECK(at_5->steps == 1000);
  CHECK(at_5->cost == Approx(1e-3));
  CHECK(at_5->error == Approx(1e-6));
  CHECK(at_5->worst_finer == 0);  // none is finer
  CHECK(cheapest(curve, 1e-5, Cost::evaluations)->cost == Approx(2000));

  const auto on_rung = cheapest(curve, 1e-4 * (1 + 1e-12), Cost::seconds);
  CHECK(on_rung->cost == Approx(1e-4));
  CHECK(on_rung->worst_finer == Approx(1e-6));

  const auto easy = cheapest(curve, 0.5, Cost::seconds);  // the coarsest rung is better than wanted: an upper limit
  CHECK(easy->coarsest);
  CHECK(easy->cost == Approx(1e-5));
  CHECK_FALSE(cheapest(curve, 1e-7, Cost::seconds));  // below the finest: never extrapolated
}

TEST_CASE("the most accurate measured rung within a budget") {
  std::vector<Row> rows;
  for (const std::int64_t n : {10, 100, 1000})
    rung(rows, "a/m", n, 1e-2 * std::pow(static_cast<double>(n) / 10, -2), 1e-6 * static_cast<double>(n), nan_value);
  const WorkCurve curve = only(rows);
  CHECK_FALSE(most_accurate(curve, 9e-6, Cost::seconds));
  CHECK(most_accurate(curve, 1e-5, Cost::seconds)->error == 1e-2);
  const auto between = most_accurate(curve, 1e-5 * std::sqrt(10), Cost::seconds);
  CHECK(between->error == 1e-2);
  CHECK(between->steps == 10);
  CHECK(between->cost == Approx(1e-5));
  const auto rich = most_accurate(curve, 10, Cost::seconds);
  CHECK(rich->error == Approx(1e-6));
  CHECK_FALSE(most_accurate(curve, 1e9, Cost::evaluations));  // an engine that counts none
}

TEST_CASE("an error that rises again at fine steps costs what the coarse rung costs, and a budget buys the best rung") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-2, 1e-5, 1);
  rung(rows, "a/m", 100, 1e-8, 1e-4, 1);
  rung(rows, "a/m", 1000, 1e-6, 1e-3, 1);
  const WorkCurve curve = only(rows);
  const auto dip = cheapest(curve, 1e-7, Cost::seconds);
  CHECK(dip->cost == Approx(1e-4));
  CHECK(dip->worst_finer == 1e-6);  // more than wanted: reported, because the smaller error may be chance
  CHECK(most_accurate(curve, 1, Cost::seconds)->error == 1e-8);
  CHECK(most_accurate(curve, 1, Cost::seconds)->steps == 100);
}

TEST_CASE("a rung without a time is left out of rankings by time") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-2, 1e-5, 10);
  rung(rows, "a/m", 100, 1e-4, nan_value, 100);
  rung(rows, "a/m", 1000, 1e-6, 1e-3, 1000);
  const WorkCurve curve = only(rows);
  CHECK(cheapest(curve, 1e-4, Cost::seconds)->steps == 1000);
  CHECK(cheapest(curve, 1e-4, Cost::seconds)->cost == 1e-3);
  CHECK(cheapest(curve, 1e-4, Cost::evaluations)->cost == 100);
}

TEST_CASE(
    "beyond the finest timed rung of equal steps a step costs what it cost there; tolerances tell nothing of the "
    "kind") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-2, 1e-5, 10);
  rung(rows, "a/m", 100, 1e-4, 2e-4, 100);
  rung(rows, "a/m", 1000, 1e-6, nan_value, 1000);
  rung(rows, "a/m", 4000, 1e-8, nan_value, 4000);
  CHECK(cheapest(only(rows), 1e-6, Cost::seconds)->cost == Approx(2e-3));
  CHECK(cheapest(only(rows), 1e-8, Cost::seconds)->cost == Approx(8e-3));

  std::vector<Row> tolerances;
  rung(tolerances, "c/m:1e-4", 5, 1e-2, 1e-3, 100);
  rung(tolerances, "c/m:1e-8", 5, 1e-5, nan_value, 200);
  CHECK_FALSE(cheapest(only(tolerances), 1e-5, Cost::seconds));
}

TEST_CASE("below three bars value + bar is used, with a mark") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-6, 1e-5, 10, 1e-9);
  rung(rows, "a/m", 100, 1e-9, 1e-4, 100, 1e-9);
  const WorkCurve curve = only(rows);
  CHECK(known_error(curve.points[0]) == 1e-6);
  CHECK(known_error(curve.points[1]) == 2e-9);
  CHECK_FALSE(cheapest(curve, 1e-9, Cost::seconds));  // not measured
  const auto at = cheapest(curve, 2e-9, Cost::seconds);
  REQUIRE(at);
  CHECK(at->at_bar);
  CHECK(at->cost == 1e-4);
  CHECK_FALSE(cheapest(curve, 1e-6, Cost::seconds)->at_bar);
  CHECK(most_accurate(curve, 1, Cost::seconds)->at_bar);
}

TEST_CASE("an exact result is a rung like any other") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 1e-3, 1e-5, 10);
  rung(rows, "a/m", 100, 0, 1e-4, 100);
  const auto at = cheapest(only(rows), 1e-6, Cost::seconds);
  REQUIRE(at);
  CHECK(at->cost == 1e-4);
}

TEST_CASE("tolerances are ordered from loose to tight") {
  std::vector<Row> rows;
  rung(rows, "c/m:1e-12", 5, 1e-9, 3e-3, 300);
  rung(rows, "c/m:1e-4", 5, 1e-2, 1e-3, 100);
  rung(rows, "c/m:1e-8", 5, 1e-5, 2e-3, 200);
  const WorkCurve curve = only(rows);
  CHECK(curve.family == "c/m:tol");
  CHECK(curve.points[0].method == "c/m:1e-4");
  CHECK(curve.points[2].method == "c/m:1e-12");
  CHECK(curve.points[1].h_s == 0);  // it chooses its steps
}

TEST_CASE("crossing curves: a low order is cheaper above the crossing, a high one below") {
  std::vector<Row> rows;  // low: error = c^-1, high: error = 100 c^-2 (c: cost in us); they cross at 1e-2, 100 us
  for (const double c : {1e2, 1e3, 1e4, 1e5})
    rung(rows, "atwood/low", static_cast<std::int64_t>(c), 1 / c, c * 1e-6, nan_value);
  for (const double c : {1e2, 1e3, 1e4, 1e5})
    rung(rows, "rival/high", static_cast<std::int64_t>(c), 100 / (c * c) * 1.0001, c * 1e-6, nan_value);
  const auto curves = work_curves(rows, "s", "error-position-max");
  const Dominance table = dominance(curves, "s", "error-position-max", "m", Cost::seconds);
  REQUIRE(table.by_error.size() == 5);  // 1e-3 .. 1e-7; no method reaches finer levels
  CHECK(table.by_error[2].ranked[0].family == "rival/high");
  const Contest& at_5 = table.by_error[2];
  REQUIRE(at_5.ranked.size() == 2);
  CHECK(at_5.asked == 1e-5);
  CHECK(at_5.ranked[1].cost / at_5.ranked[0].cost == Approx(10).epsilon(1e-3));  // 1e5 us over 1e4 us
  CHECK(best_of(at_5, "atwood")->family == "atwood/low");
  CHECK(best_rival(at_5, "atwood")->family == "rival/high");
  CHECK(best_of(table.by_error[3], "atwood") == nullptr);  // 1e-6: low has no rung there
  // A budget of 100 us buys 1e-2 from both: the lower one wins by the figure, not by its place.
  const auto budget =
      std::find_if(table.by_budget.begin(), table.by_budget.end(), [](const Contest& c) { return c.asked == 1e-4; });
  REQUIRE(budget != table.by_budget.end());
  CHECK(budget->ranked[0].family == "atwood/low");
}

TEST_CASE(
    "a question that names one error or one budget has one contest, of the levels' own kind, and failures are no luck") {
  std::vector<Row> rows;
  rung(rows, "a/m", 10, 2e-3, 1e-5, 10);
  rung(rows, "a/m", 100, 4e-5, 1e-4, 100);
  rung(rows, "b/m", 10, 5e-5, 9e-5, 10);
  failure(rows, "b/m", 20, Status::diverged, "gone");
  const auto curves = work_curves(rows, "s", "error-position-max");
  const Contest asked = contest_of_error(curves, 6e-5, Cost::seconds);
  REQUIRE(asked.ranked.size() == 2);
  CHECK(asked.ranked[0].method == "b/m");
  CHECK(std::isinf(asked.ranked[0].worst_finer));
  const auto tables = find_dominance(rows, {"error-position-max", 6e-5, 0});
  REQUIRE(tables.size() == 2);  // time, evaluations
  REQUIRE(tables[0].by_error.size() == 1);
  CHECK(tables[0].by_budget.empty());
  CHECK(tables[0].by_error[0].ranked[0].method == asked.ranked[0].method);
  CHECK(tables[0].by_error[0].ranked[0].steps == asked.ranked[0].steps);
  const auto bought = find_dominance(rows, {"", 0, 1e-4});
  REQUIRE(bought.size() == 1);
  REQUIRE(bought[0].by_budget.size() == 1);
  CHECK(bought[0].by_error.empty());
  CHECK(bought[0].by_budget[0].ranked[0].method == "a/m");
  CHECK(contest_of_budget(curves, 1e-4, Cost::seconds).ranked[0].steps == 100);
}

TEST_CASE("stable steps: the coarsest rung from which on no finer one fails") {
  std::vector<Row> rows;
  add(rows, "a/m", 10, "size-position", 2);
  rung(rows, "a/m", 10, 5, 1e-5, 10);  // larger than the motion
  failure(rows, "a/m", 20, Status::diverged, "|x| passed 1e6");
  rung(rows, "a/m", 40, 0.5, 1e-5, 10);
  rung(rows, "a/m", 80, 0.1, 1e-5, 10);
  const WorkCurve curve = only(rows);
  CHECK(curve.points.size() == 2);
  const StableRange range = stable_range(curve);
  CHECK(range.stable);
  CHECK(range.first.steps == 40);
  REQUIRE(range.failed.size() == 2);
  CHECK(range.failed[0].steps == 10);
  CHECK(range.failed[1].reason == "|x| passed 1e6");
  CHECK_FALSE(cheapest(curve, 0.9, Cost::seconds)->steps == 10);

  failure(rows, "a/m", 60, Status::not_finite, "x is nan");
  CHECK(stable_range(only(rows)).first.steps == 80);
  failure(rows, "a/m", 160, Status::diverged, "again");
  CHECK_FALSE(stable_range(only(rows)).stable);

  std::vector<Row> refused;
  failure(refused, "b/m", 10, Status::unsupported, "no drag");
  CHECK_FALSE(stable_range(only(refused)).stable);
}

TEST_CASE("the telling metric is the one with the larger error relative to the motion") {
  std::vector<Row> rows;
  CHECK(telling_metric(rows, "s").empty());
  add(rows, "a/m", 10, "size-position", 100);
  add(rows, "a/m", 10, "error-position-max", 1);
  CHECK(telling_metric(rows, "s") == "error-position-max");
  add(rows, "a/m", 10, "error-attitude-max", 1e-14);  // a ball that bounces: its attitude does not matter
  CHECK(telling_metric(rows, "s") == "error-position-max");
  add(rows, "b/m", 10, "error-attitude-max", 0.5);  // 0.5 of a radian against 0.01 of the motion
  CHECK(telling_metric(rows, "s") == "error-attitude-max");
  add(rows, "b/m", 10, "error-position-max", 1e6);
  add(rows, "b/m", 20, "error-attitude-max", 3);  // both as large as can be
  CHECK(telling_metric(rows, "s") == "error-attitude-max");
  add(rows, "b/m", 10, "penetration-max", 0);  // with contacts: position
  CHECK(telling_metric(rows, "s") == "error-position-max");
  CHECK(telling_metric(rows, "elsewhere").empty());
}

TEST_CASE("a study's tables: the telling metric, time and evaluations, rows of one body or one instant left out") {
  std::vector<Row> rows;
  for (const std::int64_t n : {10, 100}) {
    rung(rows, "a/m", n, 1e-3 / static_cast<double>(n), 1e-6 * static_cast<double>(n), 4.0 * static_cast<double>(n));
    add(rows, "a/m", n, "error-attitude-max", 1e-2 / static_cast<double>(n));
    rows.back().unit = "rad";
  }
  add(rows, "a/m", 1000, "error-attitude-max", 1e-12);
  rows.back().body = "box";
  const auto tables = find_dominance(rows);
  REQUIRE(tables.size() == 2);
  CHECK(tables[0].metric == "error-attitude-max");
  CHECK(tables[0].unit == "rad");
  CHECK(tables[0].cost == Cost::seconds);
  CHECK(tables[1].cost == Cost::evaluations);
  CHECK(tables[0].by_error.size() == 2);  // 1e-3 and 1e-4
  CHECK(tables[1].by_error[1].ranked[0].cost == Approx(400));
}
