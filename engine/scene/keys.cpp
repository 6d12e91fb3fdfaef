#include "scene/keys.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "scene/printable.hpp"

namespace atwood {

// ---- messages ---------------------------------------------------------------------------------------------------
std::string location_text(const Reading& reading, SourceLocation location) {
  std::string at = reading.name;
  if (location.line > 0) at += ":" + std::to_string(location.line) + ":" + std::to_string(location.column);
  return at + ": ";
}

void fail(const Reading& reading, SourceLocation location, const std::string& message) {
  throw InputError(location_text(reading, location) + message);
}

void fail_value(const Reading& reading, const Value& found, const std::string& expected) {
  const std::string key = reading.key.empty() ? reading.where : "`" + reading.key + "` in " + reading.where;
  fail(reading, found.location, key + " is " + describe(found) + "; expected " + expected);
}

std::string listed(const std::vector<std::string>& names) {
  std::string out;
  for (const std::string& name : names) out += (out.empty() ? "" : ", ") + name;
  return out;
}

// Levenshtein's distance, one row at a time.
static std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

std::string did_you_mean(const std::string& found, const std::vector<std::string>& candidates) {
  if (found.size() > 100) return "";
  std::string best;
  std::size_t least = std::max<std::size_t>(2, found.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    // `mass` for `mass_kg`: the unit was left out.
    const bool prefix = found.size() >= 4 && candidate.compare(0, found.size() + 1, found + "_") == 0;
    const std::size_t distance = prefix ? 1 : edit_distance(found, candidate);
    if (distance < least) least = distance, best = candidate;
  }
  return best.empty() ? "" : " (did you mean " + best + "?)";
}

Value object_schema(Value properties, Value::List required_keys) {
  Value schema = table_of({{"type", "object"}, {"properties", std::move(properties)}});
  if (!required_keys.empty()) add(schema, "required", std::move(required_keys));
  add(schema, "additionalProperties", false);
  return schema;
}

// ---- numbers ----------------------------------------------------------------------------------------------------
Range any_number() { return {}; }
Range positive() {
  Range r;
  r.low = 0, r.low_open = true, r.expected = "a number above 0";
  return r;
}
Range non_negative() {
  Range r;
  r.low = 0, r.expected = "a number of at least 0";
  return r;
}
Range closed_range(double low, double high) {
  Range r;
  r.low = low, r.high = high;
  r.expected = "a number from " + describe(Value(low)) + " to " + describe(Value(high));
  return r;
}

double read_number(Reading& r, const Value& v, const Range& range) {
  double number = 0;
  if (const auto* integer = std::get_if<std::int64_t>(&v.data)) number = static_cast<double>(*integer);
  else if (const auto* real = std::get_if<double>(&v.data)) number = *real;
  else fail_value(r, v, range.expected);
  const bool inside =
      std::isfinite(number) && number <= range.high && (range.low_open ? number > range.low : number >= range.low);
  if (!inside) fail_value(r, v, range.expected);
  return number;
}

static Value number_schema(const Range& range) {
  Value schema = table_of({{"type", "number"}});
  if (std::isfinite(range.low)) add(schema, range.low_open ? "exclusiveMinimum" : "minimum", range.low);
  if (std::isfinite(range.high)) add(schema, "maximum", range.high);
  return schema;
}

Codec<double> number(Range range) {
  return {number_schema(range), [range](Reading& r, const Value& v, double& out) { out = read_number(r, v, range); },
          [](const Scene&, double v) { return Value(v); }};
}

Codec<std::int64_t> integer(std::int64_t low, std::int64_t high) {
  Codec<std::int64_t> c;
  c.schema = table_of({{"type", "integer"}, {"minimum", low}, {"maximum", high}});
  c.read = [low, high](Reading& r, const Value& v, std::int64_t& out) {
    const auto* found = std::get_if<std::int64_t>(&v.data);
    if (!found || *found < low || *found > high)
      fail_value(r, v, "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    out = *found;
  };
  c.write = [](const Scene&, std::int64_t v) { return Value(v); };
  return c;
}

Codec<bool> boolean() {
  return {table_of({{"type", "boolean"}}),
          [](Reading& r, const Value& v, bool& out) {
            const auto* found = std::get_if<bool>(&v.data);
            if (!found) fail_value(r, v, "true or false");
            out = *found;
          },
          [](const Scene&, bool v) { return Value(v); }};
}

// ---- texts ------------------------------------------------------------------------------------------------------
static Codec<std::string> checked_text(Value schema, std::string expected, bool (*good)(const std::string&)) {
  return {std::move(schema),
          [expected = std::move(expected), good](Reading& r, const Value& v, std::string& out) {
            const std::string* found = v.text();
            if (!found || !good(*found)) fail_value(r, v, expected);
            out = *found;
          },
          [](const Scene&, const std::string& v) { return Value(v); }};
}

Codec<std::string> text() {
  Codec<std::string> c =
      checked_text(table_of({{"type", "string"}}), "a text", [](const std::string&) { return true; });
  c.read = [read = c.read](Reading& r, const Value& v, std::string& out) {
    read(r, v, out);
    if (r.form == Form::file && !is_printable(out)) fail_value(r, v, "a text without control characters");
  };
  return c;
}

Codec<std::string> name_text() {
  return checked_text(
      table_of({{"type", "string"}, {"pattern", "^[^\\u0000-\\u001f\\u007f-\\u009f,\"]{1,100}$"}}),
      "a name of 1 to 100 characters without commas, double quotes and control characters", [](const std::string& s) {
        return !s.empty() && s.size() <= 100 && is_printable(s) && std::none_of(s.begin(), s.end(), [](char c) {
          const auto code = static_cast<unsigned char>(c);
          return code < 0x20 || code == 0x7f || c == ',' || c == '"';
        });
      });
}

Codec<std::string> kebab_text() {
  return checked_text(
      table_of({{"type", "string"}, {"pattern", "^[a-z0-9]([a-z0-9.-]{0,98}[a-z0-9])?$"}}),
      "a kebab-case id: lower-case letters, digits, dots and hyphens, with a letter or digit at the end",
      [](const std::string& s) {
        const auto plain = [](char c) { return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9'); };
        return !s.empty() && s.size() <= 100 && plain(s.front()) && plain(s.back()) &&
               std::all_of(s.begin(), s.end(), [&](char c) { return plain(c) || c == '-' || c == '.'; });
      });
}

Codec<std::string> choice_of(std::vector<std::string> words) {
  Value::List allowed;
  for (const std::string& word : words) allowed.push_back(word);
  Codec<std::string> c;
  c.schema = table_of({{"enum", std::move(allowed)}});
  c.read = [words](Reading& r, const Value& v, std::string& out) {
    const std::string* found = v.text();
    if (!found || std::find(words.begin(), words.end(), *found) == words.end())
      fail_value(r, v, "one of " + listed(words) + (found ? did_you_mean(*found, words) : ""));
    out = *found;
  };
  c.write = [](const Scene&, const std::string& v) { return Value(v); };
  return c;
}

// ---- vectors ----------------------------------------------------------------------------------------------------
template <std::size_t N> static Codec<std::array<double, N>> numbers(const Range& range) {
  Codec<std::array<double, N>> c;
  const auto count = static_cast<std::int64_t>(N);
  c.schema = table_of({{"type", "array"}, {"items", number_schema(range)}, {"minItems", count}, {"maxItems", count}});
  c.read = [range](Reading& r, const Value& v, std::array<double, N>& out) {
    const auto* items = v.list();
    if (!items || items->size() != N) fail_value(r, v, "a list of " + std::to_string(N) + " numbers");
    for (std::size_t i = 0; i < N; ++i) out[i] = read_number(r, (*items)[i], range);
  };
  c.write = [](const Scene&, const std::array<double, N>& v) { return Value(Value::List(v.begin(), v.end())); };
  return c;
}

Codec<Real2> vector2(Range range) { return numbers<2>(range); }
Codec<Real3> vector3(Range range) { return numbers<3>(range); }

// Decimals of a unit vector rarely have unit length to the last bit. In a file they are divided by their length: within
// 1e-9 of 1 in silence, within 1e-3, as figures of three digits are, with a note. A resolved scene is kept as it
// stands, to the bit, and each engine reads that one.
template <std::size_t N> static Codec<std::array<double, N>> unit(const char* what) {
  Codec<std::array<double, N>> c = numbers<N>(any_number());
  c.read = [inner = c.read, what](Reading& r, const Value& v, std::array<double, N>& out) {
    inner(r, v, out);
    double length = 0;
    for (const double x : out) length = std::hypot(length, x);
    const bool of_file = r.form == Form::file;
    const std::string found = "`" + r.key + "` in " + r.where + " has length " + describe(Value(length));
    if (!(std::abs(length - 1) <= (of_file ? 1e-3 : 1e-9)))
      fail(r, v.location,
           found + "; expected " + what + " of length 1 " +
               (of_file ? "(a deviation up to 1e-3 is normalised)" : "(within 1e-9)"));
    if (!of_file) return;
    for (double& x : out) x /= length;
    if (std::abs(length - 1) > 1e-9) r.notes.push_back(location_text(r, v.location) + found + "; it was normalised");
  };
  return c;
}

Codec<Real3> unit_vector3() { return unit<3>("a vector"); }
Codec<Real4> unit_quaternion() { return unit<4>("a quaternion (w, x, y, z)"); }

Codec<Interval> interval() {
  Codec<Interval> c;
  const Codec<Real2> pair = vector2(non_negative());
  c.schema = pair.schema;
  c.read = [pair](Reading& r, const Value& v, Interval& out) {
    Real2 ends{};
    pair.read(r, v, ends);
    if (!(ends[0] < ends[1]))
      fail(r, v.location,
           "`" + r.key + "` in " + r.where + " has the interval [" + describe(Value(ends[0])) + ", " +
               describe(Value(ends[1])) + "]; expected [from, to] with from < to");
    out = {ends[0], ends[1]};
  };
  c.write = [](const Scene&, const Interval& v) { return Value(Value::List{Value(v.from_s), Value(v.to_s)}); };
  return c;
}

// ---- names of things ----------------------------------------------------------------------------------------------
static std::vector<std::string> sorted_names(const std::unordered_map<std::string, int>& known) {
  std::vector<std::pair<int, std::string>> by_index;
  for (const auto& [name, index] : known) by_index.emplace_back(index, name);
  std::sort(by_index.begin(), by_index.end());
  std::vector<std::string> names;
  for (auto& [index, name] : by_index) names.push_back(std::move(name));
  return names;
}

[[noreturn]] static void fail_name(Reading& r, const Value& v, std::vector<std::string> names, const char* kind) {
  const std::string* found = v.text();
  const std::string hint = found ? did_you_mean(*found, names) : "";
  const bool more = names.size() > 12;
  if (more) names.resize(12);
  if (names.empty()) names.push_back("none is declared");
  fail_value(r, v, std::string("the name of a ") + kind + " (" + listed(names) + (more ? ", ..." : "") + ")" + hint);
}

static int find_name(Reading& r, const Value& v, const std::unordered_map<std::string, int>& known, const char* kind) {
  if (const std::string* found = v.text())
    if (const auto it = known.find(*found); it != known.end()) return it->second;
  fail_name(r, v, sorted_names(known), kind);
}

// Bodies by one name: one, or all copies of a grid.
static Reading::Copies find_bodies(Reading& r, const Value& v) {
  if (const std::string* found = v.text()) {
    if (const auto it = r.grids.find(*found); it != r.grids.end()) return it->second;
    if (const auto it = r.bodies.find(*found); it != r.bodies.end()) return {it->second, 1};
  }
  std::vector<std::string> names;
  for (const auto& [name, copies] : r.grids) names.push_back(name);
  std::sort(names.begin(), names.end());
  for (std::string& name : sorted_names(r.bodies)) names.push_back(std::move(name));
  fail_name(r, v, std::move(names), "body");
}

Codec<int> material_name() {
  return {table_of({{"type", "string"}}),
          [](Reading& r, const Value& v, int& out) { out = find_name(r, v, r.materials, "material"); },
          [](const Scene& s, int i) { return Value(s.materials.at(static_cast<std::size_t>(i)).name); }};
}

Codec<int> body_name() {
  return {table_of({{"type", "string"}}),
          [](Reading& r, const Value& v, int& out) { out = find_name(r, v, r.bodies, "body"); },
          [](const Scene& s, int i) { return Value(s.bodies.at(static_cast<std::size_t>(i)).name); }};
}

Codec<int> joint_name() {
  return {table_of({{"type", "string"}}),
          [](Reading& r, const Value& v, int& out) { out = find_name(r, v, r.joints, "joint"); },
          [](const Scene& s, int i) { return Value(s.joints.at(static_cast<std::size_t>(i)).name); }};
}

Codec<std::vector<int>> body_names(bool all_takes_fixed) {
  Codec<std::vector<int>> c;
  const Value names = table_of({{"type", "array"}, {"items", table_of({{"type", "string"}})}, {"minItems", 1}});
  c.schema = table_of({{"oneOf", Value::List{table_of({{"type", "string"}}), names}}});
  c.read = [all_takes_fixed](Reading& r, const Value& v, std::vector<int>& out) {
    out.clear();
    if (const std::string* word = v.text(); word && *word == "all") {
      std::optional<std::vector<int>>& all = all_takes_fixed ? r.moving_or_charged : r.moving;
      if (!all) {
        all.emplace();
        for (std::size_t i = 0; i < r.scene->bodies.size(); ++i)
          if (const Body& body = r.scene->bodies[i]; !body.fixed || (all_takes_fixed && body.charge_C != 0))
            all->push_back(static_cast<int>(i));
      }
      out = *all;
      if (out.empty()) fail_value(r, v, "at least one body that can move");
      return;
    }
    const Value::List one = v.text() ? Value::List{v} : Value::List{};
    const auto* items = v.text() ? &one : v.list();
    if (!items || items->empty()) fail_value(r, v, "\"all\" or a list of names of bodies, or one name");
    std::vector<bool> seen(r.scene->bodies.size());
    for (const Value& item : *items) {
      const Reading::Copies found = find_bodies(r, item);
      for (int body = found.first; body < found.first + found.count; ++body) {
        if (seen[static_cast<std::size_t>(body)]) fail_value(r, item, "each body once");
        seen[static_cast<std::size_t>(body)] = true;
        out.push_back(body);
      }
    }
  };
  c.write = [](const Scene& s, const std::vector<int>& bodies) {
    Value::List items;
    for (const int body : bodies) items.push_back(s.bodies.at(static_cast<std::size_t>(body)).name);
    return Value(std::move(items));
  };
  return c;
}

}  // namespace atwood
