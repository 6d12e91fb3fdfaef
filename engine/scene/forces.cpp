// The forces: one list of keys for each, distinguished by `kind` (drag also by `model`).
#include <algorithm>

#include "scene/joint_keys.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxForces = 100'000;
constexpr std::size_t kMaxNamed = 1'000'000;  // bodies of all forces together: "all" is one word in a file

// The key for the bodies of a force: "body", "bodies", or none.
template <class T> std::string name_of_bodies(const Keys<T>& keys) {
  for (const Key<T>& key : keys)
    if (key.name == "body" || key.name == "bodies") return key.name;
  return "";
}

// The table with the key `other` renamed to `own`: `body` and `bodies` are synonyms.
Value renamed(Reading& r, const Value& v, const std::string& other, const std::string& own) {
  Value table = v;
  for (Member& member : std::get<Value::Table>(table.data)) {
    if (member.key != other) continue;
    if (v.find(own))
      fail(r, member.location,
           "`" + other + "` in " + r.where + " is given beside `" + own + "`; expected one of the two");
    member.key = own;
  }
  return table;
}

template <class T>
Alternative<Force> force(std::vector<Tag> tags, std::string doc, Keys<T> keys,
                         std::function<void(Reading&, const Value&, T&)> check = {}) {
  Alternative<Force> alternative;
  alternative.name = tags.front().value;
  alternative.doc = std::move(doc);
  alternative.tags = tags;
  std::vector<std::string> tag_keys;
  for (const Tag& tag : tags) tag_keys.push_back(tag.key);
  const std::string own = name_of_bodies(keys), other = own == "body" ? "bodies" : "body";
  alternative.read = [keys, check, tag_keys, own, other](Reading& r, const Value& v, Force& out) {
    const bool by_other = r.form == Form::file && !own.empty() && v.find(other);
    const Value with_own = by_other ? renamed(r, v, other, own) : Value();
    const Value& table = by_other ? with_own : v;
    T value;
    read_table(r, table, keys, tag_keys, value);
    if (check) check(r, table, value);
    out = std::move(value);
  };
  alternative.holds = [](const Force& f) { return std::holds_alternative<T>(f); };
  alternative.write = [keys](const Scene& s, const Force& from, Value& table) {
    write_table(s, std::get<T>(from), keys, table);
  };
  alternative.schema = [keys, tags, own](Form form) {
    Value properties{Value::Table{}};
    Value::List needed;
    for (const Tag& tag : tags) {
      add(properties, tag.key, table_of({{"const", tag.value}}));
      needed.push_back(tag.key);
    }
    schema_of(keys, form, properties, needed);
    if (form == Form::resolved || own.empty()) return object_schema(std::move(properties), std::move(needed));
    // A file may use either name, with one body or several.
    Value::Table& members = std::get<Value::Table>(properties.data);
    std::erase_if(members, [&](const Member& member) { return member.key == own; });
    for (const char* name : {"body", "bodies"}) {
      Value names = body_names(false).schema;
      add(names, "description",
          "names of bodies, or \"all\"; a body that a grid copied: all its copies. `body` and `bodies` mean the same");
      add(properties, name, std::move(names));
    }
    std::erase_if(needed, [&](const Value& key) { return *key.text() == own; });
    Value schema = object_schema(std::move(properties), std::move(needed));
    add(schema, "oneOf",
        Value::List{table_of({{"required", Value::List{Value("body")}}}),
                    table_of({{"required", Value::List{Value("bodies")}}})});
    return schema;
  };
  return alternative;
}

template <class T> Key<T> bodies(bool all_takes_fixed = false) {
  return required(key<T>("bodies", &T::bodies, body_names(all_takes_fixed),
                         all_takes_fixed ? "names of bodies, or \"all\": those that move and fixed ones with a charge"
                                         : "names of bodies, or \"all\": those that are not fixed"));
}
template <class T> Key<T> wind() {
  return key<T>("wind_m_per_s", &T::wind_m_per_s, vector3(), "velocity of the medium [m/s]; 0 unless given");
}
template <class T> Key<T> angular_drag() {
  return key<T>("angular_coefficient_N_m_s", &T::angular_coefficient_N_m_s, number(non_negative()),
                "torque = -coefficient w [N m s]; 0 unless given");
}
template <class T> Key<T> on_times() {
  return key<T>("on_s", &T::on_s, list_of(interval(), 4096),
                "when it acts: [from, to) pairs [s], in order; always unless given");
}
template <class T> Key<T> point() {
  return key<T>("point_body_m", &T::point_body_m, vector3(),
                "where it acts, in body axes [m]; the centre of mass unless given");
}

template <class T> void check_on_times(Reading& r, const Value& v, T& f) { check_intervals(r, v, f.on_s); }

