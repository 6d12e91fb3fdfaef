#include "validation/study/load_rows.hpp"

#include <algorithm>
#include <functional>
#include <future>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <thread>
#include <tuple>
#include <unordered_map>
#include <unordered_set>

#include "scene/files.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/joints.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/study/content_hash.hpp"

namespace atwood {
namespace {

constexpr unsigned kMaxReaders = 4;         // connections that visit_ladders reads by
constexpr std::size_t kLaddersAtOnce = 32;  // of a connection

bool failed(Status status) { return status == Status::crashed || status == Status::timeout; }

void append(std::vector<Row>& rows, Row row, const Cell& cell, const SharedProvenance& provenance) {
  row.scenario = cell.scenario->id;
  row.method = cell.method;
  row.steps = cell.plan.steps;
  row.h_s = cell.plan.t_end_s / static_cast<double>(cell.plan.steps);
  row.spacing_m = cell.spacing_m;
  row.sound_speed_m_per_s = cell.sound_speed_m_per_s;
  row.settings_hash = cell.settings_hash;
  row.provenance = provenance;
  rows.push_back(std::move(row));
}

Row failure_row(const std::string& metric, Status status, const std::string& reason) {
  Row row = metrics::row(metric, 0);
  row.unit = "";
  row.status = status;
  row.reason = reason;
  return row;
}

// ns-per-particle-evaluation of a cell with fluids, from its run-time; none where the engine counts no evaluations.
std::vector<Row> particle_time_rows(const Cell& cell, const Outcome& outcome, const std::vector<Row>& timed,
                                    std::span<const Row> measured) {
  double particles = 0;
  for (const Fluid& fluid : cell.scenario->scene.fluids)
    particles += static_cast<double>(fluid.particles.mass_kg.size());
  const auto evaluations = static_cast<double>(outcome.rate_evaluations);
  std::vector<Row> rows;
  for (const Row& run : timed) {
    if (run.metric != "run-time" || !(particles > 0) || !(evaluations > 0)) continue;
    std::string reason = std::to_string(static_cast<std::int64_t>(particles)) + " particles, " +
                         std::to_string(outcome.rate_evaluations) + " evaluations";
    for (const Row& row : measured)
      if (row.metric == "neighbours") reason += ", " + format_measure(row.value, 0, 3) + " neighbours";
    const double scale = 1e9 / (particles * evaluations);
    rows.push_back(metrics::row("ns-per-particle-evaluation", run.value * scale, run.truth_bar * scale, reason));
  }
  return rows;
}

// The time of a step shared out among the bodies that joints or ropes hold.
std::vector<Row> link_time_rows(const Scene& scene, const std::vector<Row>& timed) {
  const int links = linked_bodies(scene);
  std::vector<Row> rows;
  for (const Row& step : timed)
    if (step.metric == "step-time" && links > 0)
      rows.push_back(metrics::row("step-time-per-link", step.value / links, step.truth_bar / links,
                                  std::to_string(links) + " links"));
  return rows;
}

// The cell's other rows are those of the result from `first` on.
void append_timing(Store& store, const Cell& cell, const std::string& timing_hash, std::int64_t accuracy_steps,
                   std::size_t first, StudyResult& result) {
  auto timing = store.timing(timing_hash);
  if (!timing) return;
  if (!timing->host.empty()) result.hosts.insert(timing->host);
  timing->provenance.host = timing->host;
  const SharedProvenance provenance(std::move(timing->provenance));
  const Outcome& outcome = timing->outcome;
  if (outcome.status != Status::ok) {
    append(result.rows, failure_row("step-time", outcome.status, outcome.reason), cell, provenance);
    if (failed(outcome.status)) ++result.failed_cells;
    return;
  }
  // The number of steps of an adaptive method is not the plan's.
  const bool adaptive = parse_method_id(cell.method).rtol.has_value() && accuracy_steps > 0;
  std::vector<Row> rows = timing_rows(outcome, adaptive ? accuracy_steps : cell.plan.steps);
  for (Row& row : particle_time_rows(cell, outcome, rows, std::span(result.rows).subspan(first)))
    rows.push_back(std::move(row));
  for (Row& row : link_time_rows(cell.scenario->scene, rows)) rows.push_back(std::move(row));
  for (Row& row : rows) append(result.rows, std::move(row), cell, provenance);
}

// False: the store does not have the cell although an available engine can run it. `outcome`: how its run ended;
// untouched where it has none.
bool append_cell(Store& store, const Cell& cell, const CellKeys& keys, StudyResult& result,
                 std::optional<Outcome>& outcome) {
  if (cell.worker < 0) {
    append(result.rows, failure_row("status", cell.absent, cell.absent_reason), cell, {});
    if (failed(cell.absent)) ++result.failed_cells;
    ++result.skipped;
    return true;
  }
  const auto run = store.run(keys.accuracy);
  if (!run) return false;
  outcome = run->outcome;
  auto measured = store.measured(keys.measured, true, false);
  if (!measured) return false;
  ++result.skipped;
  const SharedProvenance provenance(run->provenance);
  const std::size_t first = result.rows.size();
  for (Row& row : measured->rows) append(result.rows, std::move(row), cell, provenance);
  // Of equal steps too where there is no other figure (no truth, no invariant): a cell that ended well has a row.
  const bool chooses_steps = parse_method_id(cell.method).rtol.has_value(), alone = result.rows.size() == first;
  if ((chooses_steps || alone) && run->outcome.status == Status::ok && run->outcome.steps_taken > 0) {
    append(result.rows, metrics::row("steps-taken", static_cast<double>(run->outcome.steps_taken)), cell, provenance);
  }
  if (failed(run->outcome.status)) ++result.failed_cells;
  append_timing(store, cell, keys.timing, run->outcome.steps_taken, first, result);
  return true;
}

// Calls `read`; the StoreDamage that it throws names the cell and what to do about it.
template <class Read> void of_cell(const Cell& cell, Read read) {
  try {
    read();
  } catch (const StoreDamage& error) {
    throw StoreDamage(std::string(error.what()) + "; damaged is the cell " + cell.scenario->id + ", " + cell.method +
                      ", " + std::to_string(cell.plan.steps) +
                      " steps: `atwood run` measures it again, `atwood doctor --check-store` lists all damage");
  }
}

Campaigns latest_campaigns(Store& store, const std::vector<Cell>& cells, const std::string& purpose) {
  try {
    return Campaigns::latest(store, cells, purpose);
  } catch (const StoreDamage& error) {
    throw StoreDamage(std::string(error.what()) + "; the next `atwood run` starts a new campaign");
  }
}

// A ladder of steps: scenario, method, and the particles' resolution.
using LadderKey = std::tuple<std::string, std::string, Resolution>;
LadderKey ladder_of(const Row& row) { return {row.scenario, row.method, resolution_of(row)}; }

// The end states of the runs of each ladder; methods with a tolerance are left out. One outcome a cell.
std::map<LadderKey, std::vector<LadderEnd>> ladder_ends(Store& store, const std::vector<Cell>& cells,
                                                        const Campaigns& campaigns,
                                                        const std::vector<std::optional<Outcome>>& outcomes) {
  std::map<LadderKey, std::vector<LadderEnd>> ends;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& cell = cells[i];
    if (!outcomes[i] || outcomes[i]->status != Status::ok) continue;
    if (cell.worker < 0 || cell.probe != Probe::none || cell.method.find(':') != std::string::npos) continue;
    const std::string hash = campaigns.keys(cell).accuracy;
    Recording recording;
    of_cell(cell, [&] { recording = store.recording(hash, *outcomes[i]); });
    if (recording.values.empty()) continue;
    ends[{cell.scenario->id, cell.method, resolution_of(cell)}].push_back(
        {cell.plan.steps, cell.plan.t_end_s / static_cast<double>(cell.plan.steps), copy_of(recording.values.back()),
         cell.claimed_order});
  }
  return ends;
}

// Orders of fluids, of the rows of each scenario and method at all its resolutions together.
void append_fluid_orders(StudyResult& result) {
  std::vector<std::pair<std::string, std::string>> order;
  std::map<std::pair<std::string, std::string>, std::vector<Row>> ladders;
  for (const Row& row : result.rows) {
    if (!row.spacing_m || row.steps == 0) continue;
    auto& ladder = ladders[{row.scenario, row.method}];
    if (ladder.empty()) order.emplace_back(row.scenario, row.method);
    ladder.push_back(row);
  }
  for (const auto& key : order)
    for (Row& row : fit_fluid_orders(ladders[key])) result.rows.push_back(std::move(row));
}

bool same_ladder(const Row& a, const Row& b) {
  return a.scenario == b.scenario && a.method == b.method && resolution_of(a) == resolution_of(b);
}

void append_ladders(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns,
                    const std::vector<std::optional<Outcome>>& outcomes, StudyResult& result) {
  std::vector<LadderKey> order;
  std::map<LadderKey, std::vector<Row>> copies;
  std::map<LadderKey, std::span<const Row>> ladders;
  std::map<std::pair<std::string, Resolution>, std::vector<Row>> scenarios;
  const std::span<const Row> rows = result.rows;
  const auto of_first = [&](const Row& row) { return same_ladder(row, rows.front()); };
  if (!rows.empty() && std::all_of(rows.begin(), rows.end(), of_first)) {
    order.push_back(ladder_of(rows.front()));
    ladders[order.front()] = rows;
  } else {
    for (const Row& row : rows) {
      auto& ladder = copies[ladder_of(row)];
      if (ladder.empty()) order.push_back(ladder_of(row));
      ladder.push_back(row);
    }
    for (const auto& [key, ladder] : copies) ladders[key] = ladder;
  }
  for (const Row& row : rows)
    if (row.method.find(':') != std::string::npos) scenarios[{row.scenario, resolution_of(row)}].push_back(row);
  const auto ends = ladder_ends(store, cells, campaigns, outcomes);
  std::vector<Row> figures;  // of the ladders
  std::map<std::string, const Scenario*> by_id;
  std::map<LadderKey, LadderInstants> instants;
  for (const Cell& cell : cells) {
    by_id[cell.scenario->id] = cell.scenario.get();
    if (cell.probe != Probe::none || cell.worker < 0) continue;
    LadderInstants& of_ladder = instants[{cell.scenario->id, cell.method, resolution_of(cell)}];
    of_ladder.samples = cell.scenario->samples;
    of_ladder.shared[cell.plan.steps] = cell.plan.samples;
  }
  for (const auto& key : order) {
    const std::span<const Row> ladder = ladders[key];
    std::vector<Row> fitted = fit_ladder(ladder, instants[key]);
    const auto append_all = [&](std::vector<Row> more) { fitted.insert(fitted.end(), more.begin(), more.end()); };
    append_all(fit_round_off_v(ladder));
    if (const auto found = ends.find(key); found != ends.end())
      append_all(fit_ends(*by_id[std::get<0>(key)], found->second, ladder));
    for (Row& row : fitted) {
      row.scenario = std::get<0>(key);
      row.method = std::get<1>(key);
      row.spacing_m = std::get<2>(key).first;
      row.sound_speed_m_per_s = std::get<2>(key).second;
      row.settings_hash = ladder.front().settings_hash;
      row.provenance = ladder.front().provenance;
      figures.push_back(std::move(row));
    }
  }
  std::move(figures.begin(), figures.end(), std::back_inserter(result.rows));
  for (const auto& [scenario, some] : scenarios)
    for (Row& row : fit_tolerances(some)) {
      row.spacing_m = scenario.second.first;
      row.sound_speed_m_per_s = scenario.second.second;
      result.rows.push_back(std::move(row));
    }
  append_fluid_orders(result);
}

}  // namespace

