#include "benchmarks/goal_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "benchmarks/calmest.hpp"
#include "benchmarks/goal_candidates.hpp"
#include "benchmarks/goal_variants.hpp"
#include "benchmarks/last_quarter.hpp"
#include "benchmarks/rates.hpp"
#include "benchmarks/stopwatch.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/work_precision.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace {

// Candidates of each side that are timed alternately: the quickest of a first timing, this many, and up to kMaxTimed
// that took at most kMaxTimeRatio times as long as the quickest.
constexpr std::size_t kTimed = 5, kMaxTimed = 12;
constexpr double kMaxTimeRatio = 1.3;
// What costs more than kFar times the quickest of ours is timed in kFarRounds rounds; of a side that is as far, its
// quickest and those within kMaxTimeRatio of it: another digit of such a ratio tells nothing. A first timing of more
// than kLong seconds is not repeated before the rounds.
constexpr double kFar = 10, kLong = 0.01;
constexpr int kFarRounds = 5;
constexpr double kClose = 1.2;  // those within this factor of their side's best cost are printed

// Whether a row is the figure that a goal judges: of the whole run, or at an instant. Orders are of the method's
// ladder. Probes have a row each, of which the worst is judged.
bool is_figure(const Row& row, const Goal& goal) {
  const bool of_part = !row.body.empty() && goal.metric != "probe-error";
  if (row.metric != goal.metric || of_part || row.t_s.has_value() != (goal.at_s > 0)) return false;
  return goal.at_s == 0 || std::fabs(*row.t_s - goal.at_s) <= 1e-9 * goal.at_s;
}

// Whether the figure is what the goal asks: at most the error, or with all of its interval between the limits.
void judge(GoalEntrant& entrant, const Goal& goal) {
  if (std::isfinite(goal.low)) {
    entrant.accurate = entrant.error - entrant.bar >= goal.low && entrant.error + entrant.bar <= goal.high;
    return;
  }
  WorkPoint point;
  point.error = entrant.error;
  point.bar = entrant.bar;
  entrant.accurate = !std::isfinite(goal.error) || known_error(point) <= goal.error;
}

GoalEntrant entrant_of(const Cell& cell, const std::vector<Row>& rows, const Goal& goal) {
  GoalEntrant entrant{cell.method, cell.plan.steps, kNotMeasured, 0, kNotMeasured, kNotMeasured, kNotMeasured, false};
  std::vector<Row> of_cell;
  for (const Row& row : rows) {
    const bool ladder = row.steps == 0 && goal.metric.starts_with("order-");
    if (row.method != cell.method || (row.steps != cell.plan.steps && !ladder) || row.status != Status::ok) continue;
    of_cell.push_back(row);
    if (is_figure(row, goal) && !(std::fabs(row.value) <= std::fabs(entrant.error))) {
      entrant.error = std::isfinite(goal.low) ? row.value : std::fabs(row.value);
      entrant.bar = row.truth_bar;
    }
    if (row.metric == "rate-evaluations" && row.body.empty() && !row.t_s) entrant.evaluations = row.value;
  }
  entrant.floor = accuracy_floor(goal.metric, of_cell);
  judge(entrant, goal);
  return entrant;
}

// Why a run that ended ok has no number for the goal: what its figure says.
std::string why_no_figure(const Cell& cell, const std::vector<Row>& rows, const Goal& goal) {
  for (const Row& row : rows)
    if (row.method == cell.method && is_figure(row, goal) && !row.reason.empty()) return row.metric + ", " + row.reason;
  return goal.metric + " was not measured";
}

double cost_of(const GoalEntrant& entrant, const std::string& kind) {
  return kind == "evaluations" ? entrant.evaluations : kind == "ns_per_step" ? entrant.ns_per_step : entrant.seconds;
}

// Whether `a` ranks before `b`: accurate before inaccurate; among the accurate the cheaper, among the others the more
// accurate.
bool better(const GoalEntrant& a, const GoalEntrant& b, const std::string& kind) {
  if (a.accurate != b.accurate) return a.accurate;
  if (!a.accurate) return a.error < b.error;
  const double x = cost_of(a, kind), y = cost_of(b, kind);
  if (std::isfinite(x) != std::isfinite(y)) return std::isfinite(x);
  return kind.empty() ? a.error < b.error : x < y;
}

class GoalRun {
 public:
  explicit GoalRun(const GoalSetup& setup)
      : setup_(setup), workers_(setup.workers), stopwatch_(setup.study.cell_limit_s) {}

  GoalResult run(const Goal& goal);

