// Gates: tolerances as data, each with a reason, and the verdicts on them.
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood {

struct Gate {
  std::string scenario, method, metric;  // globs
  std::optional<std::int64_t> steps;
  std::optional<double> spacing_m = {}, sound_speed_m_per_s = {};  // of fluids: rows at this resolution alone
  enum class Kind { within, max, min, max_ratio, within_claim } kind = Kind::max;
  double low = 0, high = 0;  // within; max uses high, min uses low, max_ratio uses high
  std::string claim;         // within_claim: the class of motion, until gates_of_claims() replaces the gate
  std::string ratio_to;      // max_ratio: the other method
  std::string reason;        // required
  std::string study;         // the file's `study = "..."`: the gate judges only runs of that study
  bool named = false;        // of a file that the user named: it is never left out silently
  std::string origin;        // file:line
  // In a narrowed run, of a gate with globs: cells that the command line left out may match and have its metric, so
  // that without rows it gives no verdict. The whole study judges it.
  bool partial = false;
};

enum class Judgement { pass, fail, unverifiable, not_run };

struct Verdict {
  Gate gate;
  Judgement judgement = Judgement::not_run;
  std::string scenario, method, metric, unit;  // of the row it judges; of the gate when not_run
  std::int64_t steps = 0;
  std::optional<double> spacing_m = {}, sound_speed_m_per_s = {};
  double value = 0, bar = 0, allowed_low = 0, allowed_high = 0, margin = 0;
  std::string text;                // measured, allowed and margin as a sentence
  std::vector<std::string> rerun;  // the words of the command that reruns just that cell, program first
  bool of_cell = false;            // the status of a cell, which no gate judges
  bool of_baseline = false;        // the comparison of a scenario and method with the baseline
};

// The words that rerun a cell: {"atwood", "run", "--scenario", ...}. Of a whole ladder where steps is 0.
std::vector<std::string> rerun_words(const std::string& scenario, const std::string& method, std::int64_t steps,
                                     const Resolution& at = {});
// One line that a POSIX shell splits into exactly these words, whatever bytes they contain. Plain words are unchanged,
// others are in single quotes; a word with control characters or invalid UTF-8 is written by printf, so that the line
// itself contains no such byte.
std::string shell_line(std::span<const std::string> words);

std::vector<Gate> read_gates(const std::string& path);  // InputError on anything unknown or ambiguous

// A ladder that measures the order its method claims for a class of motion.
struct Claim {
  std::string scenario, method, motion;
  double order = 0;
};
// Replaces each `within_claim` gate by a `within` gate for each matching claim: the claimed order +- max(0.1, 2 %).
// Gates on claims that no ladder of this study measures are left out.
std::vector<Gate> gates_of_claims(std::span<const Gate> gates, std::span<const Claim> claims);
std::vector<Verdict> judge(std::span<const Gate> gates, std::span<const Row> rows);  // one per gate and matching row
// The same where all rows together are too many to hold: ladder by ladder. The verdicts are those of judge(), in
// another order.
class LadderJudge {
 public:
  // `rivals`: the rows of every method that a gate's ratio is taken to.
  explicit LadderJudge(std::vector<Gate> gates, std::vector<Row> rivals = {});
  ~LadderJudge();
  std::vector<Verdict> add(std::span<const Row> rows);  // all rows of one scenario's method, or of several
  std::vector<Verdict> rest() const;                    // of gates without rows, of scenes without a truth

 private:
  struct State;
  std::unique_ptr<State> state_;
};
std::string to_string(Judgement judgement);

// Whether the glob (* and ?) matches the whole of `text`.
bool glob_match(const std::string& pattern, const std::string& text);
// Does the text hold a character of a pattern?
bool has_glob(const std::string& text);

// ---- baselines: sorted, one metric per line, no timestamps, the environment in a second file ----------------
// Of PATH and PATH.env
struct BaselineText {
  std::string figures, environment;
};
// The rows with status ok and a finite bar as a baseline. InputError: a blank reason.
BaselineText baseline_text(std::span<const Row> rows, const std::string& reason);

struct BaselineEntry {
  std::string scenario, method, metric;
  std::int64_t steps = 0;
  double value = 0, bar = 0;  // value may be NaN: inconclusive; bar is finite, not negative
  std::string unit;
  int definition = 1;  // the version of the metric's definition that it was measured by
};
struct Baseline {
  std::string path;
  std::vector<BaselineEntry> entries;                        // sorted by scenario, method, steps, metric
  std::map<std::string, std::set<std::string>> environment;  // "cpu", "flags", ..., "engine<tab>ode"; empty: no .env
  std::vector<std::string> notes;                            // warnings about the file, in sentences
};
// std::runtime_error: no file. InputError: not a baseline, truncated, an invalid number, or the same figure twice.
Baseline read_baseline(const std::string& path);

struct BaselineChange {
  enum class Kind { regression, improvement, unchanged, missing, added } kind = Kind::unchanged;
  std::string scenario, method, metric;
  std::int64_t steps = 0;
  double before = 0, now = 0, bar = 0;  // NaN: missing
  double allowed = 0;                   // the worst value that still counts as unchanged
  double ratio = 1;                     // the factor by which it became worse; infinite where it was exact
  std::string unit, text;
  std::vector<std::string> rerun;
};
inline const std::string kDefinitionChanged = "definition changed";
// A figure that was NaN in the baseline and is a number now is `added`, and so is one whose metric had another
// definition then; its text begins with kDefinitionChanged. A bar of the baseline is limited to 10 times
// the present one or 0.1 % of the value, whichever is larger.
std::vector<BaselineChange> compare_baseline(const Baseline& baseline, std::span<const Row> rows);
// Differences between the present environment and the .env file: processor and its features, mathematics library,
// compiler, flags, versions of the engines. A sentence each; none where there is no .env file.
std::vector<std::string> environment_changes(const Baseline& baseline, std::span<const Row> rows);

std::string six_digits(double value);  // as messages print figures: "%.6g"

}  // namespace atwood
