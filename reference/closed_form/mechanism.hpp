// What the closed forms of mechanisms share: poses of bodies from coordinates of joints, and reactions from the motion.
//
// A solution gives coordinates, rates and their derivatives of every joint. Poses, velocities and accelerations of the
// bodies follow along the tree of placing joints (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 4.4),
// and the wrenches of all joints from the Newton-Euler equations of all bodies, taken as linear equations for them.
// These equations outnumber the unknowns by the degrees of freedom: a motion that does not solve the equations of
// motion leaves a residual, and is refused.
#pragma once

#include <string>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct BodyKinematics {
  Pose<S> pose;
  Vec<S> a_W{}, w_W{}, alpha_W{};  // acceleration of the centre, angular velocity and acceleration, world axes
};

// Unit vector along `given` in S.
template <class S> Vec<S> unit(const Real3& given);

// Poses, velocities and accelerations of all bodies of a scene; free bodies without a placing joint stay as they start.
template <class S>
std::vector<BodyKinematics<S>> place_bodies(const Scene& scene, const std::vector<JointState<S>>& joints);

// Fills applied, force_N, torque_N_m and not_unique of all joints. Components that the equations leave open are NaN.
// Answers the largest residual of the equations over the largest of their terms.
template <class S>
S solve_reactions(const Scene& scene, const std::vector<BodyKinematics<S>>& bodies, S t_s,
                  std::vector<JointState<S>>& joints);

// The springs, dampers and motors at a joint's coordinate, along its rate.
template <class S> S applied_at(const Scene& scene, int joint, int coordinate, S q, S u, S t_s);

// The motion of a mechanism whose joints move as `joints_at` says. Every free body has a placing joint.
template <class S, class JointsAt>
Motion<S> move_mechanism(const Scenario& scenario, const std::vector<S>& t_s, const JointsAt& joints_at);

// A sentence with a free body that no joint places, or that is the child of two placing joints, or two bodies whose
// shapes could touch; empty: there is none.
std::string not_a_tree(const Scene& scene);

bool is_grounded(const Scene& scene, const Joint& joint);  // its parent is the world or a fixed body

// Of a hinge or slider that joins a body to the world: the moment of inertia about its axis, or the mass, and the force
// of gravity along a slider. Refused: other parents, and a hinge about which gravity has a moment.
template <class S> std::string single_joint(const Scene& scene, std::size_t joint, S& inertia, S& gravity);

// A joint's state at the start, from the scene's doubles.
template <class S> JointState<S> initial_joint(const Joint& joint);

// All joints at the start, those of loops after the projection onto the constraints. Answers why there is no start;
// empty: there is one.
template <class S> std::string start_joints(const Scene& scene, std::vector<JointState<S>>& joints);

// The world's body is -1, and so is every fixed body.
int moving_body(const Scene& scene, int body);

// The sign of a hinge's axis along the unit vector n, on which it lies to round-off; 0: it does not.
template <class S> S sign_along(const Joint& joint, const std::vector<BodyKinematics<S>>& bodies, const Vec<S>& n);

// A joint's anchor on its child (1) or parent (0) in the world.
template <class S> Vec<S> anchor_at(const Joint& joint, int end, const std::vector<BodyKinematics<S>>& bodies);

// Forces that exceed this part of the largest term, unbalanced, show that a scene is not the one that a solution
// solves.
constexpr double kMaxResidual = 0x1p-30;

template <class S> void add_instant(const Scene& scene, S t_s, std::vector<JointState<S>> joints, Motion<S>& motion) {
  const std::vector<BodyKinematics<S>> bodies = place_bodies(scene, joints);
  const S residual = solve_reactions(scene, bodies, t_s, joints);
  if (!(residual <= S(kMaxResidual)))
    motion.refusal = "the scene has forces or masses with which it does not solve the equations of motion";
  auto& poses = motion.poses.emplace_back();
  for (const BodyKinematics<S>& body : bodies) poses.push_back(body.pose);
  motion.joints.push_back(std::move(joints));
}

template <class S, class JointsAt>
Motion<S> move_mechanism(const Scenario& scenario, const std::vector<S>& t_s, const JointsAt& joints_at) {
  Motion<S> motion;
  for (const S& t : t_s) {
    add_instant<S>(scenario.scene, t, joints_at(t), motion);
    if (!motion.refusal.empty()) break;
  }
  return motion;
}

}  // namespace atwood::closed_form
