// The description of a worker (hello): written by serve(), read and checked by the program that starts it.
#include <cmath>
#include <limits>
#include <set>

#include "protocol/json_lines.hpp"

namespace atwood::wire {
namespace {

// Limits of an engine's description.
constexpr std::size_t kLongestName = 64, kLongestId = 256, kMaxMethods = 10000;
constexpr std::size_t kLongestFingerprint = 1024, kMaxFiles = 1000, kLongestPath = 4096;

Json to_json(const Settings& settings) {
  Json json = Json::object();
  for (const auto& [key, value] : settings) {
    if (const auto* real = std::get_if<double>(&value)) json[key] = json_number(*real);
    else std::visit([&, &name = key](const auto& v) { json[name] = v; }, value);
  }
  return json;
}

Settings read_settings(const Json& json) {
  if (!json.is_object()) throw Garbage("\"settings\" is not an object");
  Settings settings;
  for (const auto& [key, value] : json.items()) {
    if (value.is_boolean()) settings[key] = value.get<bool>();
    else if (value.is_number_integer()) settings[key] = value.get<std::int64_t>();
    else if (value.is_number()) settings[key] = value.get<double>();
    else settings[key] = value.is_string() ? value.get<std::string>() : value.dump();
  }
  return settings;
}

// "setting_rules": {"substeps": {"doc": "...", "unit": "", "least": 0, "most": 1000}}; a bound that is absent is none.
Json to_json(const SettingRules& rules, const Settings& settings) {
  Json json = Json::object();
  for (const auto& [name, rule] : rules) {
    Json each = {{"doc", rule.doc}, {"unit", rule.unit}};
    if (std::isfinite(rule.range.least)) each["least"] = rule.range.least;
    if (std::isfinite(rule.range.most)) each["most"] = rule.range.most;
    if (rule.range.least_excluded) each["least_excluded"] = true;
    if (rule.range.most_excluded) each["most_excluded"] = true;
    const bool flag = std::holds_alternative<bool>(settings.at(name));
    const bool whole = std::holds_alternative<std::int64_t>(settings.at(name));
    for (const std::string& choice : rule.range.choices)
      each["choices"].push_back(flag ? Json(choice == "true") : whole ? Json(std::stoll(choice)) : Json(choice));
    json[name] = std::move(each);
  }
  return json;
}

// The rules of a method's settings: each names a setting and fits its type, and the default is in the range.
class RuleReader {
 public:
  explicit RuleReader(MethodInfo& method) : method_(method) {}

  void read(const Json& json) {
    if (!json.is_object()) throw Garbage("\"setting_rules\" of `" + cut(method_.id) + "` is not an object");
    for (const auto& [name, each] : json.items()) read_rule(name, each);
  }

 private:
  void read_rule(const std::string& name, const Json& json) {
    where_ = "method `" + cut(method_.id) + "`, the rule of the setting `" + cut(name) + "`: ";
    if (!json.is_object()) throw Garbage(where_ + "found " + excerpt(json) + "; expected an object");
    const auto setting = method_.settings.find(name);
    if (setting == method_.settings.end()) throw Garbage(where_ + "\"settings\" has no such setting");
    SettingRule rule;
    for (const auto& [key, value] : json.items()) read_member(rule, key, value);
    check_range(rule.range, json, setting->second);
    const Result<SettingValue> standard =
        checked_value(cut(method_.id), cut(name), setting->second, &rule, setting->second);
    if (!standard) throw Garbage(where_ + "the default is outside the range: " + standard.fault().reason);
    method_.rules[name] = std::move(rule);
  }

  void read_member(SettingRule& rule, const std::string& key, const Json& value) const {
    SettingRange& range = rule.range;
    if (key == "doc") rule.doc = text(value, "doc");
    else if (key == "unit") rule.unit = text(value, "unit");
    else if (key == "least" || key == "most") (key == "least" ? range.least : range.most) = bound(key, value);
    else if (key == "least_excluded" || key == "most_excluded")
      (key == "least_excluded" ? range.least_excluded : range.most_excluded) = flag(key, value);
    else if (key == "choices") range.choices = choices(value);
    else
      throw Garbage(where_ + "unknown key \"" + cut(key) +
                    "\"; expected doc, unit, least, most, least_excluded, most_excluded or choices");
  }

