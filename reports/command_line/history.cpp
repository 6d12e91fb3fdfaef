// history: the runs that were kept; with --metric, that metric over runs and where its level changed.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "reports/command_line/history.hpp"
#include "reports/render/palette.hpp"
#include "scene/files.hpp"
#include "validation/gates/times.hpp"
#include "validation/study/machine.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kRunsShown = 30;     // in text; JSON has all
constexpr std::size_t kTrendsPrinted = 12;  // in text; JSON and HTML have all
constexpr std::size_t kMaxTrends = 2000;    // that are held at once
constexpr std::int64_t kAllRuns = 1'000'000;

Json json_of(const HistoryRun& run) {
  Json json{{"run", run.id},
            {"begun", moment_words(run.begun_ns)},
            {"ended", nullptr},
            {"study", one_line(run.study)},
            {"selection", one_line(run.selection)},
            {"cells", run.cells},
            {"commit", run.commit},
            {"machine", one_line(run.host)},
            {"cpu", one_line(run.cpu)},
            {"command", one_line(run.command)},
            {"verdict", run.ended_ns == 0 ? "not finished" : run.verdict},
            {"pass", run.passed},
            {"fail", run.failed},
            {"unverifiable", run.unverifiable},
            {"not_run", run.not_run}};
  if (run.ended_ns != 0) json["ended"] = moment_words(run.ended_ns);
  return json;
}

int list_runs(const Options& options) {
  const RunHistory history(history_path(options), RunHistory::Mode::read);
  const std::vector<HistoryRun> runs = history.runs(options.study, options.json ? kAllRuns : kRunsShown + 1);
  if (options.json) {
    Json all = Json::array();
    for (const HistoryRun& run : runs) all.push_back(json_of(run));
    fmt::print("{}\n", all.dump(2));
    return exit_pass;
  }
  if (runs.empty()) {
    fmt::print("no run{} in {}; `atwood run` records one\n",
               options.study.empty() ? "" : " of the study " + one_line(options.study), history_path(options));
    return exit_pass;
  }
  const Palette& palette = use_colour(STDOUT_FILENO) ? kColours : kPlain;
  std::size_t widest = 5, machine = 7;
  const auto what = [](const HistoryRun& run) {
    return fit(one_line(run.study) + (run.selection.empty() ? "" : " " + one_line(run.selection)), 48);
  };
  for (const HistoryRun& run : runs) {
    widest = std::max(widest, display_width(what(run)));
    machine = std::max(machine, display_width(one_line(run.host)));
  }
  fmt::print("{}  run  {}  {}  {:>6}  {}  {}  verdict{}\n", palette.dim, padded("begun (UTC)", 19),
             padded("study", widest), "cells", padded("commit", 20), padded("machine", machine), palette.off);
  for (std::size_t i = 0; i < runs.size() && i < static_cast<std::size_t>(kRunsShown); ++i) {
    const HistoryRun& run = runs[i];
    const char* shade = run.verdict == "pass" ? palette.green : run.verdict == "fail" ? palette.red : palette.yellow;
    fmt::print("{:>5}  {}  {}  {:>6}  {}  {}  {}{}{}\n", run.id, moment_words(run.begun_ns), padded(what(run), widest),
               run.cells, padded(fit(one_line(run.commit), 20), 20), padded(one_line(run.host), machine), shade,
               verdict_words(run), palette.off);
  }
  if (runs.size() > static_cast<std::size_t>(kRunsShown)) fmt::print("  and earlier ones: --json has them all\n");
  return exit_pass;
}

bool any_matches(const std::vector<std::string>& patterns, const std::string& text) {
  return patterns.empty() || std::any_of(patterns.begin(), patterns.end(),
                                         [&](const std::string& pattern) { return glob_match(pattern, text); });
}

std::vector<Trend> find_trends(const RunHistory& history, const Options& options) {
  std::vector<Trend> trends;
  each_trend(history, {options.metric, options.scenarios, options.methods, options.steps, options.study},
             [&](Trend&& trend) {
               trends.push_back(std::move(trend));
               if (trends.size() > kMaxTrends)
                 throw InputError(
                     fmt::format("history: more than {} figures are named `{}`; expected fewer: --scenario, --method "
                                 "and --steps narrow them",
                                 kMaxTrends, one_line(options.metric)));
             });
  std::stable_sort(trends.begin(), trends.end(),
                   [](const Trend& a, const Trend& b) { return a.changes.starts.size() > b.changes.starts.size(); });
  return trends;
}

