// What a run is held against, and what came of it: gates, a baseline, and how each cell ended.
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <map>
#include <set>
#include <stdexcept>
#include <tuple>

#include <fmt/format.h>

#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

using Kind = BaselineChange::Kind;
using CellKey = std::tuple<std::string, std::string, std::int64_t>;

bool has_glob(const std::string& text) { return text.find_first_of("*?") != std::string::npos; }

std::vector<Claim> claims_of(const Selection& selection) {
  std::set<std::tuple<std::string, std::string, std::string, double>> claimed;
  for (const Cell& cell : selection.cells)
    if (!cell.claim.empty()) claimed.insert({cell.scenario.id, cell.method, cell.claim, cell.claimed_order});
  std::vector<Claim> claims;
  for (const auto& [scenario, method, motion, order] : claimed) claims.push_back({scenario, method, motion, order});
  return claims;
}

std::vector<Gate> gates_named(const Place& place, const std::string& file) {
  if (file.empty()) return read_all_gates(place);
  std::vector<Gate> gates = read_gates(file);
  for (Gate& gate : gates) gate.named = true;
  return gates;
}

void judge_gates(const Place& place, const Options& options, const Selection& selection, const std::vector<Gate>& gates,
                 const std::vector<Row>& rows, Judged& judged, const StudyResult* stored = nullptr) {
  const SiftedGates sifted = sift_gates(place, options, selection, gates);
  const std::vector<Gate> asked = gates_of_claims(sifted.judged, claims_of(selection));
  judged.verdicts = judge(asked, rows);
  for (Verdict& verdict : judged.verdicts)
    verdict.rerun = with_own_files(place, options, selection, verdict.scenario, verdict.rerun);
  if (stored != nullptr) judge_missing(selection, asked, *stored, same_call_words(options, "run"), judged.verdicts);
  judged.verdicts.insert(judged.verdicts.end(), sifted.unmatched.begin(), sifted.unmatched.end());
  if (sifted.left_out > 0)
    judged.notes.push_back(
        fmt::format("{} gate{} left out by the filter.", sifted.left_out, sifted.left_out == 1 ? "" : "s"));
}

// ---- the baseline -------------------------------------------------------------------------------------------------

// "atwood/dopri5:1e-8@quad" and "atwood/dopri5@quad": figures of a ladder of tolerances go by the id without one.
std::string without_tolerance(const std::string& method) {
  const std::size_t colon = method.find(':');
  if (colon == std::string::npos) return method;
  const std::size_t end = std::min(method.find_first_of("+@{", colon), method.size());
  return method.substr(0, colon) + method.substr(end);
}

bool names_cell(const BaselineEntry& entry, const std::vector<CellName>& cells, bool with_ladders) {
  return std::any_of(cells.begin(), cells.end(), [&](const CellName& cell) {
    if (cell.scenario != entry.scenario) return false;
    if (entry.steps == 0)
      return with_ladders && (cell.method == entry.method || without_tolerance(cell.method) == entry.method);
    return cell.method == entry.method && cell.steps == entry.steps;
  });
}

// Each metric has one unit: a figure in another one, edited by hand, would be compared as if it were in the metric's.
void require_units(const Baseline& baseline) {
  std::map<std::string, std::string> units;
  for (const MetricInfo& metric : all_metrics()) units[metric.name] = metric.unit;
  for (const BaselineEntry& e : baseline.entries) {
    const auto known = units.find(e.metric);
    if (known != units.end() && known->second != e.unit)
      throw InputError(fmt::format("{}: {} {} {}: the unit is `{}`; expected `{}`, the unit of this metric",
                                   baseline.path, e.scenario, e.method, e.metric, e.unit, known->second));
  }
}

// Inconclusive in the baseline, a number now: told, since nothing holds such a figure to anything.
void tell_no_numbers(Judged& judged) {
  const auto count = std::count_if(judged.changes.begin(), judged.changes.end(), [](const BaselineChange& c) {
    return c.kind == Kind::added && c.text.starts_with("was not a number");
  });
  if (count > 0)
    judged.notes.push_back(
        fmt::format("{} figure{} not a number in the baseline and {} one now: counted as new, not compared.", count,
                    count == 1 ? " was" : "s were", count == 1 ? "is" : "are"));
}

