// A baseline: what was measured once and agreed to, one metric a line, sorted, so that a change reads well in a diff.
//
//   # atwood baseline 1
//   # reason: <text>
//   # scenario <tab> method <tab> steps <tab> metric <tab> value <tab> bar <tab> unit
//   kepler-e0.6  atwood/rk4  960  error-position-end  1.319e-06  0  m
//
// The environment it was measured in is in <path>.env: compiler, flags, CPU, engine versions. No timestamps.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <stdexcept>
#include <tuple>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/gates/gates.hpp"

namespace atwood {
namespace {

// How far a value may move before it counts as a change, beside both bars. Our own engine is deterministic: what is
// left is another compiler's round-off inside an error that is itself measured in full. Rivals are built elsewhere.
// Times come from a noisy machine.
constexpr double kOwnTolerance = 1e-3, kRivalTolerance = 0.02, kTimingTolerance = 0.25;
// Below this share of a metric's own unit, values are round-off of round-off and change with the mathematics library.
constexpr double kRoundOff = 1e-14;

struct Key {
  std::string scenario, method, metric;
  std::int64_t steps = 0;
  auto operator<=>(const Key&) const = default;
};
struct Entry { double value = 0, bar = 0; std::string unit; };

bool timing(const std::string& metric) { return metric.starts_with("step-time"); }
bool judged(const Row& row) {
  return row.status == Status::ok && row.body.empty() && !row.t_s && row.metric != "status" &&
         !row.metric.starts_with("size-") && row.metric != "condition";
}

std::map<Key, Entry> entries(std::span<const Row> rows) {
  std::map<Key, Entry> list;
  for (const Row& r : rows)
    if (judged(r)) list[{r.scenario, r.method, r.metric, r.steps}] = {r.value, r.truth_bar, r.unit};
  return list;
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (c == '\n' || c == '\r' || c == '\t') c = ' ';
  return text;
}

std::string environment(std::span<const Row> rows) {
  std::set<std::string> lines;
  for (const Row& r : rows) {
    if (!judged(r)) continue;
    lines.insert("compiler\t" + one_line(r.provenance.compiler));
    lines.insert("flags\t" + one_line(r.provenance.flags));
    lines.insert("cpu\t" + one_line(r.provenance.cpu));
    lines.insert("engine\t" + r.method.substr(0, r.method.find('/')) + "\t" + one_line(r.provenance.engine_version));
  }
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

// Beside the target, then renamed over it: a full disk leaves the old baseline whole.
void write_whole(const std::string& path, const std::string& content) {
  const std::string partial = path + ".partial-" + std::to_string(getpid());
  std::ofstream out(partial, std::ios::binary);
  out << content;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(partial, path, error);
  if (!out || error) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    throw std::runtime_error(path + ": could not be written");
  }
}

std::map<Key, Entry> read_baseline(const std::string& path) {
  if (!std::filesystem::exists(path)) throw std::runtime_error(path + ": no baseline there");
  std::istringstream file(read_input_file(path, "a baseline", largest::table));
  std::map<Key, Entry> list;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    const auto refuse = [&](const std::string& what) {
      throw InputError(path + ":" + std::to_string(number) + ":1: " + what);
    };
    if (number == 1 && line != "# atwood baseline 1") refuse("expected `# atwood baseline 1`, found `" + line + "`");
    if (line.empty() || line[0] == '#') continue;
    std::vector<std::string> cells;
    std::stringstream stream(line);
    for (std::string cell; std::getline(stream, cell, '\t');) cells.push_back(cell);
    if (cells.size() == 6) cells.push_back("");
    if (cells.size() != 7) refuse("expected 7 columns separated by tabs, found " + std::to_string(cells.size()));
    try {
      const Key key{cells[0], cells[1], cells[3], std::stoll(cells[2])};
      const Entry entry{std::stod(cells[4]), std::stod(cells[5]), cells[6]};
      if (!list.emplace(key, entry).second) refuse("the metric is there twice");
    } catch (const std::logic_error&) {
      refuse("expected numbers in columns 3, 5 and 6");
    }
  }
  return list;
}

bool same_machine(const std::string& path, std::span<const Row> rows) {
  const std::string beside = path + ".env";
  std::istringstream file(
      std::filesystem::exists(beside) ? read_input_file(beside, "a baseline's environment", largest::settings) : "");
  std::set<std::string> then, now;
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("cpu\t")) then.insert(line.substr(4));
  for (const Row& r : rows)
    if (judged(r)) now.insert(one_line(r.provenance.cpu));
  return then == now;
}