std::string trend_name(const Trend& trend) {
  return fmt::format("{}  {}  {}{}{}{}", one_line(trend.scenario), one_line(trend.method), one_line(trend.metric),
                     trend.steps > 0 ? fmt::format(" at {} steps", trend.steps) : "",
                     trend.unit == "1" || trend.unit.empty() ? "" : fmt::format(" [{}]", trend.unit),
                     trend.host.empty() ? "" : ", on " + one_line(trend.host));
}

std::string trend_text(const Trend& trend) {
  constexpr std::size_t max_printed = 40;
  const auto& starts = trend.changes.starts;
  std::string out = trend_name(trend) + "\n";
  const std::size_t from = trend.points.size() > max_printed ? trend.points.size() - max_printed : 0;
  if (from > 0) out += fmt::format("    {} earlier runs\n", from);
  for (std::size_t i = from; i < trend.points.size(); ++i) {
    const TrendPoint& p = trend.points[i];
    out += fmt::format("  {:>5}  {}  {}  {:>12}{}{}\n", p.run, moment_words(p.begun_ns),
                       padded(fit(one_line(p.commit), 20), 20), figure(p.value),
                       p.bar > 0 ? fmt::format(" +- {}", figure(p.bar, 2)) : "",
                       std::find(starts.begin(), starts.end(), i) != starts.end() ? "  <- a new level" : "");
  }
  if (!trend.changes.enough)
    return out + fmt::format("  {} run{}: change points need {} or more\n", trend.points.size(),
                             trend.points.size() == 1 ? "" : "s", kMinRuns);
  if (starts.empty()) return out + "  one level: no change point\n";
  for (std::size_t i = 0; i < starts.size(); ++i)
    out += fmt::format("  change at run {}: {} -> {}\n", trend.points[starts[i]].run,
                       figure(level_of(trend, i == 0 ? 0 : starts[i - 1], starts[i])),
                       figure(level_of(trend, starts[i], i + 1 < starts.size() ? starts[i + 1] : trend.points.size())));
  return out;
}

Json json_of(const Trend& trend) {
  Json json{{"scenario", trend.scenario},
            {"method", trend.method},
            {"metric", trend.metric},
            {"steps", trend.steps},
            {"unit", trend.unit},
            {"machine", trend.host},
            {"enough_runs", trend.changes.enough}};
  json["points"] = Json::array();
  for (const TrendPoint& p : trend.points)
    json["points"].push_back({{"run", p.run},
                              {"begun", moment_words(p.begun_ns)},
                              {"commit", p.commit},
                              {"value", p.value},
                              {"bar", p.bar}});
  json["changes_at_runs"] = Json::array();
  for (const std::size_t start : trend.changes.starts) json["changes_at_runs"].push_back(trend.points[start].run);
  return json;
}

int show_trends(const Options& options) {
  const RunHistory history(history_path(options), RunHistory::Mode::read);
  const std::vector<Trend> trends = find_trends(history, options);
  if (trends.empty())
    throw InputError(fmt::format("history: no run in {} has a figure `{}` of these scenarios and methods",
                                 history_path(options), one_line(options.metric)));
  for (const std::string& output : options.outputs)
    write_file(output.substr(5), render_trends(trends, options.metric + " over runs", {}, ""));
  if (options.json) {
    Json all = Json::array();
    for (const Trend& trend : trends) all.push_back(json_of(trend));
    fmt::print("{}\n", all.dump(2, ' ', false, Json::error_handler_t::replace));
    return exit_pass;
  }
  for (std::size_t i = 0; i < trends.size() && i < kTrendsPrinted; ++i) fmt::print("{}\n", trend_text(trends[i]));
  if (trends.size() > kTrendsPrinted)
    fmt::print("and {} more figures, with fewer changes: --json and -o html:FILE have them all\n",
               trends.size() - kTrendsPrinted);
  return exit_pass;
}

