// Reads files of goals.
#include "scene/toml_parser.hpp"

#include <cmath>
#include <set>
#include <tuple>

#include "benchmarks/goals.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"

namespace atwood {
namespace {

struct GoalsFile {
  const std::string& path;

  [[noreturn]] void refuse(const toml::source_region& at, const std::string& what) const {
    throw InputError(path + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) + ": " + what);
  }

  std::string text(const toml::table& table, const char* key) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return "";
    const auto value = node->value_exact<std::string>();
    if (!value) refuse(node->source(), std::string("`") + key + "`: expected a string");
    return *value;
  }

  double number(const toml::table& table, const char* key, double otherwise) const {
    const toml::node* node = table.get(key);
    if (node == nullptr) return otherwise;
    const auto value = node->value<double>();
    if (!node->is_number() || !value || !(*value > 0))
      refuse(node->source(), std::string("`") + key + "`: expected a number above 0");
    return *value;
  }

  template <class T> std::vector<T> list(const toml::table& table, const char* key, const char* expected) const {
    std::vector<T> values;
    const toml::node* node = table.get(key);
    if (node == nullptr) return values;
    const toml::array* found = node->as_array();
    if (found == nullptr) refuse(node->source(), std::string("`") + key + "`: expected " + expected);
    for (const toml::node& each : *found) {
      const auto value = each.value<T>();
      if (!value) refuse(each.source(), std::string("`") + key + "`: expected " + expected);
      values.push_back(*value);
    }
    return values;
  }

  void read_budget(const toml::table& table, Goal& goal) const {
    for (const auto& [key, kind, scale] :
         {std::tuple{"time", "seconds", 1.0}, {"step_time", "ns_per_step", 1e9}, {"figure", "ns", 1e9}}) {
      const std::string words = text(table, key);
      if (words.empty()) continue;
      goal.budget_kind = kind;
      goal.budget = scale * parse_duration(words, path + ": `" + key + "`");
    }
    if (table.contains("evaluations")) {
      goal.budget_kind = "evaluations";
      goal.budget = number(table, "evaluations", 0);
    }
  }

