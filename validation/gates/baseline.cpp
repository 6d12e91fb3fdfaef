// A baseline: accepted figures of an earlier measurement, one metric per line, sorted, so that a diff shows every
// change.
//
//   # atwood baseline 3
//   # reason: <text>
//   # definition <tab> order-position <tab> 2
//   # scenario <tab> method <tab> steps <tab> metric <tab> value <tab> bar <tab> unit
//   kepler-e0.6  atwood/rk4  960  error-position-end  1.319e-06  0  m
//   # end 1
//
// The last line counts the figures, so that a truncated file is not taken for a smaller one. Version 1 had no such
// line. A metric whose definition is not the first one has a line with its version, since version 3 of the file; a
// figure by another definition is not compared. The environment of the measurement is in <path>.env: compiler, flags,
// CPU and its features, mathematics library, engine versions. No timestamps.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"
#include "validation/gates/gates.hpp"
#include "validation/gates/times.hpp"
#include "validation/metrics/metrics.hpp"

namespace atwood {
namespace {

// Relative differences, besides both bars, that do not count as a change. Our own engine is deterministic: only the
// round-off of another compiler changes its figures. Rivals are built elsewhere. Times vary on a busy machine.
constexpr double kOwnTolerance = 1e-3, kRivalTolerance = 0.02, kTimingTolerance = 0.25;
// A bar of the baseline is limited to kBarGrowth times the present one or kBarShare of the value, whichever is larger:
// the file may be edited by hand or merged, and with a large bar every value would agree.
constexpr double kBarGrowth = 10, kBarShare = 1e-3;
// Values below this many units of their metric are round-off and change with the mathematics library.
constexpr double kRoundOff = 1e-14;

struct Key {
  std::string scenario, method;
  std::int64_t steps = 0;
  std::string metric;
  auto operator<=>(const Key&) const = default;
};
struct Entry {
  double value = 0, bar = 0;
  std::string unit;
};

// The metric of a figure, and its present definition.
const MetricInfo& definition_of(const std::string& figure) {
  static const std::map<std::string, MetricInfo> known = [] {
    std::map<std::string, MetricInfo> all;
    for (const MetricInfo& metric : all_metrics()) all[metric.name] = metric;
    return all;
  }();
  static const MetricInfo unknown;
  const auto found = known.find(figure.substr(0, figure.find('[')));
  return found == known.end() ? unknown : found->second;
}

// Whether a row belongs to the baseline. Residuals of solvers do not: at round-off they change with the order of a sum,
// and gates judge them. Infinite figures and figures with an infinite bar do not: every value agrees with them. A time
// of one repeat has an unknown bar; it is compared with the tolerance of times alone.
bool judged(const Row& row) {
  return row.status == Status::ok && row.body.empty() && !row.t_s && row.metric != "status" &&
         !row.metric.starts_with("size-") && row.metric != "solver-residual-max" && row.metric != "condition" &&
         !std::isinf(row.value) &&
         (std::isnan(row.value) || is_time(row.metric) || (std::isfinite(row.truth_bar) && row.truth_bar >= 0));
}

// A figure of a fluid's row is named with its resolution: "velocity-l2[dx=0.02,c=20]".
std::string figure_name(const Row& row) {
  const std::string at = resolution_text(resolution_of(row));
  return at.empty() ? row.metric : row.metric + "[" + at + "]";
}

std::map<Key, Entry> entries(std::span<const Row> rows) {
  std::map<Key, Entry> list;
  for (const Row& r : rows)
    if (judged(r))
      list[{r.scenario, r.method, r.steps, figure_name(r)}] = {
          r.value, std::isfinite(r.truth_bar) && !std::isnan(r.value) ? r.truth_bar : 0, r.unit};
  return list;
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  return printable(text);
}

// The environment of the rows: "cpu", "flags", ..., "engine ode".
std::map<std::string, std::set<std::string>> environment(std::span<const Row> rows) {
  std::map<std::string, std::set<std::string>> all;
  for (const Row& r : rows) {
    if (!judged(r)) continue;
    all["compiler"].insert(one_line(r.provenance->compiler));
    all["flags"].insert(one_line(r.provenance->flags));
    all["cpu"].insert(one_line(r.provenance->cpu));
    if (!r.provenance->cpu_features.empty()) all["cpu_features"].insert(one_line(r.provenance->cpu_features));
    if (!r.provenance->libm.empty()) all["libm"].insert(one_line(r.provenance->libm));
    all["engine\t" + r.method.substr(0, r.method.find('/'))].insert(one_line(r.provenance->engine_version));
  }
  return all;
}

std::map<std::string, std::set<std::string>> read_environment(const std::string& path) {
  std::map<std::string, std::set<std::string>> all;
  if (!std::filesystem::exists(path)) return all;
  std::istringstream file(read_input_file(path, "a baseline's environment", largest::kSettings));
  for (std::string line; std::getline(file, line);) {
    if (line.ends_with('\r')) line.pop_back();
    const std::size_t tab = line.starts_with("engine\t") ? line.find('\t', 7) : line.find('\t');
    if (tab != std::string::npos) all[line.substr(0, tab)].insert(line.substr(tab + 1));
  }
  return all;
}

template <class Number> bool parse_whole(const std::string& text, Number& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc() && end == text.data() + text.size();
}

constexpr std::size_t kLongestLine = 65536;

// Reads a baseline line by line.
struct Reader {
  Baseline& baseline;
  int version = 0, number = 0;
  std::map<std::string, int> definitions = {};
  bool ended = false;
  std::set<Key> seen = {};

