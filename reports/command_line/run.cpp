// run: plan, cells, rows, gates, report. report: the same from the store alone.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/history.hpp"
#include "reports/command_line/many_cells.hpp"
#include "reports/command_line/shard.hpp"
#include "reports/command_line/verdicts.hpp"
#include "reports/render/baseline_table.hpp"
#include "reports/render/solver_table.hpp"
#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kManyCells = 2000;  // of which their number is told before they run

std::string count_statuses(const std::vector<Row>& rows) {
  std::map<Status, int> counts;
  std::set<std::tuple<std::string, std::string, std::int64_t, Resolution>>
      ended;  // a cell whose timed pass failed counts once
  for (const auto& row : rows)
    if (row.metric == "status" && row.status != Status::ok) {
      ended.insert({row.scenario, row.method, row.steps, resolution_of(row)});
      ++counts[row.status];
    }
  for (const auto& row : rows)
    if (row.metric.starts_with("step-time") && (row.status == Status::crashed || row.status == Status::timeout) &&
        ended.insert({row.scenario, row.method, row.steps, resolution_of(row)}).second)
      ++counts[row.status];
  std::string text;
  for (const auto& [status, count] : counts)
    text += fmt::format("{}{} {}", text.empty() ? "" : ", ", count, to_string(status));
  return text;
}

// Cells that no available engine can run: they are in no store.
int count_absent(const Selection& selection) {
  return static_cast<int>(
      std::count_if(selection.cells.begin(), selection.cells.end(), [](const Cell& cell) { return cell.worker < 0; }));
}

// Where no cell gave a figure: why, each reason once.
std::string why_nothing_words(const std::vector<Row>& rows) {
  constexpr std::size_t max_reasons = 8;
  std::vector<std::pair<std::string, int>> reasons;
  for (const auto& row : rows) {
    if (row.status == Status::ok) return "";
    if (row.metric != "status") continue;
    const std::string words = to_string(row.status) + ": " + row.reason;
    auto known = std::find_if(reasons.begin(), reasons.end(), [&](const auto& one) { return one.first == words; });
    if (known == reasons.end()) known = reasons.insert(reasons.end(), {words, 0});
    ++known->second;
  }
  std::string text;
  for (std::size_t i = 0; i < reasons.size() && i < max_reasons; ++i)
    text += fmt::format("{} cell{}: {}\n", reasons[i].second, reasons[i].second == 1 ? "" : "s",
                        one_line(reasons[i].first));
  if (reasons.size() > max_reasons)
    text += fmt::format("and {} more reasons: the report has them\n", reasons.size() - max_reasons);
  return text;
}

// "6 cells, 2 of them run, 3 timed, 1 found whole in the store"; `report` runs nothing.
std::string work_words(const StudyResult& result, int absent) {
  const int stored = result.skipped - absent;
  std::string words = fmt::format("{} cell{}", result.cells, result.cells == 1 ? "" : "s");
  if (result.ran + result.timed + result.measured_again == 0)
    return fmt::format("{}, {} of them found in the store", words, stored);
  const std::string again = result.measured_again > 0 ? fmt::format("{} measured again, ", result.measured_again) : "";
  return fmt::format("{}, {} of them run, {}{} timed, {} found whole in the store", words, result.ran, again,
                     result.timed, stored);
}

void print_result(const Options& options, const Selection& selection, const ReportData& data, const StudyResult& result,
                  const std::string& report, const Against* against = nullptr) {
  if (options.json) {
    fmt::print("{}\n", render_json(data));
    return;
  }
  if (options.quiet) {
    fmt::print("{}", render_quiet(data, "report: " + report));
    return;
  }
  if (against) fmt::print("{}\n", against_text(*against, use_colour(STDOUT_FILENO)));
  else if (!data.baseline_path.empty())
    fmt::print("{}{}\n", render_baseline_table(data.baseline_path, data.baseline, use_colour(STDOUT_FILENO)),
               improvements_hint(options, data));
  fmt::print("{}", render_run_table(data, use_colour(STDOUT_FILENO), terminal_width()));
  if (!data.audit.empty())
    fmt::print("\n{}", render_audit_table(data.audit, use_colour(STDOUT_FILENO), terminal_width()));
  fmt::print("\n{}{}, {} row{}", why_nothing_words(data.rows), work_words(result, count_absent(selection)),
             data.rows.size(), data.rows.size() == 1 ? "" : "s");
  const auto statuses = count_statuses(data.rows);
  fmt::print("{}{}\n{}", statuses.empty() ? "" : "; ", statuses, unconverged_words(data.rows));
  if (!data.last_run.empty()) fmt::print("{}\n", change_counts(data.last_run, data.since_last_run));
  fmt::print("report: {}\n", report);
}

std::string verdict_of(int code, const std::vector<Verdict>& verdicts) {
  return code != exit_pass ? "fail" : verdicts.empty() ? "no gates" : "pass";
}

}  // namespace

