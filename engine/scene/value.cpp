#include "scene/value.hpp"

#include <charconv>
#include <cmath>

namespace atwood {

const Value* Value::find(std::string_view key) const {
  if (const Table* members = table())
    for (const Member& member : *members)
      if (member.key == key) return &member.value;
  return nullptr;
}

Value table_of(std::initializer_list<std::pair<const char*, Value>> members) {
  Value::Table table;
  for (const auto& [key, value] : members) table.push_back({key, value, {}});
  return table;
}

void add(Value& table, std::string key, Value value) {
  std::get<Value::Table>(table.data).push_back({std::move(key), std::move(value), {}});
}

namespace {

// Shortest digits that read back to the same double. "-0" would read back as the integer 0, hence the point.
std::string number_text(double value) {
  char buffer[32];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value).ptr;
  std::string text(buffer, end);
  return text == "-0" ? "-0.0" : text;
}

void quote(const std::string& text, std::string& out) {
  static constexpr char hex[] = "0123456789abcdef";
  out += '"';
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (code < 0x20) {
      out += "\\u00";
      out += hex[code >> 4];
      out += hex[code & 15];
    } else {
      out += c;
    }
  }
  out += '"';
}

bool is_flat(const Value::List& list) {
  for (const Value& item : list)
    if (item.list() || item.table()) return false;
  return true;
}

void write(const Value& value, bool pretty, int depth, std::string& out) {
  const auto new_line = [&](int level) {
    if (!pretty) return;
    out += '\n';
    out.append(static_cast<std::size_t>(2 * level), ' ');
  };
  if (value.empty()) out += "null";
  if (const auto* v = std::get_if<bool>(&value.data)) out += *v ? "true" : "false";
  if (const auto* v = std::get_if<std::int64_t>(&value.data)) out += std::to_string(*v);
  if (const auto* v = std::get_if<double>(&value.data)) out += number_text(*v);
  if (const auto* v = value.text()) quote(*v, out);
  if (const auto* items = value.list()) {
    const bool flat = is_flat(*items);
    out += '[';
    for (std::size_t i = 0; i < items->size(); ++i) {
      if (i) out += pretty && flat ? ", " : ",";
      if (!flat) new_line(depth + 1);
      write((*items)[i], pretty, depth + 1, out);
    }
    if (!flat) new_line(depth);
    out += ']';
  }
  if (const auto* members = value.table()) {
    out += '{';
    for (std::size_t i = 0; i < members->size(); ++i) {
      if (i) out += ',';
      new_line(depth + 1);
      quote((*members)[i].key, out);
      out += pretty ? ": " : ":";
      write((*members)[i].value, pretty, depth + 1, out);
    }
    if (!members->empty()) new_line(depth);
    out += '}';
  }
}

}  // namespace

std::string describe(const Value& value) {
  if (value.empty()) return "nothing";
  if (const auto* v = value.list()) return "a list of " + std::to_string(v->size());
  if (value.table()) return "a table";
  if (const auto* v = value.text(); v && v->size() > 60)
    return "a text of " + std::to_string(v->size()) + " characters";
  if (const auto* v = std::get_if<double>(&value.data); v && !std::isfinite(*v))
    return std::isnan(*v) ? "nan" : *v < 0 ? "-inf" : "inf";
  return to_json_text(value, false);
}

std::string to_json_text(const Value& value, bool pretty) {
  std::string out;
  write(value, pretty, 0, out);
  if (pretty) out += '\n';
  return out;
}

}  // namespace atwood
