// Mechanisms in a run of "+impulse": every body has its own pose and velocity, every joint is a constraint.
//
// A substep of length h begins at poses q and velocities v. With M the masses, f the forces, g(q, t) = 0 the conditions
// of the joints, G = dg/dq and J the contact Jacobian,
//   v+ = v + M^-1 (h f(q) + G(q)^T lambda + J(q)^T l)
//   q+ = the free motion of each body from q with v+ over h         (rotating bodies: rigid/free_top.hpp, splitting)
// with lambda such that g(q+, t + h) = 0, and l the contact impulses of world.hpp, both in one solve: contacts and
// stops see the mobility that the joints leave, (1 - M^-1 G^T (G M^-1 G^T)^+ G) M^-1. Without contacts this is SHAKE
// (Ryckaert, Ciccotti, Berendsen, J. Comput. Phys. 23 (1977) 327; Hairer, Lubich, Wanner, Geometric Numerical
// Integration, 2nd ed., VII.1.4): symplectic, its velocities half a substep behind its positions. Impulses of a joint
// act at the anchor where its bodies meet, and each body carries its angular momentum through the free motion, so
// momenta are kept to round-off.
//
// Dampers along joints are implicit: a row whose impulse is -h c times its rate after the substep, in the least-norm
// problem a row with a further unknown of mass 1 and the coefficient 1 / sqrt(h c). Springs and torques act explicitly.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "contact/stepping/world.hpp"
#include "joints/constraint.hpp"
#include "joints/least_norm.hpp"

