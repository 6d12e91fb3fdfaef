// The timed pass of a study: one process at a time, pinned to a processor.
#include <algorithm>
#include <map>
#include <optional>
#include <set>

#include "scene/files.hpp"
#include "validation/study/short_text.hpp"
#include "validation/study/study_run.hpp"

namespace atwood {
namespace {

// The timed pass of one cell takes about this long: long runs are repeated less often.
constexpr double kTimedBudgetNs = 50e6;
// A run longer than this is not timed if a coarser rung of its ladder was: that one gives the time of a step.
constexpr std::int64_t kLongRunNs = 250'000'000;

}  // namespace

std::vector<const Cell*> StudyRun::cells_to_time() {
  std::map<int, std::vector<const Cell*>> by_worker;  // one process after another
  std::set<std::string> timed_ladders;
  for (const Cell& cell : cells_) {
    if (cell.worker < 0) continue;
    const CellKeys keys = campaigns_.keys(cell);
    const auto run = store_.run(keys.accuracy);
    if (!run || run->outcome.status != Status::ok) continue;
    if (cell.probe != Probe::none) continue;
    const bool first =
        timed_ladders.insert(cell.scenario->id + "\n" + cell.method + "\n" + resolution_text(resolution_of(cell)))
            .second;
    if (run->wall_ns > kLongRunNs && !first) continue;
    if (cell.repeats > 0 && (options_.fresh || !store_.timing(keys.timing))) by_worker[cell.worker].push_back(&cell);
  }
  std::vector<const Cell*> cells;
  for (const auto& [worker, some] : by_worker) cells.insert(cells.end(), some.begin(), some.end());
  return cells;
}

void StudyRun::timed_pass() {
  const std::vector<const Cell*> cells = cells_to_time();
  for (const Cell* cell : cells) touched_[index_of(*cell)] = true;
  std::optional<WorkerClient> client;
  int worker = -1;
  std::string scene_id, scene_json;
  for (const Cell* cell : cells) {
    if (interrupt_signal() != 0) break;
    if (cell->worker != worker) {
      worker = cell->worker;
      client.reset();
      const Worker& next = workers_[static_cast<std::size_t>(worker)];
      client.emplace(next, true);
    }
    const std::string id = cell->scenario->id + "\n" + resolution_text(resolution_of(*cell));
    if (scene_id != id) {
      scene_id = id;
      scene_json = scene_to_json(cell->scenario->scene);
    }
    const CellKeys keys = campaigns_.keys(*cell);
    const auto run = store_.run(keys.accuracy);
    const double expected_ns = std::max(1.0, static_cast<double>(run->wall_ns));
    const int repeats =
        static_cast<int>(std::clamp(kTimedBudgetNs / expected_ns, 1.0, static_cast<double>(cell->repeats)));
    TimingRecord timing;
    timing.provenance = options_.provenance;
    timing.host = options_.host;
    timing.provenance.engine_version = workers_[static_cast<std::size_t>(worker)].engine.version;
    try {
      timing.outcome = client
                           ->run(cell->method, scene_json, sampled_bodies(cell->scenario->scene), own_plan(*cell),
                                 repeats, limit_of(*cell, options_) * repeats)
                           .outcome;
    } catch (const Interrupted&) {
      break;
    }
    timing.outcome.reason = shortened(timing.outcome.reason, kLongestReason);
    if (!client->killed_from_outside()) store_.put_timing(keys.timing, keys.accuracy, timing);
    ++timed_;
    progress_.done("timing");
  }
}

std::vector<Reused> StudyRun::reused() const {
  std::map<int, Reused> by_worker;
  for (const Cell& cell : cells_) {
    if (cell.worker < 0) continue;
    const Worker& worker = workers_[static_cast<std::size_t>(cell.worker)];
    Reused& reused = by_worker[cell.worker];
    if (reused.cells == 0) reused.engine = worker.engine.name;
    ++reused.cells;
    reused.reused += ran_[index_of(cell)] ? 0 : 1;
    if (!cell.campaign.empty() && reused.campaign.empty())
      reused.campaign = campaigns_.origin(cell) +
                        ", because not all of the code behind its results is known: " + worker.unknown_code +
                        ". Send \"fingerprint\" in hello to let results be reused";
  }
  std::vector<Reused> all;
  for (auto& [worker, reused] : by_worker) all.push_back(std::move(reused));
  Reused truths{"truth", 0, 0};
  for (const TruthWork& work : truths_) {
    if (work.scenario->truth.kind == TruthKind::none || !work.scenario->scene.fluids.empty()) continue;
    ++truths.cells;
    truths.reused += work.reused ? 1 : 0;
  }
  if (truths.cells > 0) all.push_back(truths);
  return all;
}

std::string reused_text(const std::vector<Reused>& reused) {
  std::string text, campaigns;
  for (const Reused& each : reused) {
    const std::string name = printable(each.engine);
    text += (text.empty() ? "reused from the store: " : ", ") + name + " " + std::to_string(each.reused) + " of " +
            std::to_string(each.cells) + (each.engine == "truth" ? " scenes" : " cells");
    if (!each.campaign.empty()) campaigns += "\n" + name + ": " + each.campaign;
  }
  return text + campaigns;
}

}  // namespace atwood
