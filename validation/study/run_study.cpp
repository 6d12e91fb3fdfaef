// Runs the cells of a study by workers and stores their rows.
//
// First the truths and the accuracy cells, several processes at once: a thread owns one process per engine and takes
// one ladder (scenario x method) after another, coarse rungs first. Then the timed pass (timed_pass.cpp).
#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include "metrics_version.hpp"
#include "protocol/wire.hpp"
#include "scene/files.hpp"
#include "scene/fluid_surface.hpp"
#include "validation/metrics/fluid.hpp"
#include "validation/metrics/fluid_picture.hpp"
#include "validation/metrics/instants.hpp"
#include "validation/metrics/measurements.hpp"
#include "validation/metrics/probes.hpp"
#include "validation/study/campaigns.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/keep_recordings.hpp"
#include "validation/study/load_rows.hpp"
#include "validation/study/pose_sweep.hpp"
#include "validation/study/progress.hpp"
#include "validation/study/shard_record.hpp"
#include "validation/study/shares.hpp"
#include "validation/study/short_text.hpp"
#include "validation/study/study_run.hpp"
#include "validation/study/truth_paths.hpp"
#include "validation/study/worker_client.hpp"
#include "validation/study/worker_identity.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxDamagedNamed = 20;
constexpr double kShortest_s = 1e-3;  // limit of a truth for which no time is left
constexpr const char* kNoTimeLeft = "not tried: the time was over";

Outcome outcome_of(Status status, const std::string& reason) {
  Outcome outcome;
  outcome.status = status;
  outcome.reason = reason;
  return outcome;
}

std::size_t own_samples(const Scenario& scenario) {
  return static_cast<std::size_t>(std::max<std::int64_t>(0, scenario.samples));
}

bool settled(const StoreOverview::Run& run, double limit_s) {
  if (run.killed_from_outside) return false;
  return run.status != Status::timeout || run.limit_s >= limit_s;
}

}  // namespace

// ---- the plan -----------------------------------------------------------------------------------------------------
std::size_t StudyRun::truth_index(const Scenario& scenario) {
  if (last_scenario_ != &scenario) last_truth_ = find_truth(scenario), last_scenario_ = &scenario;
  return last_truth_;
}

std::size_t StudyRun::find_truth(const Scenario& scenario) {
  const Resolution at = scenario.scene.fluids.empty() ? Resolution{}
                                                      : Resolution{scenario.scene.fluids.front().spacing_m,
                                                                   scenario.scene.fluids.front().sound_speed_m_per_s};
  const std::string name = scenario.id + "\n" + resolution_text(at);
  if (const auto known = truth_by_scenario_.find(name); known != truth_by_scenario_.end()) return known->second;
  const std::string hash = truth_hash(scenario, truth_build_);
  const auto [place, fresh] = truth_by_hash_.emplace(hash, truths_.size());
  truth_by_scenario_[name] = place->second;
  if (fresh) {
    truths_.push_back(
        {hash, &scenario, TruthWork::State::pending, content_hash({hash, kMetricsVersion}), false, nullptr, 0});
    const bool of_fluid = !scenario.scene.fluids.empty();  // its truths are asked for at the particles of each run
    if (scenario.truth.kind == TruthKind::none || of_fluid) {
      auto none = std::make_shared<Truth>();
      none->outcome = outcome_of(Status::unsupported, "the scene names no truth");
      truths_.back().truth = none;
      truths_.back().state = TruthWork::State::ready;
    }
  }
  return place->second;
}

namespace {

// Of rows that lack the parts of a fluid's error.
std::string without_parts(const std::string& basis) { return content_hash({basis, "without parts"}); }

}  // namespace

// Rows with all parts serve where none are asked for.
bool StudyRun::is_measured(const Cell& cell, const std::string& basis, const StoreOverview* overview) const {
  const CellKeys keys = campaigns_.keys(cell);
  const auto from = [&](const std::string& known) {
    return overview != nullptr ? overview->measured_from(keys.measured, known)
                               : store_.measured_basis(keys.measured) == known;
  };
  return from(basis) || (!options_.parts && !cell.scenario->scene.fluids.empty() && from(without_parts(basis)));
}