void check_spring(Reading& r, const Value& v, Spring& spring) {
  const Value& names = *v.find("bodies");
  const std::size_t count = spring.bodies.size();
  if (count > 2)
    fail(r, names.location,
         "`bodies` in " + r.where + " names " + std::to_string(count) + " bodies; expected one and `anchor_m`, or two");
  const Value* anchor = v.find("anchor_m");
  if (count == 1 && !anchor)
    fail(r, v.location,
         "missing key `anchor_m` in " + r.where + "; expected the other end of the spring, as there is one body");
  if (count == 2 && anchor && r.form == Form::file)
    fail(r, anchor->location,
         "`anchor_m` in " + r.where + " is given beside two bodies; expected it with one body only");
  if (spring.points_body_m.empty()) spring.points_body_m.resize(count);
  if (spring.points_body_m.size() != count)
    fail(r, v.find("points_body_m")->location,
         "`points_body_m` in " + r.where + " is a list of " + std::to_string(spring.points_body_m.size()) +
             "; expected one point for each of " + std::to_string(count) + " bodies");
}

void check_mutual_gravity(Reading& r, const Value& v, MutualGravity& gravity) {
  for (const int body : gravity.bodies)
    if (const Body& b = r.scene->bodies[static_cast<std::size_t>(body)]; b.fixed)
      fail(r, v.find("bodies")->location,
           "`bodies` in " + r.where + " names the fixed body `" + b.name +
               "`, which has no mass; expected free bodies (a fixed centre is an attractor)");
}

void check_frame(Reading& r, const Value& v, RotatingFrame&) {
  for (const Body& body : r.scene->bodies)
    if (!body.fixed && rotates(body))
      fail(r, v.location,
           "found the body `" + body.name + "`, which rotates, in a scene with " + r.where +
               "; expected point masses only (no shape, no inertia)");
}

// The potentials of the catalogue. henon-heiles: V = (x^2 + y^2) / 2 + x^2 y - y^3 / 3, no parameters.
Key<Potential> parameters() {
  Key<Potential> k;
  k.name = "parameters";
  k.doc = "numbers that the potential takes, by name (henon-heiles takes none)";
  k.schema = table_of({{"type", "object"}, {"additionalProperties", table_of({{"type", "number"}})}});
  k.read = [](Reading& r, const Value& v, Potential& out) {
    const auto* members = v.table();
    if (!members) fail_value(r, v, "a table of numbers");
    for (const Member& member : *members) {
      if (r.form == Form::file)
        fail(r, member.location,
             "unknown parameter `" + member.key + "` in " + r.where + "; expected none for " + out.name);
      out.parameters[member.key] = read_number(r, member.value, any_number());
    }
  };
  k.write = [](const Scene&, const Potential& from) {
    if (from.parameters.empty()) return Value();
    Value table{Value::Table{}};
    for (const auto& [name, value] : from.parameters) add(table, name, value);
    return table;
  };
  return k;
}

std::vector<Alternative<Force>> fields() {
  return {
      force<MutualGravity>({{"kind", "gravity"}}, "mutual gravity",
                           {bodies<MutualGravity>(),
                            key<MutualGravity>("constant_m3_per_kg_s2", &MutualGravity::constant_m3_per_kg_s2,
                                               number(positive()), "G [m^3/(kg s^2)]; 6.6743e-11 unless given"),
                            key<MutualGravity>("softening_m", &MutualGravity::softening_m, number(non_negative()),
                                               "Plummer softening [m]; 0 unless given")},
                           check_mutual_gravity),
      force<Attractor>(
          {{"kind", "attractor"}}, "gravity of a fixed centre",
          {bodies<Attractor>(),
           key<Attractor>("center_m", &Attractor::center_m, vector3(), "where [m]; the origin unless given"),
           required(
               key<Attractor>("mu_m3_per_s2", &Attractor::mu_m3_per_s2, number(non_negative()), "G M [m^3/s^2]"))}),
      force<LinearDrag>({{"kind", "drag"}, {"model", "linear"}}, "F = -coefficient (v - wind)",
                        {bodies<LinearDrag>(),
                         required(key<LinearDrag>("coefficient_kg_per_s", &LinearDrag::coefficient_kg_per_s,
                                                  number(non_negative()), "coefficient [kg/s]")),
                         wind<LinearDrag>(), angular_drag<LinearDrag>()}),
      force<QuadraticDrag>({{"kind", "drag"}, {"model", "quadratic"}}, "F = -1/2 rho C_d A |u| u, u = v - wind",
                           {bodies<QuadraticDrag>(),
                            required(key<QuadraticDrag>("density_kg_per_m3", &QuadraticDrag::density_kg_per_m3,
                                                        number(non_negative()), "density of the medium [kg/m^3]")),
                            required(key<QuadraticDrag>("drag_coefficient", &QuadraticDrag::drag_coefficient,
                                                        number(non_negative()), "C_d")),
                            required(key<QuadraticDrag>("area_m2", &QuadraticDrag::area_m2, number(non_negative()),
                                                        "cross section [m^2]")),
                            wind<QuadraticDrag>(), angular_drag<QuadraticDrag>()}),
      force<Lorentz>(
          {{"kind", "lorentz"}}, "F = q (E + v x B)",
          {bodies<Lorentz>(),
           key<Lorentz>("electric_V_per_m", &Lorentz::electric_V_per_m, vector3(), "E [V/m]; 0 unless given"),
           key<Lorentz>("magnetic_T", &Lorentz::magnetic_T, vector3(), "B [T]; 0 unless given")}),
      force<Coulomb>(
          {{"kind", "coulomb"}}, "mutual force of charges",
          {bodies<Coulomb>(true), required(key<Coulomb>("constant_N_m2_per_C2", &Coulomb::constant_N_m2_per_C2,
                                                        number(non_negative()), "k [N m^2/C^2]"))}),
      force<RotatingFrame>(
          {{"kind", "rotating-frame"}}, "Coriolis and centrifugal terms on every point mass",
          {required(key<RotatingFrame>("angular_velocity_rad_per_s", &RotatingFrame::angular_velocity_rad_per_s,
                                       vector3(), "of the frame [rad/s]"))},
          check_frame),
      force<Potential>(
          {{"kind", "potential"}}, "F = -grad V of a named potential",
          {bodies<Potential>(),
           required(key<Potential>("name", &Potential::name, choice_of({"henon-heiles"}), "which")), parameters()}),
  };
}

