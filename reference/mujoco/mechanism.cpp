#include "mujoco/mechanism.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::mujoco {
namespace {

using rivals::cross;
using rivals::Motion;
using rivals::operator+;
using rivals::operator-;
using rivals::operator*;
using rivals::Reaction;
using rivals::Wrench;

std::string text(const Real3& v) { return fmt::format("{} {} {}", v[0], v[1], v[2]); }
std::string body_name(int body) { return body < 0 ? "world" : fmt::format("b{}", body); }

// What is tied to a fixed body is tied to the world: MuJoCo's body of a plane has another pose than the scene's.
bool is_ground(const Scene& scene, int body) { return body < 0 || scene.bodies[static_cast<std::size_t>(body)].fixed; }
Placement ground_pose(const Scene& scene, int body) {
  if (body < 0 || !is_ground(scene, body)) return {};
  return {scene.bodies[static_cast<std::size_t>(body)].position_m,
          scene.bodies[static_cast<std::size_t>(body)].orientation_wxyz};
}
Real3 placed(const Placement& frame, const Real3& point) { return frame.p + rivals::to_world(frame.q, point); }

std::string softness_words(const Settings& settings, const char* suffix) {
  const auto number = [&](const char* name) { return rivals::number(settings, name); };
  return fmt::format("solref{0}=\"{1} {2}\" solimp{0}=\"{3} {4} {5} {6} {7}\"", suffix,
                     number("joint_solref_time_constant_s"), number("joint_solref_damping_ratio"),
                     number("joint_solimp_least"), number("joint_solimp_most"), number("solimp_width_m"),
                     number("solimp_midpoint"), number("solimp_power"));
}

// The equality constraints in the order of the scene's closing joints: connects of a hinge lie this far from its
// anchor, along the axis.
double half_span(const Joint& joint) {
  const double lever = std::max(rivals::length(joint.anchors_body_m[0]), rivals::length(joint.anchors_body_m[1]));
  return lever > 0 ? lever : 1.0;
}

// Points of a connect, in the parent's and the child's axes.
struct ConnectPoints {
  Real3 parent{}, child{};
};
std::vector<ConnectPoints> connects_of(const Joint& joint) {
  const auto& [a, b] = joint.anchors_body_m;
  if (joint.kind == JointKind::ball) return {{a, b}};
  if (joint.kind != JointKind::hinge) return {};
  const Real3 in_child = half_span(joint) * joint.axis_body;
  const Real3 in_parent = rivals::to_world(joint.frame_wxyz, in_child);  // F's rotation leaves the axis of the hinge
  return {{a + in_parent, b + in_child}, {a - in_parent, b - in_child}};
}

Real3 real3(const mjtNum* v) { return {v[0], v[1], v[2]}; }

// Forces of the rows of one equality constraint; zeros where it has no rows.
std::vector<double> row_forces(const mjData* data, int equality) {
  std::vector<double> forces;
  for (int i = 0; i < data->nefc; ++i) {
    if (data->efc_type[i] == mjCNSTR_EQUALITY && data->efc_id[i] == equality) forces.push_back(data->efc_force[i]);
  }
  forces.resize(6, 0.0);
  return forces;
}

// Rows of a weld's orientation: e' = 1/2 vec(q_child^* w q_parent F), w = w_parent - w_child, in world axes.
Real3 weld_torque_on_parent(const Joint& joint, const Motion& parent, const Motion& child, const Real3& rows) {
  const Real4 turned = rivals::product(parent.q_WB, joint.frame_wxyz);
  Real3 torque{};
  for (int k = 0; k < 3; ++k) {
    Real4 unit{};
    unit[k + 1] = 1;
    const Real4 column = rivals::product(rivals::product(rivals::conjugate(child.q_WB), unit), turned);
    torque[k] = 0.5 * (rows[0] * column[1] + rows[1] * column[2] + rows[2] * column[3]);
  }
  return torque;
}

// Equality constraints are numbered in the order of constraint_elements.
struct Equalities {
  std::vector<int> first_of_joint;  // -1: no closing joint
  std::vector<int> of_rope;
};
Equalities equalities_of(const Scene& scene) {
  Equalities all;
  int count = 0;
  for (const Joint& joint : scene.joints) {
    all.first_of_joint.push_back(joint.closes_loop ? count : -1);
    if (joint.closes_loop) count += joint.kind == JointKind::hinge ? 2 : 1;
  }
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) all.of_rope.push_back(count++);
  return all;
}