std::string measured_key(const Cell& cell, const std::string& accuracy_hash) {
  const Scenario& scenario = *cell.scenario;
  std::string judged;
  for (const std::string& tag : scenario.tags) judged += tag + "\n";
  judged += "\n";
  for (const Invariant& invariant : scenario.invariants) judged += invariant.quantity + "\n";
  return content_hash({"measured 1", accuracy_hash, scenario.id, judged,
                       std::to_string(static_cast<int>(scenario.truth.kind)), scenario.truth.solution,
                       scenario.truth.file});
}

StudyResult collect_rows(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns) {
  StudyResult result;
  result.cells = static_cast<int>(cells.size());
  std::vector<std::optional<Outcome>> outcomes(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i) {
    of_cell(cells[i], [&] {
      if (!append_cell(store, cells[i], campaigns.keys(cells[i]), result, outcomes[i])) result.missing.push_back(i);
    });
  }
  append_ladders(store, cells, campaigns, outcomes, result);
  return result;
}

StudyResult collect_endings(Store& store, const std::vector<Cell>& cells, const Campaigns& campaigns) {
  StudyResult result, one;
  result.cells = static_cast<int>(cells.size());
  const std::unordered_set<std::string> bad = store.not_ok();
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const CellKeys keys = campaigns.keys(cells[i]);
    const bool plain = cells[i].worker >= 0 && cells[i].probe == Probe::none;
    if (plain && store.has(keys) && !bad.contains(keys.accuracy) && !bad.contains(keys.timing)) {
      ++one.skipped;
      continue;
    }
    one.rows.clear();
    of_cell(cells[i], [&] {
      std::optional<Outcome> outcome;
      if (!append_cell(store, cells[i], keys, one, outcome)) result.missing.push_back(i);
    });
    for (Row& row : one.rows)
      if (row.status != Status::ok) result.rows.push_back(std::move(row));
  }
  result.skipped = one.skipped;
  result.failed_cells = one.failed_cells;
  return result;
}

