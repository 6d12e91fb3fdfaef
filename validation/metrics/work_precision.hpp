// Work and precision: the cost of an error, the error within a budget, the stable steps. Pure functions of rows.
//
// A *curve* is one method's ladder on one scenario: of step counts, or of tolerances (many ids, one family
// "cvode/adams:tol"). Methods are ranked by measured rungs only: nothing is interpolated or extrapolated.
//
// An error below three bars of its truth is only known to be less than value + bar: this sum is used in its place, and
// results are marked `at_bar`.
//
// Of a scene with fluids a curve also runs over the spacings and the sound speeds of its particles. Evaluations of
// rates of different numbers of particles are not a common cost: these scenes are ranked by time alone, and at equal
// spacing by their error.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood {

enum class Cost { seconds, evaluations };

// "cvode/adams:1e-10" and "cvode/adams:1e-8,1e-9" are rungs of one ladder: "cvode/adams:tol". The family of other ids
// is the id.
std::string method_family(const std::string& method);
// "bullet64" of "bullet64/tuned".
std::string engine_of(const std::string& method);
// "atwood/rk4" of "atwood/rk4+event@quad": what stands before tolerance, response, scalar and settings.
std::string base_of(const std::string& method);

struct WorkPoint {
  std::string method;         // full id
  std::int64_t steps = 0;     // of the plan
  double h_s = 0;             // 0: the method chooses
  double error = 0, bar = 0;  // in the metric's unit
  double seconds = 0;      // of the whole run, from the timed pass; NaN: not timed. Equal steps beyond the finest timed
                           // rung (long runs are not timed twice): that rung's time of a step
  double evaluations = 0;  // NaN: the engine does not count them
  Resolution at = {};      // of fluids
};
// The error; value + bar where the value is below three bars.
double known_error(const WorkPoint& point);
bool at_bar(const WorkPoint& point);
double cost_of(const WorkPoint& point, Cost cost);

// Rungs without an error: the run failed, or its error is not smaller than the size of the motion.
struct FailedRung {
  std::string method;
  std::int64_t steps = 0;
  double h_s = 0;
  Status status = Status::ok;
  std::string reason;
  Resolution at = {};
};

struct WorkCurve {
  std::string family;
  std::vector<WorkPoint> points;   // coarsest first: by spacing, sound speed and step count, or by falling tolerance
  std::vector<FailedRung> failed;  // in the same order
  // Timed as WebAssembly alone. Such times are not comparable with native ones: the points have no seconds, and
  // rankings by time leave the curve out.
  bool under_wasm = false;
};

// Every method's curve on one scenario, in the order of the rows. `metric` is an error with one figure per run. Where
// several hosts measured the scenario's times, these are not comparable, and no point has seconds.
std::vector<WorkCurve> work_curves(std::span<const Row> rows, const std::string& scenario, const std::string& metric);

// The size of the motion that an error of this metric is compared with: the scenario's own size-... row; 1 for angles
// (a radian), relative errors, and where there is no such row. Infinite for figures that are no errors of the motion's
// kind: energies in joules, counts, exponents.
double motion_size(std::span<const Row> rows, const std::string& scenario, const std::string& metric);

// Whether the metric is a figure of a whole ladder, as an order is, and no run has one of its own.
bool is_of_ladder(const std::string& metric);

struct Reached {
  std::string family, method;  // method and steps: the measured rung
  std::int64_t steps = 0;
  double error = 0, cost = 0;  // of that rung
  bool at_bar = false;         // the rung's error is below three bars of the truth
  bool coarsest = false;       // nothing cheaper was measured: the cost is an upper limit
  double worst_finer = 0;  // the largest error of this curve's finer rungs, infinite where one failed; 0: none is finer
  Resolution at = {};
};

// The cheapest measured rung with an error of at most `wanted`; none where no rung reaches it, or where
// no such rung has a known cost.
std::optional<Reached> cheapest(const WorkCurve& curve, double wanted, Cost cost);
// The measured rung of least error with a cost of at most `budget`; none where every rung costs more.
std::optional<Reached> most_accurate(const WorkCurve& curve, double budget, Cost cost);

// The coarsest rung such that it and every finer one have a finite error below the size of the motion.
struct StableRange {
  std::string family;
  bool stable = false;  // whether there is such a rung
  WorkPoint first;
  std::vector<FailedRung> failed;  // the rungs that failed
};
StableRange stable_range(const WorkCurve& curve);

// ---- cheapest method per error -------------------------------------------------------------------------------------
// A ratio of times with its 95 % interval
struct TimedRatio {
  double value = 1, low = 1, high = 1;
  int pairs = 0;
};
struct Contest {
  double asked = 0;                   // an error, or a budget
  std::vector<Reached> ranked;        // best first; one per family
  std::optional<TimedRatio> to_next;  // the second's cost over the first's, where both were timed alternately
};
// Of fluids: each method at one spacing and sound speed, the most accurate first. A method's rung is its cheapest one
// with an error within 1 % of its least error there.
struct EqualSpacing {
  Resolution at;
  std::vector<Reached> ranked;
};
struct Dominance {
  std::string scenario, metric, unit;
  Cost cost = Cost::seconds;
  std::vector<Contest> by_error;              // of cost; levels that no curve reaches are left out
  std::vector<Contest> by_budget;             // of error; budgets that no rung keeps are left out
  std::vector<StableRange> stable;            // one for each curve with rungs
  std::vector<EqualSpacing> by_spacing = {};  // of fluids, coarsest first
};

// The ranking used by `compare`, `advise` and the reports: each curve's rung for this error, cheapest first, or for
// this budget, most accurate first (with equal errors the cheaper first).
Contest contest_of_error(std::span<const WorkCurve> curves, double wanted, Cost cost);
Contest contest_of_budget(std::span<const WorkCurve> curves, double budget, Cost cost);

// The question of a comparison. Empty metric: that of telling_metric(); 0: all levels of error, all budgets.
struct Question {
  std::string metric;
  double error = 0, budget_s = 0;
};

// 1e-3, 1e-4 .. 1e-13; of fluids 0.1, 0.03, 0.01 .. 1e-6.
const std::vector<double>& error_levels(bool fluids = false);
// In seconds: a frame at 60 Hz and at 25 Hz, and smaller budgets for small problems: 1 us, 10 us, 100 us, 1 ms; of
// fluids whole runs of 10 ms to 100 s. In evaluations: 1e2, 1e3 .. 1e6.
const std::vector<double>& budgets(Cost cost, bool fluids = false);

Dominance dominance(std::span<const WorkCurve> curves, const std::string& scenario, const std::string& metric,
                    const std::string& unit, Cost cost, const Question& question = {});

// The metric in which methods differ most on a scenario: attitude or position, whichever has the larger error relative
// to the size of the motion (attitude where both are as large as the motion). It is the largest error over the run,
// because the error at the end may be small by chance. Scenes with contacts use position. Fluids: the l1 error of the
// velocity, or where the exact fluid rests of the temperature or pressure, whose exact field is not 0 everywhere.
// Empty where the rows have none of these.
std::string telling_metric(std::span<const Row> rows, const std::string& scenario);

// One table for each scenario of these rows, by time and (where an engine counts them) by evaluations.
std::vector<Dominance> find_dominance(std::span<const Row> rows, const Question& question = {});

// The best of the ranked ones that is (or is not) of one engine; null where there is none.
const Reached* best_of(const Contest& contest, const std::string& engine);
const Reached* best_rival(const Contest& contest, const std::string& engine);

}  // namespace atwood
