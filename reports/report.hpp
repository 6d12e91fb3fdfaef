// Rows in, documents out. Rendering runs no physics: a report can be made again from its rows.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "benchmarks/figures.hpp"
#include "protocol/method.hpp"
#include "scene/scene.hpp"
#include "validation/gates/gates.hpp"
#include "validation/metrics/metrics.hpp"
#include "validation/metrics/overhead.hpp"
#include "validation/metrics/work_precision.hpp"
#include "validation/row.hpp"
#include "validation/study/study.hpp"
#include "validation/study/truth_paths.hpp"

namespace atwood {

// A table of measured figures for a terminal.
std::string render_bench_table(const BenchTable& table);

// A law that predicts a measured figure, printed beside it ("range error = v_x h").
struct Law {
  std::string scenario, method, metric, statement;
  std::int64_t steps;
  double predicted, measured;
  std::string unit;
};

std::string last_quarter_words(double error);  // "2e-10 over the last quarter"; infinity: "not finite .."
std::string floor_words(double error);         // what accuracy_floor() says of a goal's error
// "58 finer rungs of 9 methods, whose coarser ones cost more than 10 times .."
std::string left_out_words(const GoalResult& goal);
std::string machine_words(const MachineState& machine);  // "3 of 150 timings interrupted, 2.9 to 3.1 GHz"
// Which goals were timed again, and which remained on a busy machine; empty: none.
std::string busy_words(const std::vector<GoalResult>& goals);
std::string goal_words(const GoalResult& goal);                // "error-state-end 2e-10 in 40 us"
std::string goals_text(const std::vector<GoalResult>& goals);  // for a terminal: asked, reached, the best of each side

// A library's own claim beside what its method does, problem by problem (the study `audit`). A method's order is a
// whole number, so an executed order within a quarter of one is evidence of that one; in between it is evidence of
// none.
enum class AuditVerdict { as_claimed, lower, higher, inconclusive, unsupported };
struct AuditProblem {
  std::string scenario;
  AuditVerdict verdict = AuditVerdict::inconclusive;
  double order = 0, half_width_95 = 0;  // NaN when inconclusive or unsupported
  std::string quantity;                 // "position", or "velocity" where position's order is inconclusive
  std::string reason;                   // the window and interval, or why there is none
};
struct AuditFinding {
  std::string method, claim;  // claim: where the claimed order comes from
  double claimed = 0;
  AuditVerdict verdict = AuditVerdict::inconclusive;  // lower on one problem: lower; else higher on two, or on
                                                      // the only one that tells: higher; ...
  std::vector<AuditProblem> problems;
};
std::string to_string(AuditVerdict verdict);
// Of every method whose engine is not ours and that claims an order, at equal steps. And of every method run with three
// tolerances or more, as "lib/method:tol": the claim is then an error in proportion to the tolerance, and the executed
// figure the exponent p of error ~ tolerance^p (largest position error of the run); under 1/2, or an error over
// tolerance that varies a thousandfold, counts as lower where the error is over a hundred times its tolerance.
std::vector<AuditFinding> audit_orders(const std::vector<Engine>& engines, const std::vector<Row>& rows);
// Findings first, each with its claim, its executed orders and the command that prints its evidence.
std::string render_audit_table(const std::vector<AuditFinding>& findings, bool colour, int width);

// How a cell ended: a case of JUnit beside those of the gates.
struct CellEnding {
  std::string scenario, method;
  std::int64_t steps = 0;
  Status status = Status::ok;
  std::string reason = {};
  bool there = true;   // false: the store does not have it
  Resolution at = {};  // of fluids
  bool fails = false;  // crashed, hung, sent an invalid answer; or blew up where that is not allowed
};

// A truth that does not cover its scene: nothing that needs one is measured there.
struct RefusedTruth {
  std::string scenario, truth;  // "extended precision, two methods"
  Status status = Status::unsupported;
  std::string reason, remedy;  // which other truth covers the scene, in words
  std::string method = {};     // whose cells alone have no such truth; empty: all that ran
  bool has_errors = false;     // errors against an exact field are measured; that of the steps is not told apart
};

// What a method claims beside what its ladder shows.
struct ClaimedOrder {
  std::string scenario, method, metric;
  double claimed = 0, observed = 0, half_width_95 = 0;  // observed: NaN where the ladder is inconclusive
  bool foreign = false;                                 // of the user's own engine
};
// "claims 2, observed 0.98 +/- 0.02: below its claim", or above it; empty where the two agree or nothing is observed.
std::string claim_words(const ClaimedOrder& order);

// Counts of the cells and gates of a scene, or of all scenes.
struct SceneCounts {
  std::size_t ladders = 0, shown = 0, cells = 0, not_ok = 0, missing = 0;
  std::size_t pass = 0, fail = 0, unverifiable = 0, not_run = 0;
};
struct CountedScene {
  std::string scenario;
  SceneCounts counts;
  std::string command;  // a line for a shell: the report of this scene alone
};

struct ReportData {
  std::string title;
  std::string command;             // how this report was made
  std::string program = "atwood";  // its first word, quoted for a shell: as the program was called
  Provenance provenance;
  std::vector<Scenario> scenarios;
  std::map<std::string, std::string> own_files;                      // scenario: the user's file that reruns it
  std::vector<Engine> engines;                                       // settings of every method
  std::vector<std::pair<std::string, std::string>> missing_engines;  // name, reason
  std::vector<MetricInfo> metrics;
  std::vector<Row> rows;
  std::vector<Verdict> verdicts;
  std::vector<StoredSeries> series;
  std::vector<StoredPicture> pictures;  // of fluids
  std::vector<TruthPath> paths;         // of the truths: pictures of the scenes
  std::vector<Law> laws;
  std::vector<BenchFigure> bench;
  std::vector<Dominance> dominance;  // which method is cheapest for an error, which most accurate for a budget
  std::string rates;                 // compare: whose right-hand sides the ranked methods evaluate, a sentence
  bool same_rate = false;            // ... all of them the reference's
  std::vector<MethodOverhead> overheads;
  std::vector<GoalResult> goals;
  std::vector<BenchTable> tables;
  std::vector<AuditFinding> audit;  // of the study `audit`
  bool compared = false;            // methods side by side: nothing is judged
  std::vector<std::string> notes;   // how this report's cells came about, in sentences
  // Of studies of so many cells that the rows and verdicts above are those of some ladders: all that was counted.
  // Empty: they are those of all.
  std::vector<CountedScene> counted;
  SceneCounts counted_in_all;
  std::vector<CellEnding> cells;
  std::vector<RefusedTruth> refused_truths;
  std::vector<ClaimedOrder> claimed_orders;
  std::string baseline_path;  // empty: no baseline was judged
  std::vector<BaselineChange> baseline;
  // Beside no baseline: the last run of the same study and selection, in words, and what changed since. Empty: none is
  // known, and `first_run` says whether there was none.
  std::string last_run;
  std::vector<BaselineChange> since_last_run;
  bool first_run = false;
};

std::string render_html(const ReportData& data);  // one self-contained file
std::string render_json(const ReportData& data);
std::string render_csv(const std::vector<Row>& rows);  // the contract's columns
std::string render_markdown(const ReportData& data);
std::string render_junit(const std::vector<Verdict>& verdicts, const std::vector<CellEnding>& cells = {});
// What `run` ends with: of up to 40 pairs of scenario and method a table of figures, of more a line a scenario; then
// every gate and cell that did not pass with its command, what truths and claims have to say, and the verdict.
std::string render_run_table(const ReportData& data, bool colour, int width);
// What did not pass, then one line: the verdict's counts and `tail`.
std::string render_quiet(const ReportData& data, const std::string& tail);
// One line a scenario and method that became worse, the worst first, with its command; then what is missing, better and
// new, counted.
std::string render_baseline_table(const std::string& path, const std::vector<BaselineChange>& changes, bool colour);
std::string render_baseline_json(const std::vector<BaselineChange>& changes);  // an array of what is not unchanged
// Workflow commands of GitHub Actions, at most ten lines; and the summary of a step, in Markdown. `workspace`: the
// folder that files are named from.
std::string render_github_annotations(const ReportData& data, const std::string& workspace);
std::string render_step_summary(const ReportData& data);
std::string render_verdict_table(const std::vector<Verdict>& verdicts, const std::vector<Row>& rows, bool colour,
                                 int width);

}  // namespace atwood