Reaction closing_reaction(const Joint& joint, int equality, const Motion& parent, const Motion& child,
                          const mjData* data) {
  const Real3 anchor = child.p_WB + rivals::to_world(child.q_WB, joint.anchors_body_m[1]);
  Reaction on_child{{0, 0, 0}, {0, 0, 0}};
  if (joint.kind == JointKind::fixed) {
    const std::vector<double> rows = row_forces(data, equality);
    on_child.force_N = {-rows[0], -rows[1], -rows[2]};
    on_child.torque_N_m = -1.0 * weld_torque_on_parent(joint, parent, child, {rows[3], rows[4], rows[5]});
    return on_child;
  }
  for (const ConnectPoints& points : connects_of(joint)) {
    const std::vector<double> rows = row_forces(data, equality++);
    const Real3 force{-rows[0], -rows[1], -rows[2]};
    const Real3 at = child.p_WB + rivals::to_world(child.q_WB, points.child);
    rivals::add(on_child.force_N, force);
    rivals::add(on_child.torque_N_m, cross(at - anchor, force));
  }
  return on_child;
}

double tension_of(const Scene& scene, int rope, const mjData* data) {
  return -row_forces(data, equalities_of(scene).of_rope[static_cast<std::size_t>(rope)])[0];
}

void add_at(Wrench& wrench, const Motion& body, const Real3& point, const Real3& force) {
  rivals::add(wrench.force_N, force);
  rivals::add(wrench.torque_N_m, cross(point - body.p_WB, force));
}

// A contact's frame has its axes in rows; force and torque are on the body of geom2.
void add_contacts(const std::vector<Motion>& motions, const std::vector<int>& body_of_id, const mjModel* model,
                  const mjData* data, std::vector<Wrench>& outer) {
  for (int c = 0; c < data->ncon; ++c) {
    const mjContact& contact = data->contact[c];
    if (contact.efc_address < 0) continue;
    mjtNum along[6], force[3], torque[3];
    mj_contactForce(model, data, c, along);
    mju_rotVecMatT(force, along, contact.frame);
    mju_rotVecMatT(torque, along + 3, contact.frame);
    for (const bool second : {true, false}) {
      const int geom = second ? contact.geom2 : contact.geom1;
      const int body = body_of_id[static_cast<std::size_t>(model->geom_bodyid[geom])];
      if (body < 0) continue;  // the world's: a plane
      const double sign = second ? 1 : -1;
      Wrench& wrench = outer[static_cast<std::size_t>(body)];
      add_at(wrench, motions[static_cast<std::size_t>(body)], real3(contact.pos), sign * real3(force));
      rivals::add(wrench.torque_N_m, sign * real3(torque));
    }
  }
}

// Everything that acts on bodies besides gravity and the joints of the tree.
std::vector<Wrench> outer_wrenches(const Scene& scene, const std::vector<Motion>& motions,
                                   const std::vector<Wrench>& applied, const std::vector<Reaction>& reactions,
                                   const std::vector<int>& body_of_id, const mjModel* model, const mjData* data) {
  std::vector<Wrench> outer = applied;
  outer.resize(scene.bodies.size());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (!joint.closes_loop) continue;
    const Motion& child = motions[static_cast<std::size_t>(joint.child)];
    const Real3 anchor = child.p_WB + rivals::to_world(child.q_WB, joint.anchors_body_m[1]);
    Wrench& on_child = outer[static_cast<std::size_t>(joint.child)];
    add_at(on_child, child, anchor, reactions[j].force_N);
    rivals::add(on_child.torque_N_m, reactions[j].torque_N_m);
    if (joint.parent < 0) continue;
    Wrench& on_parent = outer[static_cast<std::size_t>(joint.parent)];
    add_at(on_parent, motions[static_cast<std::size_t>(joint.parent)], anchor, -1.0 * reactions[j].force_N);
    rivals::add(on_parent.torque_N_m, -1.0 * reactions[j].torque_N_m);
  }
  add_contacts(motions, body_of_id, model, data, outer);
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) {
    const Rope& rope = scene.ropes[r];
    Real3 ends[2];
    for (int k = 0; k < 2; ++k) {
      const Motion& body = motions[static_cast<std::size_t>(rope.bodies[k])];
      ends[k] = body.p_WB + rivals::to_world(body.q_WB, rope.points_body_m[k]);
    }
    const double tension = tension_of(scene, static_cast<int>(r), data);
    for (int k = 0; k < 2; ++k) {
      const Real3 next = rope.over.empty() ? ends[1 - k] : (k == 0 ? rope.over.front() : rope.over.back()).axle_m;
      const Real3 along = next - ends[k];
      add_at(outer[static_cast<std::size_t>(rope.bodies[k])], motions[static_cast<std::size_t>(rope.bodies[k])],
             ends[k], (tension / rivals::length(along)) * along);
    }
  }
  return outer;
}

}  // namespace