void StudyRun::plan_cell(const Cell& cell, const StoreOverview* overview) {
  if (cell.worker < 0) return;
  const std::size_t truth = truth_index(*cell.scenario);
  const CellKeys keys = campaigns_.keys(cell);
  const std::string& basis = truths_[truth].basis;
  if (overview != nullptr && !options_.fresh) {
    const StoreOverview::Run* known = overview->run(keys.accuracy);
    if (known != nullptr && settled(*known, limit_of(cell, options_)) && is_measured(cell, basis, overview)) return;
  }
  std::optional<RunRecord> run = store_.run(keys.accuracy);
  if (run && (options_.fresh ||
              !settled({run->outcome.status, run->killed_from_outside, run->limit_s}, limit_of(cell, options_))))
    run.reset();
  if (run && is_measured(cell, basis, nullptr)) return;
  // A probe keeps no samples to measure again, nor does a cell whose recording was dropped (--keep).
  if (run && (cell.probe != Probe::none || !store_.keeps_recording(keys.accuracy))) run.reset();
  if (!run) ran_[index_of(cell)] = true;
  else ++measured_again_;
  const auto [place, fresh] =
      ladder_index_.emplace(cell.scenario->id + "\n" + cell.method + "\n" + to_string(cell.probe) + "\n" +
                                resolution_text(resolution_of(cell)),
                            ladders_.size());
  if (fresh) ladders_.push_back({{}, truth});
  touched_[index_of(cell)] = true;
  ladders_[place->second].todo.push_back(
      {&cell, run ? std::make_unique<const RunRecord>(std::move(*run)) : std::unique_ptr<const RunRecord>()});
}

// Reports damaged entries and deletes them, so that their cells run again.
void StudyRun::forget_damaged() {
  std::size_t count = 0;
  for (const Cell& cell : cells_) {
    if (cell.worker < 0) continue;
    const CellKeys keys = campaigns_.keys(cell);
    const std::string what = store_.damage(keys);
    if (what.empty()) continue;
    store_.rebuild();
    store_.forget({keys});
    if (++count <= kMaxDamagedNamed && options_.notice)
      options_.notice("store " + options_.store_path + ": " + what + " of the cell " + cell.scenario->id + ", " +
                      cell.method + ", " + std::to_string(cell.plan.steps) + " steps " +
                      (what == "the rows" || what == "the times" ? "are" : "is") + " damaged; the cell runs again");
  }
  if (count > kMaxDamagedNamed && options_.notice)
    options_.notice("store " + options_.store_path + ": ... and " + std::to_string(count - kMaxDamagedNamed) +
                    " more damaged cells run again");
}

bool StudyRun::is_known(const TruthWork& work) {
  if (const std::string damage = store_.truth_damage(work.hash); !damage.empty()) {
    store_.rebuild();
    store_.forget_truth(work.hash);
    if (options_.notice)
      options_.notice(damage + ": the truth of `" + work.scenario->id + "`, which is solved again where it is needed");
  }
  return !options_.fresh && store_.has_truth(work.hash);
}

double StudyRun::left_s() const {
  if (!options_.until) return std::numeric_limits<double>::infinity();
  return std::chrono::duration<double>(*options_.until - std::chrono::steady_clock::now()).count();
}
double StudyRun::truth_limit_s() const { return std::min(options_.truth_limit_s, left_s()); }

RunRecord StudyRun::new_run(const Cell& cell) const {
  RunRecord run;
  run.provenance = options_.provenance;
  run.provenance.engine_version = workers_[static_cast<std::size_t>(cell.worker)].engine.version;
  run.limit_s = std::max(0.0, std::min(limit_of(cell, options_), left_s()));
  run.scenario = cell.scenario->id;
  run.method = cell.method;
  run.steps = cell.plan.steps;
  return run;
}

