#include "reports/command_line/units.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "benchmarks/goals.hpp"
#include "scene/files.hpp"
#include "validation/metrics/work_precision.hpp"

namespace atwood {
namespace {

struct Unit {
  const char* name;
  const char* base;
  double size;
};
constexpr double kDegree = 3.14159265358979323846 / 180;
// clang-format off
constexpr Unit kUnits[] = {
    {"m", "m", 1},           {"km", "m", 1e3},        {"cm", "m", 1e-2},          {"mm", "m", 1e-3},
    {"um", "m", 1e-6},       {"nm", "m", 1e-9},       {"rad", "rad", 1},          {"mrad", "rad", 1e-3},
    {"urad", "rad", 1e-6},   {"deg", "rad", kDegree}, {"m/s", "m/s", 1},          {"km/s", "m/s", 1e3},
    {"cm/s", "m/s", 1e-2},   {"mm/s", "m/s", 1e-3},   {"um/s", "m/s", 1e-6},      {"rad/s", "rad/s", 1},
    {"mrad/s", "rad/s", 1e-3}, {"deg/s", "rad/s", kDegree}, {"s", "s", 1},        {"ms", "s", 1e-3},
    {"us", "s", 1e-6},       {"ns", "s", 1e-9},       {"J", "J", 1},              {"mJ", "J", 1e-3},
    {"kJ", "J", 1e3},        {"%", "1", 1e-2}};
// clang-format on

// The metric that a unit stands for where none is named.
const std::map<std::string, std::string>& metrics_of_units() {
  static const std::map<std::string, std::string> metrics{{"m", "error-position-max"},
                                                          {"rad", "error-attitude-max"},
                                                          {"m/s", "error-velocity-max"},
                                                          {"rad/s", "error-body-rate-max"},
                                                          {"1", "energy-max"}};
  return metrics;
}

std::string metric_of(const std::string& asked) {
  static const std::map<std::string, std::string> known{
      {"position", "error-position-max"},   {"velocity", "error-velocity-max"}, {"attitude", "error-attitude-max"},
      {"body-rate", "error-body-rate-max"}, {"state", "error-state-end"},       {"energy", "energy-max"},
      {"joint", "error-joint-coordinate"}};
  if (asked.empty()) return "";
  if (const auto found = known.find(asked); found != known.end()) return found->second;
  std::vector<std::string> names;
  for (const MetricInfo& metric : all_metrics()) {
    if (metric.name == asked) return asked;
    names.push_back(metric.name);
  }
  throw InputError(
      fmt::format("--metric {}: expected position, velocity, attitude, body-rate, joint, state, energy, or a metric of "
                  "`atwood list metrics`{}",
                  asked, nearest_hint(asked, names, 1)));
}

std::string unit_of(const std::string& metric) {
  for (const MetricInfo& known : all_metrics()) {
    if (known.name == metric) return known.unit;
  }
  return "";
}

const Unit* find_unit(const std::string& name) {
  for (const Unit& unit : kUnits) {
    if (name == unit.name) return &unit;
  }
  return nullptr;
}

InputError not_an_error(const std::string& text) {
  std::vector<std::string> names;
  for (const Unit& unit : kUnits) names.push_back(unit.name);
  return InputError(
      fmt::format("--error {}: expected a number above 0 and perhaps a unit, as in 1e-8, 0.1mm or 1e-6rad; units: {}",
                  text, fmt::join(names, " ")));
}

double read_error(const std::string& text, std::string& metric, const std::string& asked_metric) {
  std::size_t end = 0;
  double value = 0;
  try {
    value = std::stod(text, &end);
  } catch (const std::exception&) {
    throw not_an_error(text);
  }
  while (end < text.size() && text[end] == ' ') ++end;
  const std::string name = text.substr(end);
  if (!(value > 0) || !std::isfinite(value) || text.find_first_of("xXpP") < end) throw not_an_error(text);
  if (name.empty()) return value;
  const Unit* unit = find_unit(name);
  if (unit == nullptr) throw not_an_error(text);
  if (metric.empty()) {
    const auto found = metrics_of_units().find(unit->base);
    if (found == metrics_of_units().end())
      throw InputError(
          fmt::format("--error {}: several metrics have the unit {}; expected --metric beside it", text, name));
    metric = found->second;
  }
  // A unit chooses among the coordinates of joints: angles or offsets.
  if (metric == "error-joint-coordinate" && std::string(unit->base) == "rad") metric = "error-joint-angle";
  if (metric == "error-joint-coordinate" && std::string(unit->base) == "m") metric = "error-joint-offset";
  if (unit_of(metric) != unit->base) {
    const std::string own = metric == "error-joint-coordinate" ? "rad (angles) or m (offsets)" : unit_of(metric);
    throw InputError(fmt::format("--error {}: --metric {} is measured in {}; found the unit {}", text, asked_metric,
                                 own == "1" ? "no unit (a ratio)" : own, name));
  }
  return value * unit->size;
}

}  // namespace

Question read_question(const Options& options) {
  Question question;
  question.metric = metric_of(options.metric);
  if (is_of_ladder(question.metric))
    throw InputError(
        fmt::format("--metric {}: it is a figure of a whole ladder, and no step has it; expected a figure of a run, as "
                    "error-position-max. `atwood run` prints it",
                    options.metric));
  if (!options.wanted_error.empty()) question.error = read_error(options.wanted_error, question.metric, options.metric);
  if (!options.budget.empty()) question.budget_s = parse_duration(options.budget, "--budget");
  return question;
}

void set_frequency(Scenario& scenario, const std::vector<double>& hz) {
  if (hz.empty()) return;
  scenario.steps.clear();
  for (const double frequency : hz) {
    if (!(frequency > 0) || !std::isfinite(frequency) || frequency * scenario.t_end_s > 9e15)
      throw InputError(fmt::format("--hz {}: expected a frequency above 0", frequency));
    const double steps = scenario.t_end_s * frequency, count = std::round(steps);
    const auto samples = static_cast<double>(scenario.samples);
    const bool whole = count >= 1 && std::fabs(steps - count) <= 1e-9 * count;
    if (whole && static_cast<std::int64_t>(count) % scenario.samples == 0) {
      scenario.steps.push_back(static_cast<std::int64_t>(count));
      continue;
    }
    const double nearest_count = samples * std::max(1.0, std::round(steps / samples));
    throw InputError(
        fmt::format("--hz {}: over the {} s of `{}` these are {} steps; expected {}; nearest: --hz {} ({} steps)",
                    frequency, format_double(scenario.t_end_s), scenario.id,
                    whole ? fmt::format("{:.0f}", count) : fmt::format("{:.6g}", steps),
                    whole ? fmt::format("a multiple of its {} samples", scenario.samples) : "a whole number of them",
                    format_double(nearest_count / scenario.t_end_s), nearest_count));
  }
  std::sort(scenario.steps.begin(), scenario.steps.end());
  scenario.steps.erase(std::unique(scenario.steps.begin(), scenario.steps.end()), scenario.steps.end());
}

std::map<std::string, std::string> set_frequencies(std::vector<Scenario>& scenarios, const std::vector<double>& hz,
                                                   Study& study) {
  std::map<std::string, std::string> unfit;
  if (hz.empty()) return unfit;
  for (StudyCells& cells : study.cells) cells.steps.clear();
  for (Scenario& scenario : scenarios) {
    const std::vector<std::int64_t> ladder = scenario.steps;
    try {
      set_frequency(scenario, hz);
    } catch (const InputError& error) {
      unfit[scenario.id] = error.what();
      scenario.steps = ladder;
    }
  }
  return unfit;
}

void require_frequencies(const std::vector<Cell>& cells, const std::map<std::string, std::string>& unfit) {
  for (const Cell& cell : cells) {
    if (const auto found = unfit.find(cell.scenario->id); found != unfit.end()) throw InputError(found->second);
  }
}

}  // namespace atwood
