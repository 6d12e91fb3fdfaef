// The page of a study's earlier runs: which there were, and which of their figures changed level.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "reports/command_line/history.hpp"
#include "reports/render/text.hpp"
#include "validation/gates/times.hpp"

namespace atwood {
namespace {

constexpr std::int64_t kRunsAsked = 400;  // of the study, whatever their part
constexpr std::size_t kMaxRuns = 60;      // whose figures are read
constexpr std::size_t kMaxPlots = 40;
constexpr double kTimeChange = 1.25;  // as comparisons of times allow

// The largest change of level, as a factor either way; infinite where a level is zero or has another sign.
double largest_change(const Trend& trend) {
  double largest = 1;
  std::vector<std::size_t> ends = trend.changes.starts;
  ends.insert(ends.begin(), 0);
  ends.push_back(trend.points.size());
  for (std::size_t i = 1; i + 1 < ends.size(); ++i) {
    const double ratio = level_of(trend, ends[i], ends[i + 1]) / level_of(trend, ends[i - 1], ends[i]);
    largest = std::max(largest, ratio > 0 && std::isfinite(ratio) ? std::max(ratio, 1 / ratio) : HUGE_VAL);
  }
  return largest;
}

}  // namespace

std::string study_trends(const RunHistory& history, const std::string& study, const std::string& selection,
                         const std::string& report) {
  std::vector<HistoryRun> runs = history.runs(study, kRunsAsked);
  std::erase_if(runs, [&](const HistoryRun& run) { return run.selection != selection; });
  if (runs.size() > kMaxRuns) runs.resize(kMaxRuns);
  const auto judged = std::count_if(runs.begin(), runs.end(), [](const HistoryRun& run) {
    return run.verdict == "pass" || run.verdict == "fail" || run.verdict == "no gates";
  });
  std::size_t figures = 0, small = 0;
  std::vector<std::pair<double, Trend>> changed;
  if (judged >= static_cast<std::int64_t>(kMinRuns))
    each_trend(history, {.study = study, .selection = selection, .from_run = runs.back().id}, [&](Trend&& trend) {
      if (!trend.changes.enough) return;
      ++figures;
      if (trend.changes.starts.empty()) return;
      const double change = largest_change(trend);
      if (is_time(trend.metric) && change < kTimeChange) ++small;
      else changed.emplace_back(change, std::move(trend));
    });
  std::stable_sort(changed.begin(), changed.end(), [](const auto& a, const auto& b) {
    const bool time_a = is_time(a.second.metric), time_b = is_time(b.second.metric);
    return time_a != time_b ? time_b : a.first > b.first;
  });
  std::vector<Trend> shown;
  for (std::size_t i = 0; i < changed.size() && i < kMaxPlots; ++i) shown.push_back(std::move(changed[i].second));
  std::string about =
      judged < static_cast<std::int64_t>(kMinRuns)
          ? fmt::format(
                "<p>{} run{} of this study and selection {} figures: changes of level are looked "
                "for from {} runs on.</p>\n",
                judged, judged == 1 ? "" : "s", judged == 1 ? "has" : "have", kMinRuns)
          : fmt::format("<p>{} figures were measured by {} runs or more; the level of {} changed{}.{}</p>\n", figures,
                        kMinRuns, changed.size() + small,
                        small > 0
                            ? fmt::format("; {} of these changed a time by less than 25 % and are not plotted", small)
                            : "",
                        changed.size() > shown.size()
                            ? fmt::format(" The {} largest changes are plotted, errors before times.", shown.size())
                            : "");
  std::string page = render_trends(shown, study + (selection.empty() ? "" : " " + selection) + " over runs",
                                   {{"The report", report}, {"All reports and runs", "../index.html"}}, about);
  page.insert(page.size() - std::string_view(kPageEnd).size(), runs_table(runs, study + " runs"));
  return page;
}

}  // namespace atwood