// Whether a worker has loaded code since `hello`, which no hash contains. Its cell is then stored like one that was
// killed from outside, so that the next run repeats it.
bool StudyRun::loads_more(int index, const WorkerClient& client) {
  const Worker& worker = workers_[static_cast<std::size_t>(index)];
  if (!worker.foreign || !worker.engine.fingerprint.empty() || !worker.unknown_code.empty()) return false;
  if (client.process_id() == 0 || worker.code.empty()) return false;
  const std::string file = code_loaded_since(worker.command, worker.engine, worker.code, client.process_id());
  if (file.empty()) return false;
  const std::lock_guard<std::mutex> held(mutex_);
  if (told_to_load_more_.insert(index).second && options_.notice)
    options_.notice(
        worker.engine.name + ": it loads " + file +
        " after its hello, so that its cells are measured again by every run; name it in hello's `files`, or "
        "give a `fingerprint`");
  return true;
}

// The dearest ladder begins first, so that the last ones to end are short and few threads wait for them (longest
// processing time first; Graham, Bounds on multiprocessing timing anomalies, 1969). Rows are exported in the study's
// order all the same.
void StudyRun::order_by_cost() {
  std::vector<const Cell*> cells;
  for (const Ladder& ladder : ladders_)
    for (const Todo& todo : ladder.todo) cells.push_back(todo.cell);
  const std::vector<double> cost_ns = expected_costs_ns(cells, *options_.costs);
  std::size_t i = 0;
  for (Ladder& ladder : ladders_)
    for (std::size_t k = 0; k < ladder.todo.size(); ++k) ladder.cost_ns += cost_ns[i++];
  std::stable_sort(ladders_.begin(), ladders_.end(),
                   [](const Ladder& a, const Ladder& b) { return a.cost_ns > b.cost_ns; });
}

void StudyRun::plan_work() {
  truth_build_ = find_workers({options_.truth_worker}).front().build_id;
  {
    // A later chunk of a lease is small beside the store: its cells are looked up one by one.
    const bool later_chunk = options_.shard && !options_.shard->plan.empty();
    const StoreOverview overview = later_chunk ? StoreOverview() : store_.overview();
    const bool one_by_one = later_chunk || !overview.whole;
    if (one_by_one) forget_damaged();
    for (const Cell& cell : cells_) plan_cell(cell, one_by_one ? nullptr : &overview);
  }
  ladder_index_.clear();
  std::set<std::size_t> needed;
  for (const Ladder& ladder : ladders_) {
    needed.insert(ladder.truth);
    ++truths_[ladder.truth].ladders_left;
  }
  for (std::size_t i = 0; i < truths_.size(); ++i) {
    if (truths_[i].state == TruthWork::State::ready) continue;
    if (!is_known(truths_[i]) && needed.contains(i)) continue;
    truths_[i].state = TruthWork::State::ready;
    truths_[i].reused = true;
  }
  if (options_.costs) order_by_cost();
  taken_.assign(ladders_.size(), false);
}

// ---- the accuracy pass --------------------------------------------------------------------------------------------
StudyRun::Task StudyRun::next() {
  std::unique_lock<std::mutex> held(mutex_);
  for (;;) {
    if (stop_ || interrupt_signal() != 0) return {};
    for (; first_truth_ < truths_.size(); ++first_truth_) {
      const std::size_t i = first_truth_;
      if (truths_[i].state != TruthWork::State::pending) continue;
      truths_[i].state = TruthWork::State::running;
      return {Task::Kind::truth, i};
    }
    while (first_ladder_ < taken_.size() && taken_[first_ladder_]) ++first_ladder_;
    bool left = false;
    for (std::size_t i = first_ladder_; i < ladders_.size(); ++i) {
      if (taken_[i]) continue;
      left = true;
      if (truths_[ladders_[i].truth].state != TruthWork::State::ready) continue;
      taken_[i] = true;
      return {Task::Kind::ladder, i};
    }
    if (!left) return {};
    changed_.wait_for(held, std::chrono::milliseconds(50));
  }
}

void StudyRun::solve_truth(TruthWork& work, WorkerClient& client) {
  const Scenario& scenario = *work.scenario;
  auto truth =
      std::make_shared<Truth>(client.truth(scenario_to_json(scenario), sampled_bodies(scenario.scene), scenario.t_end_s,
                                           samples_of_truth(scenario), std::max(truth_limit_s(), kShortest_s)));
  truth->outcome.reason = shortened(truth->outcome.reason, kLongestReason);
  const Status status = truth->outcome.status;
  if (status != Status::ok) truth->values.clear(), truth->bars.clear();  // a study needs the truth of the whole run
  const bool failed = status == Status::crashed || status == Status::timeout || status == Status::not_built;
  if (!failed) store_.put_truth(work.hash, scenario.id, *truth);
  {
    const std::lock_guard<std::mutex> held(mutex_);
    if (failed) {  // rows measured without a truth must not be taken for rows measured with it
      work.hash += " failed";
      ++failed_truths_;
    }
    work.truth = truth;
    work.state = TruthWork::State::ready;
  }
  changed_.notify_all();
  progress_.done("truth");
}