 private:
  std::vector<Candidate> measured(const Goal& goal, const Scenario& scenario, bool with_rivals,
                                  std::vector<Cell>& cells);
  void take_variants(const Goal& goal, const Scenario& scenario, std::vector<Candidate>& candidates);
  std::vector<Candidate*> choose(const Goal& goal, Side side, std::vector<Candidate>& candidates, double& quickest);
  MachineState time(const Goal& goal, std::vector<Candidate>& candidates);
  const Candidate* best_of_ours(const Goal& goal, Side side, std::vector<Candidate>& candidates, LastQuarter& quarter);
  void add_close(const Goal& goal, const std::vector<Candidate>& candidates, LastQuarter& quarter, GoalResult& result);
  Contender contender(const Candidate& candidate) const {
    return {&workers_[static_cast<std::size_t>(candidate.cell->worker)],
            candidate.cell->method,
            &candidate.cell->scenario->scene,
            candidate.cell->plan,
            candidate.entrant.seconds,
            candidate.entrant.evaluations};
  }

  const GoalSetup& setup_;
  const std::vector<Worker>& workers_;
  Stopwatch stopwatch_;
  std::string refusal_;                // why the first of our candidates without a figure has none
  std::vector<std::string> left_out_;  // rungs that were not run (CostlyRungs)
};

std::vector<Candidate> GoalRun::measured(const Goal& goal, const Scenario& scenario, bool with_rivals,
                                         std::vector<Cell>& cells) {
  StudyOptions how = setup_.study;
  how.timing = false;
  how.cell_limit_s = std::max(how.cell_limit_s, goal.limit_s);
  how.truth_limit_s = std::max(how.truth_limit_s, 6 * goal.limit_s);
  how.purpose = "goals";
  std::vector<Candidate> candidates;
  CostlyRungs costly;
  for (const std::vector<PlannedCell>& wave :
       plan_waves(goal, scenario, with_rivals, workers_, setup_.study.provenance.cpu)) {
    std::vector<Cell> asked;
    std::vector<Side> sides;
    for (const PlannedCell& planned : wave) {
      if (variant_count(goal) == 1 && costly.leaves_out(planned)) {
        left_out_.push_back(planned.cell.method);
        continue;
      }
      asked.push_back(planned.cell);
      sides.push_back(planned.side);
    }
    if (asked.empty()) continue;
    const StudyResult result = run_study(asked, workers_, how);
    setup_.end_progress();
    if (result.interrupted) throw Interrupted{};
    std::map<std::string, const Row*> failed;
    for (const Row& row : result.rows)
      if (row.metric == "status" && row.status != Status::ok)
        failed.emplace(row.method + " " + std::to_string(row.steps), &row);
    for (std::size_t i = 0; i < asked.size(); ++i) {
      const auto failure = failed.find(asked[i].method + " " + std::to_string(asked[i].plan.steps));
      if (failure != failed.end() && refusal_.empty() && sides[i] == Side::ours)
        refusal_ = to_string(failure->second->status) + ": " + failure->second->reason;
      if (asked[i].worker < 0 || failure != failed.end()) continue;
      const bool of_ladder = goal.metric.starts_with("order-");  // all rungs have the one figure
      if (of_ladder && !candidates.empty() && candidates.back().cell->method == asked[i].method) continue;
      GoalEntrant entrant = entrant_of(asked[i], result.rows, goal);
      costly.note(entrant);
      if (!goal.metric.empty() && !std::isfinite(entrant.error)) {
        if (sides[i] == Side::ours && refusal_.empty()) refusal_ = why_no_figure(asked[i], result.rows, goal);
        continue;
      }
      const Side side = sides[i] == Side::rival && is_library(engine_of(asked[i].method)) ? Side::library : sides[i];
      cells.push_back(asked[i]);
      candidates.push_back({side, &cells.back(), entrant, {}});
    }
  }
  return candidates;
}

// The error of every candidate becomes that over all variants of the goal's scene. One that failed in a variant has no
// error.
void GoalRun::take_variants(const Goal& goal, const Scenario& scenario, std::vector<Candidate>& candidates) {
  std::map<std::string, std::vector<double>> errors;
  const auto key = [](const Candidate& c) { return c.cell->method + " " + std::to_string(c.cell->plan.steps); };
  for (const Candidate& c : candidates) errors[key(c)].push_back(c.entrant.error);
  const std::int64_t count = variant_count(goal), of_rivals = goal.rival_seeds > 0 ? goal.rival_seeds : count;
  for (std::int64_t k = 1; k < count; ++k) {
    std::vector<Cell> cells;
    cells.reserve(4096);
    for (const Candidate& c : measured(goal, variant_of(goal, scenario, k), k < of_rivals, cells))
      errors[key(c)].push_back(c.entrant.error);
  }
  for (Candidate& c : candidates) {
    c.entrant.error = combined_error(goal, errors[key(c)], is_rival(c.side) ? of_rivals : count);
    judge(c.entrant, goal);
  }
  std::erase_if(candidates, [](const Candidate& c) { return !std::isfinite(c.entrant.error); });
}

