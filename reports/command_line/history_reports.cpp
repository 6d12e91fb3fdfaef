// What a run leaves besides the store: its entry in the history, its report under its own name, and the index.
#include <algorithm>
#include <cctype>
#include <chrono>
#include <filesystem>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "reports/command_line/history.hpp"
#include "reports/render/text.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"
#include "validation/study/content_hash.hpp"
#include "validation/study/machine.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestName = 60;
constexpr std::int64_t kRunsOfIndex = 200;

std::int64_t now_ns() {
  using namespace std::chrono;
  return duration_cast<nanoseconds>(system_clock::now().time_since_epoch()).count();
}

void tell(const std::exception& error, const char* what) {
  std::fputs(printable_lines(fmt::format("atwood: {}: {}\n", error.what(), what)).c_str(), stderr);
}

constexpr const char* kFrame =
    "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" "
    "content=\"default-src 'none'; style-src 'unsafe-inline'\">\n<meta name=\"viewport\" "
    "content=\"width=device-width, initial-scale=1\">\n<meta name=\"color-scheme\" content=\"light dark\">\n"
    "<title>Atwood: reports and runs</title>\n<style>\n"
    ":root{color-scheme:light dark;--ink:#1c2330;--paper:#fff;--line:#d5dae2;--bad:#b3261e;--good:#1b7a3d}\n"
    "@media(prefers-color-scheme:dark){:root{--ink:#e6e9ef;--paper:#14181f;--line:#39414f;--bad:#ff8a80;--good:#7bd99a}}\n"
    "body{font:16px/1.5 system-ui,sans-serif;color:var(--ink);background:var(--paper);max-width:70rem;margin:2rem auto;"
    "padding:0 1rem}\n.wide{overflow-x:auto}table{border-collapse:collapse;width:100%}caption{text-align:left;"
    "font-weight:600;padding:.5rem 0}\nth,td{text-align:left;padding:.3rem .8rem .3rem 0;border-bottom:1px solid "
    "var(--line);vertical-align:top}td.n,th.n{text-align:right}a{color:inherit}.fail{color:var(--bad)}"
    ".pass{color:var(--good)}\n</style></head>\n<body><main>\n<h1>Reports and runs</h1>\n";

std::string verdict_cell(const std::string& verdict, const std::string& words) {
  const char* kind = verdict == "pass" ? "pass" : verdict == "fail" ? "fail" : "";
  return fmt::format("<td class=\"{}\">{}</td>", kind, escape_html(words));
}

}  // namespace

std::string history_path(const Options& options) { return options.out_dir + "/history.db"; }