std::shared_ptr<const Truth> StudyRun::truth_of(TruthWork& work) {
  const std::lock_guard<std::mutex> held(mutex_);
  if (!work.truth) {
    auto stored = store_.truth(work.hash);
    if (!stored) throw std::runtime_error("store " + options_.store_path + ": a truth has vanished from it");
    work.truth = std::make_shared<Truth>(std::move(*stored));
  }
  std::shared_ptr<const Truth> truth = work.truth;
  if (--work.ladders_left == 0) work.truth.reset();  // the ladders that use it have copies of the pointer
  return truth;
}

namespace {

// The response of a method with all its settings, as a method id has it without the plus sign; empty: it has none.
std::string response_text(const std::string& method, const Worker& worker) {
  const MethodId id = parse_method_id(method);
  if (id.response.empty()) return "";
  MethodId response;
  response.engine = "a", response.scheme = "b", response.response = id.response;
  response.overrides = response_settings(worker, id);
  return to_string(response).substr(4);  // "a/b+"
}

}  // namespace

// The particles' own equations, without an error of time: one solution of all rungs of a ladder.
Truth StudyRun::semi_discrete(const Cell& cell, const std::string& hash, const std::string& response,
                              WorkerClient& client) {
  const std::string key = content_hash({"semi-discrete 1", hash, response});
  if (!options_.fresh)
    if (auto stored = store_.truth(key)) return std::move(*stored);
  const Scenario& scenario = *cell.scenario;
  Truth truth = client.truth(scenario_to_json(scenario), sampled_bodies(scenario.scene), scenario.t_end_s,
                             scenario.samples, std::max(truth_limit_s(), kShortest_s), response);
  truth.outcome.reason = shortened(truth.outcome.reason, kLongestReason);
  if (truth.outcome.status != Status::ok) truth.values.clear(), truth.bars.clear();
  else store_.put_truth(key, scenario.id, truth);
  return truth;
}

MeasuredRecord StudyRun::measured_fluid(const Cell& cell, const std::string& hash, const Recording& recording,
                                        WorkerClient& client) {
  const std::string response = response_text(cell.method, workers_[static_cast<std::size_t>(cell.worker)]);
  const TruthSpec& spec = cell.scenario->truth;
  // The particles' own equations are those of a response: an engine of other equations has no error of time apart.
  const bool stepping =
      spec.kind == TruthKind::semi_discrete && ((options_.parts && !response.empty()) || spec.solution.empty());
  bool late = false;
  const FluidTruths truths = fluid_truths(
      *cell.scenario, recording,
      [&](TruthKind kind, const std::vector<Wide>& t_s, const std::vector<std::vector<FieldPosition>>& positions) {
        Scenario asked = *cell.scenario;
        FieldAtParticles field;
        const bool part = kind == TruthKind::weakly_compressible && asked.truth.kind != kind;
        if (part && !options_.parts) field.outcome = outcome_of(Status::unsupported, "not asked for");
        else if (!(truth_limit_s() > 0)) field.outcome = outcome_of(Status::timeout, kNoTimeLeft);
        if (field.outcome.status != Status::ok) return field;
        asked.truth.kind = kind;
        field = client.field(scenario_to_json(asked), response, t_s, positions, truth_limit_s());
        late = late || (options_.until && field.outcome.status == Status::timeout);
        return field;
      },
      [&] {
        if (stepping) return semi_discrete(cell, hash, response, client);
        Truth truth;
        truth.outcome = outcome_of(Status::unsupported, "not asked for");
        return truth;
      });
  MeasuredRecord record;
  record.basis = late             ? content_hash({hash, kMetricsVersion, "late"})  // like no other: measured again
                 : options_.parts ? content_hash({hash, kMetricsVersion})
                                  : without_parts(content_hash({hash, kMetricsVersion}));
  record.rows = measure_fluid(*cell.scenario, truths, recording);
  record.picture = picture_of(*cell.scenario, truths.exact, recording);
  const Settings settings =
      response_settings(workers_[static_cast<std::size_t>(cell.worker)], parse_method_id(cell.method));
  const Scene& scene = cell.scenario->scene;
  const bool free_surface =
      settings.contains("degree") && recording.outcome.status == Status::ok && !surface_points(scene).empty();
  for (Row& row :
       neighbour_rows(scene, recording, kernel_support_m(settings, scene.fluids.front().spacing_m, free_surface)))
    record.rows.push_back(std::move(row));
  for (Row& row : fluid_work_rows(scene, recording, response)) record.rows.push_back(std::move(row));
  const Outcome& outcome = stepping ? truths.semi_discrete.outcome : truths.exact.outcome;
  if (outcome.status != Status::ok && cell.scenario->truth.kind != TruthKind::none &&
      recording.outcome.status == Status::ok) {
    Row row = metrics::row("truth", 0);
    row.status = outcome.status;
    row.reason = shortened(outcome.reason, kLongestReason);
    record.rows.push_back(row);
  }
  return record;
}

