// Modes of contacts: which are active, which slip, stick or roll.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// What cannot be told from zero at one instant.
template <class S> struct Tolerances {
  S scale{};         // [m/s^2] of accelerations
  S heaviest_kg{};   // largest mass in contact
  S acceleration{};  // [m/s^2]
  S force_N{};
};

// First guess: all contacts are active; those with slip slip, the others stick.
template <class S>
void modes_from_velocities(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active);
// Do the forces of the linear solve obey the laws, with all contacts active and those without slip sticking?
template <class S>
bool laws_hold(const Proximity<S>& proximity, const ActiveSet<S>& active, const ConstraintSystem<S>& constraints,
               S tiny_N);
// Finds modes whose forces obey the laws by a sequence of linear solves. False: none were found; contacts are as
// before.
template <class S> bool search_modes(EventRun<S>& run, S t_s, const Tolerances<S>& tiny);
// Modes from the forces of solve_forces_gauss_seidel().
template <class S>
void modes_from_forces(const Proximity<S>& proximity, ActiveSet<S>& active, S tiny_N, S tiny_acceleration);
// A pair whose contacts all stand at their cones' limits is held by none of them: they slip.
template <class S> void release_cone_limits(const Proximity<S>& proximity, ActiveSet<S>& active);

}  // namespace atwood::event
