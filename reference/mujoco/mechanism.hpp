// Joints and ropes of a scene in MuJoCo's terms. Conventions of MuJoCo 2.2:
//   - the tree of joints is the tree of <body> elements: a child stands in its parent as at coordinates 0, and its
//     anchor and axes are in its own frame. A fixed joint is a body without joints, universal and cylindrical are two
//     joints of
//     one body; qpos is then the scene's coordinates, and the rates of a ball are in the child's axes, as in the scene;
//   - a closing joint is an equality constraint: ball `connect`, fixed `weld`, hinge two `connect` at points of the
//     axis. A rope over fixed points is the equality of a tendon through sites. These constraints and the limits of
//     joints are
//     soft: solref and solimp say how soft;
//   - joint springs and dampers are MuJoCo's own; Euler is implicit in the damping. Motors are evaluated by the adapter
//     at each evaluation of forces (mjcb_passive);
//   - reactions come from MuJoCo's accelerations by Newton's and Euler's equations of each subtree. Its own cfrc_int
//     has twice the torque of a weld and nothing of a tendon.
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "rivals/joints.hpp"

namespace atwood::mujoco {

// Why MuJoCo cannot represent the scene's joints and ropes; empty when it can.
std::string refused_mechanism(const Scene& scene);

// ---- the model ----------------------------------------------------------------------------------------------------
// The pose of a placed body at coordinates 0 in its parent's frame; in the world's where the parent is fixed or the
// world.
struct Placement {
  Real3 p{};
  Real4 q{1, 0, 0, 0};
};
Placement placement_at_zero(const Scene& scene, const Joint& joint);

std::string joint_elements(const Scene& scene, const Settings& settings, int joint);
std::string rope_sites(const Scene& scene, int body);  // in this body's element; -1: in the world's
std::string constraint_elements(const Scene& scene, const Settings& settings);  // <equality> and <tendon>
std::string excluded_pairs(const Scene& scene);  // <exclude>: bodies with a common joint do not collide
int constraint_rows(const Scene& scene);         // most rows of closing joints, ropes and limits

// MuJoCo finds the points of a connect and the length of a tendon from the poses at coordinates 0, where loops are open
// and ropes have other lengths. These are the scene's; the state of `data` is that of the start.
void set_constraints(const Scene& scene, mjModel* model, mjData* data);
// The time constant of the softness, where it is a number of steps.
void set_softness(const Settings& settings, double h_s, mjModel* model);

// ---- the state ----------------------------------------------------------------------------------------------------
// MuJoCo's number of the first joint of each joint of the scene; -1: it has none (fixed joints, joints that close
// loops).
std::vector<int> joint_ids(const Scene& scene, const mjModel* model);
rivals::JointState joint_of(JointKind kind, int joint_id, const mjModel* model, const mjData* data);
void set_joint(JointKind kind, int joint_id, const rivals::JointState& state, const mjModel* model, mjData* data);

// `data` after mj_forward and mj_rnePostConstraint, with `wrenches` in xfrc_applied.
std::vector<rivals::Reaction> reactions_of(const Scene& scene, const std::vector<int>& body_ids,
                                           const std::vector<rivals::Motion>& motions,
                                           const std::vector<rivals::Wrench>& wrenches, const mjModel* model,
                                           const mjData* data);
std::vector<RopeSample> ropes_of(const Scene& scene, const mjData* data);

}  // namespace atwood::mujoco
