// Joints in the worlds of rival engines: coordinates from poses, the forces of joints that an engine lacks, and the
// part of a force between two bodies that is a reaction. Notation and kinds as in scene/joint.hpp.
#pragma once

#include <array>
#include <limits>
#include <string>
#include <vector>

#include "rivals/applied_forces.hpp"
#include "scene/scene.hpp"

namespace atwood::rivals {

struct JointState {
  Real4 q{};  // the first coordinate_count() of them
  Real3 u{};  // the first rate_count() of them
};

// Force on the child at its anchor and torque about it, world axes. NaN: not reported.
struct Reaction {
  Real3 force_N{std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::quiet_NaN(),
                std::numeric_limits<double>::quiet_NaN()};
  Real3 torque_N_m = force_N;
};

inline bool has_mechanism(const Scene& scene) { return !scene.joints.empty() || !scene.ropes.empty(); }

// The joint that places each body, -1: none (free bodies, fixed bodies).
std::vector<int> placing_joints(const Scene& scene);
// All bodies, the parent of a placed body ahead of it; otherwise in the scene's order.
std::vector<int> parents_first(const Scene& scene);

// Whether a joint connects the two bodies: they do not collide.
bool joined(const Scene& scene, int body_a, int body_b);

// The motion of the scene's start; of the world (-1): at rest at the origin.
Motion motion_at_start(const Scene& scene, int body);
inline Motion motion_of(const std::vector<Motion>& motions, int body) {
  return body < 0 ? Motion{} : motions[static_cast<std::size_t>(body)];
}

// Coordinates and rates that the motions of its bodies give a joint. Angles lie in [-pi, pi].
JointState state_from_motions(const Joint& joint, const Motion& parent, const Motion& child);

// The coordinates of `now` that continue those of `last`: whole turns are added to angles, and the sign of a ball's
// quaternion is that of `last`. Right if no angle changed by half a turn since.
void continue_coordinates(JointKind kind, const JointState& last, JointState& now);

// The point where a joint acts and its axes, in world axes: of hinge, slider and cylindrical one axis, of universal
// two.
struct JointPlace {
  Real3 parent_anchor_m{}, child_anchor_m{};
  std::array<Real3, 2> axes{};
};
JointPlace place_of(const Joint& joint, const Motion& parent, const Motion& child);

// All springs and dampers of one coordinate as one: stiffness = sum of k_i, rest = sum of k_i rest_i / stiffness.
struct PassiveForce {
  double stiffness = 0, rest = 0, damping = 0;
};
PassiveForce passive_force(const Scene& scene, int joint, int coordinate);

// What motors of the scene apply along each rate of each joint [N m or N], at time t_s; they are on or off as they are
// at t_switch_s.
std::vector<Real3> motor_efforts(const Scene& scene, double t_s, double t_switch_s);

// What springs, dampers and motors of the scene apply along each rate of each joint [N m or N], at time t_s; motors are
// on or off as they are at t_switch_s.
std::vector<Real3> joint_efforts(const Scene& scene, double t_s, double t_switch_s,
                                 const std::vector<JointState>& states);

// Adds the efforts to the wrenches of both bodies of each joint, for engines that have no forces along coordinates.
void add_joint_wrenches(const Scene& scene, const std::vector<Motion>& motions, const std::vector<Real3>& efforts,
                        std::vector<Wrench>& wrenches);

// The constraints' part of everything that a joint transmits to its child: what has no power along the free rates. A
// joint whose motion is prescribed has no free rate.
Reaction constraint_part(const Joint& joint, const JointPlace& place, const Reaction& total);

// Reactions of the joints of the tree by Newton's and Euler's equations of each subtree. `missing` is, for each body,
// what its motion requires (m a, I alpha + w x I w about its centre of mass) less all that acts on it besides the
// joints of the tree. `reactions` has those of closing joints, and is returned with the others filled in.
std::vector<Reaction> subtree_reactions(const Scene& scene, const std::vector<Motion>& motions,
                                        std::vector<Wrench> missing, std::vector<Reaction> reactions);

// The kinds of joint forces in this scene, as "joint-spring, joint-torque"; empty: none.
std::string names_of_joint_forces(const Scene& scene);

// A point mass that turns with its parent: its inertia is zero, which most engines do not admit; -1: none.
int turning_point_mass(const Scene& scene);

// A point mass that no joint places but some joint moves: engines would turn it; -1: none.
int jointed_point_mass(const Scene& scene);

}  // namespace atwood::rivals