StudyResult load_rows(const std::string& store_path, const std::vector<Cell>& cells, const std::string& purpose) {
  StudyResult nothing;
  nothing.cells = static_cast<int>(cells.size());
  for (std::size_t i = 0; i < cells.size(); ++i)
    if (cells[i].worker >= 0) nothing.missing.push_back(i);
  if (!store_exists(store_path)) return nothing;
  Store store(store_path, Store::Mode::read);
  return store.empty() ? nothing : collect_rows(store, cells, latest_campaigns(store, cells, purpose));
}

void visit_ladders(const std::string& store_path, const std::vector<Cell>& cells, const VisitLadder& visit,
                   const std::string& purpose) {
  std::unordered_map<std::string, std::size_t> index;
  std::vector<std::vector<std::size_t>> ladders;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const bool tolerance = cells[i].method.find(':') != std::string::npos;
    const std::string name = cells[i].scenario->id + "\n" + (tolerance ? ":" : cells[i].method);
    const auto [place, fresh] = index.emplace(name, ladders.size());
    if (fresh) ladders.emplace_back();
    ladders[place->second].push_back(i);
  }
  index.clear();
  if (!store_exists(store_path)) return;
  // Several connections read ahead, a batch of ladders each; the batches are visited in their order.
  std::vector<std::unique_ptr<Store>> stores(std::clamp(std::thread::hardware_concurrency(), 1U, kMaxReaders));
  stores.front() = std::make_unique<Store>(store_path, Store::Mode::read);
  if (stores.front()->empty()) return;
  const Campaigns campaigns = latest_campaigns(*stores.front(), cells, purpose);
  const auto read_batch = [&](std::unique_ptr<Store>& store, std::span<const std::vector<std::size_t>> batch) {
    if (!store) store = std::make_unique<Store>(store_path, Store::Mode::read);
    std::vector<StudyResult> results;
    for (const std::vector<std::size_t>& which : batch) {
      std::vector<Cell> some;
      for (const std::size_t i : which) some.push_back(cells[i]);
      results.push_back(collect_rows(*store, some, campaigns));
      for (std::size_t& missing : results.back().missing) missing = which[missing];
    }
    return results;
  };
  const std::size_t batches = (ladders.size() + kLaddersAtOnce - 1) / kLaddersAtOnce, readers = stores.size();
  const auto ladders_of = [&](std::size_t batch) {
    const std::size_t first = batch * kLaddersAtOnce;
    return std::span(ladders).subspan(first, std::min(kLaddersAtOnce, ladders.size() - first));
  };
  std::vector<std::future<std::vector<StudyResult>>> reading(readers);
  for (std::size_t batch = 0; batch < batches + readers; ++batch) {
    std::future<std::vector<StudyResult>>& slot = reading[batch % readers];
    std::vector<StudyResult> results;
    if (batch >= readers) results = slot.get();
    if (batch < batches)
      slot = std::async(std::launch::async, read_batch, std::ref(stores[batch % readers]), ladders_of(batch));
    for (std::size_t i = 0; i < results.size(); ++i) visit(ladders_of(batch - readers)[i], results[i]);
  }
}