// Figures that only a filter of this call leaves without a cell are no loss.
int leave_out_filtered(const Place& place, const Options& options, const Selection& selection, Baseline& baseline) {
  if (options.scenarios.empty() && options.methods.empty() && options.steps.empty()) return 0;
  std::vector<CellName> kept;
  for (const Cell& cell : selection.cells)
    kept.push_back({cell.scenario.id, cell.method, cell.claim, cell.plan.steps, false, false});
  const std::vector<CellName> whole = unfiltered_cells(place, options, selection);
  return static_cast<int>(std::erase_if(baseline.entries, [&](const BaselineEntry& entry) {
    return !names_cell(entry, kept, options.steps.empty()) && names_cell(entry, whole, true);
  }));
}

// One verdict a scenario and method: the figure that became worse most, or what is missing.
std::vector<Verdict> baseline_verdicts(const Baseline& baseline, const std::vector<BaselineChange>& changes) {
  struct Group {
    const BaselineChange* worst = nullptr;
    const BaselineChange* first = nullptr;
    int count[5] = {};
  };
  std::map<std::pair<std::string, std::string>, Group> groups;
  for (const BaselineChange& change : changes) {
    if (change.kind == Kind::added) continue;
    Group& group = groups[{change.scenario, change.method}];
    if (group.first == nullptr || change.kind == Kind::missing) group.first = &change;
    ++group.count[static_cast<int>(change.kind)];
    if (change.kind == Kind::regression && (group.worst == nullptr || change.ratio > group.worst->ratio))
      group.worst = &change;
  }
  std::vector<Verdict> verdicts;
  for (const auto& [key, group] : groups) {
    const int worse = group.count[static_cast<int>(Kind::regression)],
              missing = group.count[static_cast<int>(Kind::missing)];
    const BaselineChange& change = group.worst ? *group.worst : *group.first;
    Verdict v;
    v.of_baseline = true;
    v.scenario = v.gate.scenario = key.first;
    v.method = v.gate.method = key.second;
    v.metric = v.gate.metric = group.worst ? change.metric : "baseline";
    v.gate.reason = "As good as the baseline.";
    v.gate.origin = baseline.path;
    v.steps = group.worst ? change.steps : 0;
    v.unit = group.worst ? change.unit : "";
    v.value = group.worst ? change.now : std::numeric_limits<double>::quiet_NaN();
    v.bar = group.worst ? change.bar : 0;
    v.gate.kind = group.worst && change.metric.starts_with("order-") ? Gate::Kind::min : Gate::Kind::max;
    v.allowed_low = v.gate.kind == Gate::Kind::min ? change.allowed : -std::numeric_limits<double>::infinity();
    v.allowed_high = v.gate.kind == Gate::Kind::min ? std::numeric_limits<double>::infinity() : change.allowed;
    v.margin = v.gate.kind == Gate::Kind::min ? v.value - v.allowed_low : v.allowed_high - std::abs(v.value);
    v.judgement = worse > 0 ? Judgement::fail : missing > 0 ? Judgement::not_run : Judgement::pass;
    v.rerun = change.rerun;
    std::string text;
    if (group.worst) text = fmt::format("worse than the baseline: {}", change.text);
    if (worse > 1) text += fmt::format("; {} more figure{}", worse - 1, worse == 2 ? "" : "s");
    if (missing > 0)
      text += fmt::format("{}{} figure{} of the baseline not measured now", text.empty() ? "" : "; ", missing,
                          missing == 1 ? "" : "s");
    if (text.empty())
      text = fmt::format("{} figures as they were, {} better", group.count[static_cast<int>(Kind::unchanged)],
                         group.count[static_cast<int>(Kind::improvement)]);
    v.text = text;
    verdicts.push_back(v);
  }
  return verdicts;
}

// Without a gate or a baseline nothing else says that a part of the study was never measured.
Verdict cells_missing(const std::string& text, const std::vector<std::string>& words) {
  Verdict v;
  v.of_cell = true;
  v.scenario = v.gate.scenario = v.method = v.gate.method = "*";
  v.metric = v.gate.metric = "cells";
  v.gate.reason = "What a study plans has been measured.";
  v.gate.origin = "the study itself";
  v.judgement = Judgement::not_run;
  v.value = v.allowed_high = std::numeric_limits<double>::quiet_NaN();
  v.text = text;
  v.rerun = words;
  return v;
}

Verdict nothing_compared(const Baseline& baseline, const std::string& why) {
  Verdict v;
  v.scenario = v.gate.scenario = v.method = v.gate.method = "*";
  v.metric = v.gate.metric = "baseline";
  v.gate.reason = "As good as the baseline.";
  v.gate.origin = baseline.path;
  v.judgement = Judgement::not_run;
  v.value = v.allowed_high = std::numeric_limits<double>::quiet_NaN();
  v.text = fmt::format("{}: {}", baseline.path, why);
  return v;
}

