#include "reports/command_line/table.hpp"

#include <algorithm>
#include <cmath>

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

std::string as_json(const std::string& field) {
  const auto parsed = nlohmann::json::parse(field, nullptr, false);
  const auto digits =
      std::count_if(field.begin(), field.begin() + static_cast<std::ptrdiff_t>(std::min(field.find('e'), field.size())),
                    [](char c) { return c >= '0' && c <= '9'; });
  if (parsed.is_number() && std::isfinite(parsed.get<double>()) && digits <= 18) return field;
  return nlohmann::json(field).dump();
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
    text += fmt::format("{}\"{}\":{}", i == 0 ? "{" : ",", columns_.at(i), as_json(unguarded_cell(fields[i])));
  }
  fmt::print("{}}}", text);
  first_ = false;
}

}  // namespace atwood