// Sets the wanted error to `error_ratio` times that of the most accurate rival, known when all have run. Rivals then
// count as accurate.
void ask_by_rivals(Goal& goal, std::vector<Candidate>& candidates) {
  double least = kNotMeasured;
  for (const Candidate& c : candidates) {
    if (is_rival(c.side) && !(c.entrant.error >= least)) least = c.entrant.error;
  }
  goal.error = goal.error_ratio * least;
  for (Candidate& c : candidates) c.entrant.accurate = is_rival(c.side) || c.entrant.error <= goal.error;
}

// Those of one side that are timed in turns: the quickest accurate ones, or else the most accurate one. `quickest`: the
// first cost of the quickest of ours, which is set where the side is ours.
std::vector<Candidate*> GoalRun::choose(const Goal& goal, Side side, std::vector<Candidate>& candidates,
                                        double& quickest) {
  const bool by_evaluations = goal.budget_kind == "evaluations", by_step = goal.budget_kind == "ns_per_step";
  std::vector<Candidate*> own;
  for (Candidate& c : candidates) {
    if (c.side == side && c.entrant.accurate) own.push_back(&c);
  }
  if (own.empty()) {  // none reaches the error: take the most accurate one
    Candidate* nearest = nullptr;
    for (Candidate& c : candidates) {
      if (c.side == side && (nearest == nullptr || c.entrant.error < nearest->entrant.error)) nearest = &c;
    }
    if (nearest != nullptr) own.push_back(nearest);
  }
  if (goal.limit_s > 0) return own;  // runs of minutes are timed once
  if (by_evaluations) {              // times are reported too
    std::erase_if(own, [&](const Candidate* c) { return own.size() > 1 && !std::isfinite(c->entrant.evaluations); });
  } else {
    if (goal.budget_kind == "seconds") leave_cheap(own);
    for (Candidate* c : own) c->entrant.seconds = stopwatch_.seconds(contender(*c));
    std::erase_if(own, [](const Candidate* c) { return !std::isfinite(c->entrant.seconds); });
  }
  const auto first_cost = [&](const Candidate& c) {
    if (by_evaluations) return c.entrant.evaluations;
    return by_step ? c.entrant.seconds / static_cast<double>(c.entrant.steps) : c.entrant.seconds;
  };
  std::vector<std::pair<double, Candidate*>> ranked;
  for (Candidate* c : own) ranked.emplace_back(first_cost(*c), c);
  std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  if (side == Side::ours && !ranked.empty()) quickest = ranked[0].first;
  const bool far = !ranked.empty() && ranked[0].first > kFar * quickest;
  std::vector<Candidate*> chosen;
  for (std::size_t i = 0; i < std::min(ranked.size(), kMaxTimed); ++i)
    if (i < (far ? 1 : kTimed) || ranked[i].first <= kMaxTimeRatio * ranked[0].first)
      chosen.push_back(ranked[i].second);
  for (Candidate* c : own)
    if (std::find(chosen.begin(), chosen.end(), c) == chosen.end()) c->entrant.seconds = kNotMeasured;
  return chosen;
}