void judge_baseline(const Place& place, const Options& options, const Selection& selection, Baseline baseline,
                    const std::vector<Row>& rows, Judged& judged) {
  judged.notes.insert(judged.notes.end(), baseline.notes.begin(), baseline.notes.end());
  const bool empty = baseline.entries.empty();
  if (const int left_out = leave_out_filtered(place, options, selection, baseline); left_out > 0)
    judged.notes.push_back(
        fmt::format("{} figure{} of the baseline left out by the filter.", left_out, left_out == 1 ? "" : "s"));
  judged.changes = compare_baseline(baseline, rows);
  if (!options.steps.empty())  // a part of a ladder has no figure of the whole: none was compared, and none is new
    std::erase_if(judged.changes, [](const BaselineChange& c) { return c.kind == Kind::added && c.steps == 0; });
  for (BaselineChange& change : judged.changes)
    change.rerun = with_own_files(place, options, selection, change.scenario, change.rerun);
  tell_no_numbers(judged);
  const bool compared = std::any_of(judged.changes.begin(), judged.changes.end(), [](const BaselineChange& change) {
    return change.kind != Kind::missing && change.kind != Kind::added;
  });
  const std::vector<Verdict> verdicts = baseline_verdicts(baseline, judged.changes);
  judged.verdicts.insert(judged.verdicts.end(), verdicts.begin(), verdicts.end());
  if (!compared)
    judged.verdicts.push_back(nothing_compared(
        baseline, empty ? "it holds no figure"
                        : "none of its figures is of a cell that was measured here: nothing was compared"));
  const std::vector<std::string> differing = environment_changes(baseline, rows);
  judged.notes.insert(judged.notes.end(), differing.begin(), differing.end());
}

// ---- how cells ended ----------------------------------------------------------------------------------------------

bool is_failure(Status status) { return status == Status::crashed || status == Status::timeout; }
bool blew_up(Status status) { return status == Status::diverged || status == Status::not_finite; }

// An engine of the user's own, or a method that was asked for by its name, must come to its end.
bool must_end_well(const Cell& cell, const Selection& selection) {
  const bool foreign = cell.worker >= 0 && selection.workers[static_cast<std::size_t>(cell.worker)].foreign;
  return foreign || (!cell.pattern.empty() && !has_glob(cell.pattern));
}

std::vector<CellEnding> endings_of(const Selection& selection, const std::vector<Row>& rows) {
  std::map<CellKey, const Row*> bad;
  std::set<CellKey> there;
  for (const Row& row : rows) {
    if (row.steps == 0) continue;
    const CellKey key{row.scenario, row.method, row.steps};
    there.insert(key);
    if (row.status == Status::ok || row.metric == "truth") continue;
    if (row.metric != "status" && !is_failure(row.status)) continue;  // one figure that has no value
    const auto [place, is_new] = bad.try_emplace(key, &row);
    if (!is_new && is_failure(row.status) && !is_failure(place->second->status)) place->second = &row;
  }
  std::vector<CellEnding> endings;
  for (const Cell& cell : selection.cells) {
    CellEnding ending{cell.scenario.id, cell.method, cell.plan.steps};
    const CellKey key{ending.scenario, ending.method, ending.steps};
    ending.there = there.contains(key);
    if (const auto found = bad.find(key); found != bad.end()) {
      ending.status = found->second->status;
      ending.reason = found->second->reason;
    }
    const bool allowed = std::find(cell.allow.begin(), cell.allow.end(), ending.status) != cell.allow.end();
    ending.fails = is_failure(ending.status) || (blew_up(ending.status) && !allowed && must_end_well(cell, selection));
    endings.push_back(std::move(ending));
  }
  return endings;
}

// Why a user's own engine refused scenes: a sentence for each method and scene, the first ten of them.
void tell_refusals(const Selection& selection, const std::vector<CellEnding>& endings,
                   std::vector<std::string>& notes) {
  constexpr int kShown = 10;
  std::set<std::pair<std::string, std::string>> told;
  for (std::size_t i = 0; i < endings.size() && i < selection.cells.size(); ++i) {
    const Cell& cell = selection.cells[i];
    const CellEnding& ending = endings[i];
    const bool foreign = cell.worker >= 0 && selection.workers[static_cast<std::size_t>(cell.worker)].foreign;
    if (!foreign || ending.status != Status::unsupported || !told.insert({ending.method, ending.scenario}).second)
      continue;
    if (told.size() > kShown) continue;
    notes.push_back(fmt::format("{} does not run {}: {}.", ending.method, ending.scenario,
                                ending.reason.empty() ? "its engine gives no reason" : printable(ending.reason)));
  }
  if (told.size() > kShown)
    notes.push_back(fmt::format("{} more scenes and methods are unsupported.", told.size() - kShown));
}

