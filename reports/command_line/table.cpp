#include "reports/command_line/table.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "scene/printable.hpp"

namespace atwood {
namespace {

// Quotes as in RFC 4180.
std::vector<std::string> split(const std::string& line) {
  std::vector<std::string> fields(1);
  bool quote = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] == '"' && quote && i + 1 < line.size() && line[i + 1] == '"') fields.back() += line[++i];
    else if (line[i] == '"') quote = !quote;
    else if (line[i] == ',' && !quote) fields.emplace_back();
    else fields.back() += line[i];
  }
  return fields;
}

// The columns of names and words in all tables; the others are of numbers.
constexpr std::array<std::string_view, 14> kTextColumns{"body",  "body_a", "body_b", "by",   "by_name",
                                                        "fluid", "from",   "joint",  "kind", "of",
                                                        "probe", "rope",   "source", "unit"};
bool holds_text(const std::string& column) {
  return std::find(kTextColumns.begin(), kTextColumns.end(), column) != kTextColumns.end();
}

// A number keeps its digits, however many: JSON bounds them no more than CSV does. What no double can hold, as `nan`,
// is its text, and so are words in place of a number.
std::string as_json(const std::string& field, bool text) {
  const bool number = !text && nlohmann::json::parse(field, nullptr, false).is_number();
  return number ? field : nlohmann::json(field).dump();
}

}  // namespace

std::string quoted(const std::string& raw) {
  const std::string text = guarded_cell(raw);
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

Table::Table(const std::string& columns, bool json) : json_(json), columns_(split(columns)) {
  fmt::print("{}", json ? "[" : columns + "\n");
}

Table::~Table() {
  if (json_) std::fputs("\n]\n", stdout);
}

void Table::row(const std::string& line) {
  if (!json_) {
    fmt::print("{}\n", line);
    return;
  }
  const auto fields = split(line);
  std::string text = first_ ? "\n" : ",\n";
  for (std::size_t i = 0; i < fields.size(); ++i) {
    text += fmt::format("{}\"{}\":{}", i == 0 ? "{" : ",", columns_.at(i),
                        as_json(unguarded_cell(fields[i]), holds_text(columns_.at(i))));
  }
  fmt::print("{}}}", text);
  first_ = false;
}

}  // namespace atwood
