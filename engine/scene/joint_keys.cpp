// The keys of joints and ropes.
#include "scene/joint_keys.hpp"

#include <algorithm>

#include "scene/orientation.hpp"

namespace atwood {
namespace {

const std::vector<std::string> kJointKinds = {"fixed",       "hinge",     "slider",
                                              "cylindrical", "universal", "ball"};  // as in JointKind

template <class T> Codec<std::optional<T>> maybe(Codec<T> inner) {
  Codec<std::optional<T>> c;
  c.schema = inner.schema;
  c.read = [inner](Reading& r, const Value& v, std::optional<T>& out) { inner.read(r, v, out.emplace()); };
  c.write = [inner](const Scene& s, const std::optional<T>& from) { return from ? inner.write(s, *from) : Value(); };
  return c;
}

// A number, or a list of two.
Codec<std::vector<double>> one_or_two() {
  Codec<std::vector<double>> c;
  const Codec<double> one = number();
  const Codec<Real2> two = vector2();
  c.schema = table_of({{"oneOf", Value::List{one.schema, two.schema}}});
  c.read = [](Reading& r, const Value& v, std::vector<double>& out) {
    const auto* items = v.list();
    if (items && items->size() != 2) fail_value(r, v, "a number, or a list of two");
    out.clear();
    if (!items) out.push_back(read_number(r, v, any_number()));
    else
      for (const Value& item : *items) out.push_back(read_number(r, item, any_number()));
  };
  return c;
}

bool turns_about_axis(const Joint& j) { return j.kind == JointKind::hinge || j.kind == JointKind::cylindrical; }
bool slides(const Joint& j) { return j.kind == JointKind::slider || j.kind == JointKind::cylindrical; }
bool has_axis(const Joint& j) { return turns_about_axis(j) || slides(j); }

Key<JointDraft> kind_key() {
  Key<JointDraft> k;
  const auto codec = choice_of(kJointKinds);
  k.name = "kind", k.doc = "one of " + listed(kJointKinds), k.schema = codec.schema, k.required = true;
  k.read = [codec](Reading& r, const Value& v, JointDraft& out) {
    std::string word;
    codec.read(r, v, word);
    out.kind = static_cast<JointKind>(std::find(kJointKinds.begin(), kJointKinds.end(), word) - kJointKinds.begin());
  };
  k.write = [](const Scene&, const JointDraft& from) { return Value(to_word(from.kind)); };
  return k;
}

// "world" or a body's name. A grid's body has no name of its own left.
int read_end(Reading& r, const Value& v, bool may_be_world) {
  const std::string* word = v.text();
  if (word && *word == "world") {
    if (!may_be_world) fail_value(r, v, "the name of a body: the world is the parent, the first of the two");
    if (r.bodies.contains(*word))
      fail(r, v.location,
           "`bodies` in " + r.where + " says \"world\", and a body has that name; expected another name for it");
    return -1;
  }
  if (word && r.grids.contains(*word))
    fail_value(r, v, "a single body: a grid copies this one, and what is tied to it would not be copied");
  int body = -1;
  body_name().read(r, v, body);
  return body;
}

template <class T>
Key<T> bodies_key(std::string doc, std::function<void(Reading&, const Value&, const Value&, T&)> take,
                  std::function<std::array<int, 2>(const T&)> of) {
  Key<T> k;
  k.name = "bodies", k.doc = std::move(doc), k.required = true;
  k.schema = table_of({{"type", "array"}, {"items", table_of({{"type", "string"}})}, {"minItems", 2}, {"maxItems", 2}});
  k.read = [take](Reading& r, const Value& v, T& out) {
    const auto* items = v.list();
    if (!items || items->size() != 2) fail_value(r, v, "a list of two names of bodies");
    take(r, (*items)[0], (*items)[1], out);
  };
  k.write = [of](const Scene& s, const T& from) {
    Value::List names;
    for (const int body : of(from))
      names.push_back(body < 0 ? Value("world") : Value(s.bodies.at(static_cast<std::size_t>(body)).name));
    return Value(std::move(names));
  };
  return k;
}

Codec<std::array<Real3, 2>> two_vectors(Codec<Real3> one) {
  Codec<std::array<Real3, 2>> c;
  c.schema = table_of({{"type", "array"}, {"items", one.schema}, {"minItems", 2}, {"maxItems", 2}});
  c.read = [one](Reading& r, const Value& v, std::array<Real3, 2>& out) {
    const auto* items = v.list();
    if (!items || items->size() != 2) fail_value(r, v, "a list of two vectors");
    for (std::size_t i = 0; i < 2; ++i) one.read(r, (*items)[i], out[i]);
  };
  c.write = [one](const Scene& s, const std::array<Real3, 2>& from) {
    return Value(Value::List{one.write(s, from[0]), one.write(s, from[1])});
  };
  return c;
}

Key<JointDraft> hold_key() {
  Key<JointDraft> k;
  k.name = "hold";
  k.doc =
      "of a joint that closes a loop: names of joints whose coordinates and rates stay as given while the start is "
      "moved onto the loop";
  k.schema = table_of({{"type", "array"}, {"items", table_of({{"type", "string"}})}});
  k.read = [](Reading&, const Value& v, JointDraft& out) { out.hold_names = &v; };
  k.write = [](const Scene& s, const JointDraft& from) {
    Value::List names;
    for (const int j : from.hold) names.push_back(s.joints.at(static_cast<std::size_t>(j)).name);
    return names.empty() ? Value() : Value(std::move(names));
  };
  return k;
}

// The first entries of the coordinates or rates.
Key<JointDraft> state_key(std::string name, std::vector<double> JointDraft::*read_into, std::string doc, bool is_rate) {
  Key<JointDraft> k = key<JointDraft>(std::move(name), read_into, list_of(number(), 4), std::move(doc));
  k.write = [is_rate](const Scene&, const JointDraft& from) {
    const auto n = static_cast<std::size_t>(is_rate ? rate_count(from.kind) : coordinate_count(from.kind));
    Value::List values;
    for (std::size_t i = 0; i < n; ++i) values.emplace_back(is_rate ? from.rates[i] : from.coordinates[i]);
    return n == 0 ? Value() : Value(std::move(values));
  };
  return only(In::resolved, std::move(k));
}

Keys<JointDraft> start_keys() {
  Keys<JointDraft> keys = {
      key<JointDraft>("angle_rad", &JointDraft::angle_rad, one_or_two(),
                      "hinge, cylindrical: the angle at t = 0; universal: both [rad]; 0 unless given"),
      key<JointDraft>("offset_m", &JointDraft::offset_m, maybe(number()),
                      "slider, cylindrical: the offset at t = 0 [m]; 0 unless given"),
      key<JointDraft>("orientation_wxyz", &JointDraft::orientation, maybe(unit_quaternion()),
                      "ball: the orientation at t = 0 in the joint's frame; identity unless given"),
      key<JointDraft>("axis_angle_deg", &JointDraft::orientation, maybe(axis_angle_degrees()),
                      "in place of orientation_wxyz, as of a body [degrees]"),
      key<JointDraft>("euler_xyz_deg", &JointDraft::orientation, maybe(euler_xyz_degrees()),
                      "in place of orientation_wxyz, as of a body [degrees]"),
      key<JointDraft>("rate_rad_per_s", &JointDraft::rate_rad_per_s, one_or_two(),
                      "hinge, cylindrical: the angle's rate at t = 0; universal: both [rad/s]; 0 unless given"),
      key<JointDraft>("rate_m_per_s", &JointDraft::rate_m_per_s, maybe(number()),
                      "slider, cylindrical: the offset's rate at t = 0 [m/s]; 0 unless given"),
      key<JointDraft>(
          "angular_velocity_body_rad_per_s", &JointDraft::angular_velocity, maybe(vector3()),
          "ball: the child's angular velocity relative to the parent at t = 0, child's axes [rad/s]; 0 unless "
          "given"),
  };
  for (auto& k : keys) k = only(In::file, std::move(k));
  keys.push_back(state_key("coordinates", &JointDraft::resolved_coordinates,
                           "at t = 0: angle [rad], offset [m], both, two angles, or a quaternion (w, x, y, z)", false));
  keys.push_back(state_key("rates", &JointDraft::resolved_rates,
                           "at t = 0, of the coordinates; of a ball the relative angular velocity, child's axes",
                           true));
  return keys;
}

Keys<JointDraft> motion_keys() {
  auto limits_rad = key<JointDraft>("limits_rad", &JointDraft::limits_rad, maybe(vector2()),
                                    "hinge: the angle's smallest and largest value [rad]; none unless given");
  auto limits_m = key<JointDraft>("limits_m", &JointDraft::limits_m, maybe(vector2()),
                                  "slider: the offset's smallest and largest value [m]; none unless given");
  auto stop = key<JointDraft>("stop_restitution", &JointDraft::stop_restitution, maybe(number(closed_range(0, 1))),
                              "of the rate at a limit, 0 to 1; 0 unless given");
  auto driven_angle = key<JointDraft>("driven_rate_rad_per_s", &JointDraft::driven_rate_rad_per_s, maybe(number()),
                                      "hinge: prescribes its motion, angle_rad plus t times this rate [rad/s]");
  auto driven_offset = key<JointDraft>("driven_rate_m_per_s", &JointDraft::driven_rate_m_per_s, maybe(number()),
                                       "slider: prescribes its motion, offset_m plus t times this rate [m/s]");
  limits_rad.write = [](const Scene&, const JointDraft& j) {
    return j.limits && j.kind == JointKind::hinge ? Value(Value::List{j.limits->lower, j.limits->upper}) : Value();
  };
  limits_m.write = [](const Scene&, const JointDraft& j) {
    return j.limits && j.kind == JointKind::slider ? Value(Value::List{j.limits->lower, j.limits->upper}) : Value();
  };
  stop.write = [](const Scene&, const JointDraft& j) { return j.limits ? Value(j.limits->restitution) : Value(); };
  driven_angle.write = [](const Scene&, const JointDraft& j) {
    return j.driven_rate && j.kind == JointKind::hinge ? Value(*j.driven_rate) : Value();
  };
  driven_offset.write = [](const Scene&, const JointDraft& j) {
    return j.driven_rate && j.kind == JointKind::slider ? Value(*j.driven_rate) : Value();
  };
  return {limits_rad, limits_m, stop, driven_angle, driven_offset};
}

// ---- ropes --------------------------------------------------------------------------------------------------------
const Keys<Pulley>& pulley_keys() {
  static const Keys<Pulley> keys = {
      required(key<Pulley>("axle_m", &Pulley::axle_m, vector3(), "a point of its axle, in the plane of the rope [m]")),
      key<Pulley>("radius_m", &Pulley::radius_m, number(non_negative()),
                  "radius [m]; 0, a fixed frictionless point, unless given"),
      key<Pulley>("inertia_kg_m2", &Pulley::inertia_kg_m2, number(non_negative()),
                  "about the axle [kg m^2]; 0 unless given"),
      key<Pulley>("axis", &Pulley::axis, unit_vector3(),
                  "unit vector of the axle: the rope runs on the side where axis x (point - axle) points along it; "
                  "unless given the side on which the rope bends around the pulley"),
      key<Pulley>("angle_rad", &Pulley::angle_rad, number(), "at t = 0 [rad]; 0 unless given"),
  };
  return keys;
}

Key<Rope> over_key() {
  Key<Rope> k;
  k.name = "over_m";
  k.doc = "what it runs over from the first body to the last: fixed points, or pulleys";
  const Value pulley = object_schema(pulley_keys(), Form::file);
  k.schema = table_of({{"type", "array"}, {"items", table_of({{"oneOf", Value::List{vector3().schema, pulley}}})}});
  k.read = [](Reading& r, const Value& v, Rope& out) {
    const auto* items = v.list();
    if (!items) fail_value(r, v, "a list of points and pulleys");
    for (const Value& item : *items) {
      Pulley& pulley_read = out.over.emplace_back();
      if (item.list()) {
        vector3().read(r, item, pulley_read.axle_m);
        continue;
      }
      if (!item.table())
        fail_value(r, item, "a point [x, y, z], or { axle_m, radius_m, inertia_kg_m2, axis, angle_rad }");
      const std::string outer = r.where;
      r.where = "`over_m` of " + outer;
      pulley_read.axis = {};  // not given
      read_table(r, item, pulley_keys(), {}, pulley_read);
      r.where = outer, r.key = "over_m";
    }
  };
  k.write = [](const Scene& s, const Rope& from) {
    Value::List items;
    for (const Pulley& each : from.over) {
      Value table{Value::Table{}};
      write_table(s, each, pulley_keys(), table);
      items.push_back(std::move(table));
    }
    return items.empty() ? Value() : Value(std::move(items));
  };
  return k;
}

}  // namespace

const char* to_word(JointKind kind) { return kJointKinds[static_cast<std::size_t>(kind)].c_str(); }

JointDraft draft_of(const Joint& joint) {
  JointDraft draft;
  static_cast<Joint&>(draft) = joint;
  return draft;
}

const Keys<JointDraft>& joint_keys() {
  static const Keys<JointDraft> keys = [] {
    const auto only_if = [](Key<JointDraft> k, bool (*shown)(const Joint&)) {
      k.write = [write = k.write, shown](const Scene& s, const JointDraft& from) {
        return shown(from) ? write(s, from) : Value();
      };
      return k;
    };
    Keys<JointDraft> all = {
        key<JointDraft>("name", &Joint::name, name_text(), "a name, used once among joints; joint.K unless given"),
        kind_key(),
        bodies_key<JointDraft>(
            "parent (or \"world\") and child",
            [](Reading& r, const Value& first, const Value& second, JointDraft& out) {
              out.parent = read_end(r, first, true);
              out.child = read_end(r, second, false);
            },
            [](const JointDraft& j) {
              return std::array<int, 2>{j.parent, j.child};
            }),
        key<JointDraft>(
            "anchors_body_m", &Joint::anchors_body_m, two_vectors(vector3()),
            "where it holds parent and child, from each centre of mass in body axes (of the world: from the "
            "origin) [m]; 0 unless given"),
        only_if(key<JointDraft>("axis_body", &Joint::axis_body, unit_vector3(),
                                "hinge, slider, cylindrical: unit vector of the axis in the child's axes"),
                has_axis),
        only_if(
            key<JointDraft>("axes_body", &Joint::axes_body, two_vectors(unit_vector3()),
                            "universal: the first axis in the parent's axes, the second in the child's, orthogonal"),
            [](const Joint& j) { return j.kind == JointKind::universal; }),
        key<JointDraft>("frame_wxyz", &Joint::frame_wxyz, unit_quaternion(),
                        "the child's orientation in the parent at coordinate 0; identity unless given"),
        only_if(key<JointDraft>("closes_loop", &Joint::closes_loop, boolean(),
                                "it places no body: the loop that it closes is a constraint; false unless given"),
                [](const Joint& j) { return j.closes_loop; }),
        only_if(key<JointDraft>("assemble", &Joint::assemble, boolean(),
                                "of a joint that closes a loop: the start may be open by any gap; false unless given"),
                [](const Joint& j) { return j.assemble; }),
        hold_key(),
    };
    for (auto& k : start_keys()) all.push_back(std::move(k));
    for (auto& k : motion_keys()) all.push_back(std::move(k));
    return all;
  }();
  return keys;
}

const Keys<Rope>& rope_keys() {
  static const Keys<Rope> keys = {
      key<Rope>("name", &Rope::name, name_text(), "a name, used once among ropes; rope.K unless given"),
      bodies_key<Rope>(
          "the bodies at its first and its last end",
          [](Reading& r, const Value& first, const Value& second, Rope& out) {
            for (const Value* end : {&first, &second})
              if (end->text() && *end->text() == "world")
                fail_value(r, *end, "the name of a body (a fixed one holds a rope's end in the world)");
            out.bodies = {read_end(r, first, false), read_end(r, second, false)};
          },
          [](const Rope& rope) { return rope.bodies; }),
      key<Rope>("points_body_m", &Rope::points_body_m, two_vectors(vector3()),
                "where it holds each, from its centre of mass in body axes [m]; 0 unless given"),
      over_key(),
  };
  return keys;
}

}  // namespace atwood
