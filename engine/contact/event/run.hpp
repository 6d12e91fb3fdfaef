// A run of `+event`: free flight by the method, impacts located on its numerical flow, and between them lasting
// contacts whose forces follow from their geometry and Coulomb's law.
//
//   part          owner of                                         changed by
//   bodies        poses, inertias, scales of round-off             kinematics.cpp, constraints.cpp, impacts
//   proximity     pairs, candidates, their gaps                    near_phase.cpp, active_set.cpp
//   active        lasting contacts, their modes and forces         active_set.cpp, contact_forces.cpp, step.cpp
//   constraints   linear system of the contacts, its factors       constraints.cpp, linear_solve.cpp
//   impacts       impacts of the present instant                   impacts.cpp
//   states        state vectors and their versions                 step.cpp, projection.cpp, impacts.cpp
//   integration   the method, error control                        step.cpp
//   report        observer and outcome                             whoever ends the run
#pragma once

#include <vector>

#include "contact/event/active_set.hpp"
#include "contact/event/constraints.hpp"
#include "contact/event/integration.hpp"
#include "contact/event/proximity.hpp"
#include "contact/event/report.hpp"
#include "contact/event/states.hpp"

namespace atwood::event {

struct EventOptions {
  Restitution restitution = Restitution::newton;
  bool together = false;  // simultaneous impacts are solved at once, instead of pair after pair
};

// A candidate that touches at the instant of an impact.
template <class S> struct ImpactPoint {
  int candidate = 0, pair = 0;
  GapKinematics<S> kinematics;
  ImpactBody<S> surface, feature;
  S inverse_mass_n{}, inverse_mass_t{};  // [1/kg] inverse effective masses along and across the normal
  S before{}, target{};                  // [m/s] normal velocity before, and the least one after
  S least{}, normal_N_s{};               // [N s] normal impulse: at least, and so far
  Vec3<S> tangential_N_s;
};
// An impulse that was applied, to be reported as an event.
template <class S> struct AppliedImpulse {
  int pair = 0;
  bool feature_is_a = false;
  GapKinematics<S> kinematics;
  Impulse<S> impulse;
};
template <class S> struct Impacts {
  std::vector<ImpactPoint<S>> points;  // by pair
  std::vector<AppliedImpulse<S>> applied;
};

template <class S> struct EventRun {
  EventRun(RigidModel<S>& model, Stepper<S>& stepper) : bodies(model), integration(stepper) {}

  EventOptions options;
  Bodies<S> bodies;
  Proximity<S> proximity;
  ActiveSet<S> active;
  ConstraintSystem<S> constraints;
  Impacts<S> impacts;
  StateBuffers<S> states;
  Integration<S> integration;
  std::vector<DragBody<S>> drag_bodies;
  Report report;
};

}  // namespace atwood::event