namespace atwood::stepping {

// One scalar condition on the velocities of two bodies: sum of on[k] . (v, w) = target_rate.
template <class S> struct TiedRow {
  int body[2] = {-1, -1};  // index into BodyRows; -1: the world
  Wrench<S> on[2];         // torques about the centres of mass, world axes
  S scale{};               // of its column, to unit length
  S value{}, tolerance{};  // of the condition: m, or the sine of an angle; its round-off
  S rate{};                // of a prescribed motion
  S target_rate{};
  S impulse{};                 // of the substep so far
  int joint = -1;              // index into Scene::joints
  int compliant_unknown = -1;  // of a damper: its further unknown; -1: a condition of the joint
  int coordinate = 0;          // of a damper: the joint's rate
  S compliance{};              // of a damper: 1 / sqrt(h c)
};

// A stop of a hinge or slider: gap >= 0. Its impulse acts along the coordinate.
template <class S> struct StopConstraint {
  int joint = 0;
  S side{};   // 1: the lower limit, -1: the upper
  S limit{};  // the coordinate there [rad], [m]
  S restitution{}, round_off{};
  S begin_gap{};  // at the beginning of the substep
  S gap{};        // at the beginning of the substep, of the uniform motion that follows the impacts so far
  S bias{}, impulse{};
  S rate_before{};  // of the gap, at an impact
  S mobility{};     // change of the gap's rate by a unit impulse, under the joints
  TiedRow<S> row;   // of the gap's rate
};

// Bodies that joints connect with each other. Fixed ones and the world connect nothing.
template <class S> struct Mechanism {
  std::vector<int> bodies, joints, stops;  // indices into BodyRows, Scene::joints, TiedBodies::stops
  std::vector<TiedRow<S>> rows;
  LeastNorm<S> qr;                    // columns: M^-1/2 times the rows, scaled
  std::vector<S> columns;             // before they were factored
  std::vector<S> compliant_velocity;  // of the further unknowns
  std::vector<S> b, x, z;             // work arrays
};

template <class S> struct TiedJoint {
  JointConstraint<S> constraint;
  S q[4] = {}, u[3] = {};  // coordinates, unwrapped
  Vec3<S> force,
      torque;         // impulses of the constraints on the child in this step: N s; about its anchor, N m s; world axes
  S applied[3] = {};  // of springs, dampers and motors along the rates in this step: N m s or N s
  S stop = S(0);      // of the stops, along the first rate
  S damping[3] = {};  // along each rate
};

template <class S> struct TiedBodies {
  std::vector<Mechanism<S>> mechanisms;
  std::vector<TiedJoint<S>> joints;  // in the scene's order
  std::vector<StopConstraint<S>> stops;
  std::vector<int> mechanism_of;            // by body, -1: none
  std::vector<int> first_unknown;           // by body: of its six
  std::vector<std::pair<int, int>> joined;  // pairs of bodies that a joint ties, smaller index first, sorted
  // by body, of this substep
  std::vector<Quat<S>> q_begin, q_end;
  std::vector<Vec3<S>> p_end;
  S size_m{};           // of the mechanisms at the start
  bool failed = false;  // the joint constraints were not satisfied; the run ends
  bool has_stop_restitution = false;
  std::vector<Row<S>> velocity_before_impact;  // by body: work array
};

// Null where the scene has no joints.
template <class S> std::unique_ptr<TiedBodies<S>> make_tied_bodies(const Scene& scene);
// The state at t = 0 of the bodies, in the model's layout, from the mechanisms' start, projected onto the
// joints. Returns why there is none; empty: it was set.
template <class S> std::string set_mechanism_start(World<S>& world, S* y);

template <class S> bool is_tied(const World<S>& world, int body) {
  return world.tied != nullptr && world.tied->mechanism_of[static_cast<std::size_t>(body)] >= 0;
}
// Whether a joint ties the two bodies: they do not collide.
template <class S> bool are_joined(const World<S>& world, int a, int b);

// ---- a substep
// Before impacts: orientations and stops' gaps at its beginning.
template <class S> void begin_tied_substep(World<S>& world);
// After the free increments: v += h M^-1 f of springs and torques along joints.
template <class S> void apply_joint_forces(World<S>& world);
// After contacts are prepared: poses moved by position corrections return to the joints; rows and factors.
template <class S> void prepare_joints(World<S>& world);
// The joint impulses of least kinetic energy that give all rows of a mechanism their target rates.
template <class S> void satisfy_joints(World<S>& world, Mechanism<S>& mechanism);
// Iterates the joint impulses until all joints hold at the end of the substep. Returns how often target rates changed.
template <class S> int satisfy_joints_at_end(World<S>& world);
// The biases of loaded stops follow the gaps at the end of the substep. True: some was changed.
template <class S> bool correct_stop_biases(World<S>& world);
// After positions are advanced: poses, velocities and inertias of tied bodies at the end of the substep.
template <class S> void end_tied_substep(World<S>& world);

// ---- helpers
// The rows at poses that lie after_s later on uniform motion (0: at the beginning), and their factors.
template <class S> void factor_rows(World<S>& world, Mechanism<S>& mechanism, S after_s, bool dampers);
// The row's rate: sum of on[k] . (v, w).
template <class S> S rate_of(const World<S>& world, const TiedRow<S>& row);
// The rate u_k of a joint as a row after_s later; a force along it has the row's wrenches.
template <class S> void coordinate_row(const World<S>& world, int joint, int k, S after_s, TiedRow<S>& row);
// Adds impulse times the row's wrenches.
template <class S> void apply_row(World<S>& world, const TiedRow<S>& row, S impulse);
// Adds M^-1/2 (force, torque) on a body to z, of its mechanism's size; then projects z onto what the joints leave free.
template <class S>
void add_to_response(const World<S>& world, int body, const Vec3<S>& force, const Vec3<S>& torque, TiedResponse<S>& to);
template <class S> void project_response(World<S>& world, TiedResponse<S>& response);
// Pose of any body, -1 being the world, after_s later.
template <class S> TiedBody<S> tied_body(const World<S>& world, int body, S after_s);
// Impulses of the rows go into the joints' sums, and become 0.
template <class S> void add_reactions(World<S>& world, Mechanism<S>& mechanism, S after_s);

// One sweep: solves the joints, then each stop with the joints.
template <class S> void sweep_joints(World<S>& world);
// The row of a stop's gap, after_s later; and its response.
template <class S> void set_stop_row(const World<S>& world, StopConstraint<S>& stop, S after_s);
template <class S> TiedResponse<S> stop_response(World<S>& world, const StopConstraint<S>& stop);
// The square of a response's length: the diagonal entry of W of its row.
template <class S> S squared(const TiedResponse<S>& response);

// ---- mechanism_impacts.cpp
// The impact at the stop that is reached first in [now_s, until_s] of the substep, among those with restitution.
// Returns its mechanism and sets now_s to its time; null: there is none.
template <class S> const Mechanism<S>* resolve_stop_impact(World<S>& world, S& now_s, S until_s);
// Whether there is one.
template <class S> bool reaches_stop(World<S>& world, S now_s, S until_s);
// An impact at t_s between bodies of which one is tied at least: an impulse at the contact point under Coulomb's law
// and the impulses of all joints. Changes velocities and impact shifts of all bodies of their mechanisms. Returns the
// impulse on b.
template <class S>
Impulse<S> collide_tied(World<S>& world, int a, int b, const ImpactLaw<S>& law, const Vec3<S>& normal,
                        const Vec3<S>& arm_a, const Vec3<S>& arm_b, S t_s, Vec3<S>& impulse_W);

// ---- joint_report.cpp
template <class S> void clear_joint_sums(World<S>& world);
// `h_s`: the step that the sums are of; 0: no reactions are reported.
template <class S> void report_joints(World<S>& world, S h_s, Sample& sample);

}  // namespace atwood::stepping
