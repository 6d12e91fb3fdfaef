// Study files: which methods run which scenarios.
#include "scene/toml_parser.hpp"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <set>
#include <sstream>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/gates/gates.hpp"
#include "validation/gates/toml_text.hpp"
#include "validation/metrics/probes.hpp"
#include "validation/study/study.hpp"

namespace atwood {
namespace fs = std::filesystem;
namespace {

// "; nearest: scenes/satellite.toml": the file of that folder whose name has the longest common prefix and suffix with
// the missing one, together at least half of its letters; empty where there is none.
std::string nearest_file(const fs::path& missing, const std::string& written) {
  const std::string word = missing.stem().string();
  std::string best;
  std::size_t most = (word.size() + 1) / 2;
  std::error_code error;
  for (fs::directory_iterator entry(missing.parent_path(), error), end; !error && entry != end;
       entry.increment(error)) {
    if (entry->path().extension() != ".toml") continue;
    const std::string name = entry->path().stem().string();
    const auto head = static_cast<std::size_t>(std::mismatch(word.begin(), word.end(), name.begin(), name.end()).first -
                                               word.begin());
    const auto tail = static_cast<std::size_t>(
        std::mismatch(word.rbegin(), word.rend(), name.rbegin(), name.rend()).first - word.rbegin());
    const std::size_t common = std::min(head + tail, std::min(word.size(), name.size()));
    if (common < most || (common == most && !best.empty() && name > best)) continue;
    most = common;
    best = name;
  }
  if (best.empty()) return "";
  return "; nearest: " + (fs::path(written).parent_path() / (best + ".toml")).string();
}

struct StudyFile {
  const std::string& path;
  std::string id = {};  // of the study, once it is read

  [[noreturn]] void refuse(const toml::source_region& at, const std::string& what) const {
    throw InputError(place_of(at) + what);
  }
  std::string place_of(const toml::source_region& at) const {
    return path + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) + ": ";
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
    if (!node) refuse(table.source(), "missing key `" + std::string(key) + "`; expected a list of strings");
    const toml::array* list = node->as_array();
    if (!list || list->empty())
      refuse(node->source(),
             "`" + std::string(key) + "` is " + found_text(*node) + "; expected a list of strings, at least one");
    std::vector<std::string> values;
    for (const toml::node& each : *list) {
      const auto text = each.value_exact<std::string>();
      if (!text || text->empty())
        refuse(each.source(),
               "`" + std::string(key) + "` has " + found_text(each) + "; expected strings that are not empty");
      values.push_back(*text);
    }
    return values;
  }

  std::int64_t positive(const toml::node& node, const std::string& key, std::int64_t most) const {
    const auto value = node.value_exact<std::int64_t>();
    if (!value || *value <= 0 || *value > most) {
      refuse(node.source(),
             "`" + key + "` is " + found_text(node) + "; expected a whole number from 1 to " + std::to_string(most));
    }
    return *value;
  }

  std::vector<std::int64_t> step_counts(const toml::node& node) const {
    const toml::array* list = node.as_array();
    if (!list || list->empty())
      refuse(node.source(), "`steps` is " + found_text(node) + "; expected a list of step counts, at least one");
    std::vector<std::int64_t> steps;
    for (const toml::node& each : *list) steps.push_back(positive(each, "steps", 1'000'000'000'000));
    return steps;
  }

  std::vector<double> positive_numbers(const toml::node& node, const std::string& key) const {
    const toml::array* list = node.as_array();
    if (!list || list->empty()) refuse(node.source(), "`" + key + "`: expected a list of numbers, at least one");
    std::vector<double> values;
    for (const toml::node& each : *list) {
      const auto value = each.is_number() ? each.value<double>() : std::nullopt;
      if (!value || !(*value > 0) || !std::isfinite(*value))
        refuse(each.source(), "`" + key + "`: expected numbers above 0");
      values.push_back(*value);
    }
    return values;
  }