int prune(const Options& options) {
  const std::string path = history_path(options);
  if (!std::filesystem::exists(path)) throw InputError(fmt::format("history: no runs are kept at {}", path));
  const auto older_ns = static_cast<std::int64_t>(options.prune_older_days * 86400e9);
  RunHistory history(path, RunHistory::Mode::write);
  const auto before = static_cast<double>(std::filesystem::file_size(path));
  const std::int64_t removed =
      history.prune(options.study, options.prune_keep, older_ns > 0 ? now_ns() - older_ns : 0, options.dry_run);
  if (removed > 0 && !options.dry_run) renew_history_pages(options, history);
  const std::int64_t left = static_cast<std::int64_t>(history.runs("", kAllRuns).size());
  const auto bytes = static_cast<double>(std::filesystem::file_size(path));
  if (options.json)
    fmt::print("{}\n", Json{{"removed", removed},
                            {"dry_run", options.dry_run},
                            {"left", left},
                            {"bytes", std::filesystem::file_size(path)}}
                           .dump(2));
  else if (options.dry_run) fmt::print("{}: {} of {} runs would be removed\n", path, removed, left);
  else
    fmt::print("{}: {} run{} removed, {} left; {:.1f} kB, before {:.1f} kB\n", path, removed, removed == 1 ? "" : "s",
               left, 1e-3 * bytes, 1e-3 * before);
  return exit_pass;
}

}  // namespace

void each_trend(const RunHistory& history, const TrendFilter& filter, const std::function<void(Trend&&)>& each) {
  const auto wanted = [&](const HistoryRun& run) {
    return (filter.study.empty() || run.study == filter.study) &&
           (!filter.selection || run.selection == *filter.selection);
  };
  for (const auto& [scenario, method] : history.measured()) {
    if (!any_matches(filter.scenarios, scenario) || !any_matches(filter.methods, method)) continue;
    std::map<std::pair<std::string, std::int64_t>, Trend> here;
    history.each_run(
        scenario, method, filter.from_run,
        [&, scenario = scenario, method = method](const HistoryRun& run, const std::vector<HistoryFigure>& figures) {
          if (!wanted(run)) return;
          for (const HistoryFigure& f : figures) {
            if (!glob_match(filter.metric, f.metric) || !std::isfinite(f.value)) continue;
            if (!filter.steps.empty() &&
                std::find(filter.steps.begin(), filter.steps.end(), f.steps) == filter.steps.end())
              continue;
            Trend& trend = here[{f.metric, f.steps}];
            if (is_time(f.metric) && trend.host != run.host) {  // a time of another machine begins the trend anew
              trend.points.clear();
              trend.host = run.host;
            }
            trend.scenario = scenario, trend.method = method, trend.metric = f.metric, trend.unit = f.unit;
            trend.steps = f.steps;
            trend.points.push_back({run.id, run.begun_ns, run.commit, f.value, f.bar});
          }
        });
    for (auto& [key, trend] : here) {
      std::vector<double> values;
      for (const TrendPoint& point : trend.points) values.push_back(point.value);
      trend.changes = find_change_points(values);
      each(std::move(trend));
    }
  }
}

double level_of(const Trend& trend, std::size_t from, std::size_t to) {
  double sum = 0;
  for (std::size_t i = from; i < to; ++i)
    sum += trend.changes.logarithmic ? std::log(trend.points[i].value) : trend.points[i].value;
  const double mean = sum / static_cast<double>(to - from);
  return trend.changes.logarithmic ? std::exp(mean) : mean;
}

int command_history(const Place&, const Options& options) {
  for (const std::string& output : options.outputs)
    if (!output.starts_with("html:") || output.size() == 5)
      throw InputError(fmt::format("history: -o {}: expected html:FILE", output));
  const bool prunes = options.prune_keep > 0 || options.prune_older_days > 0;
  if (options.dry_run && !prunes)
    throw InputError("history: --dry-run is about removing runs; expected --prune-keep or --prune-older beside it");
  if (!options.metric.empty() && prunes)
    throw InputError(
        "history: --metric shows runs and --prune-keep or --prune-older removes some; expected one of them");
  if (!options.metric.empty()) {
    require_outputs_make_sense(options);
    return show_trends(options);
  }
  if (!options.scenarios.empty() || !options.methods.empty() || !options.steps.empty() || !options.outputs.empty())
    throw InputError("history: --scenario, --method, --steps and -o are about a metric; expected --metric beside them");
  return prunes ? prune(options) : list_runs(options);
}

}  // namespace atwood