  double bound(const std::string& key, const Json& value) const {
    if (!value.is_number()) throw Garbage(where_ + "\"" + key + "\" is " + excerpt(value) + "; expected a number");
    return value.get<double>();
  }
  bool flag(const std::string& key, const Json& value) const {
    if (!value.is_boolean())
      throw Garbage(where_ + "\"" + key + "\" is " + excerpt(value) + "; expected true or false");
    return value.get<bool>();
  }
  std::vector<std::string> choices(const Json& value) const {
    if (!value.is_array() || value.empty())
      throw Garbage(where_ + "\"choices\" is " + excerpt(value) + "; expected a list of values");
    std::vector<std::string> all;
    for (const Json& choice : value) {
      if (choice.is_boolean()) all.push_back(value_words(choice.get<bool>()));
      else if (choice.is_number_integer()) all.push_back(value_words(choice.get<std::int64_t>()));
      else if (choice.is_string()) all.push_back(text(choice, "choices"));
      else
        throw Garbage(where_ + "found the choice " + excerpt(choice) +
                      "; expected a word, a whole number, or true or false");
    }
    return all;
  }

  void check_range(const SettingRange& range, const Json& json, SettingValue& standard) const {
    const bool bounded = json.contains("least") || json.contains("most");
    if ((range.least_excluded && !json.contains("least")) || (range.most_excluded && !json.contains("most")))
      throw Garbage(where_ + "found a bound that is excluded and not given");
    if (bounded) read_infinity(standard);
    const bool number = std::holds_alternative<std::int64_t>(standard) || std::holds_alternative<double>(standard);
    if (bounded && !number) throw Garbage(where_ + "found bounds of " + range_words(standard, {}));
    if (range.least > range.most || (range.least == range.most && (range.least_excluded || range.most_excluded)))
      throw Garbage(where_ + "no number lies in it: \"least\" is " + value_words(range.least) + ", \"most\" " +
                    value_words(range.most));
    if (!json.contains("choices")) return;
    const bool flag = std::holds_alternative<bool>(standard), whole = std::holds_alternative<std::int64_t>(standard);
    if (number && !whole) throw Garbage(where_ + "found choices of " + range_words(standard, {}));
    for (const Json& choice : json["choices"])
      if (choice.is_boolean() != flag || choice.is_number_integer() != whole)
        throw Garbage(where_ + "found the choice " + excerpt(choice) + "; expected " + range_words(standard, {}));
  }

  // JSON has no infinity: a default "inf" beside bounds is a number.
  static void read_infinity(SettingValue& standard) {
    const auto* word = std::get_if<std::string>(&standard);
    if (word == nullptr || (*word != "inf" && *word != "-inf")) return;
    standard = *word == "inf" ? std::numeric_limits<double>::infinity() : -std::numeric_limits<double>::infinity();
  }

