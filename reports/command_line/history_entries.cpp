// What the history of runs keeps of a run: its entry, its figures; of joined shards, and of studies of many cells.
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <set>

#include <fmt/chrono.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include "reports/command_line/history.hpp"
#include "reports/render/text.hpp"
#include "scene/printable.hpp"
#include "validation/gates/times.hpp"
#include "validation/study/machine.hpp"
#include "validation/study/store.hpp"

namespace atwood {
namespace {

// The entry of a run that begins now; without study, selection and cells.
HistoryRun entry_of(const Place& place, const Options& options) {
  HistoryRun run;
  run.begun_ns = now_ns();
  run.command = options.program;
  run.commit = place.provenance.commit;
  run.host = host_name();
  run.cpu = place.provenance.cpu;
  return run;
}

}  // namespace

std::int64_t now_ns() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

void report_history(const std::exception& error, const char* what) {
  std::fputs(printable_lines(fmt::format("atwood: {}: {}\n", error.what(), what)).c_str(), stderr);
}

std::string history_path(const Options& options) { return options.out_dir + "/history.db"; }

std::string moment_words(std::int64_t ns) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::gmtime(static_cast<std::time_t>(ns / 1'000'000'000)));
}

std::string selection_words(const Options& options) {
  const std::vector<std::string> words = filter_words(options);
  return words.empty() ? "" : shell_line(words);
}

std::string verdict_words(const HistoryRun& run) {
  if (run.ended_ns == 0) return "not finished";
  if (run.verdict == "merged") return "merged, not judged";
  const std::int64_t bad = run.failed + run.unverifiable + run.not_run, all = bad + run.passed;
  if (run.verdict == "fail" && bad > 0) return fmt::format("fail, {} of {} gates", bad, all);
  if (run.verdict == "pass") return fmt::format("pass, {} gate{}", all, all == 1 ? "" : "s");
  return run.verdict;
}

std::optional<HistoryRun> begin_history(const Place& place, const Options& options, const Selection& selection) {
  HistoryRun run = entry_of(place, options);
  run.study = selection.study;
  run.selection = selection_words(options);
  run.cells = static_cast<std::int64_t>(selection.cells.size());
  try {
    RunHistory history(history_path(options), RunHistory::Mode::write);
    run.id = history.begin(run);
    return run;
  } catch (const std::runtime_error& error) {
    report_history(error, "this run is not kept in the history");
    return std::nullopt;
  }
}

void end_history(const Place& place, const Options& options, std::optional<HistoryRun>& run,
                 const std::vector<Row>& rows, const JudgementCounts& counts, const std::string& verdict) {
  if (!run) return;
  run->ended_ns = now_ns();
  run->verdict = verdict;
  run->passed = counts.pass, run->failed = counts.fail;
  run->unverifiable = counts.unverifiable, run->not_run = counts.not_run;
  std::vector<Row> measured, old_times;
  for (const Row& row : rows)
    (is_time(row.metric) && row.provenance->run_id != place.provenance.run_id ? old_times : measured).push_back(row);
  try {
    RunHistory(history_path(options), RunHistory::Mode::write)
        .finish(*run, baseline_text(measured, "a run").figures, baseline_text(old_times, "a run").figures,
                baseline_text(rows, "a run").environment);
  } catch (const std::runtime_error& error) {
    report_history(error, "the figures of this run are not kept in the history");
  }
}

std::vector<Row> count_rows(const std::string& scenario,
                            const std::vector<std::pair<const char*, std::size_t>>& counts) {
  std::vector<Row> rows;
  for (const auto& [metric, count] : counts) {
    Row row;
    row.scenario = scenario, row.method = kAllMethods, row.metric = metric, row.unit = "1";
    row.value = static_cast<double>(count), row.truth_bar = 0;
    rows.push_back(std::move(row));
  }
  return rows;
}

void note_merge(const Place& place, Options options, const std::string& store) {
  const std::filesystem::path file = std::filesystem::absolute(store);
  if (file.filename() != "store.db") return;
  options.out_dir = file.parent_path().string();
  try {
    std::vector<StoredPlan> plans;
    std::set<std::string> hosts;
    {
      Store joined(store, Store::Mode::read);
      plans = joined.plans();
      for (const ShardRecord& shard : joined.shards()) hosts.insert(one_line(shard.host));
    }
    if (plans.empty()) return;
    RunHistory history(history_path(options), RunHistory::Mode::write);
    for (const StoredPlan& plan : plans) {
      HistoryRun run = entry_of(place, options);
      run.study = plan.study;
      run.cells = static_cast<std::int64_t>(plan.cells.size());
      run.host = hosts.size() == 1 ? *hosts.begin() : fmt::format("{} machines", hosts.size());
      run.id = history.begin(run);
      run.ended_ns = run.begun_ns;
      run.verdict = kMerged;
      history.finish(run, "", "", "");
    }
  } catch (const std::runtime_error& error) {
    report_history(error, "this merge is not kept in the history");
  }
}

std::optional<HistoryRun> merged_entry(const Options& options, const Selection& selection) {
  const auto cells =
      std::count_if(selection.cells.begin(), selection.cells.end(), [](const Cell& cell) { return cell.worker >= 0; });
  try {
    for (HistoryRun& run : RunHistory(history_path(options), RunHistory::Mode::read).runs(selection.study, 1))
      if (run.verdict == kMerged && run.cells == cells) {
        run.selection = selection_words(options);
        return run;
      }
  } catch (const std::runtime_error& error) {
    report_history(error, "what this report judges is not kept in the history");
  }
  return std::nullopt;
}

}  // namespace atwood