  std::map<std::string, std::vector<SettingValue>> sweep(const toml::node& node) const {
    const toml::table* table = node.as_table();
    if (!table)
      refuse(node.source(),
             "`sweep` is " + found_text(node) + "; expected a table of lists, as in { erp = [0.0, 0.2] }");
    std::map<std::string, std::vector<SettingValue>> sweep;
    for (const auto& [key, list] : *table) {
      const std::string name(key.str());
      if (!list.is_array() || list.as_array()->empty())
        refuse(list.source(), "`" + name + "` is " + found_text(list) + "; expected a list of values, at least one");
      for (const toml::node& each : *list.as_array()) {
        if (const auto flag = each.value_exact<bool>()) sweep[name].push_back(*flag);
        else if (const auto integer = each.value_exact<std::int64_t>()) sweep[name].push_back(*integer);
        else if (const auto real = each.value_exact<double>(); real && std::isfinite(*real))
          sweep[name].push_back(*real);
        else if (real) refuse(each.source(), "`" + name + "` has " + found_text(each) + "; expected finite numbers");
        else if (const auto text = each.value_exact<std::string>()) sweep[name].push_back(*text);
        else
          refuse(each.source(), "`" + name + "` has " + found_text(each) + "; expected booleans, numbers or strings");
      }
    }
    return sweep;
  }

  // claim = "rotation", orders = [4, 6]: the methods that claim an order from 4 to 6 in this class of motion.
  void read_claim(const toml::node& claim, const toml::node* orders, StudyCells& cells) const {
    static const std::array known{"point-mass", "velocity-dependent", "rotation", "mechanism", "loop", "contact",
                                  "fluid"};
    const auto name = claim.value_exact<std::string>();
    if (!name || std::find(known.begin(), known.end(), *name) == known.end())
      refuse(claim.source(), "`claim` is " + found_text(claim) +
                                 "; expected a class of motion: point-mass, velocity-dependent, rotation, "
                                 "mechanism, loop, contact or fluid");
    cells.claim = *name;
    if (!orders) return;
    const toml::array* pair = orders->as_array();
    if (!pair || pair->size() != 2 || !pair->get(0)->is_number() || !pair->get(1)->is_number())
      refuse(orders->source(), "`orders` is " + found_text(*orders) + "; expected two numbers, [lowest, highest]");
    cells.least_order = *pair->get(0)->value<double>();
    cells.most_order = *pair->get(1)->value<double>();
    if (cells.least_order > cells.most_order)
      refuse(orders->source(), "`orders` is " + found_text(*orders) + "; expected the lower order first");
  }

  Probe probe(const toml::node& node) const {
    const auto name = node.value_exact<std::string>();
    if (const std::optional<Probe> found = find_probe(name.value_or("")); found) return *found;
    std::string known;
    for (const ProbeInfo& each : all_probes()) known += (known.empty() ? "" : ", ") + each.name;
    refuse(node.source(), "`probe` is " + found_text(node) + "; expected one of " + known);
  }

  // A path in the file is relative to the file's folder.
  std::string beside(const std::string& name) const {
    return (fs::path(path).parent_path() / name).lexically_normal().string();
  }

  // Ids, globs over ids and tags are kept as they are. A name with a slash or with the ending ".toml" is a file; a glob
  // over file names (scenes/*.toml) is replaced by the files that match it.
  std::vector<std::string> scenarios(const toml::table& table) const {
    std::vector<std::string> found;
    for (const std::string& name : strings(table, "scenarios")) {
      const toml::source_region& at = table.get("scenarios")->source();
      const bool file = name.rfind("tag:", 0) != 0 && (name.find('/') != std::string::npos || name.ends_with(".toml"));
      if (!file) {
        found.push_back(name);
        continue;
      }
      const fs::path full = beside(name);
      std::error_code error;
      if (full.filename().string().find_first_of("*?") == std::string::npos) {
        if (!fs::exists(full, error))
          refuse(at, "study `" + id + "`: scenarios: found no file `" + name + "`, relative to the study's folder " +
                         fs::path(path).parent_path().string() + nearest_file(full, name));
        found.push_back(full.string());
        continue;
      }
      std::set<std::string> matching;
      for (const auto& entry :
           fs::directory_iterator(full.has_parent_path() ? full.parent_path() : fs::path("."), error))
        if (glob_match(full.filename().string(), entry.path().filename().string()))
          matching.insert(entry.path().string());
      if (matching.empty()) refuse(at, "study `" + id + "`: scenarios: no file matches `" + name + "`");
      found.insert(found.end(), matching.begin(), matching.end());
    }
    return found;
  }

