// Tolerances as data, each with a reason; verdicts that can fail.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "validation/row.hpp"

namespace atwood {

struct Gate {
  std::string scenario, method, metric;           // globs
  std::optional<std::int64_t> steps;
  enum class Kind { within, max, min, max_ratio, within_claim } kind = Kind::max;
  double low = 0, high = 0;                       // within; max uses high, min uses low, max_ratio uses high
  std::string claim;                              // within_claim: the class of motion, until claims are known
  std::string ratio_to;                           // max_ratio: the other method
  std::string reason;                             // required
  std::string study;                              // the file's `study = "..."`: it is about that study's runs alone
  std::string origin;                             // file:line
};

enum class Judgement { pass, fail, unverifiable, not_run };

struct Verdict {
  Gate gate;
  Judgement judgement = Judgement::not_run;
  std::string scenario, method, metric, unit;     // of the row it judges; of the gate when not_run
  std::int64_t steps = 0;
  double value = 0, bar = 0, allowed_low = 0, allowed_high = 0, margin = 0;
  std::string text;                               // measured, allowed, margin, in words
  std::string rerun;                              // the command that reruns just that cell
};

std::vector<Gate> read_gates(const std::string& path);  // InputError on anything unknown or ambiguous

// A ladder that is to show the order its method claims in a class of motion.
struct Claim { std::string scenario, method, motion; double order = 0; };
// Each `within_claim` gate becomes one `within` gate a matching claim: the claimed order, give or take max(0.1, 2 %).
// Gates on claims that no ladder of this study is to show are left out.
std::vector<Gate> gates_of_claims(std::span<const Gate> gates, std::span<const Claim> claims);
std::vector<Verdict> judge(std::span<const Gate> gates, std::span<const Row> rows);  // one a gate x matching row
std::string to_string(Judgement judgement);

// Does the shell-like pattern (* ? and literal text) match the whole of `text`?
bool glob_match(const std::string& pattern, const std::string& text);

// ---- baselines: sorted, one metric a line, no timestamps, the environment in a file beside ------------------
void write_baseline(const std::string& path, std::span<const Row> rows, const std::string& reason);
struct BaselineChange {
  enum class Kind { regression, improvement, unchanged, missing, added } kind;
  std::string scenario, method, metric; std::int64_t steps; double before, now, bar; std::string text, rerun;
};
std::vector<BaselineChange> compare_baseline(const std::string& path, std::span<const Row> rows);  // throws if no file

}  // namespace atwood