  Goal goal(const toml::node& node) const {
    static const std::set<std::string> known{"id",          "title",
                                             "scenario",    "metric",
                                             "error",       "time",
                                             "step_time",   "figure",
                                             "evaluations", "samples",
                                             "steps",       "tolerances",
                                             "first_steps", "methods",
                                             "rivals",      "uncounted",
                                             "benchmark",   "rival_benchmarks",
                                             "per",         "times_faster",
                                             "error_ratio", "limit",
                                             "table",       "row",
                                             "column",      "at_most",
                                             "spacings_m",  "t_end_s",
                                             "seeds",       "at_s",
                                             "phases",      "starts",
                                             "within",      "sound_speed_m_per_s",
                                             "rival_steps", "rival_seeds"};
    const toml::table* table = node.as_table();
    if (table == nullptr) refuse(node.source(), "expected [[goal]] to be tables");
    for (const auto& [key, value] : *table) {
      if (!known.contains(std::string(key.str())))
        refuse(key.source(), "unknown key `" + std::string(key.str()) + "` in [[goal]]");
    }
    Goal goal;
    goal.id = text(*table, "id");
    if (goal.id.empty()) refuse(table->source(), "a goal without `id`");
    goal.title = text(*table, "title").empty() ? goal.id : text(*table, "title");
    goal.scenario = text(*table, "scenario");
    goal.metric = text(*table, "metric");
    goal.error = number(*table, "error", goal.error);
    read_budget(*table, goal);
    goal.samples = static_cast<std::int64_t>(number(*table, "samples", 1));
    goal.steps = list<std::int64_t>(*table, "steps", "a list of step counts");
    goal.tolerances = list<double>(*table, "tolerances", "a list of tolerances");
    goal.first_steps = static_cast<std::int64_t>(
        number(*table, "first_steps", goal.steps.empty() ? 1000.0 : static_cast<double>(goal.steps.front())));
    goal.methods = list<std::string>(*table, "methods", "a list of method ids");
    goal.rivals = list<std::string>(*table, "rivals", "a list of method ids");
    goal.uncounted = list<std::string>(*table, "uncounted", "a list of method ids");
    goal.benchmark = text(*table, "benchmark");
    goal.rival_benchmarks = list<std::string>(*table, "rival_benchmarks", "a list of benchmark names");
    goal.per = number(*table, "per", 1);
    goal.times_faster = number(*table, "times_faster", 0);
    goal.error_ratio = number(*table, "error_ratio", 0);
    if (goal.times_faster > 0 && goal.budget_kind.empty())
      goal.budget_kind = "ns_per_step", goal.budget = std::numeric_limits<double>::infinity();
    if (const std::string limit = text(*table, "limit"); !limit.empty())
      goal.limit_s = parse_duration(limit, path + ": `limit`");
    goal.spacings_m = list<double>(*table, "spacings_m", "a list of spacings");
    goal.sound_speed_m_per_s = number(*table, "sound_speed_m_per_s", 0);
    goal.t_end_s = number(*table, "t_end_s", 0);
    goal.seeds = static_cast<std::int64_t>(number(*table, "seeds", 1));
    goal.rival_steps = list<std::int64_t>(*table, "rival_steps", "a list of step counts");
    goal.rival_seeds = static_cast<std::int64_t>(number(*table, "rival_seeds", 0));
    if (goal.rival_seeds > goal.seeds)
      refuse(table->get("rival_seeds")->source(), "`rival_seeds`: expected at most `seeds`");
    goal.phases = static_cast<std::int64_t>(number(*table, "phases", 1));
    goal.starts = static_cast<std::int64_t>(number(*table, "starts", 1));
    if ((goal.seeds > 1) + (goal.phases > 1) + (goal.starts > 1) > 1)
      refuse(table->source(), "goal `" + goal.id + "`: expected one of `seeds`, `phases`, `starts`");
    goal.at_s = number(*table, "at_s", 0);
    if (const auto within = list<double>(*table, "within", "two numbers"); !within.empty()) {
      if (within.size() != 2 || !(within[0] < within[1]) || std::isfinite(goal.error))
        refuse(table->get("within")->source(), "`within`: expected two rising numbers, and no `error` beside them");
      goal.low = within[0], goal.high = within[1];
    }
    goal.table = text(*table, "table");
    goal.row = text(*table, "row");
    goal.column = text(*table, "column");
    if (!goal.table.empty()) goal.error = number(*table, "at_most", goal.error);
    const int works = !goal.scenario.empty() + !goal.benchmark.empty() + !goal.table.empty();
    if (works != 1)
      refuse(table->source(), "goal `" + goal.id + "`: expected one of `scenario`, `benchmark` and `table`");
    if (!goal.table.empty() && (goal.row.empty() || goal.column.empty() || !std::isfinite(goal.error)))
      refuse(table->source(), "goal `" + goal.id + "`: a `table` needs its `row`, `column` and `at_most`");
    if (goal.scenario.empty()) return goal;
    if (goal.error_ratio > 0 && (goal.metric.empty() || std::isfinite(goal.error)))
      refuse(table->source(), "goal `" + goal.id + "`: an `error_ratio` needs its `metric`, and no `error` beside it");
    if ((std::isfinite(goal.error) || std::isfinite(goal.low)) && goal.metric.empty())
      refuse(table->source(), "goal `" + goal.id + "`: an `error` or `within` needs its `metric`");
    for (const auto& [key, steps] : {std::pair{"steps", &goal.steps}, {"rival_steps", &goal.rival_steps}})
      for (const std::int64_t n : *steps)
        if (n <= 0 || n % goal.samples != 0)
          refuse(table->get(key)->source(), std::string("`") + key + "`: expected multiples of `samples`");
    return goal;
  }
};

}  // namespace

double parse_duration(const std::string& text, const std::string& what) {
  std::size_t end = 0;
  double value = 0;
  try {
    value = std::stod(text, &end);
  } catch (const std::exception&) {
    end = 0;
  }
  while (end < text.size() && text[end] == ' ') ++end;
  const std::string unit = text.substr(end);
  const double scale = unit == "ns" ? 1e-9 : unit == "us" ? 1e-6 : unit == "ms" ? 1e-3 : unit == "s" ? 1 : 0;
  if (end == 0 || scale == 0 || !(value > 0) || !std::isfinite(value)) {
    throw InputError(what + ": found `" + text + "`; expected a time with its unit: ns, us, ms or s, as in 16.7ms");
  }
  return value * scale;
}

std::vector<Goal> read_goals(const std::string& path) {
  const std::string text = read_input_file(path, "a file of goals (TOML)", largest::kSettings);
  require_shallow_toml(text, path);
  const GoalsFile file{path};
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    file.refuse(error.source(), std::string(error.description()));
  }
  const toml::array* list = root["goal"].as_array();
  if (list == nullptr || list->empty()) throw InputError(path + ": no [[goal]]; expected at least one");
  std::vector<Goal> goals;
  std::set<std::string> ids;
  for (const toml::node& each : *list) {
    goals.push_back(file.goal(each));
    if (!ids.insert(goals.back().id).second)
      file.refuse(each.source(), "two goals are called `" + goals.back().id + "`");
  }
  return goals;
}

}  // namespace atwood
