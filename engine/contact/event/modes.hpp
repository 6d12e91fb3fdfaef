// Modes of contacts: which are active, which slip, stick or roll.
#pragma once

#include "contact/event/run.hpp"

namespace atwood::event {

// Bounds below which values at one instant count as zero.
template <class S> struct Tolerances {
  S scale{};         // [m/s^2] of accelerations
  S heaviest_kg{};   // largest mass in contact
  S acceleration{};  // [m/s^2]
  S force_N{};
};

// First guess: all contacts are active; those with slip slip, the others stick.
template <class S>
void modes_from_velocities(const Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active);
// True if the linear solve succeeded, every contact is active with a normal force, and friction and rolling couples are
// within their bounds.
template <class S>
bool laws_hold(const Proximity<S>& proximity, const ActiveSet<S>& active, const ConstraintSystem<S>& constraints,
               S tiny_N);
// Finds modes whose forces obey the laws by a sequence of linear solves. False: none were found; contacts are as
// before.
template <class S> bool search_modes(EventRun<S>& run, S t_s, const Tolerances<S>& tolerances);
// Modes from the forces of solve_forces_gauss_seidel(). Sets active, modes, slip and roll directions, at_cone_limit,
// warm_start_N and largest_N.
template <class S>
void modes_from_forces(const Proximity<S>& proximity, ActiveSet<S>& active, S tiny_N, S tiny_acceleration);
// Clears at_cone_limit of contacts whose pair has no active sticking contact left: nothing holds them, so they slip.
template <class S> void release_cone_limits(const Proximity<S>& proximity, ActiveSet<S>& active);

}  // namespace atwood::event
