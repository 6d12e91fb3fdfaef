// Gate files: [[gate]] tables, each with exactly one of within, max, min, max_ratio, within_claim, and a reason. The
// gates of a file that begins with `study = "..."` judge the runs of that study.
#include "scene/toml_parser.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <sstream>

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/gates/gates.hpp"
#include "validation/gates/toml_text.hpp"

namespace atwood {
namespace {

constexpr std::array<std::string_view, 12> kKeys = {
    "scenario", "method", "metric", "steps",     "spacing_m",    "sound_speed_m_per_s",
    "within",   "max",    "min",    "max_ratio", "within_claim", "reason"};
constexpr std::array<std::string_view, 5> kKinds = {"within", "max", "min", "max_ratio", "within_claim"};

std::string place(const std::string& path, const toml::source_region& at) {
  return path + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column);
}

[[noreturn]] void refuse(const std::string& path, const toml::source_region& at, const std::string& what) {
  throw InputError(place(path, at) + ": " + what);
}

// Levenshtein's distance of two words.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

template <std::size_t N> std::string expected(std::string_view found, const std::array<std::string_view, N>& known) {
  std::string text = "; expected one of ";
  std::string_view nearest;
  std::size_t best = 3;
  for (std::string_view k : known) {
    text += (k == known.front() ? "" : ", ") + std::string(k);
    if (edits(found, k) < best) {
      best = edits(found, k);
      nearest = k;
    }
  }
  return nearest.empty() ? text : text + " (did you mean " + std::string(nearest) + "?)";
}

std::string text_of(const std::string& path, const toml::table& table, std::string_view key, bool required) {
  const toml::node* node = table.get(key);
  if (!node) {
    if (required)
      refuse(path, table.source(), "missing key `" + std::string(key) + "`; expected a text that is not empty");
    return "";
  }
  const auto value = node->value_exact<std::string>();
  if (!value || value->empty())
    refuse(path, node->source(),
           "`" + std::string(key) + "` is " + found_text(*node) + "; expected a text that is not empty");
  return *value;
}

double number_of(const std::string& path, const toml::node& node, const std::string& key) {
  const auto value = node.is_number() ? node.value<double>() : std::nullopt;
  if (!value || !std::isfinite(*value))
    refuse(path, node.source(), "`" + key + "` is " + found_text(node) + "; expected a finite number");
  return *value;
}

void read_within(const std::string& path, const toml::node& node, Gate& gate) {
  const toml::array* pair = node.as_array();
  if (!pair || pair->size() != 2)
    refuse(path, node.source(), "`within` is " + found_text(node) + "; expected two numbers, [low, high]");
  gate.kind = Gate::Kind::within;
  gate.low = number_of(path, *pair->get(0), "within");
  gate.high = number_of(path, *pair->get(1), "within");
  if (!(gate.low < gate.high))
    refuse(path, node.source(),
           "`within` is [" + format_double(gate.low) + ", " + format_double(gate.high) +
               "]; expected the lower bound first");
}

void read_ratio(const std::string& path, const toml::node& node, Gate& gate) {
  const toml::table* ratio = node.as_table();
  if (!ratio)
    refuse(path, node.source(), "`max_ratio` is " + found_text(node) + "; expected { to = METHOD, value = NUMBER }");
  for (auto&& [key, entry] : *ratio)
    if (key != "to" && key != "value")
      refuse(path, key.source(),
             "unknown key `" + std::string(key.str()) + "` in max_ratio" +
                 expected(key.str(), std::array<std::string_view, 2>{"to", "value"}));
  gate.kind = Gate::Kind::max_ratio;
  gate.ratio_to = text_of(path, *ratio, "to", true);
  const toml::node* value = ratio->get("value");
  if (!value) refuse(path, node.source(), "missing key `value` in `max_ratio`; expected a number above 0");
  gate.high = number_of(path, *value, "value");
  if (!(gate.high > 0))
    refuse(path, value->source(), "`value` of `max_ratio` is " + found_text(*value) + "; expected a number above 0");
}

Gate read_gate(const std::string& path, const toml::table& table) {
  Gate gate;
  gate.origin = path + ":" + std::to_string(table.source().begin.line);
  std::string kind;
  for (auto&& [key, node] : table) {
    const std::string name(key.str());
    if (std::find(kKeys.begin(), kKeys.end(), name) == kKeys.end())
      refuse(path, key.source(), "unknown key `" + name + "` in [[gate]]" + expected(name, kKeys));
    if (std::find(kKinds.begin(), kKinds.end(), name) == kKinds.end()) continue;
    if (!kind.empty())
      refuse(path, key.source(),
             "found `" + kind + "` and `" + name +
                 "` in one [[gate]]; expected exactly one of within, max, min, max_ratio, within_claim");
    kind = name;
  }
  gate.scenario = text_of(path, table, "scenario", true);
  gate.method = text_of(path, table, "method", true);
  gate.metric = text_of(path, table, "metric", true);
  gate.reason = text_of(path, table, "reason", true);
  if (const toml::node* steps = table.get("steps")) {
    const auto value = steps->value_exact<std::int64_t>();
    if (!value || *value <= 0)
      refuse(path, steps->source(), "`steps` is " + found_text(*steps) + "; expected a whole number above 0");
    gate.steps = *value;
  }
  for (const auto& [key, member] :
       {std::pair{"spacing_m", &Gate::spacing_m}, {"sound_speed_m_per_s", &Gate::sound_speed_m_per_s}}) {
    const toml::node* node = table.get(key);
    if (!node) continue;
    gate.*member = number_of(path, *node, key);
    if (!(*(gate.*member) > 0)) refuse(path, node->source(), "`" + std::string(key) + "` must be positive");
  }
  if (kind.empty())
    refuse(path, table.source(),
           "found no limit in [[gate]]; expected exactly one of within, max, min, max_ratio, within_claim");
  const toml::node& limit = *table.get(kind);
  if (kind == "within") read_within(path, limit, gate);
  else if (kind == "max_ratio") read_ratio(path, limit, gate);
  else if (kind == "within_claim") {
    gate.kind = Gate::Kind::within_claim;
    gate.claim = text_of(path, table, kind, true);
  } else if (kind == "max") {
    gate.kind = Gate::Kind::max;
    gate.high = number_of(path, limit, kind);
  } else {
    gate.kind = Gate::Kind::min;
    gate.low = number_of(path, limit, kind);
  }
  return gate;
}

}  // namespace

std::vector<Gate> read_gates(const std::string& path) {
  const std::string text = read_input_file(path, "a file of gates (TOML)", largest::kSettings);
  require_shallow_toml(text, path);
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    refuse(path, error.source(), "not valid TOML: " + std::string(error.description()));
  }
  std::vector<Gate> gates;
  const std::string study = text_of(path, root, "study", false);
  for (auto&& [key, node] : root) {
    if (key == "study") continue;
    if (key != "gate")
      refuse(path, key.source(), "unknown key `" + std::string(key.str()) + "`; expected [[gate]] or study");
    const toml::array* list = node.as_array();
    if (!list || !list->is_array_of_tables())
      refuse(path, key.source(), "`gate` is " + found_text(node) + "; expected [[gate]] tables");
    for (const toml::node& gate : *list) gates.push_back(read_gate(path, *gate.as_table()));
  }
  if (gates.empty()) throw InputError(path + ":1:1: found no [[gate]]; expected at least one");
  for (Gate& gate : gates) gate.study = study;
  return gates;
}

}  // namespace atwood
