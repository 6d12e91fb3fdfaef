// Study files: which scenarios meet which methods.
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <iterator>
#include <set>

#include "scene/files.hpp"
#include "validation/metrics/probes.hpp"
#include "validation/study/study.hpp"

namespace atwood {
namespace {

struct StudyFile {
  const std::string& path;

  [[noreturn]] void refuse(const toml::source_region& at, const std::string& what) const {
    throw InputError(path + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) + ": " + what);
  }

  template <std::size_t n>
  void check_keys(const toml::table& table, const std::array<const char*, n>& known, const std::string& where) const {
    for (const auto& [key, value] : table) {
      if (std::find(known.begin(), known.end(), key.str()) != known.end()) continue;
      std::string expected;
      for (const char* name : known) expected += (expected.empty() ? "" : ", ") + std::string(name);
      refuse(key.source(),
             "unknown key `" + std::string(key.str()) + "` in " + where + "; expected one of " + expected);
    }
  }

  std::vector<std::string> strings(const toml::table& table, const char* key) const {
    const toml::node* node = table.get(key);
    if (!node) refuse(table.source(), "no `" + std::string(key) + "` in [[cells]]; expected a list of strings");
    const toml::array* list = node->as_array();
    if (!list || list->empty())
      refuse(node->source(), "`" + std::string(key) + "`: expected a list of strings, at least one");
    std::vector<std::string> values;
    for (const toml::node& each : *list) {
      const auto text = each.value_exact<std::string>();
      if (!text || text->empty()) refuse(each.source(), "`" + std::string(key) + "`: expected a string");
      values.push_back(*text);
    }
    return values;
  }

