#include "benchmarks/overheads.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "benchmarks/rates.hpp"
#include "benchmarks/stopwatch.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

constexpr std::array kRepeats{1, 2, 4, 8};
constexpr double kBestRun_s = 1e-3;  // long enough for the clock, short enough for many rounds
constexpr std::size_t kMaxFamilies = 8;

// The rung at which a method's overhead on a scenario is measured.
struct Family {
  std::string scenario, family;
  const Cell* cell = nullptr;
  double seconds = 0, evaluations = 0;
};

// In the order of the cells.
std::vector<Family> choose_rungs(const std::vector<Cell>& cells, const std::vector<Row>& rows) {
  std::map<std::pair<std::string, std::string>, std::size_t> index;  // by scenario and family
  std::vector<Family> families;
  for (const Cell& cell : cells) {
    if (cell.worker < 0 || !runs_at_reference_rate(cell.method) || engine_of(cell.method) == "ida") continue;
    double seconds = 0, evaluations = 0;
    for (const Row& row : rows) {
      if (row.scenario != cell.scenario->id || row.method != cell.method || row.steps != cell.plan.steps) continue;
      if (row.metric == "run-time") seconds = row.value;
      if (row.metric == "rate-evaluations") evaluations = row.value;
    }
    if (!(seconds > 0) || !(evaluations > 0)) continue;
    const std::pair key{cell.scenario->id, method_family(cell.method)};
    const auto [at, fresh] = index.emplace(key, families.size());
    if (fresh) families.push_back({key.first, key.second});
    Family& chosen = families[at->second];
    const auto distance = [](double s) { return std::fabs(std::log(s / kBestRun_s)); };
    if (chosen.cell == nullptr || distance(seconds) < distance(chosen.seconds)) {
      chosen.cell = &cell;
      chosen.seconds = seconds;
      chosen.evaluations = evaluations;
    }
  }
  if (families.size() > kMaxFamilies) families.resize(kMaxFamilies);
  return families;
}

}  // namespace

std::vector<MethodOverhead> measure_overheads(const std::vector<Cell>& cells, const std::vector<Worker>& workers,
                                              const std::vector<Row>& rows, double limit_s) {
  const std::vector<Family> families = choose_rungs(cells, rows);
  std::vector<MethodOverhead> overheads;
  std::vector<Contender> contenders;
  for (const Family& chosen : families) {
    overheads.push_back(
        {chosen.scenario, chosen.family, chosen.cell->method, chosen.cell->plan.steps, chosen.evaluations, {}, false});
    for (const int repeats : kRepeats) {
      MethodId id = parse_method_id(chosen.cell->method);
      id.overrides["rate_repeats"] = std::int64_t(repeats);
      contenders.push_back({&workers[static_cast<std::size_t>(chosen.cell->worker)], to_string(id),
                            &chosen.cell->scenario->scene, chosen.cell->plan, chosen.seconds * repeats,
                            chosen.evaluations});
    }
  }
  Stopwatch stopwatch(limit_s);
  const auto rounds = stopwatch.in_turns(contenders, kRounds);
  const bool machine_was_busy = busy(stopwatch.take_machine());
  for (std::size_t i = 0; i < overheads.size(); ++i) {
    overheads[i].busy = machine_was_busy;
    std::vector<std::vector<double>> ns;
    for (const auto& round : rounds) {
      const auto from = round.begin() + static_cast<std::ptrdiff_t>(i * kRepeats.size());
      ns.emplace_back(from, from + kRepeats.size());
      for (double& t : ns.back()) t *= 1e9 / overheads[i].evaluations;
    }
    overheads[i].fit = fit_overhead(kRepeats, ns);
  }
  std::erase_if(overheads, [](const MethodOverhead& one) { return one.fit.rounds == 0; });
  return overheads;
}

}  // namespace atwood
