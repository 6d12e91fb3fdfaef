// Runs that are kept: what each measured, which reports were written, and how a figure went over runs.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/verdicts.hpp"
#include "reports/render/text.hpp"
#include "validation/study/change_points.hpp"
#include "validation/study/run_history.hpp"

namespace atwood {

std::string history_path(const Options& options);     // OUT/history.db
std::string selection_words(const Options& options);  // the filters of a call; empty: the whole study
std::string moment_words(std::int64_t ns);            // "2026-01-31 09:05:00", UTC
std::string verdict_words(const HistoryRun& run);     // "fail, 3 of 14", "not finished"

// Records a run before its cells. Where the history cannot be written that is said on standard error, and the run goes
// on without.
std::optional<HistoryRun> begin_history(const Place& place, const Options& options, const Selection& selection);
void end_history(const Options& options, std::optional<HistoryRun>& run, const std::vector<Row>& rows,
                 const JudgementCounts& counts, const std::string& verdict);

// The name of a report's file under OUT/reports: the study's id as far as a file name can have it, and a hash where it
// cannot, or of the filters of a part.
std::string report_file(const std::string& study, const std::string& selection);
// Writes OUT/reports/NAME.html; OUT/report.html, unless that is the report of more cells; OUT/index.html, which links
// to all; and what -o names. The path to tell the user.
std::string write_reports(const Options& options, const Selection& selection, const ReportData& data,
                          const std::string& verdict);
std::string render_index(const std::vector<HistoryReport>& reports, const std::vector<HistoryRun>& runs);

// What --against names: a run by its number, commit, `last` or `previous`, or a baseline's file.
struct Against {
  std::string words;  // "run 3 (...)", or the file
  std::vector<BaselineChange> changes;
  std::vector<std::string> notes;
};
bool names_baseline_file(const std::string& named);
Against hold_against(const Place& place, const Options& options, const Selection& selection, const std::string& named,
                     const std::vector<Row>& rows);
std::string against_text(const Against& against, bool colour);

// One figure over runs.
struct TrendPoint {
  std::int64_t run = 0, begun_ns = 0;
  std::string commit;
  double value = 0, bar = 0;
};
struct Trend {
  std::string scenario, method, metric, unit, host;  // host: of times, which are of one machine only
  std::int64_t steps = 0;
  std::vector<TrendPoint> points;  // finite values, the oldest first
  ChangePoints changes;
};
std::string render_trends(const std::vector<Trend>& trends, const std::string& title);  // a page
// The level of each segment, from `from` to before `to`: the mean, of logarithms where the change points are.
double level_of(const Trend& trend, std::size_t from, std::size_t to);

int command_history(const Place&, const Options&);

}  // namespace atwood