void append_failed_cells(const Place& place, const Options& options, const Selection& selection,
                         const std::vector<Row>& rows, Judged& judged) {
  const auto append = [&](const std::string& scenario, const std::string& method, std::int64_t steps,
                          const std::string& metric, const std::string& text, const std::string& reason) {
    Verdict verdict;
    verdict.of_cell = true;
    verdict.judgement = Judgement::fail;
    verdict.gate.scenario = verdict.scenario = scenario;
    verdict.gate.method = verdict.method = method;
    verdict.gate.metric = verdict.metric = metric;
    verdict.gate.reason = reason;
    verdict.gate.origin = "the run itself";
    verdict.steps = steps;
    verdict.value = verdict.allowed_high = std::numeric_limits<double>::quiet_NaN();
    verdict.text = text;
    verdict.rerun = with_own_files(place, options, selection, scenario, rerun_words(scenario, method, steps));
    judged.verdicts.push_back(std::move(verdict));
  };
  for (const CellEnding& cell : judged.cells)
    if (cell.fails)
      append(cell.scenario, cell.method, cell.steps, "status",
             fmt::format("{}: {}", to_string(cell.status), cell.reason),
             is_failure(cell.status)
                 ? "A run comes to its end."
                 : "A method of one's own, or asked for by name, stays finite; a study's `allow` says where not.");
  std::set<std::string> told;
  for (const Row& row : rows)
    if (row.metric == "truth" && is_failure(row.status) && told.insert(row.scenario).second)
      append(row.scenario, row.method, row.steps, "truth", fmt::format("{}: {}", to_string(row.status), row.reason),
             "A truth is there, or refuses in words.");
}

}  // namespace

namespace {

// A path that means the same file in any other folder. Links are left as they are.
std::string absolute_words(const std::string& path) {
  if (path.empty()) return path;
  fs::path whole;
  for (const fs::path& part : fs::absolute(path))
    if (part != ".") whole /= part;
  return whole.string();
}

// Of a word that may also be an id or a glob.
std::string absolute_if_file(const std::string& word) {
  std::error_code error;
  return fs::is_regular_file(word, error) ? absolute_words(word) : word;
}

}  // namespace