MeasuredRecord StudyRun::measured(const Cell& cell, const Truth& truth, const std::string& hash,
                                  const Recording& recording, WorkerClient& truth_client) {
  if (!cell.scenario->scene.fluids.empty()) return measured_fluid(cell, hash, recording, truth_client);
  MeasuredRecord record;
  record.basis = content_hash({hash, kMetricsVersion});
  record.rows = measure(*cell.scenario, truth, recording);
  if (std::optional<Truth> fewer; recording.outcome.status == Status::ok)
    record.series = error_series(*cell.scenario, at_samples(truth, own_samples(*cell.scenario), fewer), recording);
  if (truth.outcome.status != Status::ok && cell.scenario->truth.kind != TruthKind::none) {
    Row row = metrics::row("truth", 0);
    row.status = truth.outcome.status;
    row.reason = truth.outcome.reason;
    record.rows.push_back(row);
  }
  return record;
}

WorkerClient& StudyRun::client_of(const Cell& cell, std::map<int, WorkerClient>& clients) const {
  const Worker& worker = workers_[static_cast<std::size_t>(cell.worker)];
  return clients.try_emplace(cell.worker, worker).first->second;
}

// A probe's runs, of which only the rows are kept. Each run has the cell's time limit, all together ten times that.
void StudyRun::run_probe_cell(const Cell& cell, const Truth& truth, const std::string& truth_hash,
                              std::map<int, WorkerClient>& clients) {
  WorkerClient& client = client_of(cell, clients);
  RunRecord run = new_run(cell);
  double left_s = 10 * run.limit_s;
  const auto one = [&](const std::string& method, const Scene& scene, const Plan& plan) {
    if (left_s <= 0) {
      Recording late;
      late.outcome = outcome_of(Status::timeout, "the runs of this probe take longer than ten runs may");
      return late;
    }
    Recording recording = client.run(method, scene_to_json(scene), sampled_bodies(scene), plan, 0, run.limit_s);
    run.wall_ns += client.wall_ns();
    left_s -= 1e-9 * static_cast<double>(client.wall_ns());
    run.killed_from_outside = run.killed_from_outside || client.killed_from_outside() ||
                              recording.outcome.status == Status::not_built || loads_more(cell.worker, client);
    return recording;
  };
  MeasuredRecord record;
  record.basis = content_hash({truth_hash, kMetricsVersion});
  std::optional<Truth> fewer;
  const Truth& at_own = at_samples(truth, own_samples(*cell.scenario), fewer);
  record.rows = run_probe(cell.probe, {*cell.scenario, cell.method, cell.plan, at_own, one});
  for (const Row& row : record.rows)
    if (row.status == Status::crashed || row.status == Status::timeout)
      run.outcome = outcome_of(row.status, row.reason);
  const CellKeys keys = campaigns_.keys(cell);
  store_.put_run(keys.accuracy, run, {}, keys.measured, record);
  progress_.done("probes");
}