  MethodInfo& method_;
  std::string where_;
};

Json describe(const std::vector<MethodInfo>& methods) {
  Json list = Json::array();
  for (const MethodInfo& method : methods) {
    Json claims = Json::object();
    for (const auto& [motion, order] : method.claimed_order) claims[motion] = json_number(order);
    list.push_back({{"id", method.id},
                    {"doc", method.doc},
                    {"settings", to_json(method.settings)},
                    {"source", method.source},
                    {"claims", claims},
                    {"adaptive", method.adaptive}});
    if (!method.formula.empty()) list.back()["formula"] = method.formula;
    if (!method.rules.empty()) list.back()["setting_rules"] = to_json(method.rules, method.settings);
  }
  return list;
}

MethodInfo read_method(const Json& each) {
  if (!each.is_object()) throw Garbage("found a method that is not an object: " + excerpt(each));
  MethodInfo method;
  method.id = text(need(each, "id"), "id");
  method.doc = text_or(each, "doc", "");
  method.source = text_or(each, "source", "");
  method.formula = text_or(each, "formula", "");
  if (each.contains("settings")) method.settings = read_settings(each["settings"]);
  if (each.contains("setting_rules")) RuleReader(method).read(each["setting_rules"]);
  if (each.contains("adaptive")) method.adaptive = each["adaptive"].is_boolean() && each["adaptive"].get<bool>();
  if (each.contains("claims") && each["claims"].is_object()) {
    for (const auto& [motion, order] : each["claims"].items()) {
      const double claimed = narrow_number(order);
      if (!(claimed > 0 && std::isfinite(claimed)))
        throw Garbage("method `" + cut(method.id) + "` claims the order " + excerpt(order) + " for \"" + cut(motion) +
                      "\"; expected a finite, positive number");
      method.claimed_order[motion] = claimed;
    }
  }
  return method;
}

void add_method(MethodInfo method, std::vector<MethodInfo>& methods) {
  if (methods.size() >= kMaxMethods) throw Garbage("more than " + std::to_string(kMaxMethods) + " methods");
  methods.push_back(std::move(method));
}

void check_name(const std::string& name) {
  const bool known = name.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_.-") == std::string::npos;
  const bool begins = name.empty() || name.find_first_of("_.-") != 0;
  if (name.size() > kLongestName || !known || !begins)
    throw Garbage(
        "the name of the engine is `" + cut(name) + "`; expected a name of at most " + std::to_string(kLongestName) +
        " bytes of lower-case letters a to z, digits, `_`, `.` and `-`, which begins with a letter or a digit");
}

void check_methods(const Engine& engine) {
  if (engine.name.empty() && !engine.methods.empty())
    throw Garbage("found methods of an engine without a name; expected \"engine\"");
  std::set<std::string> ids;
  for (const MethodInfo& method : engine.methods) {
    const bool whole_engine = method.id == engine.name && engine.name == "truth";
    if (!whole_engine && (method.id.rfind(engine.name + "/", 0) != 0 || method.id.size() == engine.name.size() + 1))
      throw Garbage("method `" + cut(method.id) + "` of engine `" + engine.name +
                    "`; expected an id that begins with `" + engine.name + "/`");
    if (method.id.size() > kLongestId)
      throw Garbage("a method's id of more than " + std::to_string(kLongestId) + " bytes");
    if (!ids.insert(method.id).second) throw Garbage("method `" + cut(method.id) + "` is listed twice");
  }
}

void read_fingerprint(const std::string& member, const Json& value, Engine& engine) {
  if (member == "fingerprint") {
    engine.fingerprint = text(value, "fingerprint");
    if (engine.fingerprint.size() > kLongestFingerprint)
      throw Garbage("a fingerprint of more than " + std::to_string(kLongestFingerprint) + " bytes");
    return;
  }
  if (engine.files.size() >= kMaxFiles) throw Garbage("more than " + std::to_string(kMaxFiles) + " files");
  engine.files.push_back(text(value, "files"));
  if (engine.files.back().empty() || engine.files.back().size() > kLongestPath)
    throw Garbage("a name in \"files\" of " + std::to_string(engine.files.back().size()) + " bytes; expected 1 to " +
                  std::to_string(kLongestPath));
}

}  // namespace

std::string hello_line(const Engine& engine) {
  Json json{{"protocol", kProtocol}, {"engine", engine.name}, {"version", engine.version}};
  json["scalar"] = engine.scalar;
  json["frames"] = engine.frames;
  if (engine.fluids) json["fluids"] = true;
  if (engine.joints) json["joints"] = true;
  if (!engine.fingerprint.empty()) json["fingerprint"] = engine.fingerprint;
  if (!engine.files.empty()) json["files"] = engine.files;
  json["methods"] = describe(engine.methods);
  if (!engine.responses.empty()) json["responses"] = describe(engine.responses);
  return dump(json);
}

Engine read_hello(std::string_view line) {
  Engine engine;
  bool lists_methods = false, has_name = false;
  engine.scalar = "double";
  read_members(
      line,
      [&](const std::string& member) {
        lists_methods = lists_methods || member == "methods";
        if (member == "methods" || member == "responses" || member == "files") return Reading::by_element;
        for (const char* name :
             {"protocol", "engine", "version", "scalar", "frames", "fluids", "joints", "fingerprint"})
          if (member == name) return Reading::whole;
        return Reading::ignored;
      },
      [&](const std::string& member, const Json& value) {
        if (member == "protocol") check_protocol(value, "this program");
        else if (member == "engine") engine.name = text(value, "engine"), check_name(engine.name), has_name = true;
        else if (member == "version") engine.version = text(value, "version");
        else if (member == "scalar") engine.scalar = text(value, "scalar");
        else if (member == "frames") engine.frames = value.is_boolean() && value.get<bool>();
        else if (member == "fluids") engine.fluids = value.is_boolean() && value.get<bool>();
        else if (member == "joints") engine.joints = value.is_boolean() && value.get<bool>();
        else if (member == "methods") add_method(read_method(value), engine.methods);
        else if (member == "responses") add_method(read_method(value), engine.responses);
        else read_fingerprint(member, value, engine);
      });
  if (!has_name) throw Garbage("no \"engine\" in " + cut(line));
  if (!lists_methods) throw Garbage("no \"methods\" in " + cut(line));
  check_methods(engine);
  return engine;
}

}  // namespace atwood::wire