// One line that rewrites itself on a terminal, plain lines elsewhere. A reader that has gone (`2>&1 | head`) ends no
// run: fputs, which does not throw.
std::function<void(const std::string&)> progress_printer(const Options& options) {
  if (!is_terminal(STDERR_FILENO)) {
    if (!options.progress) return {};
    return [](const std::string& line) { std::fputs((line + "\n").c_str(), stderr); };
  }
  return [](const std::string& line) {
    std::fputs(("\r\x1b[2K" + line.substr(0, static_cast<std::size_t>(terminal_width() - 1))).c_str(), stderr);
  };
}

void end_progress() {
  if (is_terminal(STDERR_FILENO)) fmt::print(stderr, "\r\x1b[2K");
}

namespace {

// Outputs must be regular files, or /dev/stdout, /dev/stderr, /dev/null: a pipe without a reader would hang, and a
// block device would be overwritten.
void require_ordinary(const std::string& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (file.starts_with("/dev/std") || file.starts_with("/dev/fd/") || file == "/dev/null" || !fs::exists(status))
    return;
  const char* kind = fs::is_fifo(status)                                          ? "a pipe"
                     : fs::is_socket(status)                                      ? "a socket"
                     : fs::is_character_file(status) || fs::is_block_file(status) ? "a device"
                                                                                  : "";
  if (*kind != '\0') throw InputError(fmt::format("{}: found {}; expected a file to write to", file, kind));
}

}  // namespace

void require_output(const std::string& file) {
  const fs::path folder = fs::absolute(file).parent_path();
  if (!fs::is_directory(folder))
    throw std::runtime_error(fmt::format("{}: cannot be written: no folder {}", file, folder.string()));
  require_ordinary(file);
  if (!fs::exists(file) && access(folder.c_str(), W_OK) != 0) {
    throw std::runtime_error(fmt::format("{}: cannot be written: {}: {}", file, folder.string(), std::strerror(errno)));
  }
}

void require_outputs_make_sense(const Options& options) {
  for (const auto& output : options.outputs) {
    const auto colon = output.find(':');
    const auto format = output.substr(0, colon);
    const bool known = format == "csv" || format == "json" || format == "markdown" || format == "md" ||
                       format == "junit" || format == "html";
    if (!known || colon == std::string::npos || colon + 1 == output.size()) {
      throw InputError(
          fmt::format("-o {}: expected FORMAT:FILE, format one of csv, json, markdown, junit, html", output));
    }
    require_output(output.substr(colon + 1));
  }
  if (!options.junit.empty()) require_output(options.junit);
  for (const char* document : {"report.html", "index.html", "compare.html", "bench.json"})
    require_ordinary(options.out_dir + "/" + document);
  const char* summary = options.github ? std::getenv("GITHUB_STEP_SUMMARY") : nullptr;
  if (summary && *summary) require_ordinary(summary);
}

void report_without_recording(const Options& options, const std::set<std::string>& metrics) {
  if (options.quiet || metrics.empty()) return;
  fmt::print(
      stderr,
      "atwood: --keep none: no recordings are kept; these metrics cannot be made again, nor new ones made, without "
      "running their cells again: {}\n",
      fmt::join(metrics, ", "));
}

void make_out_dir(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error) throw std::runtime_error(fmt::format("{}: cannot make this folder: {}", path, error.message()));
}

namespace {

// What follows the run's entry in the history, and ends it.
int run_and_report(const Place& place, const Options& options, const Selection& selection, const Standards& standards,
                   const StudyOptions& how, std::optional<HistoryRun>& kept) {
  const StudyResult result = run_study(selection.cells, selection.workers, how);
  end_progress();
  if (!options.quiet && !result.reused.empty())
    std::fputs(("atwood: " + reused_text(result.reused) + "\n").c_str(), stderr);
  const int absent = count_absent(selection);
  if (!options.quiet && result.cells > absent && result.skipped == result.cells) {
    const int stored = result.cells - absent;
    fmt::print(stderr, "atwood: nothing to do: {} in the store already\n",
               stored == 1 ? "the cell is" : fmt::format("all {} cells are", stored));
  }
  if (result.interrupted) {
    end_history(place, options, kept, {}, {}, "interrupted");
    fmt::print(stderr, "atwood: interrupted; what was done is in {}, and the same command goes on from there\n",
               how.store_path);
    return exit_of(result, {});
  }
  report_without_recording(options, result.without_recording);
  if (!how.rows) return report_many(place, options, selection, standards, &result, &kept);
  const Judged judged = judge_everything(place, options, selection, standards, result, true);
  ReportData data = assemble_report(place, options, selection, result, {});
  add_judged(data, selection, judged);
  if (standards.baseline) data.baseline_path = selection.baseline;
  else if (!selection.baseline.empty())
    data.notes.push_back(fmt::format("{}: no baseline is there yet; `{}` writes one.", selection.baseline,
                                     same_call(options, "bless", selection.baseline)));
  const int code = exit_of(result, judged.verdicts);
  const std::string verdict = verdict_of(code, judged.verdicts);
  if (data.baseline_path.empty()) add_last_run(place, options, selection, 0, data);
  end_history(place, options, kept, data.rows, count(judged.verdicts), verdict);
  const std::string report = write_reports(options, selection, data, verdict);
  print_result(options, selection, data, result, report);
  report_to_github(options, data);
  return code;
}

// What confines workers less than elsewhere, once for the run.
void report_confinement(const std::vector<Worker>& workers) {
  if (const std::string gaps = confinement_gaps(kernel_means()); !gaps.empty())
    fmt::print(stderr, "atwood: workers are confined in part: {}\n", gaps);
  for (const std::string& sentence : unconfined_engines(workers)) fmt::print(stderr, "atwood: {}\n", sentence);
}

}  // namespace

