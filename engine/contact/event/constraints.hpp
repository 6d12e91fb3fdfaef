// Contact constraints as rows of a linear system, J M^-1 J^T x = b: the Delassus operator (Brogliato, Nonsmooth
// Mechanics, 2016, ch. 5) on the unknown normal forces, friction forces and couples.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/event/active_set.hpp"

namespace atwood::event {

// Of one body, world axes: a velocity, an acceleration or a wrench (Featherstone, Rigid Body Dynamics Algorithms, 2008,
// ch. 2).
template <class S> struct SpatialVector { Vec3<S> linear, angular; };
template <class S> S dot(const SpatialVector<S>& a, const SpatialVector<S>& b) {
  return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}

// A row of J, and the accelerations M^-1 f that a unit of its unknown gives the contact's two bodies.
template <class S> struct ConstraintRow {
  int body[2] = {-1, -1};  // the feature's, the surface's; -1: does not move
  SpatialVector<S> jacobian[2], response[2];
};

// Level at which the rows are imposed.
//   acceleration   of contacts that are not decoupled; friction of slip and rolling couples are functions of the
//                  normal force
//   velocity       of all active contacts
//   position       of all active contacts, normals only
enum class ConstraintLevel : unsigned char { acceleration, velocity, position };

template <class S> struct ConstraintSystem {
  int row_count = 0, row_contacts = 0;  // rows in use, contacts that have rows; vectors below may be longer
  std::vector<ConstraintRow<S>> rows;
  std::vector<S> matrix;  // the Delassus matrix, row_count x row_count by rows, then its LU factors
  std::vector<S> right, unknown, residual, start;
  std::vector<S> right_round_off;       // of each row: a residual up to this size is round-off of `right`'s own terms
  std::vector<S> weight;                // of each unknown, in the norm that decides among redundant solutions
  std::vector<S> diagonal;              // of the Delassus matrix, absolute values
  std::vector<int> pivots, block_ends;  // of the factors
  std::uint64_t factors_key = 0;        // what the factors in `matrix` were computed for; 0: none
  bool solvable = true;                 // no matrix was singular since this was last set

  // A body: acceleration without contacts, and under the unknowns; does some unknown load it?
  std::vector<SpatialVector<S>> free_acceleration, acceleration;
  std::vector<unsigned char> loaded;
};

// The bodies of a contact that move, and the contact point relative to their centres.
template <class S>
LeverArms<S> levers_of(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact);

// The wrench of a force at a lever arm and a couple, times `sign`.
template <class S> SpatialVector<S> wrench_of(const Vec3<S>& force, const Vec3<S>& couple, const Vec3<S>& arm, S sign) {
  return {sign * force, sign * (cross(arm, force) + couple)};
}
// A body's acceleration under a wrench.
template <class S> SpatialVector<S> acceleration_under(const InverseInertia<S>& body, const SpatialVector<S>& wrench) {
  return {body.inverse_mass_per_kg * wrench.linear, times(body.I_row, wrench.angular)};
}

// The components of a relative acceleration `a` at the contact point and an angular one `alpha` along a contact's rows,
// into values[0 .. force_rows + couple_rows).
template <class S> void project_rows(const Contact<S>& contact, const Vec3<S>& a, const Vec3<S>& alpha, S* values) {
  values[0] = dot(contact.kinematics.normal, a);
  if (contact.force_rows == 3) {
    values[1] = dot(contact.tangent[0], a);
    values[2] = dot(contact.tangent[1], a);
  }
  if (contact.couple_rows == 2) {
    values[contact.force_rows] = dot(contact.tangent[0], alpha);
    values[contact.force_rows + 1] = dot(contact.tangent[1], alpha);
  }
}

// Kinematics of one contact, from bodies.poses.
template <class S> void update_kinematics(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact);
// Poses, inverse inertias and kinematics of all active contacts at y, of the version given (0: unknown). Nothing is
// computed twice for one version.
template <class S>
void update_active_kinematics(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active, const S* y,
                              std::uint64_t version);

// Sets unit_force_W and unit_couple_W for the contact's modes.
template <class S>
void update_unit_load(const Bodies<S>& bodies, const Proximity<S>& proximity, Contact<S>& contact,
                      ConstraintLevel level);
// Numbers the rows of active contacts and makes room for them.
template <class S>
void assign_rows(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                 ConstraintSystem<S>& constraints, ConstraintLevel level);
// Computes the rows, the Delassus matrix and its diagonal.
template <class S>
void assemble_delassus(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints);
// constraints.acceleration of the bodies in contact: free_acceleration and the response to constraints.unknown.
template <class S>
void apply_unknowns(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints);
// The components of constraints.acceleration along the contact's rows.
template <class S> void row_values(const ConstraintSystem<S>& constraints, const Contact<S>& contact, S* values);
// The unknowns as the contact's forces and couple.
template <class S> void store_forces(const ConstraintSystem<S>& constraints, Contact<S>& contact);
// The row of a force and a couple on the feature's body, the opposite on the surface's; f . A g of two such loads, A
// the Delassus operator of the contact.
template <class S>
ConstraintRow<S> row_of_load(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                             const Vec3<S>& force, const Vec3<S>& couple);
template <class S>
S delassus_entry(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact, const Vec3<S>& on,
                 const Vec3<S>& on_couple, const Vec3<S>& force, const Vec3<S>& couple);

}  // namespace atwood::event