  std::int64_t positive(const toml::node& node, const std::string& key, std::int64_t most) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value <= 0 || *value > most) {
      refuse(node.source(), "`" + key + "`: expected a whole number from 1 to " + std::to_string(most));
    }
    return *value;
  }

  std::vector<std::int64_t> step_counts(const toml::node& node) const {
    const toml::array* list = node.as_array();
    if (!list || list->empty()) refuse(node.source(), "`steps`: expected a list of step counts, at least one");
    std::vector<std::int64_t> steps;
    for (const toml::node& each : *list) steps.push_back(positive(each, "steps", std::int64_t{1} << 40));
    return steps;
  }

  std::map<std::string, std::vector<SettingValue>> sweep(const toml::node& node) const {
    const toml::table* table = node.as_table();
    if (!table) refuse(node.source(), "`sweep`: expected a table of lists, as in { erp = [0.0, 0.2] }");
    std::map<std::string, std::vector<SettingValue>> sweep;
    for (const auto& [key, list] : *table) {
      const std::string name(key.str());
      if (!list.is_array() || list.as_array()->empty())
        refuse(list.source(), "`" + name + "`: expected a list of values");
      for (const toml::node& each : *list.as_array()) {
        if (const auto flag = each.value_exact<bool>()) sweep[name].push_back(*flag);
        else if (const auto integer = each.value_exact<std::int64_t>()) sweep[name].push_back(*integer);
        else if (const auto real = each.value_exact<double>()) sweep[name].push_back(*real);
        else if (const auto text = each.value_exact<std::string>()) sweep[name].push_back(*text);
        else refuse(each.source(), "`" + name + "`: expected a boolean, a number or a string");
      }
    }
    return sweep;
  }

  // claim = "rotation", orders = [4, 6]: the methods that claim an order from 4 to 6 in this class of motion.
  void read_claim(const toml::node& claim, const toml::node* orders, StudyCells& cells) const {
    static const std::array known{"point-mass", "velocity-dependent", "rotation", "contact"};
    const auto name = claim.value_exact<std::string>();
    if (!name || std::find(known.begin(), known.end(), *name) == known.end())
      refuse(claim.source(),
             "`claim`: expected a class of motion: point-mass, velocity-dependent, rotation or contact");
    cells.claim = *name;
    if (!orders) return;
    const toml::array* pair = orders->as_array();
    if (!pair || pair->size() != 2 || !pair->get(0)->is_number() || !pair->get(1)->is_number())
      refuse(orders->source(), "`orders`: expected two numbers, [least, most]");
    cells.least_order = *pair->get(0)->value<double>();
    cells.most_order = *pair->get(1)->value<double>();
  }

  // allow = ["diverged"], allow_reason = "...": endings of the block's cells that do not fail the run.
  void read_allow(const toml::table& table, StudyCells& cells) const {
    const toml::node* reason = table.get("allow_reason");
    if (!table.get("allow")) {
      if (reason) refuse(reason->source(), "`allow_reason` needs `allow`");
      return;
    }
    for (const std::string& word : strings(table, "allow")) {
      if (word != "diverged" && word != "not finite")
        refuse(table.get("allow")->source(), "`allow`: expected \"diverged\" or \"not finite\", found `" + word + "`");
      cells.allow.push_back(word == "diverged" ? Status::diverged : Status::not_finite);
    }
    const auto text = reason ? reason->value_exact<std::string>() : std::nullopt;
    if (!text || text->find_first_not_of(" \t\n") == std::string::npos)
      refuse((reason ? reason : table.get("allow"))->source(), "`allow` needs `allow_reason`: why these cells may end so");
    cells.allow_reason = *text;
  }

  std::string probe_name(const toml::node& node) const {
    const auto name = node.value_exact<std::string>();
    std::string known;
    for (const ProbeInfo& probe : all_probes()) {
      if (name && *name == probe.name) return *name;
      known += (known.empty() ? "" : ", ") + probe.name;
    }
    refuse(node.source(),
           "`probe`: " + (name ? "unknown probe `" + *name + "`; " : std::string()) + "expected one of " + known);
  }

  StudyCells cells(const toml::node& node) const {
    const toml::table* table = node.as_table();
    if (!table) refuse(node.source(), "expected [[cells]] to be tables");
    check_keys(
        *table,
        std::array{"scenarios", "methods", "steps", "repeats", "sweep", "timing", "claim", "orders", "except", "probe", "limit",
                   "allow", "allow_reason"},
        "[[cells]]");
    StudyCells cells;
    cells.scenarios = strings(*table, "scenarios");
    cells.methods = strings(*table, "methods");
    if (table->get("except")) cells.except = strings(*table, "except");
    for (const std::string& method : cells.methods) {
      if (method.find_first_of("*?") != std::string::npos) continue;
      try {
        parse_method_id(method);
      } catch (const std::invalid_argument& error) {
        refuse(table->get("methods")->source(), error.what());
      }
    }
    if (const toml::node* steps = table->get("steps")) cells.steps = step_counts(*steps);
    if (const toml::node* repeats = table->get("repeats")) {
      cells.repeats = static_cast<int>(positive(*repeats, "repeats", 10000));
    }
    if (const toml::node* timing = table->get("timing")) {
      const auto flag = timing->value_exact<bool>();
      if (!flag) refuse(timing->source(), "`timing`: expected true or false");
      if (!*flag) cells.repeats = 0;
    }
    if (const toml::node* limit = table->get("limit")) {
      const auto seconds = limit->value<double>();
      if (!limit->is_number() || !(*seconds >= 0.01 && *seconds <= 1e6))
        refuse(limit->source(), "`limit`: expected the seconds that a cell may take, 0.01 to 1e6");
      cells.limit_s = *seconds;
    }
    read_allow(*table, cells);
    if (const toml::node* probe = table->get("probe")) cells.probe = probe_name(*probe);
    if (const toml::node* claim = table->get("claim")) read_claim(*claim, table->get("orders"), cells);
    else if (const toml::node* orders = table->get("orders")) refuse(orders->source(), "`orders` needs `claim`");
    if (const toml::node* values = table->get("sweep")) cells.sweep = sweep(*values);
    return cells;
  }
};

}  // namespace

Study read_study(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream && !stream.eof()) throw InputError(path + ": cannot be read; expected a study file (TOML)");
  const StudyFile file{path};
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    file.refuse(error.source(), std::string(error.description()));
  }
  file.check_keys(root, std::array{"id", "cells"}, "a study");
  Study study;
  const auto id = root["id"].value_exact<std::string>();
  if (!id || id->empty()) throw InputError(path + ": no `id`; expected a name for the study");
  study.id = *id;
  const toml::array* list = root["cells"].as_array();
  if (!list || list->empty()) throw InputError(path + ": no [[cells]]; expected at least one");
  for (const toml::node& each : *list) study.cells.push_back(file.cells(each));
  return study;
}

}  // namespace atwood
