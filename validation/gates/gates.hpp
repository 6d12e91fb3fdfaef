// Tolerances as data, each with a reason; verdicts that can fail.
#pragma once

#include <map>
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
  std::string claim;         // within_claim: the class of motion, until claims are known
  std::string ratio_to;      // max_ratio: the other method
  std::string reason;        // required
  std::string study;         // the file's `study = "..."`: it is about that study's runs alone
  bool named = false;        // of a file that the user named: never left out in silence
  std::string origin;        // file:line
};

enum class Judgement { pass, fail, unverifiable, not_run };

struct Verdict {
  Gate gate;
  Judgement judgement = Judgement::not_run;
  std::string scenario, method, metric, unit;  // of the row it judges; of the gate when not_run
  std::int64_t steps = 0;
  std::optional<double> spacing_m = {}, sound_speed_m_per_s = {};
  double value = 0, bar = 0, allowed_low = 0, allowed_high = 0, margin = 0;
  std::string text;                // measured, allowed, margin, in words
  std::vector<std::string> rerun;  // the words of the command that reruns just that cell, program first
  bool of_cell = false;            // how a cell ended: no gate's question
  bool of_baseline = false;        // of a scenario and method against the baseline
};

// The words that rerun a cell: {"atwood", "run", "--scenario", ...}. Of a whole ladder where steps is 0.
std::vector<std::string> rerun_words(const std::string& scenario, const std::string& method, std::int64_t steps,
                                     const Resolution& at = {});
// Words as one line that a POSIX shell takes apart into exactly these words again, whatever bytes they hold. Plain words
// stand as they are, others in single quotes; one with control characters or broken UTF-8 is spelled by printf, so that
// neither a terminal nor a document meets such a byte.
std::string shell_line(std::span<const std::string> words);

std::vector<Gate> read_gates(const std::string& path);  // InputError on anything unknown or ambiguous

// A ladder that is to show the order its method claims in a class of motion.
struct Claim {
  std::string scenario, method, motion;
  double order = 0;
};
// Each `within_claim` gate becomes one `within` gate a matching claim: the claimed order, give or take max(0.1, 2 %).
// Gates on claims that no ladder of this study is to show are left out.
std::vector<Gate> gates_of_claims(std::span<const Gate> gates, std::span<const Claim> claims);
std::vector<Verdict> judge(std::span<const Gate> gates, std::span<const Row> rows);  // one a gate x matching row
std::string to_string(Judgement judgement);

// Does the shell-like pattern (* ? and literal text) match the whole of `text`?
bool glob_match(const std::string& pattern, const std::string& text);

// ---- baselines: sorted, one metric a line, no timestamps, the environment in a file beside ------------------
// Of PATH and PATH.env
struct BaselineText {
  std::string figures, environment;
};
// Rows that ended well, of whole runs, with a finite bar. InputError: a blank reason.
BaselineText baseline_text(std::span<const Row> rows, const std::string& reason);

struct BaselineEntry {
  std::string scenario, method, metric;
  std::int64_t steps = 0;
  double value = 0, bar = 0;  // value may be NaN: inconclusive; bar is finite, not negative
  std::string unit;
};
struct Baseline {
  std::string path;
  std::vector<BaselineEntry> entries;                        // sorted by scenario, method, steps, metric
  std::map<std::string, std::set<std::string>> environment;  // "cpu", "flags", ..., "engine<tab>ode"; empty: no .env
  std::vector<std::string> notes;                            // what its reader should know, in sentences
};
// std::runtime_error: no file. InputError: not a baseline, truncated, a number that is none, a figure that is there twice.
Baseline read_baseline(const std::string& path);

struct BaselineChange {
  enum class Kind { regression, improvement, unchanged, missing, added } kind = Kind::unchanged;
  std::string scenario, method, metric;
  std::int64_t steps = 0;
  double before = 0, now = 0, bar = 0;  // NaN: not there
  double allowed = 0;                   // the worst value that still counts as unchanged
  double ratio = 1;                     // how many times as bad as before; infinite where it was exact
  std::string unit, text;
  std::vector<std::string> rerun;
};
// A figure that was NaN then and is a number now is `added`. A bar of the baseline counts up to 10 times today's or 0.1 % of
// the value, whichever is larger.
std::vector<BaselineChange> compare_baseline(const Baseline& baseline, std::span<const Row> rows);
// What is another now than then, or is not in the .env: processor and its features, mathematics library, compiler, flags,
// versions of the engines. A sentence each; none where there is no .env.
std::vector<std::string> environment_changes(const Baseline& baseline, std::span<const Row> rows);

}  // namespace atwood