// The poses of every pair, against their exact answers; the worst are kept as scenes beside the store.
void StudyRun::run_sweep_cell(const Cell& cell, const std::string& truth_hash, std::map<int, WorkerClient>& clients) {
  WorkerClient& client = client_of(cell, clients);
  RunRecord run = new_run(cell);
  MeasuredRecord record;
  record.basis = content_hash({truth_hash, kMetricsVersion});
  const std::string tables = std::filesystem::path(cell.scenario->path).replace_filename("geometry").string();
  const std::string& scalar = workers_[static_cast<std::size_t>(cell.worker)].engine.scalar;
  record.rows = cell.probe == Probe::contact_tables
                    ? table_rows(cell, client, tables, run.limit_s, scalar, run.outcome)
                    : sweep_rows(cell, client, pose_truths_, options_, run.limit_s, scalar, run.outcome);
  const CellKeys keys = campaigns_.keys(cell);
  store_.put_run(keys.accuracy, run, {}, keys.measured, record);
  progress_.done("sweeps");
}

void StudyRun::note_without_recording(const std::vector<Row>& rows) {
  const std::lock_guard<std::mutex> held(mutex_);
  for (const Row& row : rows)
    if (row.metric != "status" && row.metric != "truth") without_recording_.insert(row.metric);
}

void StudyRun::run_ladder(const Ladder& ladder, std::map<int, WorkerClient>& clients, WorkerClient& truth_client) {
  TruthWork& work = truths_[ladder.truth];
  std::shared_ptr<const Truth> truth = truth_of(work);
  const std::string scene_json = scene_to_json(ladder.todo.front().cell->scenario->scene);
  std::int64_t hung_at = 0;
  std::optional<RunRecord> ended;  // the rung before
  for (const Todo& todo : ladder.todo) {
    const Cell& cell = *todo.cell;
    const CellKeys keys = campaigns_.keys(cell);
    if (is_sweep(cell.probe)) {
      run_sweep_cell(cell, work.hash, clients);
      continue;
    }
    if (cell.probe != Probe::none) {
      run_probe_cell(cell, *truth, work.hash, clients);
      continue;
    }
    if (todo.stored) {
      const Recording recording = store_.recording(keys.accuracy, todo.stored->outcome);
      store_.put_measured(keys.measured, keys.accuracy, measured(cell, *truth, work.hash, recording, truth_client));
      progress_.done("measuring");
      continue;
    }
    RunRecord run = new_run(cell);
    Recording recording;
    const double expected_s = ended ? 1e-9 * static_cast<double>(ended->wall_ns) *
                                          static_cast<double>(cell.plan.steps) / static_cast<double>(ended->steps)
                                    : 0;
    if (const double left = left_s(); options_.until && hung_at == 0 && !(left > expected_s)) {
      recording.outcome =
          outcome_of(Status::timeout, left > 0 ? std::string("not tried: the coarser rung shows that it "
                                                             "takes longer than the time that is left")
                                               : kNoTimeLeft);
      run.limit_s = 0;  // any limit tries it again
    } else if (hung_at > 0) {
      recording.outcome = outcome_of(Status::timeout, "not tried: " + std::to_string(hung_at) +
                                                          " steps of the same ladder already reached the time limit");
    } else {
      WorkerClient& client = client_of(cell, clients);
      recording = with_instants(
          client.run(cell.method, scene_json, sampled_bodies(cell.scenario->scene), cell.plan, 0, run.limit_s),
          cell.scenario->samples, cell.plan.samples);
      run.wall_ns = client.wall_ns();
      run.killed_from_outside = client.killed_from_outside() || recording.outcome.status == Status::not_built ||
                                loads_more(cell.worker, client);
      if (recording.outcome.status == Status::timeout) hung_at = cell.plan.steps;
      if (recording.outcome.status == Status::ok) ended = run;
    }
    recording.outcome.reason = shortened(recording.outcome.reason, kLongestReason);
    run.outcome = recording.outcome;
    const MeasuredRecord record = measured(cell, *truth, work.hash, recording, truth_client);
    if (&todo == &ladder.todo.back()) truth.reset();
    store_.put_run(keys.accuracy, run, std::move(recording), keys.measured, record, options_.keep != Keep::none);
    if (options_.keep == Keep::none) note_without_recording(record.rows);
    progress_.done("accuracy");
  }
}