std::vector<Alternative<Force>> loads() {
  return {
      force<Spring>(
          {{"kind", "spring"}}, "between a body and an anchor, or two bodies",
          {bodies<Spring>(), key<Spring>("anchor_m", &Spring::anchor_m, vector3(), "the fixed end [m], with one body"),
           required(key<Spring>("stiffness_N_per_m", &Spring::stiffness_N_per_m, number(non_negative()), "k [N/m]")),
           key<Spring>("damping_N_s_per_m", &Spring::damping_N_s_per_m, number(non_negative()),
                       "along the spring [N s/m]; 0 unless given"),
           key<Spring>("rest_length_m", &Spring::rest_length_m, number(non_negative()),
                       "length without force [m]; 0 unless given"),
           key<Spring>("points_body_m", &Spring::points_body_m, list_of(vector3(), 2),
                       "where it holds each body, in body axes [m]; centres of mass unless given")},
          check_spring),
      force<Drive>({{"kind", "drive"}}, "force_N cos(w t + phase)",
                   {bodies<Drive>(), required(key<Drive>("force_N", &Drive::force_N, vector3(), "amplitude [N]")),
                    required(key<Drive>("angular_frequency_rad_per_s", &Drive::angular_frequency_rad_per_s, number(),
                                        "w [rad/s]")),
                    key<Drive>("phase_rad", &Drive::phase_rad, number(), "phase [rad]; 0 unless given")}),
      force<Thruster>(
          {{"kind", "thruster"}}, "a force that turns with the body",
          {required(key<Thruster>("body", &Thruster::body, body_name(), "name of the body")), point<Thruster>(),
           required(key<Thruster>("direction_body", &Thruster::direction_body, unit_vector3(),
                                  "unit vector of the force in body axes")),
           required(key<Thruster>("thrust_N", &Thruster::thrust_N, number(non_negative()), "its size [N]")),
           on_times<Thruster>()},
          check_on_times<Thruster>),
      force<PointForce>(
          {{"kind", "point-force"}}, "a force of fixed world direction at a point of the body",
          {required(key<PointForce>("body", &PointForce::body, body_name(), "name of the body")), point<PointForce>(),
           required(key<PointForce>("force_N", &PointForce::force_N, vector3(), "in world axes [N]")),
           on_times<PointForce>()},
          check_on_times<PointForce>),
  };
}

// The word under a tag key; fails with the expected words.
std::string read_tag(Reading& r, const Value& v, const std::string& tag_key, const std::vector<std::string>& words) {
  const Value* found = v.find(tag_key);
  if (!found) fail(r, v.location, "missing key `" + tag_key + "` in " + r.where + "; expected one of " + listed(words));
  r.key = tag_key;
  std::string word;
  choice_of(words).read(r, *found, word);
  r.key.clear();
  return word;
}

}  // namespace

void check_intervals(const Reading& r, const Value& table, const std::vector<Interval>& on_s) {
  for (std::size_t i = 1; i < on_s.size(); ++i)
    if (on_s[i].from_s < on_s[i - 1].to_s)
      fail(r, table.find("on_s")->location,
           "`on_s` in " + r.where + " has an interval that starts at " + describe(Value(on_s[i].from_s)) +
               ", before the one ahead ends at " + describe(Value(on_s[i - 1].to_s)) +
               "; expected intervals in order, apart");
}

