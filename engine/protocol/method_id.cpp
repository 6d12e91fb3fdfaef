// <engine>/<scheme>[:rtol[,atol]][+<response>][@<scalar>][{setting=value,...}]
#include <algorithm>
#include <array>
#include <charconv>
#include <stdexcept>

#include "protocol/method.hpp"

namespace atwood {
namespace {

constexpr std::array kResponses{"impulse", "event", "penalty", "sph", "polynomial"};
constexpr std::array kScalars{"float", "double", "long-double", "quad"};

[[noreturn]] void refuse(const std::string& text, const std::string& expected) {
  throw std::invalid_argument("method `" + text + "`: expected " + expected);
}

// The rest of the text to read, and the whole text for messages.
struct Cursor {
  const std::string& text;
  std::size_t at = 0;

  bool done() const { return at == text.size(); }
  bool take(char c) {
    if (done() || text[at] != c) return false;
    ++at;
    return true;
  }
  std::string until(const char* stops) {
    const std::size_t end = std::min(text.find_first_of(stops, at), text.size());
    std::string word = text.substr(at, end - at);
    at = end;
    return word;
  }
};

double tolerance(Cursor& cursor) {
  double value = 0;
  const char* begin = cursor.text.data() + cursor.at;
  const auto [end, error] = std::from_chars(begin, cursor.text.data() + cursor.text.size(), value);
  if (error != std::errc() || !(value > 0) || !(value < 1e300)) {
    refuse(cursor.text, "a positive tolerance after `:`, as in cvode/adams:1e-10");
  }
  cursor.at += static_cast<std::size_t>(end - begin);
  return value;
}

template <class Names> std::string one_of(Cursor& cursor, const Names& names, char mark) {
  std::string word = cursor.until("+@{:");
  if (std::find(names.begin(), names.end(), word) == names.end()) {
    std::string expected;
    for (const char* name : names) expected += (expected.empty() ? "" : ", ") + (mark + std::string(name));
    refuse(cursor.text, "one of " + expected);
  }
  return word;
}

SettingValue plain_value(const std::string& word) {
  if (word == "true") return true;
  if (word == "false") return false;
  const char* end = word.data() + word.size();
  std::int64_t integer = 0;
  if (auto [at, error] = std::from_chars(word.data(), end, integer); error == std::errc() && at == end) return integer;
  double real = 0;
  if (auto [at, error] = std::from_chars(word.data(), end, real); error == std::errc() && at == end) return real;
  return word;
}

SettingValue setting_value(Cursor& cursor) {
  if (!cursor.take('"')) return plain_value(cursor.until(",}"));
  std::string word;
  while (!cursor.done() && cursor.text[cursor.at] != '"') {
    if (cursor.text[cursor.at] == '\\') ++cursor.at;
    if (!cursor.done()) word += cursor.text[cursor.at++];
  }
  if (!cursor.take('"')) refuse(cursor.text, "a closing quote");
  return word;
}

void read_settings(Cursor& cursor, Settings& overrides) {
  do {
    const std::string key = cursor.until("=,}");
    if (key.empty() || !cursor.take('=')) refuse(cursor.text, "{setting=value,...}");
    if (!overrides.emplace(key, setting_value(cursor)).second)
      refuse(cursor.text, "each setting once, not two of " + key);
  } while (cursor.take(','));
  if (!cursor.take('}') || !cursor.done()) refuse(cursor.text, "`}` at the end of the settings");
}

std::string value_text(const SettingValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag ? "true" : "false";
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return std::to_string(*integer);
  if (const auto* real = std::get_if<double>(&value)) {
    const std::string text = format_double(*real);
    return text.find_first_of(".en") == std::string::npos ? text + ".0" : text;  // 1.0 stays a real
  }
  const auto& word = std::get<std::string>(value);
  const bool bare = !word.empty() && word.find_first_of("\"\\,}") == std::string::npos &&
                    std::holds_alternative<std::string>(plain_value(word));
  if (bare) return word;
  std::string quoted = "\"";
  for (const char c : word) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

}  // namespace

MethodId parse_method_id(const std::string& text) {
  MethodId id;
  if (text == "truth") {
    id.engine = text;
    return id;
  }
  Cursor cursor{text};
  id.engine = cursor.until("/:+@{");
  if (id.engine.empty() || !cursor.take('/')) refuse(text, "<engine>/<scheme>, as in atwood/rk4");
  id.scheme = cursor.until(":+@{");
  if (id.scheme.empty()) refuse(text, "a scheme after `/`, as in atwood/rk4");
  if (cursor.take(':')) {
    id.rtol = tolerance(cursor);
    if (cursor.take(',')) id.atol = tolerance(cursor);
  }
  if (cursor.take('+')) id.response = one_of(cursor, kResponses, '+');
  if (cursor.take('@')) id.scalar = one_of(cursor, kScalars, '@');
  if (cursor.take('{')) read_settings(cursor, id.overrides);
  if (!cursor.done()) {
    refuse(text, "<engine>/<scheme>[:rtol[,atol]][+response][@scalar][{setting=value,...}] in this order");
  }
  return id;
}

std::string to_string(const MethodId& id) {
  if (id.scheme.empty()) return id.engine;
  std::string text = id.engine + "/" + id.scheme;
  if (id.rtol) text += ":" + format_double(*id.rtol);
  if (id.rtol && id.atol) text += "," + format_double(*id.atol);
  if (!id.response.empty()) text += "+" + id.response;
  if (!id.scalar.empty()) text += "@" + id.scalar;
  if (id.overrides.empty()) return text;
  char before = '{';
  for (const auto& [key, value] : id.overrides) text += before + key + "=" + value_text(value), before = ',';
  return text + "}";
}

}  // namespace atwood
