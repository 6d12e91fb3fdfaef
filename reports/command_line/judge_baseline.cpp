// Rows against a baseline.
#include <algorithm>
#include <limits>
#include <map>
#include <set>

#include <fmt/format.h>

#include "reports/command_line/verdicts.hpp"
#include "scene/files.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

using Kind = BaselineChange::Kind;

// "atwood/dopri5:1e-8@quad" and "atwood/dopri5@quad": figures of a ladder of tolerances go by the id without one.
std::string without_tolerance(const std::string& method) {
  const std::size_t colon = method.find(':');
  if (colon == std::string::npos) return method;
  const std::size_t end = std::min(method.find_first_of("+@{", colon), method.size());
  return method.substr(0, colon) + method.substr(end);
}

bool rungs_chosen_for(const Options& options) { return !options.steps.empty() || !options.hz.empty(); }
bool resolutions_chosen(const Options& options) { return !options.spacings.empty() || !options.sound_speeds.empty(); }

// "dx=0.02,c=20" of "velocity-l2[dx=0.02,c=20]".
std::string resolution_of_figure(const std::string& metric) {
  const std::size_t open = metric.ends_with(']') ? metric.rfind('[') : std::string::npos;
  return open == std::string::npos ? "" : metric.substr(open + 1, metric.size() - open - 2);
}

// Inconclusive in the baseline, a number now; reported, because no gate covers it.
void report_no_numbers(Judged& judged) {
  const auto count = std::count_if(judged.changes.begin(), judged.changes.end(), [](const BaselineChange& c) {
    return c.kind == Kind::added && c.text.starts_with("was not a number");
  });
  if (count > 0)
    judged.notes.push_back(
        fmt::format("{} figure{} not a number in the baseline and {} one now: counted as new, not compared.", count,
                    count == 1 ? " was" : "s were", count == 1 ? "is" : "are"));
}

// Of metrics that were defined otherwise when the baseline was written.
void report_changed_definitions(Judged& judged) {
  std::set<std::string> what;
  int count = 0;
  for (const BaselineChange& change : judged.changes) {
    if (change.kind != Kind::added || !change.text.starts_with(kDefinitionChanged)) continue;
    ++count;
    what.insert(change.metric + change.text.substr(kDefinitionChanged.size()));
  }
  if (count == 0) return;
  std::string text;
  for (const std::string& one : what) text += (text.empty() ? "" : "; ") + one;
  judged.notes.push_back(
      fmt::format("{} of {} figure{} since the baseline was written: counted as new, not compared. "
                  "{}. `atwood bless` renews the baseline.",
                  kDefinitionChanged, count, count == 1 ? "" : "s", text));
}

// Figures that are missing only because of a filter of this call are not losses.
int leave_out_filtered(const Place& place, const Options& options, const Selection& selection, Baseline& baseline) {
  const bool rungs = rungs_chosen_for(options), resolutions = resolutions_chosen(options);
  if (options.scenarios.empty() && options.methods.empty() && !rungs && !resolutions) return 0;
  const FigureNames kept(names_of(selection.cells)), whole(unfiltered_cells(place, options, selection));
  return static_cast<int>(std::erase_if(baseline.entries, [&](const BaselineEntry& entry) {
    return !kept.has(entry, !rungs, !resolutions) && whole.has(entry, true, true);
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
    v.gate.reason = "No figure may be worse than in the baseline.";
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

Verdict nothing_compared(const Baseline& baseline, const std::string& why) {
  Verdict v;
  v.scenario = v.gate.scenario = v.method = v.gate.method = "*";
  v.metric = v.gate.metric = "baseline";
  v.gate.reason = "No figure may be worse than in the baseline.";
  v.gate.origin = baseline.path;
  v.judgement = Judgement::not_run;
  v.value = v.allowed_high = std::numeric_limits<double>::quiet_NaN();
  v.text = fmt::format("{}: {}", baseline.path, why);
  return v;
}

}  // namespace

FigureNames::FigureNames(const std::vector<CellName>& cells) {
  for (const CellName& cell : cells) {
    names_.insert({cell.scenario, cell.method, cell.steps, cell.at});
    for (const std::string& method : {cell.method, without_tolerance(cell.method)}) {
      names_.insert({cell.scenario, method, kLadder, cell.at});
      names_.insert({cell.scenario, method, kAnyResolution, ""});
    }
  }
}

bool FigureNames::has(const BaselineEntry& entry, bool ladders, bool resolutions) const {
  if (entry.steps > 0)
    return names_.contains({entry.scenario, entry.method, entry.steps, resolution_of_figure(entry.metric)});
  if (!ladders) return false;
  return resolutions ? names_.contains({entry.scenario, entry.method, kAnyResolution, ""})
                     : names_.contains({entry.scenario, entry.method, kLadder, resolution_of_figure(entry.metric)});
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

void judge_baseline(const Place& place, const Options& options, const Selection& selection, Baseline baseline,
                    const std::vector<Row>& rows, Judged& judged) {
  judged.notes.insert(judged.notes.end(), baseline.notes.begin(), baseline.notes.end());
  const bool empty = baseline.entries.empty();
  if (const int left_out = leave_out_filtered(place, options, selection, baseline); left_out > 0)
    judged.notes.push_back(
        fmt::format("{} figure{} of the baseline left out by the filter.", left_out, left_out == 1 ? "" : "s"));
  judged.changes = compare_baseline(baseline, rows);
  // A part of a ladder has no figure of the whole: none was compared, and none is new.
  std::erase_if(judged.changes, [&](const BaselineChange& c) {
    const bool of_resolutions = c.metric.starts_with("order-space") || c.metric.starts_with("order-model");
    return c.kind == Kind::added && c.steps == 0 &&
           (rungs_chosen_for(options) || (of_resolutions && resolutions_chosen(options)));
  });
  for (BaselineChange& change : judged.changes)
    change.rerun = with_own_files(place, options, selection, change.scenario, change.rerun);
  report_no_numbers(judged);
  report_changed_definitions(judged);
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

}  // namespace atwood