std::string refused_mechanism(const Scene& scene) {
  for (const Joint& joint : scene.joints) {
    const std::string named = "; found it on the joint `" + joint.name + "`";
    if (joint.driven_rate) return "MuJoCo has no joint with a prescribed motion" + named;
    if (joint.limits && joint.limits->restitution != 0)
      return "MuJoCo's stops have no restitution: expected stop_restitution = 0 on the joint `" + joint.name + "`";
    const bool can_close =
        joint.kind == JointKind::ball || joint.kind == JointKind::fixed || joint.kind == JointKind::hinge;
    if (!joint.closes_loop) continue;
    if (!can_close) return "MuJoCo's equality constraints close loops only by fixed, hinge and ball joints" + named;
    if (joint.limits) return "MuJoCo has no limits of a joint that closes a loop" + named;
  }
  for (const JointForce& force : scene.joint_forces) {
    const int j = std::visit([](const auto& f) { return f.joint; }, force);
    const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
    if (joint.closes_loop)
      return "MuJoCo has no forces of a joint that closes a loop; found one on `" + joint.name + "`";
  }
  const std::vector<int> placing = rivals::placing_joints(scene);
  if (const int body = rivals::turning_point_mass(scene); body >= 0) {
    const Joint& joint = scene.joints[static_cast<std::size_t>(placing[static_cast<std::size_t>(body)])];
    if (joint.kind != JointKind::fixed)
      return "MuJoCo requires an inertia of the point mass `" + scene.bodies[static_cast<std::size_t>(body)].name +
             "`, which turns with its parent";
  }
  for (const Rope& rope : scene.ropes) {
    for (const Pulley& pulley : rope.over) {
      if (pulley.radius_m != 0 || pulley.inertia_kg_m2 != 0)
        return "MuJoCo's tendons slide over points without friction and turn no pulley: expected points (radius 0) under "
               "the rope `" +
               rope.name + "`";
    }
  }
  return "";
}

Placement placement_at_zero(const Scene& scene, const Joint& joint) {
  const Real3 p = joint.anchors_body_m[0] - rivals::to_world(joint.frame_wxyz, joint.anchors_body_m[1]);
  if (joint.parent < 0 || !scene.bodies[static_cast<std::size_t>(joint.parent)].fixed) return {p, joint.frame_wxyz};
  const Body& parent = scene.bodies[static_cast<std::size_t>(joint.parent)];
  return {parent.position_m + rivals::to_world(parent.orientation_wxyz, p),
          rivals::product(parent.orientation_wxyz, joint.frame_wxyz)};
}

