// A tree for both TOML and JSON texts, with the position of each part in its file. Reading, checking and writing use
// it, so that a key is declared once for both formats.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace atwood {

struct SourceLocation {
  int line = 0, column = 0;  // from 1; 0: unknown (JSON)
};

struct Member;

struct Value {
  using List = std::vector<Value>;
  using Table = std::vector<Member>;  // in the order written
  std::variant<std::monostate, bool, std::int64_t, double, std::string, List, Table> data;
  SourceLocation location;

  Value();
  Value(bool v);
  Value(int v);
  Value(std::int64_t v);
  Value(double v);
  Value(const char* v);
  Value(std::string v);
  Value(List v);
  Value(Table v);
  Value(const Value& other);
  Value(Value&& other) noexcept;
  Value& operator=(const Value& other);
  Value& operator=(Value&& other) noexcept;
  ~Value();

  const std::string* text() const { return std::get_if<std::string>(&data); }
  const List* list() const { return std::get_if<List>(&data); }
  const Table* table() const { return std::get_if<Table>(&data); }
  bool empty() const { return std::holds_alternative<std::monostate>(data); }
  const Value* find(std::string_view key) const;  // null when this is not a table or has no such key
};

struct Member {
  std::string key;
  Value value;
  SourceLocation location;  // of the key
};

// Defined here, where Member is a whole type: the variant holds a list of them.
inline Value::Value() = default;
inline Value::Value(bool v) : data(v) {}
inline Value::Value(int v) : data(static_cast<std::int64_t>(v)) {}
inline Value::Value(std::int64_t v) : data(v) {}
inline Value::Value(double v) : data(v) {}
inline Value::Value(const char* v) : data(std::string(v)) {}
inline Value::Value(std::string v) : data(std::move(v)) {}
inline Value::Value(List v) : data(std::move(v)) {}
inline Value::Value(Table v) : data(std::move(v)) {}
// Constructed by its type and then moved: when an allocation fails in the copy constructor of a variant of strings and
// vectors, libstdc++ 12 destroys a member that was not constructed.
inline Value::Value(const Value& other) : location(other.location) {
  std::visit([this]<class T>(const T& held) { data.emplace<T>(T(held)); }, other.data);
}
inline Value::Value(Value&& other) noexcept = default;
inline Value& Value::operator=(const Value& other) { return *this = Value(other); }
inline Value& Value::operator=(Value&& other) noexcept = default;
inline Value::~Value() = default;

// A table from pairs, in order.
Value table_of(std::initializer_list<std::pair<const char*, Value>> members);
void add(Value& table, std::string key, Value value);

// A short description of a value for messages: `-1`, `"wood"`, `a table`, `a list of 2`.
std::string describe(const Value& value);

// JSON text: one line, or indented. Doubles in shortest round-trip form.
std::string to_json_text(const Value& value, bool pretty);

// Both throw InputError with the place; `name` stands for the file.
Value parse_toml(std::string_view text, const std::string& name);
Value parse_json(std::string_view text, const std::string& name);

// Nesting deeper than that of any scene is refused before it exhausts the stack.
inline constexpr int kDeepest = 32;

}  // namespace atwood