// The command that reruns a verdict's cell must bring along what the catalogue does not have: a scene's file, an
// engine, gates.
std::vector<std::string> with_own_files(const Place& place, const Options& options, const Selection& selection,
                                        const std::string& scenario_id, std::vector<std::string> words) {
  if (words.empty()) return words;
  if (!options.words.empty()) words[0] = options.words[0];
  for (const auto& scenario : selection.scenarios) {
    if (scenario.id != scenario_id || own_file(place, scenario).empty()) continue;
    for (std::size_t i = 1; i < words.size(); ++i)
      if (words[i - 1] == "--scenario" && words[i] == scenario.id) words[i] = absolute_words(scenario.path);
  }
  if (!options.study.empty() && words.size() > 1 && words[1] == "run")
    words.insert(words.begin() + 2, absolute_if_file(options.study));
  const auto add = [&](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  for (const auto& engine : options.engines) add("--engine", absolute_if_file(engine));
  add("--tolerances", absolute_words(options.tolerances));
  add("--baseline", absolute_words(options.baseline));
  if (options.limit_given) add("--limit", fmt::format("{}", options.cell_limit_s));
  add("--out", absolute_words(options.out_dir));
  return words;
}

std::vector<std::string> same_call_words(const Options& options, const std::string& command,
                                         const std::string& baseline) {
  std::vector<std::string> words{options.words.empty() ? "atwood" : options.words.front(), command};
  const auto add = [&](const char* flag, const std::string& value) {
    if (!value.empty()) words.insert(words.end(), {flag, value});
  };
  if (!options.study.empty()) words.push_back(absolute_if_file(options.study));
  for (const std::string& scenario : options.scenarios) add("--scenario", absolute_if_file(scenario));
  for (const std::string& method : options.methods) add("--method", method);
  if (options.hz.empty())
    for (const std::int64_t steps : options.steps) add("--steps", std::to_string(steps));
  for (const double hz : options.hz) add("--hz", fmt::format("{}", hz));
  for (const std::string& engine : options.engines) add("--engine", absolute_if_file(engine));
  if (command == "run") add("--tolerances", absolute_words(options.tolerances));
  if (command == "run" && options.limit_given) add("--limit", fmt::format("{}", options.cell_limit_s));
  if (command == "bless") {
    add("--reason", "TEXT");
    add("--baseline", absolute_words(baseline));
  }
  add("--out", absolute_words(options.out_dir));
  return words;
}

std::string same_call(const Options& options, const std::string& command, const std::string& baseline) {
  return shell_line(same_call_words(options, command, baseline));
}

std::string improvements_hint(const Options& options, const ReportData& data) {
  const bool better = std::any_of(data.baseline.begin(), data.baseline.end(),
                                  [](const BaselineChange& c) { return c.kind == Kind::improvement; });
  return better ? "to keep the improvements: " + same_call(options, "bless", data.baseline_path) + "\n" : "";
}

std::vector<Gate> read_all_gates(const Place& place) {
  std::set<std::string> files;
  for (const auto& entry : fs::directory_iterator(place.source_dir + "/validation/gates")) {
    if (entry.path().extension() == ".toml") files.insert(entry.path().string());
  }
  std::vector<Gate> gates;
  for (const auto& file : files) {
    const auto read = read_gates(file);
    gates.insert(gates.end(), read.begin(), read.end());
  }
  return gates;
}

Standards read_standards(const Place& place, const Selection& selection, bool catalogue) {
  Standards standards;
  if (catalogue || !selection.tolerances.empty()) standards.gates = gates_named(place, selection.tolerances);
  if (!selection.baseline.empty() && fs::exists(selection.baseline))
    standards.baseline = read_baseline(selection.baseline);
  if (standards.baseline) require_units(*standards.baseline);
  return standards;
}

std::vector<Verdict> judge_selection(const Place& place, const Options& options, const Selection& selection,
                                     const std::vector<Row>& rows) {
  Judged judged;
  judge_gates(place, options, selection, gates_named(place, options.tolerances), rows, judged);
  return judged.verdicts;
}

Judged judge_everything(const Place& place, const Options& options, const Selection& selection,
                        const Standards& standards, const StudyResult& result, bool try_truths) {
  Judged judged;
  judge_gates(place, options, selection, standards.gates, result.rows, judged, &result);
  if (standards.baseline) judge_baseline(place, options, selection, *standards.baseline, result.rows, judged);
  if (judged.verdicts.empty() && !result.missing.empty())
    judged.verdicts.push_back(cells_missing(missing_words(selection, result), same_call_words(options, "run")));
  judged.cells = endings_of(selection, result.rows);
  tell_refusals(selection, judged.cells, judged.notes);
  append_failed_cells(place, options, selection, result.rows, judged);
  judged.refused = refused_truths(place, selection.scenarios, result.rows, try_truths);
  return judged;
}

int gate_exit(const std::vector<Verdict>& verdicts) {
  const bool all_pass = std::all_of(verdicts.begin(), verdicts.end(),
                                    [](const Verdict& verdict) { return verdict.judgement == Judgement::pass; });
  return all_pass ? exit_pass : exit_gate;
}

int exit_of(const StudyResult& result, const std::vector<Verdict>& verdicts) {
  if (result.interrupted) return 128 + result.signal;
  if (result.failed_cells > 0) return exit_cell;
  return gate_exit(verdicts);
}

void add_judged(ReportData& data, const Selection& selection, const Judged& judged) {
  data.verdicts = judged.verdicts;
  data.cells = judged.cells;
  data.refused_truths = judged.refused;
  data.claimed_orders = claimed_orders(selection, data.rows);
  data.notes.insert(data.notes.end(), judged.notes.begin(), judged.notes.end());
  data.baseline = judged.changes;
}

void tell_github(const Options& options, const ReportData& data) {
  if (!options.github) return;
  const char* workspace = std::getenv("GITHUB_WORKSPACE");
  fmt::print(options.json ? stderr : stdout, "{}", render_github_annotations(data, workspace ? workspace : ""));
  const char* path = std::getenv("GITHUB_STEP_SUMMARY");
  if (!path || !*path) return;
  std::ofstream file(path, std::ios::app | std::ios::binary);
  file << render_step_summary(data);
  file.close();
  if (!file) throw std::runtime_error(fmt::format("{}: cannot be written: {}", path, std::strerror(errno)));
}

}  // namespace atwood