  // The program of an engine: a path relative to the study's folder, or the name of a program there or in PATH.
  std::string program(const toml::node& at, const std::string& word) const {
    const bool is_path = word.find('/') != std::string::npos;
    std::error_code error;
    std::vector<fs::path> places{fs::absolute(beside(word))};
    if (!is_path) {
      const char* variable = std::getenv("PATH");
      std::istringstream folders(variable ? variable : "");
      for (std::string folder; std::getline(folders, folder, ':');)
        places.push_back(fs::absolute(fs::path(folder.empty() ? "." : folder) / word));
    }
    for (const fs::path& place : places)
      if (fs::is_regular_file(place, error) && access(place.c_str(), X_OK) == 0) return place.string();
    if (fs::is_regular_file(places.front(), error))
      refuse(at.source(), "`engines`: " + places.front().string() + " is not executable (chmod +x?)");
    refuse(at.source(),
           "`engines`: found no program " + (is_path ? places.front().string() : "`" + word + "`") +
               (is_path ? "; expected a path relative to the study's folder" : " in the study's folder or in PATH"));
  }

  // An argument that names a file in the study's folder becomes that file's path: the working directory of the program
  // does not matter.
  std::string argument(const std::string& word) const {
    if (word.empty() || word.front() == '-' || word.front() == '/' || word.find("://") != std::string::npos)
      return word;
    std::error_code error;
    const fs::path full = fs::absolute(beside(word));
    return word.find('/') != std::string::npos || fs::exists(full, error) ? full.string() : word;
  }

  // The program of { command = ..., sandbox = false }, and whether it is confined.
  std::pair<const toml::node*, bool> unwrapped(const toml::node& node) const {
    const toml::table* table = node.as_table();
    if (!table) return {&node, true};
    check_keys(*table, std::array{"command", "sandbox"}, "an engine of `engines`");
    const toml::node* command = table->get("command");
    if (!command || command->is_table())
      refuse(node.source(), "`engines`: expected `command` in an engine's table: a program, or a list of its words");
    bool sandbox = true;
    if (const toml::node* flag = table->get("sandbox")) {
      const auto value = flag->value_exact<bool>();
      if (!value) refuse(flag->source(), "`sandbox` is " + found_text(*flag) + "; expected true or false");
      sandbox = *value;
    }
    return {command, sandbox};
  }

  void read_engines(const toml::node& node, Study& study) const {
    const char* const expected =
        "`engines`: expected a list of programs, as in [\"./my-engine\", [\"python3\", \"engine.py\", \"--fast\"], "
        "{ command = \"./other\", sandbox = false }]";
    const toml::array* list = node.as_array();
    if (!list) refuse(node.source(), expected);
    std::vector<std::vector<std::string>>& engines = study.engines;
    for (const toml::node& entry : *list) {
      const auto [command, sandbox] = unwrapped(entry);
      const toml::node& each = *command;
      std::vector<std::string> words;
      const auto add = [&](const toml::node& word) {
        const auto text = word.value_exact<std::string>();
        if (!text || text->find('\0') != std::string::npos || (words.empty() && text->empty()))
          refuse(word.source(), expected);
        words.push_back(words.empty() ? program(word, *text) : argument(*text));
      };
      if (const toml::array* argv = each.as_array())
        for (const toml::node& word : *argv) add(word);
      else add(each);
      if (words.empty()) refuse(each.source(), expected);
      if (std::find(engines.begin(), engines.end(), words) != engines.end())
        refuse(each.source(), "`engines`: found the same engine twice");
      if (!sandbox) study.unconfined.insert(words);
      engines.push_back(std::move(words));
    }
  }

  std::string file_beside(const toml::table& table, const char* key) const {
    const toml::node* node = table.get(key);
    if (!node) return "";
    const auto name = node->value_exact<std::string>();
    if (!name || name->empty())
      refuse(node->source(), "`" + std::string(key) + "` is " + found_text(*node) +
                                 "; expected a file's path relative to the study's folder");
    return beside(*name);
  }

  // allow = ["diverged"], allow_reason = "...": statuses of cells that are not failures of the run.
  void read_allowed(const toml::table& table, StudyCells& cells) const {
    const toml::node *allow = table.get("allow"), *reason = table.get("allow_reason");
    if (!allow && reason) refuse(reason->source(), "found `allow_reason` without `allow`; expected both");
    if (!allow) return;
    for (const std::string& word : strings(table, "allow")) {
      if (word == "diverged") cells.allow.push_back(Status::diverged);
      else if (word == "not finite") cells.allow.push_back(Status::not_finite);
      else refuse(allow->source(), "`allow`: found `" + word + "`; expected \"diverged\" or \"not finite\"");
    }
    const auto text = reason ? reason->value_exact<std::string>() : std::nullopt;
    if (!text || text->empty())
      refuse((reason ? reason : allow)->source(),
             "found `allow` without a reason; expected `allow_reason`, a sentence on why these are not failures");
    cells.allow_reason = *text;
  }

