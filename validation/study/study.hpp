// Plans a study's cells, runs them by workers, and stores samples and rows. It contains no physics and links no engine:
// engines are reached by the worker protocol.
#pragma once

#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "protocol/truth.hpp"
#include "scene/scene.hpp"
#include "validation/metrics/fluid_picture.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/probe.hpp"
#include "validation/row.hpp"
#include "validation/study/confinement.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/machine.hpp"

namespace atwood {

// ---- a study file -------------------------------------------------------------------------------------------
struct StudyCells {
  std::vector<std::string> scenarios;  // globs over ids, "tag:smooth"
  std::vector<std::string> methods;    // ids and globs over what the engines list
  std::vector<std::int64_t> steps;     // empty: the scenario's own ladder
  int repeats = 5;                     // of the timed pass; 0: none
  std::map<std::string, std::vector<SettingValue>> sweep = {};
  std::string claim = {};                    // a class of motion: only methods that claim an order in it
  double least_order = 0, most_order = 1e9;  // ... and that order within these
  std::vector<std::string> except = {};      // globs over base ids: left out of what `methods` takes in
  Probe probe = Probe::none;                 // several runs of a cell made for one figure
  double limit_s = 0;                        // seconds that a cell may take; 0: that of StudyOptions
  // Of scenes with fluids; empty: the scenario's own. Where one of them is given, `steps` are those of each of its
  // entries.
  std::vector<double> spacings_m = {}, sound_speeds_m_per_s = {};
  std::vector<Status> allow = {};  // `diverged`, `not finite`: statuses that do not fail the run
  std::string allow_reason = {};   // why; required with `allow`
  std::string place = {};          // of the block, "FILE:LINE:COLUMN: "; empty: not from a file
  // Where `steps` are the scenario's own: rungs below the coarsest too, halved while the samples divide them. Methods
  // of high order live there, and it shows from which step on a method is stable. Of fluids at most twice.
  bool whole_ladder = false;
  // What the command line has in place of `steps`; the ladder stays theirs, and with it the instants of its rungs.
  std::vector<std::int64_t> only_steps = {};
  const std::vector<std::int64_t>& chosen_steps() const { return only_steps.empty() ? steps : only_steps; }
};
struct Study {
  std::string id;
  std::vector<StudyCells> cells;
  std::string path = {};                               // the file; relative paths inside it start at its folder
  std::vector<std::vector<std::string>> engines = {};  // argv of each foreign engine, its first word resolved
  std::set<std::vector<std::string>> unconfined = {};  // those of them with sandbox = false
  std::string tolerances = {}, baseline = {};          // files, resolved; empty: none
};
Study read_study(const std::string& path);  // InputError

// ---- the available engines ------------------------------------------------------------------------------------
struct Worker {                        // an executable that answered hello, or why it did not
  std::string path;                    // command[0]
  std::vector<std::string> command;    // argv
  bool foreign = false;                // of --engine or a study's `engines`: not built with this program
  Engine engine;                       // `run` is empty here; name, version, scalar, methods
  std::string build_id;                // hash of its program, libraries and files (worker_identity.hpp)
  std::string unknown_code = {};       // why code beyond those may decide its results; empty: none does
  std::vector<std::string> code = {};  // files that were mapped as code after hello, sorted
  Status status = Status::ok;          // not_built, crashed, timeout: with the reason
  std::string reason;
  Confinement confinement = {};
};
// Starts each worker, sends `hello` and reads the answer (limit 10 s each).
std::vector<Worker> find_workers(const std::vector<std::string>& paths);
// The worker of this engine, by its executable's name, that did not answer; nullptr: none.
const Worker* unanswered(const std::vector<Worker>& workers, const std::string& engine);
// The settings of a method's response, the id's over the standard ones; empty: it has no response.
Settings response_settings(const Worker& worker, const MethodId& id);
// `confinements`: of each command; empty: the default one.
std::vector<Worker> find_workers_by_argv(const std::vector<std::vector<std::string>>& commands,
                                         const std::vector<Confinement>& confinements = {});
// A part of the version of an engine that runs without confinement.
inline constexpr const char* kUnconfined = " (sandbox = false)";

// ---- one cell ---------------------------------------------------------------------------------------------------
struct Cell {
  std::shared_ptr<const Scenario> scenario;  // of many cells
  std::string method;                        // full id
  Plan plan;                                 // with the samples that its ladder shares (metrics/instants.hpp)
  int worker = -1;                           // index; -1: no available engine provides the method
  int repeats = 5;
  std::string claim;  // class of motion whose claimed order this ladder measures
  double claimed_order = 0;
  ContentHash accuracy_hash, timing_hash;
  HashDigits<16> settings_hash;
  Status absent = Status::not_built;  // worker -1: why there is none
  std::string absent_reason;
  Probe probe = Probe::none;       // several runs made for one figure, instead of one run, measured
  double limit_s = 0;              // seconds it may take; 0: that of StudyOptions
  std::string pattern = {};        // the entry of the study's `methods` that gave this cell: an id or a glob
  std::vector<Status> allow = {};  // statuses that do not fail the run (StudyCells::allow)
  // For a foreign worker whose code is not fully known: cells with the same text belong to one campaign
  // (campaigns.hpp). Empty: the hashes cover everything.
  std::string campaign = {};
  // Of a scene with fluids: `scenario` is at this spacing and sound speed.
  std::optional<double> spacing_m = {}, sound_speed_m_per_s = {};
};
inline Resolution resolution_of(const Cell& cell) { return {cell.spacing_m, cell.sound_speed_m_per_s}; }
// Its plan with the scenario's own samples.
inline Plan own_plan(const Cell& cell) {
  Plan plan = cell.plan;
  plan.samples = cell.scenario->samples;
  return plan;
}
// Whether a name of `scenarios` in a study, a glob over ids or "tag:NAME", means this scenario.
bool names_scenario(const std::string& name, const Scenario& scenario);
inline constexpr std::int64_t kMaxCells = 100'000;
// InputError: a count of steps that samples do not divide, a swept setting that no method of its block has, more than
// `most_cells`, which is found before they are made. `arithmetic`: what decides the last bits on this machine.
std::vector<Cell> plan_cells(const Study& study, const std::vector<Scenario>& catalogue,
                             const std::vector<Worker>& workers, const std::string& cpu,
                             std::int64_t most_cells = kMaxCells, const std::string& arithmetic = machine_arithmetic());

// InputError for a wrong setting in a method id: each setting must be one of the method or of its response, with a
// value that the engine accepts in a scene that it supports. For cells that a glob gave: only where all of them are
// wrong. `who` begins the message: "--method ".
void check_settings(const std::string& who, const std::vector<Cell>& cells, const std::vector<Worker>& workers);
void check_settings(const std::string& who, const std::string& method, const std::vector<Worker>& workers);

// Runs one request in a worker process of its own, for `trace` and tests. time limit in seconds.
Recording run_once(const Worker& worker, const std::string& method, const Scene& scene, const Plan& plan,
                   double limit_s);
// `test`: a variant of the engine's contact test, as in ids of sweeps ("unit-size"); empty: the engine's own test.
ContactAnswer contacts_once(const Worker& worker, const Scene& scene, const ContactQuery& query, double limit_s,
                            const std::string& test = "");
Truth truth_once(const std::string& truth_worker, const Scenario& scenario, std::int64_t samples, double limit_s);

// ---- running -----------------------------------------------------------------------------------------------------
// What is kept of a run besides its rows: samples, events and the series of errors of every cell; of the worst cell of
// each ladder and of those that did not end ok; of none. Of the others the last sample stays, which orders of the end
// states are fitted from. Nothing else can be measured again without a new run.
enum class Keep { all, worst, none };
// The share of a plan that a process runs (shares.hpp).
struct ShardOfPlan {
  std::string study;
  const std::vector<Cell>* planned = nullptr;  // the whole plan
  int number = 1, count = 1;
  std::string costs, source;  // hash of the file of costs, or ""; who gave this share
  bool last = true;           // no more cells of the share follow
  // The plan's hash, where an earlier call put the plan into this store and found the store whole (StudyResult::plan):
  // neither is done again. Empty: the first call of a share.
  std::string plan = {};
};

struct Costs;  // shares.hpp

struct StudyOptions {
  std::string store_path;  // atwood-out/store.db
  std::string truth_worker;
  Confinement truth_confinement = {};  // of its worker
  int jobs = 2;
  double cell_limit_s = 20;
  double truth_limit_s = 120;  // truths are solved several times in quad
  // Of fluids: what space, time and the Mach number lose, whose truths take minutes. False: errors of the fields alone.
  bool parts = true;
  // Set: no run and no truth begins afterwards or goes on; a run that its ladder's coarser rung shows to be too long is
  // not begun. What ended before is still timed.
  std::optional<std::chrono::steady_clock::time_point> until = {};
  bool timing = true;
  bool fresh = false;           // run every cell again, also those in the store
  bool reuse = false;           // campaigns: reuse cells of the last completed one
  bool narrowed = false;        // campaigns: a part of the study, which joins the latest one
  std::string purpose = "run";  // campaigns of another purpose (compare, advise) stay apart
  Provenance provenance;        // engine_version is filled per cell
  Keep keep = Keep::all;
  bool rows = true;                // false: of the rows the result has those that are not ok, and none of ladders
  std::string host = host_name();  // recorded with times
  std::optional<ShardOfPlan> shard = {};                // a share of a plan instead of a whole one
  std::shared_ptr<const Costs> costs = {};              // ladders run dearest first; null: in the order of the study
  std::function<void(const std::string&)> progress;     // a line with an estimate, for stderr
  std::function<void(const std::string&)> notice = {};  // a warning, for stderr
};
// Cells that a run reused from the store, by engine in the order of the workers, then the truths.
struct Reused {
  std::string engine;  // "truth" for truths
  int cells = 0, reused = 0;
  std::string campaign = {};  // why its cells belong to campaigns, and which one this run chose
};
std::string reused_text(const std::vector<Reused>& reused);  // "reused from the store: atwood 120 of 120 cells, ..."
struct StudyResult {
  std::vector<Row> rows;       // of this study's cells, cell by cell, then ladders
  int cells = 0, skipped = 0;  // skipped: found in the store
  // Of run_study: cells with a new accuracy run, with a new timed pass, with new rows of a stored run.
  int ran = 0, timed = 0, measured_again = 0;
  // Indices of the cells that an available engine can run and that the store does not have (a cell without times counts
  // as stored).
  std::vector<std::size_t> missing = {};
  bool interrupted = false;  // SIGINT or SIGTERM: what was done is kept
  int signal = 0;
  int failed_cells = 0;              // crashed, timed out or sent an invalid answer
  std::vector<Reused> reused = {};   // of run_study
  std::set<std::string> hosts = {};  // that measured the times of these cells
  // Of run_study with Keep::none: metrics of new rows that were measured from a recording. Where they are to be
  // measured again (other truth, other definition), their cells run again.
  std::set<std::string> without_recording = {};
  std::string plan = {};  // of run_study of a share: the hash of the whole study's plan
};
StudyResult run_study(const std::vector<Cell>& cells, const std::vector<Worker>& workers, const StudyOptions& options);

// What the store has for these cells (for `report`, `gate`, `bless`): rows, and series for plots.
struct StoredSeries {
  std::string scenario, method;
  std::int64_t steps;
  Series series;
  std::optional<double> spacing_m = {}, sound_speed_m_per_s = {};
};
// For cells in campaigns: those of the latest campaign of that purpose, complete or not. A damaged store, or a damaged
// entry of one of these cells, is a std::runtime_error that names it.
StudyResult load_rows(const std::string& store_path, const std::vector<Cell>& cells,
                      const std::string& purpose = "run");
std::vector<StoredSeries> load_series(const std::string& store_path, const std::vector<Cell>& cells,
                                      const std::string& purpose = "run");
// The pictures of fluids: of each scenario and method its finest cell that has one, by spacing, sound speed and steps.
struct StoredPicture {
  std::string scenario, method;
  std::int64_t steps;
  Resolution at;
  FluidPicture picture;
};
std::vector<StoredPicture> load_pictures(const std::string& store_path, const std::vector<Cell>& cells,
                                         const std::string& purpose = "run");
// Verifies every checksum of the store and runs the database's own check; a line for each damaged entry. Throws
// StoreOfAnother (store.hpp).
std::vector<std::string> check_store(const std::string& store_path);

}  // namespace atwood