// How bad a value is. Orders and counts of what should happen are compared as they are, where less is worse.
double badness(const std::string& metric, double value) {
  return metric.starts_with("order-") ? -value : std::fabs(value);
}

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

BaselineChange compare(const Key& key, const Entry& before, const Entry& now, bool timings_judged) {
  using Kind = BaselineChange::Kind;
  BaselineChange change{Kind::unchanged, key.scenario, key.method, key.metric, key.steps, before.value, now.value,
                        before.bar + now.bar, "", ""};
  const double share = timing(key.metric) ? kTimingTolerance
                       : key.method.starts_with("atwood/") ? kOwnTolerance : kRivalTolerance;
  const double tolerance = change.bar + share * std::fabs(before.value) + (timing(key.metric) ? 0 : kRoundOff);
  const double worse = badness(key.metric, now.value) - badness(key.metric, before.value);
  const bool nan_before = std::isnan(before.value), nan_now = std::isnan(now.value);
  if (nan_now != nan_before) change.kind = nan_now ? Kind::regression : Kind::improvement;
  else if (!nan_now && worse > tolerance) change.kind = Kind::regression;
  else if (!nan_now && -worse > tolerance) change.kind = Kind::improvement;
  change.text = number(before.value) + " -> " + number(now.value) + (before.unit == "1" ? "" : " " + before.unit) +
                ", tolerance " + number(tolerance);
  if (timing(key.metric) && !timings_judged && change.kind != Kind::unchanged) {
    change.text += "; advisory: another machine";
    change.kind = Kind::unchanged;
  }
  return change;
}

}  // namespace

void write_baseline(const std::string& path, std::span<const Row> rows, const std::string& reason) {
  if (one_line(reason).find_first_not_of(' ') == std::string::npos) throw InputError("a baseline needs a reason");
  std::string text = "# atwood baseline 1\n# reason: " + one_line(reason) +
                     "\n# scenario\tmethod\tsteps\tmetric\tvalue\tbar\tunit\n";
  // Sorted by scenario, method, steps, metric.
  std::map<std::tuple<std::string, std::string, std::int64_t, std::string>, std::string> lines;
  for (const auto& [key, entry] : entries(rows))
    lines[{key.scenario, key.method, key.steps, key.metric}] =
        key.scenario + "\t" + key.method + "\t" + std::to_string(key.steps) + "\t" + key.metric + "\t" +
        format_double(entry.value) + "\t" + format_double(entry.bar) + "\t" + entry.unit + "\n";
  for (const auto& [key, line] : lines) text += line;
  write_whole(path, text);
  write_whole(path + ".env", environment(rows));
}

std::vector<BaselineChange> compare_baseline(const std::string& path, std::span<const Row> rows) {
  using Kind = BaselineChange::Kind;
  const std::map<Key, Entry> before = read_baseline(path), now = entries(rows);
  const bool timings_judged = same_machine(path, rows);
  std::vector<BaselineChange> changes;
  for (const auto& [key, entry] : before) {
    const auto found = now.find(key);
    if (found != now.end()) changes.push_back(compare(key, entry, found->second, timings_judged));
    else
      changes.push_back({Kind::missing, key.scenario, key.method, key.metric, key.steps, entry.value, std::nan(""),
                         entry.bar, "in the baseline, not measured now", ""});
  }
  for (const auto& [key, entry] : now)
    if (!before.contains(key))
      changes.push_back({Kind::added, key.scenario, key.method, key.metric, key.steps, std::nan(""), entry.value,
                         entry.bar, "measured now, not in the baseline", ""});
  for (BaselineChange& c : changes) {
    c.rerun = "./atwood run --scenario '" + c.scenario + "' --method '" + c.method + "'";
    if (c.steps > 0) c.rerun += " --steps " + std::to_string(c.steps);
  }
  return changes;
}

}  // namespace atwood
