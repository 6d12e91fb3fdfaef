// The shapes: one list of keys each.
#include "scene/declarations.hpp"
#include "scene/orientation.hpp"

namespace atwood {
namespace {

constexpr double kMaxHullWork = 3e8;  // a hull of 4096 points takes 70 ms, and the time grows with their square

template <class T>
Alternative<Shape> shape(std::string name, std::string doc, Keys<T> keys,
                         std::function<void(Reading&, const Value&, T&)> check = {}) {
  Alternative<Shape> alternative;
  alternative.name = std::move(name);
  alternative.doc = std::move(doc);
  alternative.read = [keys, check](Reading& r, const Value& v, Shape& out) {
    T value;
    read_table(r, v, keys, {}, value);
    if (check) check(r, v, value);
    out = std::move(value);
  };
  alternative.holds = [](const Shape& s) { return std::holds_alternative<T>(s); };
  alternative.write = [keys](const Scene& s, const Shape& from, Value& table) {
    write_table(s, std::get<T>(from), keys, table);
  };
  alternative.schema = [keys](Form form) { return object_schema(keys, form); };
  return alternative;
}

Codec<std::array<int, 3>> triangle() {
  Codec<std::array<int, 3>> c;
  const Codec<std::int64_t> corner = integer(0, 1 << 24);
  c.schema = table_of({{"type", "array"}, {"items", corner.schema}, {"minItems", 3}, {"maxItems", 3}});
  c.read = [corner](Reading& r, const Value& v, std::array<int, 3>& out) {
    const auto* items = v.list();
    if (!items || items->size() != 3) fail_value(r, v, "three indices of points");
    for (std::size_t i = 0; i < 3; ++i) {
      std::int64_t index = 0;
      corner.read(r, (*items)[i], index);
      out[i] = static_cast<int>(index);
    }
  };
  c.write = [](const Scene&, const std::array<int, 3>& v) { return Value(Value::List(v.begin(), v.end())); };
  return c;
}

const Keys<Compound::Part>& part_keys() {
  using Part = Compound::Part;
  static const Keys<Part> keys = [] {
    Keys<Part> all = {
        required(key<Part>("half_extents_m", &Part::half_extents_m, vector3(positive()),
                           "half the lengths of the sides [m]")),
        key<Part>("position_body_m", &Part::position_body_m, vector3(),
                  "centre of the box in body axes [m]; 0 unless given"),
        key<Part>("orientation_wxyz", &Part::orientation_wxyz, unit_quaternion(),
                  "unit quaternion, box to body; identity unless given"),
    };
    add_degree_keys(all, &Part::orientation_wxyz);
    return all;
  }();
  return keys;
}

Codec<Compound::Part> part() {
  Codec<Compound::Part> c;
  c.schema = object_schema(part_keys(), Form::file);
  c.read = [](Reading& r, const Value& v, Compound::Part& out) {
    read_table(r, v, part_keys(), {}, out);
    require_one_orientation(r, v);
  };
  c.write = [](const Scene& s, const Compound::Part& from) {
    Value table{Value::Table{}};
    write_table(s, from, part_keys(), table);
    return table;
  };
  return c;
}

Alternative<Shape> mesh_shape() {
  const std::size_t most = 1 << 20;
  Codec<std::string> file = text();
  return shape<Mesh>(
      "mesh", "triangles from an OBJ file inside the scene's folder",
      {required(key<Mesh>("file", &Mesh::file, file, "an OBJ file, relative to the scene's folder")),
       only(In::resolved, key<Mesh>("points_m", &Mesh::points_m, list_of(vector3(), most), "corners in body axes [m]")),
       only(In::resolved, key<Mesh>("triangles", &Mesh::triangles, list_of(triangle(), most),
                                    "three indices into points_m each, anticlockwise from outside"))},
      [](Reading& r, const Value& v, Mesh& mesh) {
        if (r.form == Form::file) load_mesh(r, *v.find("file"), mesh);
        for (const auto& corners : mesh.triangles)
          for (const int corner : corners)
            if (static_cast<std::size_t>(corner) >= mesh.points_m.size())
              fail(r, v.location,
                   "`triangles` in " + r.where + " names point " + std::to_string(corner) +
                       "; expected an index below " + std::to_string(mesh.points_m.size()));
      });
}

}  // namespace

const std::vector<Alternative<Shape>>& shapes() {
  static const auto round_keys = []<class T>(T) {
    return Keys<T>{required(key<T>("radius_m", &T::radius_m, number(positive()), "radius [m]")),
                   required(key<T>("half_length_m", &T::half_length_m, number(positive()),
                                   "half the length of the straight part [m]"))};
  };
  static const std::vector<Alternative<Shape>> all = {
      shape<Sphere>("sphere", "solid sphere",
                    {required(key<Sphere>("radius_m", &Sphere::radius_m, number(positive()), "radius [m]"))}),
      shape<Plane>("plane", "infinite, fixed, in world axes",
                   {required(key<Plane>("normal", &Plane::normal, unit_vector3(), "unit normal, out of the ground")),
                    key<Plane>("offset_m", &Plane::offset_m, number(), "n . x on the plane [m]; 0 unless given")}),
      shape<Rectangle>("rectangle", "flat plate in the body's x, y; normal +z",
                       {required(key<Rectangle>("half_extents_m", &Rectangle::half_extents_m, vector2(positive()),
                                                "half the lengths of the sides [m]"))}),
      shape<Box>("box", "solid box along the body's axes",
                 {required(key<Box>("half_extents_m", &Box::half_extents_m, vector3(positive()),
                                    "half the lengths of the sides [m]"))}),
      shape<Capsule>("capsule", "solid capsule along body z", round_keys(Capsule{})),
      shape<Cylinder>("cylinder", "solid cylinder along body z", round_keys(Cylinder{})),
      shape<Convex>("convex", "the convex hull of points",
                    {required(key<Convex>("points_m", &Convex::points_m, list_of(vector3(), 4096),
                                          "points in body axes [m]; their hull's centroid is the origin"))},
                    [](Reading& r, const Value& v, Convex& convex) {
                      const auto points = static_cast<double>(convex.points_m.size());
                      if (r.form == Form::file) r.hull_work += points * points;
                      if (r.hull_work > kMaxHullWork)
                        fail(r, v.location,
                             "the squares of the numbers of points of all convex shapes sum to more than 3e8 with " +
                                 r.where + "; expected fewer points");
                    }),
      mesh_shape(),
      shape<Compound>("compound", "a union of solid boxes that do not overlap",
                      {required(key<Compound>("boxes", &Compound::boxes, list_of(part(), 4096), "the boxes"))},
                      [](Reading& r, const Value& v, Compound& compound) {
                        if (compound.boxes.empty()) fail_value(r, v, "at least one box");
                      }),
  };
  return all;
}

Shape read_shape(Reading& r, const Value& v) {
  std::vector<std::string> names;
  for (const auto& alternative : shapes()) names.push_back(alternative.name);
  const auto* members = v.table();
  if (members && members->size() > 1)
    fail(r, v.location,
         "found " + std::to_string(members->size()) + " shapes in " + r.where +
             "; expected one (a compound has several parts)");
  if (!members || members->empty()) fail_value(r, v, "a table with one of " + listed(names));
  for (const auto& alternative : shapes()) {
    const Member& member = members->front();
    if (alternative.name != member.key) continue;
    Shape out;
    const std::string outer_where = r.where, outer_key = r.key;
    r.where = "shape " + member.key + " of " + outer_where;
    r.key.clear();
    alternative.read(r, member.value, out);
    r.where = outer_where, r.key = outer_key;
    return out;
  }
  fail(r, members->front().location,
       "unknown shape `" + members->front().key + "` in " + r.where + "; expected one of " + listed(names) +
           did_you_mean(members->front().key, names));
}

Value shape_schema(Form form) {
  Value::List options;
  for (const auto& alternative : shapes()) {
    Value inner = alternative.schema(form);
    add(inner, "description", alternative.doc);
    Value properties{Value::Table{}};
    add(properties, alternative.name, std::move(inner));
    options.push_back(object_schema(std::move(properties), {Value(alternative.name)}));
  }
  return table_of({{"oneOf", std::move(options)}});
}

}  // namespace atwood