std::string joint_elements(const Scene& scene, const Settings& settings, int j) {
  const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
  std::string xml;
  const auto add = [&](int coordinate, const char* type, const Real3& axis) {
    const rivals::PassiveForce passive = rivals::passive_force(scene, j, coordinate);
    fmt::format_to(std::back_inserter(xml), "<joint name=\"j{}{}\" type=\"{}\" pos=\"{}\"", j, coordinate ? "b" : "",
                   type, text(joint.anchors_body_m[1]));
    if (joint.kind != JointKind::ball) xml += " axis=\"" + text(axis) + "\"";
    if (passive.damping > 0) fmt::format_to(std::back_inserter(xml), " damping=\"{}\"", passive.damping);
    if (passive.stiffness > 0)
      fmt::format_to(std::back_inserter(xml), " stiffness=\"{}\" springref=\"{}\"", passive.stiffness, passive.rest);
    if (joint.limits)
      fmt::format_to(std::back_inserter(xml), " limited=\"true\" range=\"{} {}\" {}", joint.limits->lower,
                     joint.limits->upper, softness_words(settings, "limit"));
    xml += "/>";
  };
  switch (joint.kind) {
    case JointKind::fixed: break;
    case JointKind::hinge: add(0, "hinge", joint.axis_body); break;
    case JointKind::slider: add(0, "slide", joint.axis_body); break;
    case JointKind::cylindrical:
      add(0, "hinge", joint.axis_body);
      add(1, "slide", joint.axis_body);
      break;
    case JointKind::universal:  // axes in the child's frame at coordinates 0
      add(0, "hinge", rivals::to_body(joint.frame_wxyz, joint.axes_body[0]));
      add(1, "hinge", joint.axes_body[1]);
      break;
    case JointKind::ball: add(0, "ball", {}); break;
  }
  return xml;
}

std::string rope_sites(const Scene& scene, int body) {
  std::string xml;
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) {
    const Rope& rope = scene.ropes[r];
    for (int end = 0; end < 2; ++end) {
      const int at = rope.bodies[end];
      if ((is_ground(scene, at) ? -1 : at) != body) continue;
      xml += fmt::format("<site name=\"r{}e{}\" pos=\"{}\"/>", r, end,
                         text(placed(ground_pose(scene, at), rope.points_body_m[end])));
    }
    for (std::size_t p = 0; body < 0 && p < rope.over.size(); ++p)
      xml += fmt::format("<site name=\"r{}p{}\" pos=\"{}\"/>", r, p, text(rope.over[p].axle_m));
  }
  return xml;
}

std::string constraint_elements(const Scene& scene, const Settings& settings) {
  const std::string words = softness_words(settings, "");
  std::string equalities, tendons;
  for (const Joint& joint : scene.joints) {
    if (!joint.closes_loop) continue;
    const int rows = joint.kind == JointKind::hinge ? 2 : 1;
    for (int k = 0; k < rows; ++k)
      equalities +=
          fmt::format("<{} body1=\"{}\" body2=\"{}\" {} {}/>\n", joint.kind == JointKind::fixed ? "weld" : "connect",
                      body_name(is_ground(scene, joint.parent) ? -1 : joint.parent), body_name(joint.child),
                      joint.kind == JointKind::fixed ? "" : "anchor=\"0 0 0\"", words);
  }
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) {
    equalities += fmt::format("<tendon tendon1=\"r{}\" {}/>\n", r, words);
    tendons += fmt::format("<spatial name=\"r{0}\"><site site=\"r{0}e0\"/>", r);
    for (std::size_t p = 0; p < scene.ropes[r].over.size(); ++p)
      tendons += fmt::format("<site site=\"r{}p{}\"/>", r, p);
    tendons += fmt::format("<site site=\"r{}e1\"/></spatial>\n", r);
  }
  if (equalities.empty()) return "";
  return "<equality>\n" + equalities + "</equality>\n" +
         (tendons.empty() ? "" : "<tendon>\n" + tendons + "</tendon>\n");
}

std::string excluded_pairs(const Scene& scene) {
  std::string xml;
  for (const Joint& joint : scene.joints) {
    if (joint.parent >= 0)
      xml += fmt::format("<exclude body1=\"{}\" body2=\"{}\"/>\n", body_name(joint.parent), body_name(joint.child));
  }
  return xml;
}

int constraint_rows(const Scene& scene) {
  int rows = static_cast<int>(scene.ropes.size());
  for (const Joint& joint : scene.joints) rows += (joint.closes_loop ? 6 : 0) + (joint.limits ? 1 : 0);
  return rows;
}

void set_constraints(const Scene& scene, mjModel* model, mjData* data) {
  const Equalities numbers = equalities_of(scene);
  const auto put = [&](int equality, int at, const auto& values) {
    for (std::size_t k = 0; k < values.size(); ++k)
      model->eq_data[mjNEQDATA * equality + at + static_cast<int>(k)] = values[k];
  };
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    int equality = numbers.first_of_joint[j];
    if (equality < 0) continue;
    const Placement base = ground_pose(scene, joint.parent);
    if (joint.kind == JointKind::fixed) {  // anchor in the child; anchor and orientation of the child in the parent
      put(equality, 0, joint.anchors_body_m[1]);
      put(equality, 3, placed(base, joint.anchors_body_m[0]));
      put(equality, 6, rivals::product(base.q, joint.frame_wxyz));
    }
    for (const ConnectPoints& points : connects_of(joint)) {
      put(equality, 0, placed(base, points.parent));
      put(equality, 3, points.child);
      ++equality;
    }
  }
  if (scene.ropes.empty()) return;
  mj_fwdPosition(model, data);
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) model->tendon_length0[r] = data->ten_length[r];
}