void StudyRun::work() {
  try {
    std::map<int, WorkerClient> clients;
    WorkerClient truth_client({options_.truth_worker}, false, false, options_.truth_confinement);
    for (Task task = next(); task.kind != Task::Kind::none; task = next()) {
      if (task.kind == Task::Kind::truth) solve_truth(truths_[task.index], truth_client);
      else run_ladder(ladders_[task.index], clients, truth_client);
    }
  } catch (const Interrupted&) {
    // Committed cells stay; the other threads check the signal themselves.
  } catch (...) {
    stop_for_failure();
  }
  changed_.notify_all();
}

// Called where an exception is handled: the first one ends the run.
void StudyRun::stop_for_failure() {
  const std::lock_guard<std::mutex> held(mutex_);
  if (!failure_) failure_ = std::current_exception();
  stop_ = true;
}

void StudyRun::accuracy_pass() {
  plan_work();
  std::size_t cells = 0, truths = 0;
  for (const Ladder& ladder : ladders_) cells += ladder.todo.size();
  const auto timed = std::count_if(cells_.begin(), cells_.end(), [](const Cell& cell) { return cell.repeats > 0; });
  for (const TruthWork& truth : truths_) truths += truth.state == TruthWork::State::pending ? 1 : 0;
  progress_.expect(truths + cells + (options_.timing ? std::min(cells, static_cast<std::size_t>(timed)) : 0), truths);
  if (cells > 0) {
    std::vector<std::thread> threads;
    try {
      for (int i = 0; i < std::max(1, options_.jobs); ++i) threads.emplace_back([this] { work(); });
    } catch (...) {  // no memory or no thread left: the threads that run end
      stop_for_failure();
      changed_.notify_all();
    }
    for (std::thread& thread : threads) thread.join();
  }
  if (failure_) std::rethrow_exception(failure_);
}

namespace {

std::int64_t nanoseconds_now() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

}  // namespace

StudyResult run_study(const std::vector<Cell>& cells, const std::vector<Worker>& workers, const StudyOptions& options) {
  const InterruptGuard guard;
  Store store(options.store_path, Store::Mode::write);
  const std::int64_t begun_ns = nanoseconds_now();
  for (const std::string& line : store.forget_shared_damage())
    if (options.notice) options.notice(line);
  store.put_program_run(options.provenance.run_id, begun_ns, 0);
  if (options.notice && !store.network_file_system().empty())
    options.notice(
        "store " + options.store_path + " lies on " + store.network_file_system() +
        ": it is written with a rollback journal, which is slower; a store on a local disk, merged later, is quicker");
  const Campaigns campaigns =
      Campaigns::begin(store, options.shard ? *options.shard->planned : cells, workers, options);
  ShardRecord shard;
  if (options.shard) shard = begin_shard(store, *options.shard, campaigns, options.host);
  StudyRun run(cells, workers, options, store, campaigns);
  run.accuracy_pass();
  if (options.timing && interrupt_signal() == 0) run.timed_pass();
  if (options.keep == Keep::worst && interrupt_signal() == 0) keep_worst(store, cells, campaigns);
  const int signal = interrupt_signal();
  if (signal == 0) {
    if (!options.shard || options.shard->last) campaigns.complete(store);
    if (options.shard && options.shard->last) {
      shard.complete = true;
      store.put_shard(shard);
    }
    store.put_program_run(options.provenance.run_id, begun_ns, nanoseconds_now());
    if (options.keep == Keep::worst && (!options.shard || options.shard->last)) store.compact();
    store.checkpoint();
  }
  StudyResult result =
      options.shard || !options.rows ? collect_endings(store, cells, campaigns) : collect_rows(store, cells, campaigns);
  result.plan = shard.plan;
  result.skipped = result.cells - run.touched();
  result.ran = run.ran();
  result.timed = run.timed();
  result.measured_again = run.measured_again();
  result.without_recording = run.without_recording();
  result.signal = signal;
  result.reused = run.reused();
  result.interrupted = signal != 0;
  result.failed_cells += run.failed_truths();
  return result;
}

}  // namespace atwood
