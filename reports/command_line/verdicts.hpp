// What a run or a store is held against, and what came of it.
#pragma once

#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "reports/command_line/command_line.hpp"

namespace atwood {

// Read before anything is run, so that an error in a file is reported at once.
struct Standards {
  std::vector<Gate> gates;  // the tolerances' own, else the catalogue's
  std::optional<Baseline> baseline;
};
// `catalogue`: whether its gates are judged where no tolerances are named. A baseline that is named and not there is
// left out: the command says what that means.
Standards read_standards(const Place& place, const Selection& selection, bool catalogue);

// A cell by its names, as gates and baselines know it.
struct CellName {
  std::string scenario, method, claim;
  std::int64_t steps = 0;
  bool probe = false;
  bool absent = false;  // a glob over an engine that is not built: its methods are unknown
  std::string at = {};  // a fluid's resolution (resolution_text)
};
std::vector<CellName> names_of(const std::vector<Cell>& cells);
// The cells that this selection would have without --scenario, --method, --steps, --hz, --spacing and --sound-speed
// (scenes of the user's own stay).
std::vector<CellName> unfiltered_cells(const Place& place, const Options& options, const Selection& selection);

// Which figures of a baseline are of these cells.
class FigureNames {
 public:
  explicit FigureNames(const std::vector<CellName>& cells);
  // Of figures of a ladder: `ladders` false: none; `resolutions` false: only those of one resolution of the cells'.
  bool has(const BaselineEntry& entry, bool ladders, bool resolutions) const;

 private:
  static constexpr std::int64_t kLadder = 0, kAnyResolution = -1;
  std::set<std::tuple<std::string, std::string, std::int64_t, std::string>> names_;
};

// Gates met with cells. Of the user's own gates none is left out in silence: one that matches no cell of the whole
// study is not run, with the part that matches nothing and the nearest name; one that only a filter leaves without
// cells is counted.
struct SiftedGates {
  std::vector<Gate> judged;
  std::vector<Verdict> unmatched;
  int left_out = 0;
};
SiftedGates sift_gates(const Place& place, const Options& options, const Selection& selection,
                       const std::vector<Gate>& gates);

// Planned cells that the store lacks and that a gate would judge: it is then not run, one verdict a gate, which says
// how many there are; what fails of the cells that are there stays beside it. Without any gate and baseline, one
// verdict on the study. `run_words`: the command that makes the cells.
void judge_missing(const Selection& selection, const std::vector<Gate>& gates, const StudyResult& result,
                   const std::vector<std::string>& run_words, std::vector<Verdict>& verdicts);
// "4 of 6 planned cells are not in the store (the first: ...)"; empty: all of them are.
std::string missing_words(const Selection& selection, const StudyResult& result);

struct Judged {
  std::vector<Verdict> verdicts;  // of gates; of the baseline, one a scenario and method; of cells that failed
  std::vector<CellEnding> cells;
  std::vector<BaselineChange> changes;
  std::vector<RefusedTruth> refused;
  std::vector<std::string> notes;
};
// Appends the changes, a verdict a scenario and method, and notes.
void judge_baseline(const Place& place, const Options& options, const Selection& selection, Baseline baseline,
                    const std::vector<Row>& rows, Judged& judged);
// Each metric has one unit: InputError where an entry of the baseline has another.
void require_units(const Baseline& baseline);
// `try_truths`: where a truth refuses, others are tried out, which takes seconds.
Judged judge_everything(const Place& place, const Options& options, const Selection& selection,
                        const Standards& standards, const StudyResult& result, bool try_truths);
// How each cell of the selection ended, and whether that fails a run.
std::vector<CellEnding> endings_of(const Selection& selection, const std::vector<Row>& rows);
// Why a user's own engine refused scenes: a sentence for each method and scene, the first ten of them.
class Refusals {
 public:
  void add(const Selection& selection, const std::vector<CellEnding>& endings);
  void append_to(std::vector<std::string>& notes) const;

 private:
  std::set<std::pair<std::string, std::string>> told_;
  std::vector<std::string> sentences_;
};
// The gates that judge these cells, claims replaced by their bounds.
SiftedGates asked_gates(const Place& place, const Options& options, const Selection& selection,
                        const std::vector<Gate>& gates, std::vector<std::string>& notes);
// A failing verdict for each of `judged.cells` that fails, and for each truth that could not be computed, unless
// its scene is among `told`.
void append_failed_cells(const Place& place, const Options& options, const Selection& selection,
                         const std::vector<Row>& rows, Judged& judged, std::set<std::string>& told);
int exit_of(const StudyResult& result, const std::vector<Verdict>& verdicts);

// Scenes of these rows whose truth refuses, each once, with what covers it instead.
std::vector<RefusedTruth> refused_truths(const Place& place, const std::vector<Scenario>& scenarios,
                                         const std::vector<Row>& rows, bool try_truths);
// Which other kinds of truth cover this scene, tried out: "`kind = "cvode"` covers it". `limit_s` a kind.
std::string other_truths(const Place& place, const Scenario& scenario, double limit_s);

std::vector<ClaimedOrder> claimed_orders(const Selection& selection, const std::vector<Row>& rows);
void add_judged(ReportData& data, const Selection& selection, const Judged& judged);
int no_baseline(const Options& options, const std::string& path);  // says so; the exit code
// --scenario, --method, --steps or --hz, --spacing and --sound-speed of this call: a flag and its value in turn.
std::vector<std::string> filter_words(const Options& options);
// This call with another command (run, bless), as a shell's line that works in any folder: the program as it was
// called, the study, filters, engines, --out, absolute paths. `baseline`: where bless writes to.
std::string same_call(const Options& options, const std::string& command, const std::string& baseline = "");
std::vector<std::string> same_call_words(const Options& options, const std::string& command,
                                         const std::string& baseline = "");
std::string improvements_hint(const Options& options, const ReportData& data);  // a line, or nothing
// Annotations to standard output (to standard error beside JSON), the summary to $GITHUB_STEP_SUMMARY.
void report_to_github(const Options& options, const ReportData& data);

// "body `ball` is not finite at t = 0.5 s" of the first number of a motion that is not; empty: all are.
std::string not_finite_words(const Recording& run, const Scene& scene);

}  // namespace atwood