// Times the chosen ones in turns, all of it again while the machine is busy and the goal judges times.
MachineState GoalRun::time(const Goal& goal, std::vector<Candidate>& candidates) {
  std::vector<Candidate*> chosen;
  double quickest = kNotMeasured, quickest_s = kNotMeasured;
  for (const Side side : {Side::ours, Side::rival, Side::uncounted, Side::library, Side::same_rate}) {
    for (Candidate* c : choose(goal, side, candidates, quickest)) {
      // again where the first time, which includes the start of a process, gave no number of repeats
      if (goal.limit_s == 0 && !(c->entrant.seconds > kLong)) c->entrant.seconds = stopwatch_.seconds(contender(*c));
      if (side == Side::ours && !(quickest_s <= c->entrant.seconds)) quickest_s = c->entrant.seconds;
      chosen.push_back(c);
    }
  }
  const auto is_far = [&](const Candidate& c) { return c.entrant.seconds > kFar * quickest_s; };
  std::vector<Contender> contenders;
  double round_s = 0;
  for (const Candidate* c : chosen) {
    contenders.push_back(contender(*c));
    if (is_far(*c)) contenders.back().most_rounds = kFarRounds;
    else round_s += std::isfinite(c->entrant.seconds) ? c->entrant.seconds : 0;
  }
  const bool judges_times = goal.budget_kind == "seconds" || goal.budget_kind == "ns_per_step" || goal.times_faster > 0;
  const int rounds = goal.limit_s > 0 ? 1 : round_s > 2 ? 3 : judges_times ? kRounds : kFarRounds;
  const auto take_turns = [&] {
    stopwatch_.take_machine();
    std::vector<std::vector<double>> times = stopwatch_.in_turns(contenders, rounds);
    return Measured<std::vector<std::vector<double>>>{std::move(times), stopwatch_.take_machine()};
  };
  const auto measured = judges_times ? calmest(take_turns) : take_turns();
  for (const auto& round : measured.figures) {
    for (std::size_t i = 0; i < chosen.size(); ++i) chosen[i]->times_s.push_back(round[i]);
  }
  for (Candidate* c : chosen) {
    c->entrant.seconds = median_time(c->times_s);
    if (goal.limit_s > 0 || method_family(c->entrant.method) == c->entrant.method)
      c->entrant.ns_per_step = 1e9 * c->entrant.seconds / static_cast<double>(c->entrant.steps);
  }
  return measured.machine;
}

Candidate* best(std::vector<Candidate>& candidates, Side side, const std::string& kind) {
  Candidate* found = nullptr;
  for (Candidate& c : candidates) {
    if (c.side == side && (found == nullptr || better(c.entrant, found->entrant, kind))) found = &c;
  }
  return found;
}

// The best of our candidates of this side whose error is not small at the end alone.
const Candidate* GoalRun::best_of_ours(const Goal& goal, Side side, std::vector<Candidate>& candidates,
                                       LastQuarter& quarter) {
  while (true) {
    Candidate* found = best(candidates, side, goal.budget_kind);
    if (found == nullptr || !found->entrant.accurate) return found;
    found->entrant.last_quarter = quarter.error(*found->cell);
    if (!(found->entrant.last_quarter > kCancelled * goal.error)) return found;
    found->entrant.accurate = false;
  }
}

// Other candidates that reach the error at nearly the cost of their side's best; nearly its error, where no cost is
// asked for.
void GoalRun::add_close(const Goal& goal, const std::vector<Candidate>& candidates, LastQuarter& quarter,
                        GoalResult& result) {
  const auto cost = [&](const GoalEntrant& entrant) {
    return goal.budget_kind.empty() ? std::fabs(entrant.error) : cost_of(entrant, goal.budget_kind);
  };
  for (const auto& [side, best] : {std::pair{Side::ours, &result.ours}, {Side::rival, &result.rival}}) {
    const double most = kClose * cost(*best);
    for (const Candidate& c : candidates) {
      const bool of_side = side == Side::ours ? c.side == side : is_rival(c.side);
      const bool is_best = c.entrant.method == best->method && c.entrant.steps == best->steps;
      if (!of_side || is_best || !c.entrant.accurate || !(cost(c.entrant) <= most)) continue;
      GoalEntrant entrant = c.entrant;
      entrant.last_quarter = quarter.error(*c.cell);
      if (side == Side::ours && entrant.last_quarter > kCancelled * goal.error) continue;
      result.close.push_back(entrant);
    }
  }
  std::stable_sort(result.close.begin(), result.close.end(), [&](const GoalEntrant& a, const GoalEntrant& b) {
    const bool ours = engine_of(a.method) == engine_of(result.ours.method);
    if (ours != (engine_of(b.method) == engine_of(result.ours.method))) return ours;
    return cost(a) < cost(b);
  });
}

std::string shortfall(const Goal& goal, const GoalEntrant& ours, const std::string& refusal) {
  if (ours.method.empty())
    return "none of our candidate methods has a figure" + (refusal.empty() ? "" : ": " + refusal);
  if (!ours.accurate && std::isfinite(goal.low))
    return fmt::format("from {:.4g} to {:.4g} is not inside", ours.error - ours.bar, ours.error + ours.bar);
  if (!ours.accurate && ours.error <= goal.error && std::isinf(ours.last_quarter))
    return "a state over the last quarter of the run is not finite";
  if (!ours.accurate && ours.error <= goal.error)
    return fmt::format(
        "the error over the last quarter of the run is {:.3g} times that of the goal, at most {:.3g} is "
        "allowed",
        ours.last_quarter / goal.error, kCancelled);
  if (!ours.accurate) return fmt::format("the error is {:.3g} times too large", ours.error / goal.error);
  const double cost = cost_of(ours, goal.budget_kind);
  if (!std::isfinite(cost))
    return goal.budget_kind == "evaluations" ? "the method counts no evaluations" : "the method was not timed";
  if (cost > goal.budget) return fmt::format("{:.3g} times over the budget", cost / goal.budget);
  return "";
}