  // A block of the study, or the study's own scenarios and methods where it has no blocks.
  StudyCells cells(const toml::node& node, const toml::table& root) const {
    const toml::table* table = node.as_table();
    if (!table) refuse(node.source(), "expected [[cells]] to be tables");
    if (table != &root)
      check_keys(*table,
                 std::array{"scenarios", "methods", "steps", "repeats", "sweep", "timing", "claim", "orders", "except",
                            "probe", "limit", "allow", "allow_reason", "spacings_m", "sound_speeds_m_per_s"},
                 "[[cells]]");
    StudyCells cells;
    cells.place = place_of(table->source());
    cells.scenarios = scenarios(table->get("scenarios") || !root.get("scenarios") ? *table : root);
    // A block without `methods` takes all methods of the study's own engines.
    if (table->get("methods") || !root.get("engines")) cells.methods = strings(*table, "methods");
    read_allowed(*table, cells);
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
    for (const auto& [key, member] : {std::pair{"spacings_m", &StudyCells::spacings_m},
                                      {"sound_speeds_m_per_s", &StudyCells::sound_speeds_m_per_s}})
      if (const toml::node* values = table->get(key)) cells.*member = positive_numbers(*values, key);
    if (const toml::node* repeats = table->get("repeats")) {
      cells.repeats = static_cast<int>(positive(*repeats, "repeats", 10000));
    }
    if (const toml::node* timing = table->get("timing")) {
      const auto flag = timing->value_exact<bool>();
      if (!flag) refuse(timing->source(), "`timing` is " + found_text(*timing) + "; expected true or false");
      if (!*flag) cells.repeats = 0;
    }
    if (const toml::node* limit = table->get("limit")) {
      const auto seconds = limit->value<double>();
      if (!limit->is_number() || !(*seconds >= 0.01 && *seconds <= 1e6))
        refuse(limit->source(),
               "`limit` is " + found_text(*limit) + "; expected the seconds that a cell may take, from 0.01 to 1e6");
      cells.limit_s = *seconds;
    }
    if (const toml::node* name = table->get("probe")) cells.probe = probe(*name);
    if (const toml::node* claim = table->get("claim")) read_claim(*claim, table->get("orders"), cells);
    else if (const toml::node* orders = table->get("orders"))
      refuse(orders->source(), "found `orders` without `claim`; expected both");
    if (const toml::node* values = table->get("sweep")) cells.sweep = sweep(*values);
    return cells;
  }
};

}  // namespace

Study read_study(const std::string& path) {
  const std::string text = read_input_file(path, "a study file (TOML)", largest::kSettings);
  require_shallow_toml(text, path);
  StudyFile file{path};
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    file.refuse(error.source(), "not valid TOML: " + std::string(error.description()));
  }
  const toml::node* blocks = root.get("cells");
  if (blocks) {
    file.check_keys(root, std::array{"id", "scenarios", "engines", "tolerances", "baseline", "cells"},
                    "a study with [[cells]]");
  } else {
    file.check_keys(root,
                    std::array{"id", "scenarios", "engines", "tolerances", "baseline", "cells", "methods", "steps",
                               "repeats", "timing", "limit", "except", "allow", "allow_reason"},
                    "a study");
  }
  Study study;
  study.path = path;
  const auto id = root["id"].value_exact<std::string>();
  if (!id || id->empty()) throw InputError(path + ": missing key `id`; expected the name of the study");
  study.id = file.id = *id;
  if (const toml::node* engines = root.get("engines")) file.read_engines(*engines, study);
  study.tolerances = file.file_beside(root, "tolerances");
  study.baseline = file.file_beside(root, "baseline");
  if (!blocks && root.get("scenarios")) {
    study.cells.push_back(file.cells(root, root));
    return study;
  }
  const toml::array* list = root["cells"].as_array();
  if (!list || list->empty())
    throw InputError(path + ": found neither [[cells]] nor `scenarios`; expected one of the two");
  for (const toml::node& each : *list) study.cells.push_back(file.cells(each, root));
  return study;
}

}  // namespace atwood
