// Declaring keys. A kind of object is a list of Key<T>: each names a key once, with its doc, what it may hold, and how
// it goes in and out; reading TOML, reading JSON, writing JSON and the JSON Schema all walk the same list.
#pragma once

#include <array>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>
#include <vector>

#include "scene/files.hpp"
#include "scene/scene.hpp"
#include "scene/value.hpp"

namespace atwood {

// A scenario file says less than a resolved scene (densities, grids), and a resolved scene more (the points of a mesh).
enum class Form { file, resolved };

struct Reading {
  std::string name, folder;  // the file in messages; where `file` keys are looked up
  Form form = Form::file;
  std::string where, key;                                          // what is being read: "[[body]] `bat`", "mass_kg"
  Scene* scene = nullptr;                                          // as far as it is read
  std::unordered_map<std::string, int> materials, bodies, joints;  // name -> index
  struct Copies {
    int first = 0, count = 0;
  };
  std::unordered_map<std::string, Copies> grids;  // name of a copied body -> its copies in Scene::bodies
  std::vector<std::string> notes;                 // what reading changed, in sentences
  // The work that a file has asked for: the squares of the numbers of points of convex shapes; bytes of the files that
  // it names; points and triangles of its meshes; points, triangles and boxes of all bodies; bodies that its forces
  // name and times between which they act.
  double hull_work = 0;
  std::size_t mesh_bytes = 0, point_bytes = 0, corners = 0, mesh_points = 0, mesh_triangles = 0;
  std::size_t named_by_forces = 0, force_times = 0;
  std::optional<std::vector<int>> moving, moving_or_charged;  // bodies that "all" names, at its first use
  bool has_fluids = false;  // the scene has, or may have: a fixed body may slide in its surface
};

std::string location_text(const Reading& reading, SourceLocation location);  // "t.toml:12:8: "

[[noreturn]] void fail(const Reading& reading, SourceLocation location, const std::string& message);
// "`mass_kg` in [[body]] `bat` is -1; expected ..."
[[noreturn]] void fail_value(const Reading& reading, const Value& found, const std::string& expected);
std::string listed(const std::vector<std::string>& names);
// " (did you mean mass_kg?)", or nothing when no candidate is near.
std::string did_you_mean(const std::string& found, const std::vector<std::string>& candidates);

// How one type of value is read, written and described.
template <class M> struct Codec {
  Value schema;
  std::function<void(Reading&, const Value&, M&)> read;
  std::function<Value(const Scene&, const M&)> write;
};

enum class In { both, file, resolved };

template <class T> struct Key {
  std::string name, doc;
  Value schema;
  Value resolved_schema;  // where the resolved form differs; else empty
  bool required = false;
  In in = In::both;
  std::function<void(Reading&, const Value&, T&)> read;
  std::function<Value(const Scene&, const T&)> write;  // an empty Value leaves the key out
};
template <class T> using Keys = std::vector<Key<T>>;

// Whether a key that stands `in` some files stands in those of this form.
inline bool belongs(In in, Form form) { return in == In::both || (in == In::file) == (form == Form::file); }

template <class T, class B, class M> Key<T> key(std::string name, M B::*member, Codec<M> codec, std::string doc) {
  Key<T> k;
  k.name = std::move(name);
  k.doc = std::move(doc);
  k.schema = codec.schema;
  k.read = [member, read = codec.read](Reading& r, const Value& v, T& out) { read(r, v, out.*member); };
  k.write = [member, write = codec.write](const Scene& s, const T& from) { return write(s, from.*member); };
  return k;
}
template <class T> Key<T> required(Key<T> k) {
  k.required = true;
  return k;
}
template <class T> Key<T> only(In in, Key<T> k) {
  k.in = in;
  return k;
}

// Fills `out` from `table`. Members named in `tags` were read by the caller (the kind of a force).
template <class T>
void read_table(Reading& r, const Value& table, const Keys<T>& keys, const std::vector<std::string>& tags, T& out) {
  const Value::Table* members = table.table();
  if (!members) fail_value(r, table, "a table");
  std::vector<std::string> names = tags;
  for (const auto& k : keys)
    if (belongs(k.in, r.form)) names.push_back(k.name);
  for (const Member& member : *members) {
    bool known = false;
    for (const std::string& name : names) known = known || name == member.key;
    if (!known)
      fail(r, member.location,
           "unknown key `" + member.key + "` in " + r.where + "; expected one of " + listed(names) +
               did_you_mean(member.key, names));
  }
  const std::string outer_key = r.key;
  for (const auto& k : keys) {
    if (!belongs(k.in, r.form)) continue;
    r.key = k.name;
    if (const Value* value = table.find(k.name)) k.read(r, *value, out);
    else if (k.required) fail(r, table.location, "missing key `" + k.name + "` in " + r.where + "; expected " + k.doc);
  }
  r.key = outer_key;
}

// f(table) of every table under [[where]]; none where `list` is null.
template <class F> void each_table(Reading& r, const Value* list, const std::string& where, F f) {
  if (!list) return;
  r.where = where;
  r.key.clear();
  const auto* items = list->list();
  if (!items) fail_value(r, *list, "tables under " + where);
  for (const Value& item : *items) {
    r.where = where;
    r.key.clear();
    f(item);
  }
}

template <class T> void write_table(const Scene& scene, const T& from, const Keys<T>& keys, Value& table) {
  for (const auto& k : keys) {
    if (!belongs(k.in, Form::resolved) || !k.write) continue;
    Value value = k.write(scene, from);
    if (!value.empty()) add(table, k.name, std::move(value));
  }
}

// Properties and required keys of one kind of object, in one form.
template <class T> void schema_of(const Keys<T>& keys, Form form, Value& properties, Value::List& required_keys) {
  for (const auto& k : keys) {
    if (!belongs(k.in, form)) continue;
    Value schema = form == Form::resolved && !k.resolved_schema.empty() ? k.resolved_schema : k.schema;
    add(schema, "description", k.doc);
    add(properties, k.name, std::move(schema));
    if (k.required) required_keys.push_back(k.name);
  }
}
// The JSON Schema of an object with these keys.
Value object_schema(Value properties, Value::List required_keys);
template <class T> Value object_schema(const Keys<T>& keys, Form form) {
  Value properties{Value::Table{}};
  Value::List required_keys;
  schema_of(keys, form, properties, required_keys);
  return object_schema(std::move(properties), std::move(required_keys));
}

// ---- codecs ---------------------------------------------------------------------------------------------------
struct Range {
  double low = -std::numeric_limits<double>::infinity();
  bool low_open = false;
  double high = std::numeric_limits<double>::infinity();
  std::string expected = "a finite number";
};
Range any_number();
Range positive();
Range non_negative();
Range closed_range(double low, double high);

// Throws InputError where the value is not a number of the range; the same for values that the codecs read.
double read_number(Reading& r, const Value& v, const Range& range);
Codec<double> number(Range range = any_number());
Codec<bool> boolean();
Codec<std::string> text();
Codec<std::string> choice_of(std::vector<std::string> words);
Codec<std::string> name_text();   // of a body or material
Codec<std::string> kebab_text();  // an id
Codec<std::int64_t> integer(std::int64_t low, std::int64_t high);
Codec<Real2> vector2(Range range = any_number());
Codec<Real3> vector3(Range range = any_number());
Codec<Real3> unit_vector3();     // unit to 1e-9; in files to 1e-3, and normalised
Codec<Real4> unit_quaternion();  // the same
Codec<Interval> interval();
Codec<int> material_name();
Codec<int> body_name();
Codec<int> joint_name();
// "all", a name, or a list of names; the name of a body that a grid copied stands for all its copies.
Codec<std::vector<int>> body_names(bool all_takes_fixed);

template <class M> Codec<std::vector<M>> list_of(Codec<M> item, std::size_t most) {
  Codec<std::vector<M>> c;
  c.schema = table_of({{"type", "array"}, {"items", item.schema}, {"maxItems", static_cast<std::int64_t>(most)}});
  c.read = [item, most](Reading& r, const Value& v, std::vector<M>& out) {
    const auto* items = v.list();
    if (!items) fail_value(r, v, "a list");
    if (items->size() > most) fail_value(r, v, "at most " + std::to_string(most) + " entries");
    out.clear();
    out.resize(items->size());
    for (std::size_t i = 0; i < items->size(); ++i) item.read(r, (*items)[i], out[i]);
  };
  c.write = [item](const Scene& s, const std::vector<M>& from) {
    Value::List items;
    items.reserve(from.size());
    for (const M& each : from) items.push_back(item.write(s, each));
    return Value(std::move(items));
  };
  return c;
}

}  // namespace atwood