  [[noreturn]] void refuse(const std::string& what) const {
    throw InputError(baseline.path + ":" + std::to_string(number) + ":1: " + what);
  }

  void first(const std::string& line) {
    if (line == "# atwood baseline 1") version = 1;
    else if (line == "# atwood baseline 2") version = 2;
    else if (line == "# atwood baseline 3") version = 3;
    else refuse("expected `# atwood baseline 3`, found `" + line.substr(0, 60) + "`");
  }

  void definition(const std::string& text) {
    const std::size_t tab = text.find('\t');
    int of_metric = 0;
    if (tab == std::string::npos || !parse_whole(text.substr(tab + 1), of_metric) || of_metric < 1)
      refuse("expected `# definition METRIC VERSION`, separated by tabs, with a whole number from 1 on");
    definitions[text.substr(0, tab)] = of_metric;
  }

  void end(const std::string& text) {
    std::size_t count = 0;
    if (!parse_whole(text, count)) refuse("expected `# end COUNT`, found `# end " + text.substr(0, 60) + "`");
    if (count != seen.size())
      refuse("the file says that it holds " + std::to_string(count) + " figures, and holds " +
             std::to_string(seen.size()) + "; expected all of them: a part of it is lost, or was added by hand");
    ended = true;
  }

  void figure(const std::string& line) {
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; cells.size() < 8 && std::getline(stream, cell, '\t');) cells.push_back(cell);
    if (cells.size() == 6) cells.push_back("");
    if (cells.size() != 7)
      refuse("expected 7 columns separated by tabs, found " +
             (cells.size() > 7 ? "more" : std::to_string(cells.size())));
    BaselineEntry entry{cells[0], cells[1], cells[3], 0, 0, 0, cells[6]};
    if (!parse_whole(cells[2], entry.steps) || entry.steps < 0)
      refuse("steps: expected a whole number from 0 on, found `" + cells[2] + "`");
    if (!parse_whole(cells[4], entry.value) || std::isinf(entry.value))
      refuse("value: expected a finite number, or nan, found `" + cells[4] + "`");
    if (!parse_whole(cells[5], entry.bar) || !std::isfinite(entry.bar) || entry.bar < 0)
      refuse("bar: expected a finite number from 0 on, found `" + cells[5] + "`");
    const auto known = definitions.find(entry.metric.substr(0, entry.metric.find('[')));
    if (known != definitions.end()) entry.definition = known->second;
    if (!seen.insert({entry.scenario, entry.method, entry.steps, entry.metric}).second)
      refuse("the metric is there twice");
    baseline.entries.push_back(std::move(entry));
  }

