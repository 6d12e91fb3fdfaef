#include "benchmarks/turn_times.hpp"

#include <cmath>

namespace atwood {
namespace {

double rung_seconds(const std::vector<Row>& rows, const Cell& cell) {
  for (const Row& row : rows) {
    if (row.metric == "run-time" && row.scenario == cell.scenario->id && row.method == cell.method &&
        row.steps == cell.plan.steps && resolution_of(row) == resolution_of(cell))
      return row.value;
  }
  return 0;
}

}  // namespace

const Cell* TurnTimes::find_cell(const std::string& scenario, const Reached& reached) const {
  for (const Cell& cell : cells_) {
    if (cell.worker >= 0 && cell.scenario->id == scenario && cell.method == reached.method &&
        cell.plan.steps == reached.steps && resolution_of(cell) == reached.at)
      return &cell;
  }
  return nullptr;
}

Contender TurnTimes::contender(const Cell& cell, double seconds) const {
  return {&workers_[static_cast<std::size_t>(cell.worker)], cell.method, &cell.scenario->scene, cell.plan, seconds, 0};
}

const TurnTimes::Turns& TurnTimes::measured(const Cell& a, const Cell& b, double a_s, double b_s) {
  const auto [place, fresh] = known_.try_emplace({&a, &b});
  if (!fresh) return place->second;
  for (const auto& round : stopwatch_.in_turns({contender(a, a_s), contender(b, b_s)}, kPairs)) {
    if (!std::isfinite(round[0]) || !std::isfinite(round[1])) continue;
    place->second.first.push_back(round[0]);
    place->second.second.push_back(round[1]);
  }
  return place->second;
}

void TurnTimes::settle(Contest& contest, const std::string& scenario, bool of_error, double most_s) {
  if (contest.ranked.size() < 2) return;
  const Cell *a = find_cell(scenario, contest.ranked[0]), *b = find_cell(scenario, contest.ranked[1]);
  if (a == nullptr || b == nullptr) return;
  const double a_s = rung_seconds(rows_, *a), b_s = rung_seconds(rows_, *b);
  if (!(a_s > 0) || !(b_s > 0) || a_s + b_s > most_s) return;
  const Turns& turns = measured(*a, *b, a_s, b_s);
  if (turns.first.size() < 5) return;
  PairedRatio ratio = paired_ratio(turns.second, turns.first);
  if (!std::isfinite(ratio.ratio)) return;
  if (of_error && ratio.high < kClearlyQuicker) {
    std::swap(contest.ranked[0], contest.ranked[1]);
    contest.ranked[0].cost = median_time(turns.second);
    contest.ranked[1].cost = median_time(turns.first);
    ratio = paired_ratio(turns.first, turns.second);
  }
  contest.to_next = TimedRatio{ratio.ratio, ratio.low, ratio.high, static_cast<int>(turns.first.size())};
}

}  // namespace atwood