void set_softness(const Settings& settings, double h_s, mjModel* model) {
  const double steps = rivals::number(settings, "joint_solref_time_constant_steps");
  if (steps == 0) return;
  for (int e = 0; e < model->neq; ++e) model->eq_solref[mjNREF * e] = steps * h_s;
  for (int j = 0; j < model->njnt; ++j) model->jnt_solref[mjNREF * j] = steps * h_s;
}

std::vector<int> joint_ids(const Scene& scene, const mjModel* model) {
  std::vector<int> ids;
  for (std::size_t j = 0; j < scene.joints.size(); ++j)
    ids.push_back(mj_name2id(model, mjOBJ_JOINT, fmt::format("j{}", j).c_str()));
  return ids;
}

rivals::JointState joint_of(JointKind kind, int joint_id, const mjModel* model, const mjData* data) {
  rivals::JointState state;
  std::copy_n(data->qpos + model->jnt_qposadr[joint_id], coordinate_count(kind), state.q.begin());
  std::copy_n(data->qvel + model->jnt_dofadr[joint_id], rate_count(kind), state.u.begin());
  return state;
}

void set_joint(JointKind kind, int joint_id, const rivals::JointState& state, const mjModel* model, mjData* data) {
  std::copy_n(state.q.begin(), coordinate_count(kind), data->qpos + model->jnt_qposadr[joint_id]);
  std::copy_n(state.u.begin(), rate_count(kind), data->qvel + model->jnt_dofadr[joint_id]);
}

// m a = f + gravity + reactions; mj_objectAcceleration is a - gravity, of the centre of mass.
std::vector<Reaction> reactions_of(const Scene& scene, const std::vector<int>& body_ids,
                                   const std::vector<Motion>& motions, const std::vector<Wrench>& wrenches,
                                   const mjModel* model, const mjData* data) {
  const Equalities numbers = equalities_of(scene);
  std::vector<Reaction> reactions(scene.joints.size());
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop)
      reactions[j] = closing_reaction(joint, numbers.first_of_joint[j], rivals::motion_of(motions, joint.parent),
                                      rivals::motion_of(motions, joint.child), data);
  }
  std::vector<int> body_of_id(static_cast<std::size_t>(model->nbody), -1);
  for (std::size_t i = 0; i < body_ids.size(); ++i)
    body_of_id[static_cast<std::size_t>(body_ids[i])] = static_cast<int>(i);
  std::vector<Wrench> missing = outer_wrenches(scene, motions, wrenches, reactions, body_of_id, model, data);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    mjtNum acceleration[6];
    mj_objectAcceleration(model, data, mjOBJ_BODY, body_ids[i], acceleration, 0);
    const Real33& inertia = body.inertia_kg_m2;
    const Real3 alpha = rivals::to_body(motions[i].q_WB, real3(acceleration)), &w = motions[i].w_WB_B;
    const Real3 rate = rivals::times(inertia, alpha) + cross(w, rivals::times(inertia, w));
    missing[i].force_N = body.mass_kg * real3(acceleration + 3) - missing[i].force_N;
    missing[i].torque_N_m = rivals::to_world(motions[i].q_WB, rate) - missing[i].torque_N_m;
  }
  return rivals::subtree_reactions(scene, motions, missing, reactions);
}

std::vector<RopeSample> ropes_of(const Scene& scene, const mjData* data) {
  std::vector<RopeSample> samples;
  for (std::size_t r = 0; r < scene.ropes.size(); ++r) {
    RopeSample sample;
    sample.tension_N = tension_of(scene, static_cast<int>(r), data);
    for (const Pulley& pulley : scene.ropes[r].over) sample.pulley_angle_rad.push_back(pulley.angle_rad);
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace atwood::mujoco