int command_run(const Place& place, const Options& options) {
  require_outputs_make_sense(options);
  const std::optional<StudyShare> share = share_of(options);
  if (!options.costs.empty() && !share && options.lease.empty())
    throw InputError("--costs decides how a study is split; expected --shard, --lease or a launcher beside it");
  Selection selection;
  Standards standards;
  {
    const InterruptGuard guard;  // run_study has its own
    selection = select_cells(place, options);
    standards = read_standards(place, selection, true);
    if (!options.baseline.empty() && !standards.baseline) return no_baseline(options, options.baseline);
    if (options.dry_run) return dry_run(selection, options, share);
    report_confinement(selection.workers);
    make_out_dir(options.out_dir);
    if (interrupt_signal() != 0) {
      fmt::print(stderr, "atwood: interrupted before anything was run\n");
      return 128 + interrupt_signal();
    }
  }
  if (share || !options.lease.empty()) return run_share(place, options, selection, share);

  StudyOptions how = study_options(place, options);
  how.narrowed =
      !options.scenarios.empty() || !options.methods.empty() || !options.steps.empty() || !options.hz.empty();
  how.rows = !has_many_cells(options, selection, standards);
  if (!options.quiet) how.progress = progress_printer(options);
  if (!options.quiet && selection.cells.size() >= kManyCells)
    std::fputs(fmt::format("atwood: {} cells are planned\n", selection.cells.size()).c_str(), stderr);
  std::optional<HistoryRun> kept = begin_history(place, options, selection);
  try {
    return run_and_report(place, options, selection, standards, how, kept);
  } catch (...) {
    if (kept && kept->ended_ns == 0) end_history(place, options, kept, {}, {}, "error");
    throw;
  }
}

// `baseline` is what --against names.
int command_report(const Place& place, const Options& asked) {
  Options options = asked;
  options.baseline.clear();
  if (names_baseline_file(asked.baseline) && !fs::exists(asked.baseline)) return no_baseline(options, asked.baseline);
  require_outputs_make_sense(options);
  if (!fs::exists(options.out_dir + "/store.db")) {
    throw InputError(
        fmt::format("report: no store at {}/store.db; `{}` makes one", options.out_dir, same_call(options, "run")));
  }
  const Selection selection = select_cells(place, options);
  const Standards standards = read_standards(place, selection, true);
  if (asked.baseline.empty() && has_many_cells(options, selection, standards))
    return report_many(place, options, selection, standards);
  const StudyResult result = load_rows(options.out_dir + "/store.db", selection.cells);
  if (result.rows.empty()) {
    throw InputError(fmt::format(
        "{}/store.db has none of these cells: they were never run, or were run by an earlier build; `{}` runs them",
        options.out_dir, same_call(options, "run")));
  }
  const Judged judged = judge_everything(place, options, selection, standards, result, false);
  ReportData data = assemble_report(place, options, selection, result, {});
  add_judged(data, selection, judged);
  if (standards.baseline) data.baseline_path = selection.baseline;
  if (const std::string missing = missing_words(selection, result); !missing.empty()) {
    const std::string made = same_call(options, "run");
    data.notes.push_back(fmt::format("{}: `{}` makes them.", missing, made));
    std::fputs(fmt::format("atwood: {}: `{}` makes them\n", missing, made).c_str(), stderr);
  }
  std::optional<Against> against;
  if (!asked.baseline.empty()) {
    against = hold_against(place, options, selection, asked.baseline, result.rows);
    data.baseline_path = against->words;
    data.baseline = against->changes;
    data.notes.insert(data.notes.end(), against->notes.begin(), against->notes.end());
  } else if (data.baseline_path.empty()) {
    add_last_run(place, options, selection, 1, data);  // the newest run measured what is shown
  }
  const std::string verdict = verdict_of(exit_of(result, judged.verdicts), judged.verdicts);
  std::optional<HistoryRun> merged = merged_entry(options, selection);
  if (result.missing.empty()) end_history(place, options, merged, data.rows, count(judged.verdicts), verdict);
  const std::string report = write_reports(options, selection, data, verdict);
  print_result(options, selection, data, result, report, against ? &*against : nullptr);
  return exit_pass;
}

}  // namespace atwood
