#include "json_text.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <variant>

#include "protocol/sample.hpp"
#include "text.hpp"

namespace atwood {
namespace {

std::string quoted(std::string_view value) { return nlohmann::json(clean_text(value)).dump(); }

// "1.5e-07" -> "1.5e-7": a byte a figure over many thousands of figures.
std::string short_exponent(std::string text) {
  const std::size_t e = text.find('e');
  if (e == std::string::npos) return text;
  std::size_t digit = e + 2;
  while (digit + 1 < text.size() && text[digit] == '0') text.erase(digit, 1);
  if (text[e + 1] == '+') text.erase(e + 1, 1);
  return text;
}

}  // namespace

void JsonText::separate() {
  if (after_key_) {
    after_key_ = false;
    return;
  }
  if (levels_.empty()) return;
  Level& level = levels_.back();
  if (!level.empty) out_ += lines_ && level.inline_items ? ", " : ",";
  level.empty = false;
  if (lines_ && !level.inline_items) out_ += "\n" + std::string(levels_.size(), ' ');
}

JsonText& JsonText::open(char bracket) {
  separate();
  out_ += bracket;
  const bool inherited = !levels_.empty() && levels_.back().inline_items;
  levels_.push_back({true, inherited});
  return *this;
}

JsonText& JsonText::close(char bracket) {
  const Level level = levels_.back();
  levels_.pop_back();
  if (lines_ && !level.empty && !level.inline_items) out_ += "\n" + std::string(levels_.size(), ' ');
  out_ += bracket;
  if (lines_ && levels_.empty()) out_ += '\n';
  return *this;
}

JsonText& JsonText::raw(std::string_view value) {
  separate();
  out_ += value;
  return *this;
}

JsonText& JsonText::key(std::string_view name) {
  separate();
  out_ += quoted(name);
  out_ += lines_ ? ": " : ":";
  after_key_ = true;
  return *this;
}

JsonText& JsonText::inline_from_here() {
  levels_.back().inline_items = true;
  return *this;
}

JsonText& JsonText::text(std::string_view value) { return raw(quoted(value)); }

JsonText& JsonText::number(double value) {
  return std::isfinite(value) ? raw(format_double(value)) : text(format_double(value));
}

JsonText& JsonText::number(double value, int significant_digits) {
  if (!std::isfinite(value)) return text(figure(value));
  return raw(short_exponent(fmt::format("{:.{}g}", value, significant_digits)));
}

JsonText& JsonText::integer(std::int64_t value) { return raw(std::to_string(value)); }
JsonText& JsonText::boolean(bool value) { return raw(value ? "true" : "false"); }
JsonText& JsonText::null() { return raw("null"); }

JsonText& JsonText::setting(const SettingValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return boolean(*flag);
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return integer(*whole);
  if (const auto* real = std::get_if<double>(&value)) return number(*real);
  return text(std::get<std::string>(value));
}

}  // namespace atwood
