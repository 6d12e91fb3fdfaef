#include "mujoco/import_notes.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <iterator>

#include "protocol/sample.hpp"

namespace atwood::mujoco {
namespace {

struct Flag {
  int bit;
  const char *name, *effect;
};

// MuJoCo's documentation, XML reference, <option><flag>.
constexpr Flag kDisabled[] = {
    {mjDSBL_CONSTRAINT, "constraint", ": joints have no stops, and equality constraints close no loops"},
    {mjDSBL_EQUALITY, "equality", ": equality constraints close no loops"},
    {mjDSBL_FRICTIONLOSS, "frictionloss", ""},
    {mjDSBL_LIMIT, "limit", ": joints have no stops"},
    {mjDSBL_CONTACT, "contact", ""},
    {mjDSBL_PASSIVE, "passive", ": joints have no springs and dampers"},
    {mjDSBL_CLAMPCTRL, "clampctrl", ""},
    {mjDSBL_WARMSTART, "warmstart", ""},
    {mjDSBL_FILTERPARENT, "filterparent", ""},
    {mjDSBL_ACTUATION, "actuation", ""},
    {mjDSBL_REFSAFE, "refsafe", ""},
    {mjDSBL_SENSOR, "sensor", ""},
};
constexpr Flag kEnabled[] = {
    {mjENBL_OVERRIDE, "override", ""},       {mjENBL_ENERGY, "energy", ""},     {mjENBL_FWDINV, "fwdinv", ""},
    {mjENBL_SENSORNOISE, "sensornoise", ""}, {mjENBL_MULTICCD, "multiccd", ""},
};
static_assert(std::size(kDisabled) + 1 == mjNDISABLE && std::size(kEnabled) == mjNENABLE);  // and gravity

// The first of n numbers that is not finite, in words.
std::string bad_number(const mjtNum* numbers, int n, const char* what, const std::string& owner) {
  for (int i = 0; i < n; ++i)
    if (!std::isfinite(numbers[i])) return fmt::format("the {} of {} is {}", what, owner, format_double(numbers[i]));
  return "";
}

struct Numbers {
  const mjtNum* all;
  int width;
  const char* what;
};

// The first of `numbers` of the element `id` that is not finite.
template <std::size_t n>
std::string bad_element(const std::array<Numbers, n>& numbers, int id, const std::string& owner) {
  for (const Numbers& each : numbers)
    if (const std::string bad = bad_number(each.all + each.width * id, each.width, each.what, owner); !bad.empty())
      return bad;
  return "";
}

std::string bad_joint(const mjModel& m, int j) {
  const std::string owner = fmt::format("the joint `{}`", name_of(m, mjOBJ_JOINT, j, "joint"));
  const std::array<Numbers, 4> own{{{m.jnt_pos, 3, "position"},
                                    {m.jnt_axis, 3, "axis"},
                                    {m.jnt_range, 2, "range"},
                                    {m.jnt_stiffness, 1, "stiffness"}}};
  if (const std::string bad = bad_element(own, j, owner); !bad.empty()) return bad;
  const std::array<Numbers, 3> of_dof{
      {{m.dof_damping, 1, "damping"}, {m.dof_armature, 1, "armature"}, {m.dof_frictionloss, 1, "frictionloss"}}};
  if (const std::string bad = bad_element(of_dof, m.jnt_dofadr[j], owner); !bad.empty()) return bad;
  const int first = m.jnt_qposadr[j], count = std::array{7, 4, 1, 1}.at(static_cast<std::size_t>(m.jnt_type[j]));
  if (const std::string bad = bad_number(m.qpos0 + first, count, "ref", owner); !bad.empty()) return bad;
  return bad_number(m.qpos_spring + first, count, "springref", owner);
}

// "3 sites: a, b, site2".
void note_all(const mjModel& m, std::vector<std::string>& notes, int count, int type, const char* kind) {
  if (count == 0) return;
  std::string names;
  for (int i = 0; i < count; ++i) names += (i == 0 ? "" : ", ") + name_of(m, type, i, kind);
  notes.push_back(fmt::format("{} {}s: {}", count, kind, names));
}

void note_tendon(const mjModel& m, std::vector<std::string>& notes, int t) {
  std::string parts;
  const auto part = [&](bool there, const char* what) {
    if (there) parts += (parts.empty() ? ", with its " : ", ") + std::string(what);
  };
  part(m.tendon_stiffness[t] != 0, "stiffness");
  part(m.tendon_damping[t] != 0, "damping");
  part(m.tendon_frictionloss[t] != 0, "frictionloss");
  part(m.tendon_limited[t] != 0, "range");
  notes.push_back(fmt::format("the tendon {}{}", name_of(m, mjOBJ_TENDON, t, "tendon"), parts));
}

}  // namespace

std::string name_of(const mjModel& model, int type, int id, const char* kind) {
  const char* name = mj_id2name(&model, type, id);
  return name && *name ? name : fmt::format("{}{}", kind, id);
}

bool disabled(const mjModel& model, int flag) {
  const bool part = flag == mjDSBL_LIMIT || flag == mjDSBL_EQUALITY || flag == mjDSBL_FRICTIONLOSS;
  return (model.opt.disableflags & (flag | (part ? mjDSBL_CONSTRAINT : 0))) != 0;
}

std::string not_finite(const mjModel& m) {
  if (const std::string bad = bad_number(m.opt.gravity, 3, "gravity", "<option>"); !bad.empty()) return bad;
  const std::array<Numbers, 6> of_body{{{m.body_pos, 3, "position"},
                                        {m.body_quat, 4, "orientation"},
                                        {m.body_ipos, 3, "centre of mass"},
                                        {m.body_iquat, 4, "orientation of the inertia"},
                                        {m.body_mass, 1, "mass"},
                                        {m.body_inertia, 3, "inertia"}}};
  for (int b = 1; b < m.nbody; ++b)
    if (const std::string bad =
            bad_element(of_body, b, fmt::format("the body `{}`", name_of(m, mjOBJ_BODY, b, "body")));
        !bad.empty())
      return bad;
  for (int j = 0; j < m.njnt; ++j)
    if (const std::string bad = bad_joint(m, j); !bad.empty()) return bad;
  const std::array<Numbers, 1> of_equality{{{m.eq_data, mjNEQDATA, "data"}}};
  for (int e = 0; e < m.neq; ++e)
    if (const std::string bad = bad_element(
            of_equality, e, fmt::format("the equality constraint `{}`", name_of(m, mjOBJ_EQUALITY, e, "equality")));
        !bad.empty())
      return bad;
  return "";
}

std::vector<std::string> flag_notes(const mjModel& model) {
  std::vector<std::string> notes;
  for (const Flag& flag : kDisabled)
    if ((model.opt.disableflags & flag.bit) != 0)
      notes.push_back(fmt::format("the flag {}=\"disable\"{}", flag.name, flag.effect));
  for (const Flag& flag : kEnabled)
    if ((model.opt.enableflags & flag.bit) != 0) notes.push_back(fmt::format("the flag {}=\"enable\"", flag.name));
  return notes;
}

std::vector<std::string> joint_notes(const mjModel& m, int joint, bool alone) {
  const int type = m.jnt_type[joint], dof = m.jnt_dofadr[joint];
  const bool scalar = type == mjJNT_HINGE || type == mjJNT_SLIDE, passive = !disabled(m, mjDSBL_PASSIVE);
  const std::string kind = scalar ? "" : type == mjJNT_BALL ? "ball " : "free ";
  std::vector<std::string> notes;
  const auto note = [&](bool there, const char* what, const char* why = "") {
    if (there)
      notes.push_back(
          fmt::format("the {} of the {}joint {}{}", what, kind, name_of(m, mjOBJ_JOINT, joint, "joint"), why));
  };
  if (m.jnt_limited[joint] != 0 && !disabled(m, mjDSBL_LIMIT)) {
    const bool stops = scalar && alone;
    note(!stops, "range", ": only hinges and sliders have stops");
    note(stops && m.jnt_margin[joint] != 0, "margin");
  }
  note(passive && !scalar && m.jnt_stiffness[joint] != 0, "stiffness");
  note(passive && type == mjJNT_FREE && m.dof_damping[dof] != 0, "damping");
  note(m.dof_armature[dof] != 0, "armature");
  note(!disabled(m, mjDSBL_FRICTIONLOSS) && m.dof_frictionloss[dof] != 0, "frictionloss");
  return notes;
}

std::vector<std::string> remaining_notes(const mjModel& m) {
  std::vector<std::string> notes;
  const auto counted = [&](int count, const char* what) {
    if (count > 0) notes.push_back(fmt::format("{} {}", count, what));
  };
  counted(m.ngeom, "geoms: bodies have no shapes and do not collide");
  counted(m.npair + m.nexclude, "pairs and excludes of <contact>");
  note_all(m, notes, m.nu, mjOBJ_ACTUATOR, "actuator");
  for (int t = 0; t < m.ntendon; ++t) note_tendon(m, notes, t);
  note_all(m, notes, m.nsite, mjOBJ_SITE, "site");
  note_all(m, notes, m.nsensor, mjOBJ_SENSOR, "sensor");
  counted(m.ncam, "cameras");
  counted(m.nlight, "lights");
  counted(m.nskin, "skins");
  counted(m.nnumeric + m.ntext + m.ntuple, "fields of <custom>");
  counted(m.nkey, "keyframes: the start is qpos0, at rest");
  counted(m.nmocap, "mocap bodies: they stand still");
  if (m.opt.density != 0 || m.opt.viscosity != 0) notes.push_back("density and viscosity of the medium");
  return notes;
}

}  // namespace atwood::mujoco