std::vector<StoredPicture> load_pictures(const std::string& store_path, const std::vector<Cell>& cells,
                                         const std::string& purpose) {
  std::vector<StoredPicture> pictures;
  if (!store_exists(store_path)) return pictures;
  Store store(store_path, Store::Mode::read);
  if (store.empty()) return pictures;
  const Campaigns campaigns = latest_campaigns(store, cells, purpose);
  const auto rank = [](const Resolution& at, std::int64_t steps) {
    return std::tuple(-at.first.value_or(0), at.second.value_or(0), steps);
  };
  for (const Cell& cell : cells) {
    if (cell.worker < 0 || cell.scenario->scene.fluids.empty()) continue;
    const auto known = std::find_if(pictures.begin(), pictures.end(), [&](const StoredPicture& one) {
      return one.scenario == cell.scenario->id && one.method == cell.method;
    });
    const Resolution at = resolution_of(cell);
    if (known != pictures.end() && rank(known->at, known->steps) >= rank(at, cell.plan.steps)) continue;
    std::optional<MeasuredRecord> measured;
    of_cell(cell, [&] { measured = store.measured(campaigns.keys(cell).measured, false, true); });
    if (!measured || measured->picture.empty()) continue;
    StoredPicture one{cell.scenario->id, cell.method, cell.plan.steps, at, std::move(measured->picture)};
    if (known == pictures.end()) pictures.push_back(std::move(one));
    else *known = std::move(one);
  }
  return pictures;
}

std::vector<StoredSeries> load_series(const std::string& store_path, const std::vector<Cell>& cells,
                                      const std::string& purpose) {
  std::vector<StoredSeries> all;
  if (!store_exists(store_path)) return all;
  Store store(store_path, Store::Mode::read);
  if (store.empty()) return all;
  const Campaigns campaigns = latest_campaigns(store, cells, purpose);
  for (const Cell& cell : cells) {
    if (cell.worker < 0) continue;
    std::optional<MeasuredRecord> measured;
    of_cell(cell, [&] { measured = store.measured(campaigns.keys(cell).measured, false, true); });
    if (!measured || measured->series.t_s.empty()) continue;
    all.push_back({cell.scenario->id, cell.method, cell.plan.steps, std::move(measured->series), cell.spacing_m,
                   cell.sound_speed_m_per_s});
  }
  return all;
}

}  // namespace atwood