std::string moment_words(std::int64_t ns) {
  return fmt::format("{:%Y-%m-%d %H:%M:%S}", fmt::gmtime(static_cast<std::time_t>(ns / 1'000'000'000)));
}

std::string selection_words(const Options& options) {
  std::vector<std::string> words;
  const auto add = [&](const char* flag, const std::string& value) { words.insert(words.end(), {flag, value}); };
  for (const std::string& scenario : options.scenarios) add("--scenario", scenario);
  for (const std::string& method : options.methods) add("--method", method);
  if (options.hz.empty())
    for (const std::int64_t steps : options.steps) add("--steps", std::to_string(steps));
  for (const double hz : options.hz) add("--hz", fmt::format("{}", hz));
  for (const double spacing : options.spacings) add("--spacing", fmt::format("{}", spacing));
  for (const double speed : options.sound_speeds) add("--sound-speed", fmt::format("{}", speed));
  return words.empty() ? "" : shell_line(words);
}

std::string verdict_words(const HistoryRun& run) {
  if (run.ended_ns == 0) return "not finished";
  const std::int64_t bad = run.failed + run.unverifiable + run.not_run, all = bad + run.passed;
  if (run.verdict == "fail" && bad > 0) return fmt::format("fail, {} of {} gates", bad, all);
  if (run.verdict == "pass") return fmt::format("pass, {} gate{}", all, all == 1 ? "" : "s");
  return run.verdict;
}

std::optional<HistoryRun> begin_history(const Place& place, const Options& options, const Selection& selection) {
  HistoryRun run;
  run.begun_ns = now_ns();
  run.study = selection.study;
  run.selection = selection_words(options);
  run.cells = static_cast<std::int64_t>(selection.cells.size());
  run.command = options.program;
  run.commit = place.provenance.commit;
  run.host = host_name();
  run.cpu = place.provenance.cpu;
  try {
    RunHistory history(history_path(options), RunHistory::Mode::write);
    run.id = history.begin(run);
    return run;
  } catch (const std::runtime_error& error) {
    tell(error, "this run is not kept in the history");
    return std::nullopt;
  }
}

void end_history(const Options& options, std::optional<HistoryRun>& run, const std::vector<Row>& rows,
                 const JudgementCounts& counts, const std::string& verdict) {
  if (!run) return;
  run->ended_ns = now_ns();
  run->verdict = verdict;
  run->passed = counts.pass, run->failed = counts.fail;
  run->unverifiable = counts.unverifiable, run->not_run = counts.not_run;
  try {
    const BaselineText text = baseline_text(rows, "a run");
    RunHistory(history_path(options), RunHistory::Mode::write).finish(*run, text.figures, text.environment);
  } catch (const std::runtime_error& error) {
    tell(error, "the figures of this run are not kept in the history");
  }
}

std::string report_file(const std::string& study, const std::string& selection) {
  std::string name;
  for (const char c : study.substr(0, kLongestName))
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '_' ? c : '-';
  if (name.empty() || name.front() == '-') name = "study" + name;
  // A dot is in no name: it parts the name from hashes, so that two studies or parts never share a file.
  if (name != study) name += ".id-" + content_hash(study).substr(0, 8);
  if (!selection.empty()) name += ".part-" + content_hash(selection).substr(0, 8);
  return name + ".html";
}

std::string write_reports(const Options& options, const Selection& selection, const ReportData& data,
                          const std::string& verdict) {
  HistoryReport report;
  report.study = selection.study;
  report.selection = selection_words(options);
  report.file = report_file(report.study, report.selection);
  report.title = data.title;
  report.verdict = verdict;
  report.cells = static_cast<std::int64_t>(selection.cells.size());
  report.written_ns = now_ns();
  report.shown = true;
  std::vector<HistoryReport> others;
  std::unique_ptr<RunHistory> history;
  try {
    history = std::make_unique<RunHistory>(history_path(options), RunHistory::Mode::write);
    others = history->reports();
  } catch (const std::runtime_error& error) {
    tell(error, "the index of reports is not renewed");
    history = nullptr;
  }
  const std::string folder = options.out_dir + "/reports", page = options.out_dir + "/report.html";
  std::error_code ignored;
  const auto there = [&](std::vector<HistoryReport> reports) {  // those whose files are not deleted
    std::erase_if(reports, [&](const HistoryReport& one) { return !fs::exists(folder + "/" + one.file, ignored); });
    return reports;
  };
  if (fs::exists(page, ignored))
    for (const HistoryReport& other : there(others))
      if (other.shown && other.file != report.file && other.cells > report.cells) report.shown = false;
  make_out_dir(folder);
  const std::string html = render_html(data);
  write_file(folder + "/" + report.file, html);
  if (report.shown) write_file(page, html);
  if (history) {
    try {
      history->put_report(report);
      write_file(options.out_dir + "/index.html",
                 render_index(there(history->reports()), history->runs("", kRunsOfIndex)));
    } catch (const std::runtime_error& error) {
      tell(error, "the index of reports is not renewed");
    }
  }
  write_named_outputs(options, data);
  return report.shown ? page : folder + "/" + report.file;
}

std::string render_index(const std::vector<HistoryReport>& reports, const std::vector<HistoryRun>& runs) {
  std::string page = kFrame;
  page +=
      "<div class=\"wide\"><table><caption>Reports, the newest first</caption><thead><tr><th>report</th><th>part "
      "of the study</th><th class=\"n\">cells</th><th>written (UTC)</th><th>verdict</th></tr></thead><tbody>\n";
  for (const HistoryReport& report : reports)
    page += fmt::format(
        "<tr><td><a href=\"reports/{}\">{}</a>{}</td><td>{}</td><td class=\"n\">{}</td><td>{}</td>{}</tr>\n",
        escape_html(report.file), escape_html(one_line(report.title)),
        report.shown ? " (<a href=\"report.html\">report.html</a>)" : "",
        report.selection.empty() ? "all of it" : escape_html(one_line(report.selection)), report.cells,
        moment_words(report.written_ns), verdict_cell(report.verdict, report.verdict));
  page +=
      "</tbody></table></div>\n<div class=\"wide\"><table><caption>Runs, the newest first</caption><thead><tr><th "
      "class=\"n\">run</th><th>begun (UTC)</th><th>study</th><th class=\"n\">cells</th><th>commit</th><th>machine"
      "</th><th>verdict</th></tr></thead><tbody>\n";
  for (const HistoryRun& run : runs)
    page += fmt::format(
        "<tr><td class=\"n\">{}</td><td>{}</td><td>{}{}</td><td class=\"n\">{}</td><td>{}</td><td>{}</td>{}</tr>\n",
        run.id, moment_words(run.begun_ns), escape_html(one_line(run.study)),
        run.selection.empty() ? "" : " " + escape_html(one_line(run.selection)), run.cells, escape_html(run.commit),
        escape_html(one_line(run.host)), verdict_cell(run.verdict, verdict_words(run)));
  return page +
         "</tbody></table></div>\n<p><code>atwood report --against RUN</code> compares the store with a run; "
         "<code>atwood history --metric METRIC</code> shows a metric over runs.</p>\n</main></body></html>\n";
}

}  // namespace atwood
