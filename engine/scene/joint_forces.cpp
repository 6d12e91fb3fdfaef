// Springs, dampers and torques along a joint's coordinate: [[force]] with kind joint-spring or joint-torque.
#include "scene/joint_keys.hpp"

namespace atwood {
namespace {

const Joint& joint_of(const Scene& scene, int joint) { return scene.joints.at(static_cast<std::size_t>(joint)); }

// Whether a coordinate is an offset [m]; else it is an angle.
bool is_offset(const Joint& joint, int coordinate) {
  return joint.kind == JointKind::slider || (joint.kind == JointKind::cylindrical && coordinate == 1);
}

// A number under the name with the unit of the coordinate: the name with the other unit is refused.
template <class T> Key<T> with_unit(std::string name, double T::*member, bool of_offset, Range range, std::string doc) {
  Key<T> k = key<T>(std::move(name), member, number(std::move(range)), std::move(doc));
  k.write = [write = k.write, of_offset](const Scene& s, const T& from) {
    return is_offset(joint_of(s, from.joint), from.coordinate) == of_offset ? write(s, from) : Value();
  };
  return k;
}

template <class T> Keys<T> target_keys() {
  Key<T> coordinate;
  const auto codec = integer(0, 1);
  coordinate.name = "coordinate", coordinate.schema = codec.schema;
  coordinate.doc = "cylindrical: 0 the angle, 1 the offset; universal: 0 the first angle, 1 the second; 0 unless given";
  coordinate.read = [codec](Reading& r, const Value& v, T& out) {
    std::int64_t found = 0;
    codec.read(r, v, found);
    out.coordinate = static_cast<int>(found);
  };
  coordinate.write = [](const Scene& s, const T& from) {
    return rate_count(joint_of(s, from.joint).kind) == 2 ? Value(from.coordinate) : Value();
  };
  return {required(key<T>("joint", &T::joint, joint_name(), "name of the joint")), coordinate};
}

const Keys<JointSpring>& spring_keys() {
  static const Keys<JointSpring> keys = [] {
    Keys<JointSpring> all = target_keys<JointSpring>();
    for (auto& k : Keys<JointSpring>{
             with_unit("stiffness_N_m_per_rad", &JointSpring::stiffness, false, non_negative(),
                       "of an angle [N m/rad]; 0 unless given"),
             with_unit("stiffness_N_per_m", &JointSpring::stiffness, true, non_negative(),
                       "of an offset [N/m]; 0 unless given"),
             with_unit("rest_rad", &JointSpring::rest, false, any_number(),
                       "the angle without torque [rad]; 0 unless given"),
             with_unit("rest_m", &JointSpring::rest, true, any_number(),
                       "the offset without force [m]; 0 unless given"),
             with_unit("damping_N_m_s_per_rad", &JointSpring::damping, false, non_negative(),
                       "of an angle, and of a ball's relative angular velocity [N m s/rad]; 0 unless given"),
             with_unit("damping_N_s_per_m", &JointSpring::damping, true, non_negative(),
                       "of an offset [N s/m]; 0 unless given")})
      all.push_back(std::move(k));
    return all;
  }();
  return keys;
}

const Keys<JointTorque>& torque_keys() {
  static const Keys<JointTorque> keys = [] {
    Keys<JointTorque> all = target_keys<JointTorque>();
    for (auto& k : Keys<JointTorque>{
             with_unit("torque_N_m", &JointTorque::torque, false, any_number(), "along an angle, on the child [N m]"),
             with_unit("force_N", &JointTorque::torque, true, any_number(), "along an offset, on the child [N]"),
             key<JointTorque>("angular_frequency_rad_per_s", &JointTorque::angular_frequency_rad_per_s, number(),
                              "w of torque cos(w t + phase) [rad/s]; 0, a constant torque, unless given"),
             key<JointTorque>("phase_rad", &JointTorque::phase_rad, number(), "phase [rad]; 0 unless given"),
             key<JointTorque>("on_s", &JointTorque::on_s, list_of(interval(), 4096),
                              "when it acts: [from, to) pairs [s], in order; always unless given")})
      all.push_back(std::move(k));
    return all;
  }();
  return keys;
}

const std::vector<std::string> kForceKinds = {"joint-spring", "joint-torque"};  // as in JointForce

// What a joint of this kind cannot take, and units of the other kind of coordinate.
template <class T> void check_target(Reading& r, const Value& table, const T& force) {
  const Joint& joint = joint_of(*r.scene, force.joint);
  const std::string named = "the joint `" + joint.name + "`";
  const Value& at = *table.find("joint");
  if (joint.kind == JointKind::fixed)
    fail(r, at.location, "`joint` in " + r.where + " names " + named + ", which is fixed; expected one that moves");
  if (joint.driven_rate)
    fail(r, at.location,
         "`joint` in " + r.where + " names " + named + ", whose motion is prescribed, so that it would never act; " +
             "expected a joint without a driven rate");
  if (force.coordinate >= rate_count(joint.kind) || (joint.kind == JointKind::ball && table.find("coordinate")))
    fail(r, table.find("coordinate")->location,
         "`coordinate` in " + r.where + " is given for " + named + ", a " + to_word(joint.kind) +
             "; expected it with cylindrical and universal joints only");
  const bool offset = is_offset(joint, force.coordinate);
  for (const char* name : {"stiffness_N_m_per_rad", "rest_rad", "damping_N_m_s_per_rad", "torque_N_m"})
    if (const Value* given = table.find(name); given && offset)
      fail(r, given->location,
           std::string("`") + name + "` in " + r.where + " is given for an offset of " + named +
               "; expected newtons and metres: stiffness_N_per_m, rest_m, damping_N_s_per_m, force_N");
  for (const char* name : {"stiffness_N_per_m", "rest_m", "damping_N_s_per_m", "force_N"})
    if (const Value* given = table.find(name); given && !offset)
      fail(r, given->location,
           std::string("`") + name + "` in " + r.where + " is given for an angle of " + named +
               "; expected radians: stiffness_N_m_per_rad, rest_rad, damping_N_m_s_per_rad, torque_N_m");
}

JointSpring read_spring(Reading& r, const Value& table) {
  JointSpring spring;
  read_table(r, table, spring_keys(), {"kind"}, spring);
  check_target(r, table, spring);
  const Joint& joint = joint_of(*r.scene, spring.joint);
  if (joint.kind == JointKind::ball && r.form == Form::file)
    for (const char* name : {"stiffness_N_m_per_rad", "rest_rad"})
      if (const Value* given = table.find(name))
        fail(r, given->location,
             std::string("`") + name + "` in " + r.where + " is given for the ball joint `" + joint.name +
                 "`, which has no angle; expected only damping_N_m_s_per_rad");
  const bool offset = is_offset(joint, spring.coordinate);
  if (r.form == Form::file && !table.find(offset ? "stiffness_N_per_m" : "stiffness_N_m_per_rad") &&
      !table.find(offset ? "damping_N_s_per_m" : "damping_N_m_s_per_rad"))
    fail(r, table.location,
         std::string("found neither a stiffness nor a damping in ") + r.where + "; expected " +
             (offset ? "stiffness_N_per_m or damping_N_s_per_m" : "stiffness_N_m_per_rad or damping_N_m_s_per_rad"));
  return spring;
}

JointTorque read_torque(Reading& r, const Value& table) {
  JointTorque torque;
  read_table(r, table, torque_keys(), {"kind"}, torque);
  check_target(r, table, torque);
  const Joint& joint = joint_of(*r.scene, torque.joint);
  if (joint.kind == JointKind::ball)
    fail(r, table.find("joint")->location,
         "`joint` in " + r.where + " names the ball joint `" + joint.name +
             "`, which has no angle to turn; expected a hinge, slider, cylindrical or universal joint");
  const char* needed = is_offset(joint, torque.coordinate) ? "force_N" : "torque_N_m";
  if (!table.find(needed))
    fail(r, table.location, std::string("missing key `") + needed + "` in " + r.where + "; expected its size");
  check_intervals(r, table, torque.on_s);
  return torque;
}

template <class T> Value schema_of_kind(const std::string& kind, const Keys<T>& keys, Form form, const char* doc) {
  Value properties{Value::Table{}};
  Value::List needed{Value("kind")};
  add(properties, "kind", table_of({{"const", kind}}));
  schema_of(keys, form, properties, needed);
  Value schema = object_schema(std::move(properties), std::move(needed));
  add(schema, "description", doc);
  return schema;
}

}  // namespace

const std::vector<std::string>& joint_force_kinds() { return kForceKinds; }

bool is_joint_force(const Value& table) {
  const Value* kind = table.find("kind");
  return kind && kind->text() && (*kind->text() == kForceKinds[0] || *kind->text() == kForceKinds[1]);
}

namespace {

JointForce read_joint_force(Reading& r, const Value& table) {
  if (!is_joint_force(table)) {
    const Value* kind = table.find("kind");
    fail(r, kind ? kind->location : table.location,
         "found no kind of a force along a joint in " + r.where + "; expected one of " + listed(kForceKinds));
  }
  const std::string outer = r.where;
  r.where += " of kind " + *table.find("kind")->text();
  JointForce force;
  if (*table.find("kind")->text() == kForceKinds[0]) force = read_spring(r, table);
  else force = read_torque(r, table);
  r.where = outer;
  return force;
}

}  // namespace

void add_joint_force(Reading& r, const Value& table) {
  JointForce force = read_joint_force(r, table);
  const auto* torque = std::get_if<JointTorque>(&force);
  count_force(r, table.location, torque ? torque->on_s.size() : 0);
  r.scene->joint_forces.push_back(force);
}

Value write_joint_force(const Scene& scene, const JointForce& force) {
  Value table{Value::Table{}};
  add(table, "kind", kForceKinds[force.index()]);
  if (const auto* spring = std::get_if<JointSpring>(&force)) write_table(scene, *spring, spring_keys(), table);
  else write_table(scene, std::get<JointTorque>(force), torque_keys(), table);
  return table;
}

Value::List joint_force_schemas(Form form) {
  return {schema_of_kind(kForceKinds[0], spring_keys(), form,
                         "-stiffness (q - rest) - damping q' along a joint's coordinate"),
          schema_of_kind(kForceKinds[1], torque_keys(), form,
                         "torque cos(w t + phase) along a joint's coordinate, while on")};
}

}  // namespace atwood
