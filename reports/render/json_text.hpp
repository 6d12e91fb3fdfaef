// A JSON document of many rows, written front to back without holding it as a tree: commas, indentation and the digits
// of figures are set here, strings are escaped by nlohmann-json.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/method.hpp"

namespace atwood {

class JsonText {
 public:
  explicit JsonText(bool lines) : lines_(lines) {}  // lines: one member or element a line, for readers and diffs

  JsonText& begin_object() { return open('{'); }
  JsonText& end_object() { return close('}'); }
  JsonText& begin_array() { return open('['); }
  JsonText& end_array() { return close(']'); }
  JsonText& key(std::string_view name);
  JsonText& text(std::string_view value);  // cleaned to valid UTF-8
  JsonText& number(double value);          // shortest round-trip; non-finite as "nan", "inf", "-inf"
  JsonText& number(double value, int significant_digits);
  JsonText& integer(std::int64_t value);
  JsonText& boolean(bool value);
  JsonText& null();
  JsonText& setting(const SettingValue& value);

  JsonText& member(std::string_view name, std::string_view value) { return key(name).text(value); }
  JsonText& member_number(std::string_view name, double value) { return key(name).number(value); }
  JsonText& member_integer(std::string_view name, std::int64_t value) { return key(name).integer(value); }
  // From here on, the innermost open object or array stays on one line.
  JsonText& inline_from_here();

  const std::string& str() const { return out_; }

 private:
  JsonText& open(char bracket);
  JsonText& close(char bracket);
  JsonText& raw(std::string_view value);
  void separate();

  struct Level {
    bool empty = true;
    bool inline_items = false;
  };
  std::string out_;
  std::vector<Level> levels_;
  bool after_key_ = false;
  bool lines_;
};

}  // namespace atwood
