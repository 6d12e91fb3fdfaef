// The commands. Each takes parsed options and returns an exit code:
// 0 pass; 1 a gate is fail, unverifiable or not_run; 2 input or usage; 3 a cell crashed, hung or sent an invalid
// answer; 4 no baseline; 5 input/output or internal; 130 and 143 interrupted. Data goes to stdout, everything
// else to stderr.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol/truth.hpp"
#include "reports/report.hpp"
#include "scene/scene.hpp"
#include "validation/study/study.hpp"

namespace atwood {

// A foreign engine that was started and, asked `hello`, crashed, hung or sent an invalid answer: exit_cell.
struct WorkerFailure : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum ExitCode { exit_pass = 0, exit_gate = 1, exit_input = 2, exit_cell = 3, exit_no_baseline = 4, exit_internal = 5 };

struct Options {
  std::string program;                 // the words of this call, for the report: a shell's line
  std::vector<std::string> words;      // the same, one by one; the first is the program as it was called
  std::string study;                   // a file, or an id of validation/study; empty: the default study
  std::vector<std::string> scenarios;  // ids, globs or files
  std::vector<std::string> methods;
  std::vector<std::int64_t> steps;
  std::vector<double> hz;                                              // steps a second, instead of `steps`
  std::vector<double> spacings, sound_speeds;                          // of fluids, instead of the scenario's own
  std::vector<std::string> engines;                                    // executables that speak the worker protocol
  bool no_sandbox = false;                                             // of these executables
  double memory_GiB = static_cast<double>(kDefaultMemoryBytes >> 30);  // of each worker; 0: no limit
  std::vector<std::string> outputs;                                    // "csv:rows.csv"
  std::string out_dir = "atwood-out";
  std::string tolerances, baseline, junit, reason, as_method = "check";
  std::vector<std::string> limits;  // check: METRIC=VALUE
  std::string input;                // the positional argument of trace, describe, check, list, schema, bench
  std::optional<std::int64_t> samples;
  int jobs = 0;  // 0: one per core
  double cell_limit_s = 20;
  bool limit_given = false;  // by --limit: it then overrides the limits of a study's blocks
  bool no_timing = false, json = false, events = false;
  bool fresh = false, reuse = false;  // run: nothing of the store; the last completed campaign's cells
  bool check_store = false;           // doctor
  std::int64_t max_cells = kMaxCells;
  std::string shard, costs, lease;  // run: I/N; a file of costs; a directory of chunks
  double lease_expiry_s = 600;
  bool dry_run = false;
  std::string keep = "all";         // run: which recordings
  std::vector<std::string> stores;  // merge
  std::int64_t prune_keep = 0;      // history: runs of a study to keep; 0: --prune-keep was not given
  double prune_older_days = 0;
  std::string purpose = "run";             // of campaigns: those of compare and advise stay apart
  bool quiet = false;                      // run, gate: one line, and what did not pass
  bool github = false;                     // run, gate: annotations of GitHub Actions, and a step's summary
  bool swept = false;                      // contacts
  bool particles = false, probes = false;  // trace: of fluids, instead of the bodies
  bool joints = false, ropes = false;      // trace: of mechanisms, instead of the bodies
  double at_s = 0;                         // derivatives: the time of the run
  bool ladder = false;                     // derivatives: the errors of differences against their steps
  bool evidence = false;                   // describe METHOD --program
  bool same_rate = false,
       native_rate = false;         // compare, advise: whose right-hand side is evaluated; neither: compare chooses
  bool with_same_rate = false;      // the worker of same_rate.hpp joins the others
  bool named_methods_only = false;  // compare: --engine adds no methods that were not named
  bool whole_ladders = false;       // each scenario's ladder, halved as far down as its samples divide it
  std::string wanted_error, budget, metric;  // advise, compare
  double search_s = 10;                      // advise: after this no further method is begun
  bool progress = false;                     // progress lines also off a terminal
  bool long_list = false, names = false;     // list: methods in full; names alone
  std::string scene_class, tuned_file;       // tune
  std::int64_t trials = 24;
  std::uint64_t seed = 1784;
  bool manual = false;             // help --man
  std::vector<std::string> goals;  // bench goals: ids, globs
  std::string goals_file;
};

// Where the catalogue, the gates and the workers are, found once. `source_dir`: the project's root, or the folder
// share/atwood of an installation, which has the same paths below it.
struct Place {
  std::string source_dir, worker_dir, truth_worker;
  bool installed = false;  // by `cmake --install` or a package: nothing is built here
  Provenance provenance;
};
Place find_place();

// Folders of the catalogue's scenarios, and the file of an id; where none has it, where it would stand.
std::vector<std::string> catalogue_folders(const Place& place);
std::string catalogue_file(const Place& place, const std::string& id);
std::vector<Scenario> read_catalogue(const Place& place);
Scenario read_scene_argument(const Place& place, const std::string& id_or_file);  // InputError
void require_own_id(const Place& place, const Scenario& scenario);  // a file with an id of the catalogue: InputError
// The same where nothing is kept under the id: a note on standard error.
void note_shared_id(const Place& place, const Scenario& scenario);
// Our own engines and the rivals, then those of --engine and of a study's `engines`. Where `methods` names the engine
// of every method, only these of our own engines and the rivals are started: each costs a process, and some half a
// second. An --engine that is not an executable file is an InputError.
std::vector<Worker> require_workers(const Place& place, const Options& options, const Study* study = nullptr,
                                    const std::vector<std::string>& methods = {});
// "The engine `mine` runs without confinement (sandbox = false).": a sentence on each such engine.
std::vector<std::string> unconfined_engines(const std::vector<Worker>& workers);
// Foreign engines must have answered `hello`: their methods are not known otherwise. Those of --engine that did not end
// the command: WorkerFailure, or InputError where the program cannot be started.
void require_answers(const std::vector<Worker>& workers, const Study* study = nullptr);
// Ends the command: no worker provides `method`, of `option` ("--method "). Where its engine did not answer, with the
// reason (InputError where it is not built, else WorkerFailure); else with the names that are similar, and `others`.
[[noreturn]] void refuse_unknown_method(const std::string& option, const std::string& method,
                                        const std::vector<Worker>& workers,
                                        const std::vector<std::string>& others = {});
// At most `count` of the known names that are similar to the word, the most similar first; empty where none is.
std::vector<std::string> nearest(const std::string& word, std::vector<std::string> known, std::size_t count);
// The same for a message, "; nearest: a, b"; empty where no name is similar.
std::string nearest_hint(const std::string& word, const std::vector<std::string>& known, std::size_t count);
bool is_terminal(int fd);
int terminal_width();
bool use_colour(int fd);

// The cells an invocation is about: the study, narrowed by its options.
struct Selection {
  std::vector<Scenario> scenarios;
  std::vector<Worker> workers;
  std::vector<Cell> cells;
  std::string study;                 // the study's id
  std::string tolerances, baseline;  // files: of the command line, else of the study; empty: none was named
  bool narrowed = false;             // gates left without cells are dropped
};
std::string own_file(const Place& place,
                     const Scenario& scenario);  // of a scene of the user's own; empty: of the catalogue
// The words that rerun a cell of this scenario, as this call can be repeated: the program as it was called, the study,
// and what the catalogue does not have: a scene's file, an engine, gates.
std::vector<std::string> with_own_files(const Place& place, const Options& options, const Selection& selection,
                                        const std::string& scenario_id, std::vector<std::string> words);
std::vector<Gate> read_all_gates(const Place& place);                    // the catalogue's own, file by file
std::int64_t memory_limit_of(const Options& options);                    // bytes; InputError
StudyOptions study_options(const Place& place, const Options& options);  // without progress
Selection select_cells(const Place& place, const Options& options);
Selection without_cells(const Selection& selection);  // there may be a million
std::vector<Verdict> judge_selection(const Place& place, const Options& options, const Selection& selection,
                                     const std::vector<Row>& rows);
ReportData assemble_report(const Place& place, const Options& options, const Selection& selection,
                           const StudyResult& result, const std::vector<Verdict>& verdicts);
void write_named_outputs(const Options& options, const ReportData& data);  // what -o names
void require_outputs_make_sense(const Options& options);                   // before the work: InputError
// A file to write to, before the work: InputError for a pipe, a socket or a device, std::runtime_error where its folder
// is missing or cannot be written.
void require_output(const std::string& file);
void make_out_dir(const std::string& path);
// With --keep none: the metrics that were measured from recordings, which are not kept (stderr).
void report_without_recording(const Options& options, const std::set<std::string>& metrics);
// One line that rewrites itself on a terminal; elsewhere lines with --progress, and nothing without it (an empty
// function).
std::function<void(const std::string&)> progress_printer(const Options& options);
void end_progress();
// Methods that take a tolerance and were named without one: a ladder of tolerances besides their equal steps. Globs are
// spelled out, and last words of ids ("odeint/dopri5"); `notes` gets a sentence on each of the latter.
std::vector<std::string> with_tolerances(const std::vector<std::string>& methods, const std::vector<Worker>& workers,
                                         std::vector<std::string>& notes);

int gate_exit(const std::vector<Verdict>& verdicts);

// Figures that a law predicts, beside the law (reports/command_line/laws.cpp).
std::vector<Law> find_laws(const std::vector<Scenario>& scenarios, const std::vector<Row>& rows);

int command_list(const Place&, const Options&);
int command_describe(const Place&, const Options&);
int command_import(const Place&, const Options&);
int command_doctor(const Place&, const Options&);
int command_schema(const Place&, const Options&);
int command_run(const Place&, const Options&);
int command_trace(const Place&, const Options&);
int command_contacts(const Place&, const Options&);
int command_derivatives(const Place&, const Options&);
int command_compare(const Place&, const Options&);
int command_check(const Place&, const Options&);
int command_gate(const Place&, const Options&);
int command_bless(const Place&, const Options&);
int command_advise(const Place&, const Options&);
int command_goals(const Place&, const Options&);         // bench goals
int command_broad_phases(const Place&, const Options&);  // bench broad-phases
int command_frame_budget(const Place&, const Options&);  // bench frame-budget
int command_bench(const Place&, const Options&);
int command_tune(const Place&, const Options&);
int command_report(const Place&, const Options&);
int command_merge(const Place&, const Options&);
int command_costs(const Place&, const Options&);

std::string join(const std::vector<std::string>& words, const char* between);

}  // namespace atwood
