// The keys of joints, ropes and the forces along joints, in both forms, and the checks that span keys.
#pragma once

#include "scene/scenario_keys.hpp"

namespace atwood {

// A joint as it is written. Angles and offsets of a file become coordinates once its kind is known.
struct JointDraft : Joint {
  std::vector<double> angle_rad, rate_rad_per_s;
  std::optional<double> offset_m, rate_m_per_s;
  std::optional<Real4> orientation;
  std::optional<Real3> angular_velocity;
  std::optional<Real2> limits_rad, limits_m;
  std::optional<double> stop_restitution, driven_rate_rad_per_s, driven_rate_m_per_s;
  std::vector<double> resolved_coordinates, resolved_rates;
  const Value* hold_names = nullptr;  // read once all joints have names
};

const Keys<JointDraft>& joint_keys();
const Keys<Rope>& rope_keys();
JointDraft draft_of(const Joint& joint);
const char* to_word(JointKind kind);  // "hinge"

// The checks of one joint or rope that need no other: both forms. `keys` are those of the joint's table.
void finish_joint(Reading& r, const Value& table, JointDraft& joint);
void finish_rope(Reading& r, const Value& table, Rope& rope);

// [[joint]] and [[rope]] of a file, once its bodies are there: read, checked, placed, projected. Throws InputError.
void resolve_mechanisms(Reading& r, const FileDraft& draft);
// "joints" and "ropes" of a resolved scene, whose start is taken as it stands; names and the order of placing are
// checked.
void read_resolved_joints(Reading& r, const Value& list);
void read_resolved_ropes(Reading& r, const Value& list);

// ---- forces along joints, [[force]] with kind joint-spring or joint-torque ----------------------------------------
bool is_joint_force(const Value& table);
const std::vector<std::string>& joint_force_kinds();
void add_joint_force(Reading& r, const Value& table);
Value write_joint_force(const Scene& scene, const JointForce& force);
// One for each kind, to join those of the other forces.
Value::List joint_force_schemas(Form form);

}  // namespace atwood
