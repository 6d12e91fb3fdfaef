// gate and bless: judge what the store holds, or make it the baseline.
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/command_line.hpp"
#include "scene/files.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

const char* kind_name(BaselineChange::Kind kind) {
  switch (kind) {
    case BaselineChange::Kind::regression: return "regression";
    case BaselineChange::Kind::improvement: return "improvement";
    case BaselineChange::Kind::unchanged: return "unchanged";
    case BaselineChange::Kind::missing: return "missing";
    case BaselineChange::Kind::added: return "added";
  }
  return "";
}

std::string baseline_path(const Options& options) {
  return options.baseline.empty() ? "atwood-baseline.tsv" : options.baseline;
}

// A change of a baseline as a verdict, so that it reaches JUnit like any gate.
Verdict as_verdict(const BaselineChange& change) {
  Verdict verdict;
  verdict.gate.scenario = verdict.scenario = change.scenario;
  verdict.gate.method = verdict.method = change.method;
  verdict.gate.metric = verdict.metric = change.metric;
  verdict.gate.reason = "the baseline";
  verdict.steps = change.steps;
  verdict.value = change.now;
  verdict.bar = change.bar;
  verdict.allowed_high = change.before;
  verdict.text = change.text;
  verdict.rerun = change.rerun;
  const bool bad = change.kind == BaselineChange::Kind::regression;
  verdict.judgement = bad ? Judgement::fail
                      : change.kind == BaselineChange::Kind::missing ? Judgement::not_run : Judgement::pass;
  return verdict;
}

int judge_against_baseline(const Place& place, const Options& options, const Selection& selection,
                           const StudyResult& stored) {
  const std::string path = baseline_path(options);
  if (!fs::exists(path)) {
    fmt::print(stderr, "atwood: no baseline at {}; `atwood bless --reason TEXT --baseline {}` writes one\n", path,
               path);
    return exit_no_baseline;
  }
  auto changes = compare_baseline(path, stored.rows);
  for (auto& change : changes) change.rerun = with_own_files(place, options, selection, change.scenario, change.rerun);
  std::map<BaselineChange::Kind, int> counts;
  std::vector<Verdict> verdicts;
  for (const auto& change : changes) {
    ++counts[change.kind];
    verdicts.push_back(as_verdict(change));
  }
  if (options.json) {
    nlohmann::ordered_json out = nlohmann::ordered_json::array();
    for (const auto& change : changes) {
      if (change.kind == BaselineChange::Kind::unchanged) continue;
      out.push_back({{"kind", kind_name(change.kind)}, {"scenario", change.scenario}, {"method", change.method},
                     {"metric", change.metric}, {"steps", change.steps}, {"before", change.before}, {"now", change.now},
                     {"bar", change.bar}, {"text", change.text}, {"rerun", change.rerun}});
    }
    fmt::print("{}\n", out.dump(2));
  } else {
    for (const auto kind : {BaselineChange::Kind::regression, BaselineChange::Kind::missing,
                            BaselineChange::Kind::improvement, BaselineChange::Kind::added}) {
      int shown = 0;
      for (const auto& change : changes) {
        if (change.kind != kind) continue;
        if (++shown > 40) continue;
        fmt::print("{:<12} {}\n", kind_name(kind), change.text);
        if (kind == BaselineChange::Kind::regression) fmt::print("             {}\n", change.rerun);
      }
      if (shown > 40) fmt::print("{:<12} ... and {} more\n", kind_name(kind), shown - 40);
    }
    fmt::print("{} regressions, {} missing, {} improvements, {} added, {} unchanged against {}\n",
               counts[BaselineChange::Kind::regression], counts[BaselineChange::Kind::missing],
               counts[BaselineChange::Kind::improvement], counts[BaselineChange::Kind::added],
               counts[BaselineChange::Kind::unchanged], path);
    if (counts[BaselineChange::Kind::improvement] > 0)
      fmt::print("to keep the improvements: atwood bless --reason TEXT\n");
  }
  if (!options.junit.empty()) write_file(options.junit, render_junit(verdicts));
  return gate_exit(verdicts);
}

}  // namespace

int command_gate(const Place& place, const Options& options) {
  const Selection selection = select_cells(place, options);
  const StudyResult stored = load_rows(options.out_dir + "/store.db", selection.cells);
  const bool no_store = !fs::exists(options.out_dir + "/store.db");
  if (no_store) fmt::print(stderr, "atwood: no store at {}/store.db; `atwood run` makes one\n", options.out_dir);
  if (!options.baseline.empty()) return judge_against_baseline(place, options, selection, stored);
  const auto verdicts = judge_selection(place, options, selection, stored.rows);
  if (options.json) {
    ReportData data;
    data.title = "gate";
    data.command = options.program;
    data.provenance = place.provenance;
    data.verdicts = verdicts;
    fmt::print("{}\n", render_json(data));
  } else {
    fmt::print("{}", render_verdict_table(with_failed_cells(place, options, selection, stored, verdicts), stored.rows,
                                          use_colour(STDOUT_FILENO), terminal_width()));
  }
  if (!options.junit.empty()) write_file(options.junit, render_junit(verdicts));
  if (stored.failed_cells > 0) return exit_cell;
  return no_store ? exit_gate : gate_exit(verdicts);
}

int command_bless(const Place& place, const Options& options) {
  if (options.reason.find_first_not_of(" \t\n") == std::string::npos)
    throw InputError("bless: --reason is empty; expected why");
  const Selection selection = select_cells(place, options);
  const StudyResult stored = load_rows(options.out_dir + "/store.db", selection.cells);
  if (stored.rows.empty()) throw InputError("bless: the store has no rows of this study; run it first");
  write_baseline(baseline_path(options), stored.rows, options.reason);
  if (options.json) {
    const nlohmann::ordered_json out{
        {"baseline", baseline_path(options)}, {"rows", stored.rows.size()}, {"reason", options.reason}};
    fmt::print("{}\n", out.dump(2));
  } else {
    fmt::print("blessed as {}: its rows that can be judged, and the environment beside it\n", baseline_path(options));
  }
  return exit_pass;
}

}  // namespace atwood