// The ratio of times, or of times per step.
PairedRatio cost_ratio(const Candidate& rival, const Candidate& ours, const Goal& goal) {
  PairedRatio ratio = paired_ratio(rival.times_s, ours.times_s);
  if (goal.budget_kind != "ns_per_step") return ratio;
  const double per_step = static_cast<double>(ours.entrant.steps) / static_cast<double>(rival.entrant.steps);
  for (double* figure : {&ratio.ratio, &ratio.low, &ratio.high}) *figure *= per_step;
  return ratio;
}

GoalResult GoalRun::run(const Goal& asked) {
  Goal goal = asked;
  GoalResult result = blank_result(goal);
  for (const MetricInfo& metric : all_metrics()) {
    if (metric.name == goal.metric) result.unit = metric.unit;
  }
  Scenario scenario = setup_.scenario(goal.scenario);
  scenario.samples = goal.samples;
  if (!goal.steps.empty()) scenario.steps = goal.steps;
  if (goal.t_end_s > 0) scenario.t_end_s = goal.t_end_s;
  std::vector<Cell> cells;
  cells.reserve(4096);  // candidates keep pointers to them
  stopwatch_.allow(std::max(setup_.study.cell_limit_s, goal.limit_s));
  std::vector<Candidate> candidates = measured(goal, scenario, true, cells);
  if (variant_count(goal) > 1) take_variants(goal, scenario, candidates);
  if (goal.error_ratio > 0) ask_by_rivals(goal, candidates);
  result.wanted_error = goal.error;
  result.left_out = left_out_;
  if (setup_.study.timing && !goal.metric.starts_with("order-")) result.machine = time(goal, candidates);
  LastQuarter quarter(goal, workers_, setup_.study);
  const Candidate* ours = best_of_ours(goal, Side::ours, candidates, quarter);
  const Candidate* rival = best(candidates, Side::rival, goal.budget_kind);
  const Candidate* library = best(candidates, Side::library, goal.budget_kind);
  const Candidate* same_rate = best_of_ours(goal, Side::same_rate, candidates, quarter);
  if (rival == nullptr || (library != nullptr && better(library->entrant, rival->entrant, goal.budget_kind)))
    rival = library;
  const Candidate* uncounted = best(candidates, Side::uncounted, goal.budget_kind);
  if (ours != nullptr) result.ours = ours->entrant;
  if (rival != nullptr) result.rival = rival->entrant;
  if (uncounted != nullptr) result.uncounted = uncounted->entrant;
  if (rival != nullptr) result.rival.last_quarter = quarter.error(*rival->cell);
  add_close(goal, candidates, quarter, result);
  result.why = shortfall(goal, result.ours, refusal_);
  if (goal.budget_kind.empty() && result.ours.accurate) result.why.clear();
  result.reached = result.why.empty();
  if (ours != nullptr && rival != nullptr && ours->entrant.accurate && rival->entrant.accurate) {
    if (goal.budget_kind == "evaluations") {
      result.ratio = result.ratio_low = result.ratio_high = rival->entrant.evaluations / ours->entrant.evaluations;
    } else {
      const PairedRatio ratio = cost_ratio(*rival, *ours, goal);
      result.ratio = ratio.ratio, result.ratio_low = ratio.low, result.ratio_high = ratio.high;
    }
  }
  if (library != nullptr && same_rate != nullptr && goal.budget_kind != "evaluations") {
    result.library = library->entrant;
    result.same_rate = same_rate->entrant;
    if (library->entrant.accurate && same_rate->entrant.accurate) {
      const PairedRatio ratio = cost_ratio(*library, *same_rate, goal);
      result.same_rate_ratio = ratio.ratio, result.same_rate_low = ratio.low, result.same_rate_high = ratio.high;
    }
  }
  if (goal.times_faster > 0 && result.reached && !(result.ratio >= goal.times_faster)) {
    result.reached = false;
    result.why = std::isfinite(result.ratio) ? fmt::format("ours is {:.3g} times as fast as the rival", result.ratio)
                                             : "no rival was timed";
  }
  return result;
}

}  // namespace

GoalResult run_goal(const GoalSetup& setup, const Goal& goal) { return GoalRun(setup).run(goal); }

}  // namespace atwood
