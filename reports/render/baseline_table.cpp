// What changed against a baseline: a line a scenario and method, the worst first.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "baseline_table.hpp"
#include "palette.hpp"
#include "text.hpp"

namespace atwood {

using Kind = BaselineChange::Kind;

std::vector<ChangedPair> changed_pairs(const std::vector<BaselineChange>& changes) {
  std::map<std::pair<std::string, std::string>, ChangedPair> pairs;
  for (const BaselineChange& change : changes) {
    if (change.kind != Kind::regression) continue;
    ChangedPair& pair = pairs[{change.scenario, change.method}];
    ++pair.regressions;
    if (!pair.worst || change.ratio > pair.worst->ratio) pair.worst = &change;
  }
  std::vector<ChangedPair> sorted;
  for (const auto& [key, pair] : pairs) sorted.push_back(pair);
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const ChangedPair& a, const ChangedPair& b) { return a.worst->ratio > b.worst->ratio; });
  return sorted;
}

std::string ratio_words(const BaselineChange& change) {
  if (std::isnan(change.now)) return "no figure any more";
  if (std::isfinite(change.ratio) && change.ratio >= 0) return fmt::format("{:.4g} x as bad", change.ratio);
  if (change.metric.starts_with("order-")) return "nothing of the order is left";
  return change.before == 0 ? "it was zero" : "worse";
}

std::string change_words(const ChangedPair& pair) {
  const BaselineChange& worst = *pair.worst;
  const std::string steps = worst.steps > 0 ? fmt::format(" at {} steps", worst.steps) : "";
  const std::string unit = worst.unit.empty() || worst.unit == "1" ? "" : " " + worst.unit;
  const std::string more =
      pair.regressions == 1 ? ""
                            : fmt::format("; {} more figure{}", pair.regressions - 1, pair.regressions == 2 ? "" : "s");
  return fmt::format("{}{}: {} -> {}{}, allowed {}, {}{}", worst.metric, steps, figure(worst.before), figure(worst.now),
                     unit, figure(worst.allowed), ratio_words(worst), more);
}

std::vector<std::string> counted_by_scenario(const std::vector<BaselineChange>& changes, Kind kind) {
  std::map<std::string, std::pair<int, std::map<std::string, int>>> scenarios;
  for (const BaselineChange& change : changes) {
    if (change.kind != kind) continue;
    ++scenarios[change.scenario].first;
    ++scenarios[change.scenario].second[change.method];
  }
  std::vector<std::string> lines;
  for (const auto& [scenario, counts] : scenarios) {
    const auto& methods = counts.second;
    const std::string who =
        methods.size() == 1 ? "of " + methods.begin()->first : fmt::format("of {} methods", methods.size());
    lines.push_back(fmt::format("{}: {} figure{} {}", one_line(scenario), counts.first, counts.first == 1 ? "" : "s",
                                one_line(who)));
  }
  return lines;
}

std::string change_counts(const std::string& path, const std::vector<BaselineChange>& changes) {
  std::map<Kind, int> counts;
  for (const BaselineChange& change : changes) ++counts[change.kind];
  return fmt::format("{} regression{}, {} missing, {} improvement{}, {} new, {} unchanged against {}",
                     counts[Kind::regression], counts[Kind::regression] == 1 ? "" : "s", counts[Kind::missing],
                     counts[Kind::improvement], counts[Kind::improvement] == 1 ? "" : "s", counts[Kind::added],
                     counts[Kind::unchanged], one_line(path));
}

std::string render_baseline_table(const std::string& path, const std::vector<BaselineChange>& changes, bool colour) {
  const Palette& palette = colour ? kColours : kPlain;
  std::string out;
  for (const ChangedPair& pair : changed_pairs(changes)) {
    out += fmt::format("{}regression{}   {}  {}  {}\n", palette.red, palette.off, one_line(pair.worst->scenario),
                       one_line(pair.worst->method), one_line(change_words(pair)));
    out += fmt::format("             {}{}{}\n", palette.dim, shell_line(pair.worst->rerun), palette.off);
  }
  const std::pair<Kind, const char*> counted[] = {
      {Kind::missing, "missing"}, {Kind::improvement, "improvement"}, {Kind::added, "new"}};
  for (const auto& [kind, word] : counted)
    for (const std::string& line : counted_by_scenario(changes, kind)) out += fmt::format("{:<11}  {}\n", word, line);
  out += change_counts(path, changes) + "\n";
  return out;
}

}  // namespace atwood