  void line(const std::string& text) {
    ++number;
    if (text.size() > kLongestLine) refuse("expected lines of at most " + std::to_string(kLongestLine) + " bytes");
    if (number == 1) return first(text);
    if (ended && !text.empty()) refuse("expected nothing after `# end`");
    if (text.starts_with("# end ") && version >= 2) return end(text.substr(6));
    if (text.starts_with("# definition\t") && version >= 3) return definition(text.substr(13));
    if (!text.empty() && text[0] != '#') figure(text);
  }
};

// Whether a smaller value is worse: orders. For other metrics a larger absolute value is worse.
bool less_is_worse(const std::string& metric) { return metric.starts_with("order-"); }
double badness(const std::string& metric, double value) { return less_is_worse(metric) ? -value : std::fabs(value); }

// The factor by which a figure became worse; for an order, the part of it that was lost.
double times_worse(const std::string& metric, double before, double now) {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  if (std::isnan(before) && std::isnan(now)) return 1;
  if (std::isnan(now)) return infinite;
  if (std::isnan(before)) return 0;
  const double above = less_is_worse(metric) ? before : std::fabs(now);
  const double below = less_is_worse(metric) ? now : std::fabs(before);
  if (above == below) return 1;
  return below > 0 ? above / below : infinite;
}

BaselineChange change_of(const Key& key, BaselineChange::Kind kind, double before, double now, double bar,
                         const std::string& unit) {
  BaselineChange change;
  change.kind = kind;
  change.scenario = key.scenario;
  change.method = key.method;
  change.metric = key.metric;
  change.steps = key.steps;
  change.before = before;
  change.now = now;
  change.bar = bar;
  change.allowed = std::nan("");
  change.unit = unit;
  change.rerun = rerun_words(key.scenario, key.method, key.steps);
  return change;
}

BaselineChange compare(const Key& key, const Entry& before, const Entry& now, bool timings_judged) {
  using Kind = BaselineChange::Kind;
  const double largest_bar = std::max(kBarGrowth * now.bar, kBarShare * std::fabs(before.value));
  const double bar_before = std::isnan(largest_bar) ? before.bar : std::min(before.bar, largest_bar);
  BaselineChange change = change_of(key, Kind::unchanged, before.value, now.value, bar_before + now.bar, before.unit);
  if (std::isnan(before.value) && !std::isnan(now.value)) {  // it was inconclusive: neither better nor worse
    change.kind = Kind::added;
    change.text = "was not a number in the baseline: nothing to compare with";
    return change;
  }
  const double share = is_time(key.metric)                 ? kTimingTolerance
                       : key.method.starts_with("atwood/") ? kOwnTolerance
                                                           : kRivalTolerance;
  const double tolerance = change.bar + share * std::fabs(before.value) + (is_time(key.metric) ? 0 : kRoundOff);
  const double worse = badness(key.metric, now.value) - badness(key.metric, before.value);
  const bool nan_before = std::isnan(before.value), nan_now = std::isnan(now.value);
  change.allowed = less_is_worse(key.metric) ? before.value - tolerance : std::fabs(before.value) + tolerance;
  change.ratio = times_worse(key.metric, before.value, now.value);
  if (nan_now && !nan_before) change.kind = Kind::regression;
  else if (!nan_now && worse > tolerance) change.kind = Kind::regression;
  else if (!nan_now && -worse > tolerance) change.kind = Kind::improvement;
  change.text = six_digits(before.value) + " -> " + six_digits(now.value) +
                (before.unit == "1" ? "" : " " + before.unit) + ", tolerance " + six_digits(tolerance);
  if (bar_before < before.bar)
    change.text += "; of the baseline's bar of " + six_digits(before.bar) + " only " + six_digits(bar_before) +
                   " counts: today's is " + six_digits(now.bar);
  if (is_time(key.metric) && !timings_judged && change.kind != Kind::unchanged) {
    change.text += "; advisory: another machine";
    change.kind = Kind::unchanged;
  }
  return change;
}

std::string joined(const std::set<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " | ") + word;
  return text;
}

// The words that only one of two lists has: "+avx2 -sse4a".
std::string changed_words(const std::set<std::string>& before, const std::set<std::string>& now) {
  const auto words_of = [](const std::set<std::string>& lines) {
    std::set<std::string> words;
    for (const std::string& line : lines) {
      std::stringstream stream(line);
      for (std::string word; stream >> word;) words.insert(word);
    }
    return words;
  };
  const std::set<std::string> then = words_of(before), here = words_of(now);
  std::string text;
  for (const std::string& word : here)
    if (!then.contains(word)) text += (text.empty() ? "+" : " +") + word;
  for (const std::string& word : then)
    if (!here.contains(word)) text += (text.empty() ? "-" : " -") + word;
  return text;
}

}  // namespace

BaselineText baseline_text(std::span<const Row> rows, const std::string& reason) {
  if (one_line(reason).find_first_not_of(' ') == std::string::npos) throw InputError("a baseline needs a reason");
  BaselineText text;
  const std::map<Key, Entry> all = entries(rows);
  std::map<std::string, int> definitions;
  for (const auto& [key, entry] : all)
    if (const MetricInfo& metric = definition_of(key.metric); metric.version > 1)
      definitions[metric.name] = metric.version;
  text.figures = "# atwood baseline 3\n# reason: " + one_line(reason) + "\n";
  for (const auto& [metric, version] : definitions)
    text.figures += "# definition\t" + metric + "\t" + std::to_string(version) + "\n";
  text.figures += "# scenario\tmethod\tsteps\tmetric\tvalue\tbar\tunit\n";
  for (const auto& [key, entry] : all)
    text.figures += one_line(key.scenario) + "\t" + one_line(key.method) + "\t" + std::to_string(key.steps) + "\t" +
                    one_line(key.metric) + "\t" + format_double(entry.value) + "\t" + format_double(entry.bar) + "\t" +
                    one_line(entry.unit) + "\n";
  text.figures += "# end " + std::to_string(all.size()) + "\n";
  for (const auto& [name, values] : environment(rows))
    for (const std::string& value : values) text.environment += name + "\t" + value + "\n";
  return text;
}