const std::vector<Alternative<Force>>& forces() {
  static const std::vector<Alternative<Force>> all = [] {
    std::vector<Alternative<Force>> list = fields();
    for (auto& each : loads()) list.push_back(std::move(each));
    return list;
  }();
  return all;
}

Force read_force(Reading& r, const Value& v) {
  if (!v.table()) fail_value(r, v, "a table");
  const std::string outer = r.where;
  std::vector<const Alternative<Force>*> left;
  for (const auto& alternative : forces()) left.push_back(&alternative);
  for (std::size_t level = 0; left.size() > 1 || level == 0; ++level) {
    std::vector<std::string> words;
    for (const auto* each : left)
      if (std::find(words.begin(), words.end(), each->tags[level].value) == words.end())
        words.push_back(each->tags[level].value);
    if (level == 0 && r.form == Form::file)
      for (const std::string& kind : joint_force_kinds()) words.push_back(kind);
    const std::string word = read_tag(r, v, left.front()->tags[level].key, words);
    std::erase_if(left, [&](const auto* each) { return each->tags[level].value != word; });
    if (level == 0) r.where += " of kind " + word;
  }
  Force out;
  left.front()->read(r, v, out);
  r.where = outer;
  return out;
}

void count_force(Reading& r, SourceLocation location, std::size_t intervals) {
  if (r.scene->forces.size() + r.scene->joint_forces.size() >= kMaxForces)
    fail(r, location, "found more than " + std::to_string(kMaxForces) + " forces; expected fewer");
  if (r.force_times += intervals; r.force_times > kMaxNamed)
    fail(r, location,
         "found more than " + std::to_string(kMaxNamed) + " intervals under `on_s` of all forces together (" +
             std::to_string(r.force_times) + " with this one); expected fewer");
}

void add_force(Reading& r, SourceLocation location, Force force) {
  std::size_t named = 0, intervals = 0;
  std::visit(
      [&]<class T>(const T& one) {
        if constexpr (requires { one.bodies; }) named = one.bodies.size();
        else if constexpr (requires { one.body; }) named = 1;
        else named = r.scene->bodies.size();  // a rotating frame acts on all
        if constexpr (requires { one.on_s; }) intervals = one.on_s.size();
      },
      force);
  count_force(r, location, intervals);
  if (r.named_by_forces += named; r.named_by_forces > kMaxNamed)
    fail(r, location,
         "found forces that name more than " + std::to_string(kMaxNamed) + " bodies together (" +
             std::to_string(r.named_by_forces) + " with this one, each counted once a force); expected fewer");
  r.scene->forces.push_back(std::move(force));
}

void read_forces(Reading& r, const Value& table) {
  const Value* kind = table.find("kind");
  const bool single = kind && kind->text() && (*kind->text() == "thruster" || *kind->text() == "point-force");
  const Value* named = table.find("body") ? table.find("body") : table.find("bodies");
  const bool several =
      single && named &&
      (named->list() || (named->text() && (r.grids.contains(*named->text()) || *named->text() == "all")));
  if (!several || (table.find("body") && table.find("bodies")))
    return add_force(r, table.location, read_force(r, table));
  const std::string outer = r.where;
  std::vector<int> bodies;
  r.where += " of kind " + *kind->text();
  r.key = table.find("body") ? "body" : "bodies";
  body_names(false).read(r, *named, bodies);
  r.where = outer;
  const std::string key = r.key;
  for (const int body : bodies) {
    Value each = table;
    for (Member& member : std::get<Value::Table>(each.data)) {
      if (member.key != key) continue;
      member.value = Value(r.scene->bodies[static_cast<std::size_t>(body)].name);
      member.value.location = named->location;
    }
    add_force(r, table.location, read_force(r, each));
    r.where = outer;
  }
}

Value write_force(const Scene& scene, const Force& from) {
  Value table{Value::Table{}};
  for (const auto& alternative : forces()) {
    if (!alternative.holds(from)) continue;
    for (const Tag& tag : alternative.tags) add(table, tag.key, tag.value);
    alternative.write(scene, from, table);
  }
  return table;
}

Value force_schema(Form form) {
  Value::List options;
  for (const auto& alternative : forces()) {
    Value schema = alternative.schema(form);
    add(schema, "description", alternative.doc);
    options.push_back(std::move(schema));
  }
  if (form == Form::file)
    for (Value& schema : joint_force_schemas(form)) options.push_back(std::move(schema));
  return table_of({{"oneOf", std::move(options)}});
}

}  // namespace atwood
