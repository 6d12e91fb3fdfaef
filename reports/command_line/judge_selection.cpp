// Judges a run by gates, by a baseline and by the statuses of its cells.
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
#include <fmt/ranges.h>

#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

using CellKey = std::tuple<std::string, std::string, std::int64_t, Resolution>;

std::vector<Claim> claims_of(const Selection& selection) {
  std::set<std::tuple<std::string, std::string, std::string, double>> claimed;
  for (const Cell& cell : selection.cells)
    if (!cell.claim.empty()) claimed.insert({cell.scenario->id, cell.method, cell.claim, cell.claimed_order});
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
  SiftedGates sifted = asked_gates(place, options, selection, gates, judged.notes);
  judged.verdicts = judge(sifted.judged, rows);
  for (Verdict& verdict : judged.verdicts)
    verdict.rerun = with_own_files(place, options, selection, verdict.scenario, verdict.rerun);
  if (stored != nullptr)
    judge_missing(selection, sifted.judged, *stored, same_call_words(options, "run"), judged.verdicts);
  judged.verdicts.insert(judged.verdicts.end(), sifted.unmatched.begin(), sifted.unmatched.end());
}

// Without a gate or a baseline nothing else says that a part of the study was never measured.
Verdict cells_missing(const std::string& text, const std::vector<std::string>& words) {
  Verdict v;
  v.of_cell = true;
  v.scenario = v.gate.scenario = v.method = v.gate.method = "*";
  v.metric = v.gate.metric = "cells";
  v.gate.reason = "Every cell that the study plans must have been measured.";
  v.gate.origin = "the study itself";
  v.judgement = Judgement::not_run;
  v.value = v.allowed_high = std::numeric_limits<double>::quiet_NaN();
  v.text = text;
  v.rerun = words;
  return v;
}

// ---- how cells ended ----------------------------------------------------------------------------------------------

bool is_failure(Status status) { return status == Status::crashed || status == Status::timeout; }
bool blew_up(Status status) { return status == Status::diverged || status == Status::not_finite; }

// Runs of a user's own engine, and of methods that are named by id, must end ok.
bool must_end_well(const Cell& cell, const Selection& selection) {
  const bool foreign = cell.worker >= 0 && selection.workers[static_cast<std::size_t>(cell.worker)].foreign;
  return foreign || (!cell.pattern.empty() && !has_glob(cell.pattern));
}

}  // namespace

std::vector<CellEnding> endings_of(const Selection& selection, const std::vector<Row>& rows) {
  std::map<CellKey, const Row*> bad;
  std::set<CellKey> there;
  for (const Row& row : rows) {
    if (row.steps == 0) continue;
    const CellKey key{row.scenario, row.method, row.steps, resolution_of(row)};
    there.insert(key);
    if (row.status == Status::ok || row.metric == "truth") continue;
    if (row.metric != "status" && !is_failure(row.status)) continue;  // one figure that has no value
    const auto [place, is_new] = bad.try_emplace(key, &row);
    if (!is_new && is_failure(row.status) && !is_failure(place->second->status)) place->second = &row;
  }
  std::vector<CellEnding> endings;
  for (const Cell& cell : selection.cells) {
    CellEnding ending{cell.scenario->id, cell.method, cell.plan.steps};
    ending.at = resolution_of(cell);
    const CellKey key{ending.scenario, ending.method, ending.steps, ending.at};
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

void Refusals::add(const Selection& selection, const std::vector<CellEnding>& endings) {
  constexpr std::size_t max_shown = 10;
  for (std::size_t i = 0; i < endings.size() && i < selection.cells.size(); ++i) {
    const Cell& cell = selection.cells[i];
    const CellEnding& ending = endings[i];
    const bool foreign = cell.worker >= 0 && selection.workers[static_cast<std::size_t>(cell.worker)].foreign;
    if (!foreign || ending.status != Status::unsupported || !told_.insert({ending.method, ending.scenario}).second ||
        told_.size() > max_shown)
      continue;
    sentences_.push_back(fmt::format("{} does not run {}: {}.", ending.method, ending.scenario,
                                     ending.reason.empty() ? "its engine gives no reason" : printable(ending.reason)));
  }
}

void Refusals::append_to(std::vector<std::string>& notes) const {
  notes.insert(notes.end(), sentences_.begin(), sentences_.end());
  if (told_.size() > sentences_.size())
    notes.push_back(fmt::format("{} more scenes and methods are unsupported.", told_.size() - sentences_.size()));
}

SiftedGates asked_gates(const Place& place, const Options& options, const Selection& selection,
                        const std::vector<Gate>& gates, std::vector<std::string>& notes) {
  SiftedGates sifted = sift_gates(place, options, selection, gates);
  sifted.judged = gates_of_claims(sifted.judged, claims_of(selection));
  if (sifted.left_out > 0)
    notes.push_back(fmt::format("{} gate{} left out by the filter.", sifted.left_out, sifted.left_out == 1 ? "" : "s"));
  return sifted;
}

void append_failed_cells(const Place& place, const Options& options, const Selection& selection,
                         const std::vector<Row>& rows, Judged& judged, std::set<std::string>& told) {
  const auto append = [&](const std::string& scenario, const std::string& method, std::int64_t steps,
                          const Resolution& at, const std::string& metric, const std::string& text,
                          const std::string& reason) {
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
    verdict.rerun = with_own_files(place, options, selection, scenario, rerun_words(scenario, method, steps, at));
    judged.verdicts.push_back(std::move(verdict));
  };
  for (const CellEnding& cell : judged.cells)
    if (cell.fails)
      append(
          cell.scenario, cell.method, cell.steps, cell.at, "status",
          fmt::format("{}: {}", to_string(cell.status), cell.reason),
          is_failure(cell.status)
              ? "A run must end normally."
              : "A method of a user's engine, or one that is named, must stay finite unless the study's `allow` excuses it.");
  for (const Row& row : rows)
    if (row.metric == "truth" && is_failure(row.status) && told.insert(row.scenario).second)
      append(row.scenario, row.method, row.steps, resolution_of(row), "truth",
             fmt::format("{}: {}", to_string(row.status), row.reason),
             "A truth must be computed, or be refused with a reason.");
}

std::string improvements_hint(const Options& options, const ReportData& data) {
  const bool better = std::any_of(data.baseline.begin(), data.baseline.end(),
                                  [](const BaselineChange& c) { return c.kind == BaselineChange::Kind::improvement; });
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
  Refusals refusals;
  refusals.add(selection, judged.cells);
  refusals.append_to(judged.notes);
  std::set<std::string> told_truths;
  append_failed_cells(place, options, selection, result.rows, judged, told_truths);
  if (result.hosts.size() > 1)
    judged.notes.push_back(fmt::format(
        "Times of these cells are of {} hosts ({}): those of a scenario are ranked only where one host measured them all.",
        result.hosts.size(), fmt::join(result.hosts, ", ")));
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

void report_to_github(const Options& options, const ReportData& data) {
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
