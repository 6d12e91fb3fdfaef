// Runs that are kept: what each measured, which reports were written, and how a figure went over runs.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/verdicts.hpp"
#include "reports/render/text.hpp"
#include "validation/study/change_points.hpp"
#include "validation/study/run_history.hpp"

namespace atwood {

inline constexpr const char* kMerged = "merged";  // the verdict of an entry of joined stores, until they are judged
inline constexpr const char* kAllMethods = "*";   // the method of counts of a scenario (count_rows)

std::int64_t now_ns();                                               // since 1970
std::string history_path(const Options& options);                    // OUT/history.db
std::string selection_words(const Options& options);                 // the filters of a call; empty: the whole study
std::string moment_words(std::int64_t ns);                           // "2026-01-31 09:05:00", UTC
std::string verdict_words(const HistoryRun& run);                    // "fail, 3 of 14", "not finished"
void report_history(const std::exception& error, const char* what);  // on standard error: the cause, and what it means

// ---- entries (history_entries.cpp) ----
// Records a run before its cells. Where the history cannot be written that is said on standard error, and the run goes
// on without.
std::optional<HistoryRun> begin_history(const Place& place, const Options& options, const Selection& selection);
// Times that this process did not measure are kept apart: they are not new points of a trend.
void end_history(const Place& place, const Options& options, std::optional<HistoryRun>& run,
                 const std::vector<Row>& rows, const JudgementCounts& counts, const std::string& verdict);
// Of a scenario with too many cells to keep their figures: named counts.
std::vector<Row> count_rows(const std::string& scenario,
                            const std::vector<std::pair<const char*, std::size_t>>& counts);
// Stores of shards were joined into `store`: an entry of each of their plans in the history beside it, if its name is
// store.db. It has no figures until a report judges the cells.
void note_merge(const Place& place, Options options, const std::string& store);
// The study's newest entry, if it is that of a merge of as many cells as are selected here.
std::optional<HistoryRun> merged_entry(const Options& options, const Selection& selection);

// ---- reports (history_reports.cpp) ----
// The name of a report's file under OUT/reports: the study's id as far as a file name can have it, and a hash where it
// cannot, or of the filters of a part.
std::string report_file(const std::string& study, const std::string& selection);
// Writes OUT/reports/NAME.html and, beside it, NAME.trends.html; OUT/report.html, unless that is the report of more
// cells; OUT/index.html, which links to all; and what -o names. The path to tell the user.
std::string write_reports(const Options& options, const Selection& selection, const ReportData& data,
                          const std::string& verdict);
// Writes the index and each report's page of earlier runs anew, where they are: runs were removed from the history.
void renew_history_pages(const Options& options, const RunHistory& history);
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
// What changed since an earlier run of the same study and selection: the newest finished one that has figures, or with
// `skip` = 1 the one before it. Where the history cannot be read, a note says so; it ends nothing.
void add_last_run(const Place& place, const Options& options, const Selection& selection, int skip, ReportData& data);

// ---- one figure over runs (history.cpp, trend_page.cpp, study_trends.cpp) ----
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
struct TrendFilter {
  std::string metric = "*";                               // a glob
  std::vector<std::string> scenarios = {}, methods = {};  // globs; none: all
  std::vector<std::int64_t> steps = {};                   // none: all
  std::string study = {};                                 // empty: of any
  std::optional<std::string> selection = {};              // of runs of exactly this part of the study
  std::int64_t from_run = 0;
};
// Calls `each` with every trend that the filter leaves, change points found, by scenario and method.
void each_trend(const RunHistory& history, const TrendFilter& filter, const std::function<void(Trend&&)>& each);
// The level of each segment, from `from` to before `to`: the mean, of logarithms where the change points are.
double level_of(const Trend& trend, std::size_t from, std::size_t to);

// A page's beginning up to its first heading, and its end. `title` is text.
std::string page_head(const std::string& title, const std::vector<std::pair<std::string, std::string>>& links);
extern const char* const kPageEnd;
std::string runs_table(const std::vector<HistoryRun>& runs, const std::string& file);  // file: the name it is saved by
// A page; `about`: HTML below its heading.
std::string render_trends(const std::vector<Trend>& trends, const std::string& title,
                          const std::vector<std::pair<std::string, std::string>>& links, const std::string& about);
// Of the newest runs of a study and selection: the runs, and the figures whose level changed. `report`: the name of its
// report's file in the same folder.
std::string study_trends(const RunHistory& history, const std::string& study, const std::string& selection,
                         const std::string& report);

int command_history(const Place&, const Options&);

}  // namespace atwood