Baseline read_baseline(const std::string& path) {
  if (!std::filesystem::exists(path)) throw std::runtime_error(path + ": no baseline there");
  std::istringstream file(read_input_file(path, "a baseline", largest::kBaseline));
  Baseline baseline;
  baseline.path = path;
  Reader reader{baseline};
  for (std::string line; std::getline(file, line);) {
    if (line.ends_with('\r')) line.pop_back();  // allows Windows line ends
    reader.line(line);
  }
  if (reader.number == 0)
    throw InputError(path + ": the file is empty; expected a baseline (`atwood bless` writes one)");
  if (reader.version >= 2 && !reader.ended) {
    ++reader.number;
    reader.refuse("the file ends before its last line, `# end COUNT`: a part of it is lost");
  }
  if (reader.version == 1)
    baseline.notes.push_back(path +
                             " is of version 1, which does not show whether it is whole; bless again to renew it.");
  std::sort(baseline.entries.begin(), baseline.entries.end(), [](const BaselineEntry& a, const BaselineEntry& b) {
    return std::tie(a.scenario, a.method, a.steps, a.metric) < std::tie(b.scenario, b.method, b.steps, b.metric);
  });
  baseline.environment = read_environment(path + ".env");
  if (baseline.environment.empty())
    baseline.notes.push_back(path + ".env is not there: what the baseline was measured with is unknown.");
  return baseline;
}

std::vector<BaselineChange> compare_baseline(const Baseline& baseline, std::span<const Row> rows) {
  using Kind = BaselineChange::Kind;
  const std::map<Key, Entry> now = entries(rows);
  const auto then_cpu = baseline.environment.find("cpu");
  const auto here = environment(rows);
  const auto now_cpu = here.find("cpu");
  const bool timings_judged =
      then_cpu != baseline.environment.end() && now_cpu != here.end() && then_cpu->second == now_cpu->second;
  std::vector<BaselineChange> changes;
  std::set<Key> before;
  for (const BaselineEntry& e : baseline.entries) {
    const Key key{e.scenario, e.method, e.steps, e.metric};
    before.insert(key);
    const MetricInfo& metric = definition_of(e.metric);
    const auto found = now.find(key);
    if (found != now.end() && e.definition != metric.version && !metric.name.empty()) {
      const Entry& measured = found->second;
      changes.push_back(change_of(key, Kind::added, e.value, measured.value, measured.bar, measured.unit));
      changes.back().text = kDefinitionChanged + (metric.changed.empty() ? "" : ": " + metric.changed);
      continue;
    }
    if (found != now.end()) {
      changes.push_back(compare(key, {e.value, e.bar, e.unit}, found->second, timings_judged));
      continue;
    }
    changes.push_back(change_of(key, Kind::missing, e.value, std::nan(""), e.bar, e.unit));
    changes.back().text = "in the baseline, not measured now";
  }
  for (const auto& [key, entry] : now) {
    if (before.contains(key)) continue;
    changes.push_back(change_of(key, Kind::added, std::nan(""), entry.value, entry.bar, entry.unit));
    changes.back().text = "measured now, not in the baseline";
  }
  return changes;
}

std::vector<std::string> environment_changes(const Baseline& baseline, std::span<const Row> rows) {
  std::vector<std::string> notes;
  if (baseline.environment.empty()) return notes;  // the reader of the file has noted it
  struct Part {
    std::string name, words, differs;
  };
  std::vector<Part> parts{{"cpu", "processor", "differs"},
                          {"cpu_features", "processor's features", "differ"},
                          {"libm", "mathematics library", "differs"},
                          {"compiler", "compiler", "differs"},
                          {"flags", "compiler's flags", "differ"}};
  const auto now = environment(rows);
  std::set<std::string> engines;  // engines with figures in the baseline; versions of others do not matter
  for (const BaselineEntry& e : baseline.entries) engines.insert("engine\t" + e.method.substr(0, e.method.find('/')));
  for (const auto& [name, versions] : now)
    if (engines.contains(name)) parts.push_back({name, "version of the engine " + name.substr(7), "differs"});
  for (const Part& part : parts) {
    const auto here = now.find(part.name);
    if (here == now.end()) continue;
    const auto then = baseline.environment.find(part.name);
    if (then == baseline.environment.end()) {
      notes.push_back("The " + part.words + " that the baseline was measured with is not in " + baseline.path +
                      ".env; here: `" + joined(here->second) + "`.");
      continue;
    }
    if (std::includes(then->second.begin(), then->second.end(), here->second.begin(), here->second.end())) continue;
    std::string what = part.name == "cpu_features" ? changed_words(then->second, here->second) : "";
    if (what.empty()) what = "`" + joined(here->second) + "`, then `" + joined(then->second) + "`";
    notes.push_back("The " + part.words + " " + part.differs + " from the baseline's: " + what +
                    "; this alone may change figures.");
  }
  return notes;
}

}  // namespace atwood
