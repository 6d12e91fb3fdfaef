#include "benchmarks/goal_candidates.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <set>

#include "benchmarks/rates.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

// The ids that globs and ":tol" stand for.
std::vector<std::string> spelled_out(const std::vector<std::string>& patterns, const std::vector<double>& tolerances) {
  std::vector<std::string> methods;
  for (const std::string& pattern : patterns) {
    const std::size_t at = pattern.find(":tol");
    if (at == std::string::npos) methods.push_back(pattern);
    else
      for (const double rtol : tolerances)
        methods.push_back(pattern.substr(0, at) + ":" + format_double(rtol) + pattern.substr(at + 4));
  }
  return methods;
}

std::vector<Cell> plan_goal(const Goal& goal, const Scenario& scenario, const std::vector<std::string>& patterns,
                            bool rivals, const std::vector<Worker>& workers, const std::string& cpu) {
  Study study{goal.id, {}};
  StudyCells equal, adaptive;
  for (const std::string& method : spelled_out(patterns, goal.tolerances)) {
    (method_family(method) == method ? equal : adaptive).methods.push_back(method);
  }
  equal.scenarios = adaptive.scenarios = {"*"};
  equal.repeats = adaptive.repeats = 0;
  // A ladder of spacings takes its steps from the scenario, refined with the spacing.
  if (goal.spacings_m.size() < 2) equal.steps = rivals && !goal.rival_steps.empty() ? goal.rival_steps : goal.steps;
  equal.spacings_m = adaptive.spacings_m = goal.spacings_m;
  if (goal.sound_speed_m_per_s > 0)
    equal.sound_speeds_m_per_s = adaptive.sound_speeds_m_per_s = {goal.sound_speed_m_per_s};
  adaptive.steps = {goal.first_steps * goal.samples / std::max<std::int64_t>(1, goal.samples)};
  adaptive.steps[0] -= adaptive.steps[0] % goal.samples;
  adaptive.steps[0] = std::max(adaptive.steps[0], goal.samples);
  if (!equal.methods.empty() && !goal.steps.empty()) study.cells.push_back(equal);
  if (!adaptive.methods.empty()) study.cells.push_back(adaptive);
  if (study.cells.empty()) return {};
  return plan_cells(study, {scenario}, workers, cpu);
}

// Our candidates with the reference's rate, where a library is among the rivals and times are compared.
std::vector<std::string> twins_beside_libraries(const Goal& goal) {
  const bool beside = std::any_of(goal.rivals.begin(), goal.rivals.end(),
                                  [](const std::string& rival) { return is_library(engine_of(rival)); });
  if (!beside || goal.budget_kind == "evaluations") return {};
  std::vector<std::string> twins;
  for (const std::string& method : goal.methods) {
    if (engine_of(method) == "atwood" && method.find('+') == std::string::npos)
      twins.push_back("atwood-same-rate" + method.substr(method.find('/')));
  }
  return twins;
}

bool counted(double evaluations) { return std::isfinite(evaluations) && evaluations > 0; }

}  // namespace

std::vector<std::vector<PlannedCell>> plan_waves(const Goal& goal, const Scenario& scenario, bool with_rivals,
                                                 const std::vector<Worker>& workers, const std::string& cpu) {
  const std::size_t first = (goal.tolerances.size() + 1) / 2;
  std::vector<std::vector<PlannedCell>> waves(1 + goal.tolerances.size() - first);
  std::set<std::string> known;
  const std::vector<std::string> twins = twins_beside_libraries(goal);
  for (const auto& [side, patterns] : {std::pair{Side::uncounted, &goal.uncounted},
                                       {Side::ours, &goal.methods},
                                       {Side::rival, &goal.rivals},
                                       {Side::same_rate, &twins}}) {
    if (patterns->empty() || (side == Side::rival && !with_rivals)) continue;
    std::vector<std::string> with_tolerance;
    std::copy_if(patterns->begin(), patterns->end(), std::back_inserter(with_tolerance),
                 [](const std::string& pattern) { return pattern.find(":tol") != std::string::npos; });
    for (std::size_t wave = 0; wave < waves.size(); ++wave) {
      Goal part = goal;
      const auto from = goal.tolerances.begin();
      if (wave == 0) part.tolerances.assign(from, from + static_cast<std::ptrdiff_t>(first));
      else part.tolerances = {goal.tolerances[first + wave - 1]};
      for (Cell& cell :
           plan_goal(part, scenario, wave == 0 ? *patterns : with_tolerance, side == Side::rival, workers, cpu))
        if (known.insert(cell.method + " " + std::to_string(cell.plan.steps)).second)
          waves[wave].push_back({std::move(cell), side});
    }
  }
  return waves;
}

void CostlyRungs::note(const GoalEntrant& entrant) {
  if (!counted(entrant.evaluations)) return;
  double& most = of_family_.emplace(method_family(entrant.method), entrant.evaluations).first->second;
  most = std::max(most, entrant.evaluations);
  if (!entrant.accurate) return;
  double& least = of_engine_.emplace(engine_of(entrant.method), entrant.evaluations).first->second;
  least = std::min(least, entrant.evaluations);
}

bool CostlyRungs::leaves_out(const PlannedCell& planned) const {
  if (!is_rival(planned.side) || method_family(planned.cell.method) == planned.cell.method) return false;
  const auto most = of_family_.find(method_family(planned.cell.method));
  const auto least = of_engine_.find(engine_of(planned.cell.method));
  return most != of_family_.end() && least != of_engine_.end() && most->second > kMaxEvaluations * least->second;
}

void leave_cheap(std::vector<Candidate*>& accurate) {
  std::map<std::string, double> of_engine;
  std::map<std::string, std::vector<double>> of_family;
  for (const Candidate* c : accurate) {
    if (!counted(c->entrant.evaluations)) continue;
    double& least = of_engine.emplace(engine_of(c->entrant.method), c->entrant.evaluations).first->second;
    least = std::min(least, c->entrant.evaluations);
    of_family[method_family(c->entrant.method)].push_back(c->entrant.evaluations);
  }
  for (auto& [family, evaluations] : of_family) std::sort(evaluations.begin(), evaluations.end());
  std::erase_if(accurate, [&](const Candidate* c) {
    const double own = c->entrant.evaluations;
    if (!counted(own)) return false;
    if (is_rival(c->side) && own > kMaxEvaluations * of_engine.at(engine_of(c->entrant.method))) return true;
    const std::vector<double>& rungs = of_family.at(method_family(c->entrant.method));
    return own > kFinerRungs * rungs.front() && own > rungs[std::min<std::size_t>(1, rungs.size() - 1)];
  });
}

}  // namespace atwood
