// A run of `+event`: free flight by the method, impacts located on its numerical flow, and between them lasting
// contacts whose forces follow from their geometry and Coulomb's law.
//
//   part        holds                                       written by
//   options     settings of the law of impact               event.cpp
//   bodies      poses, inertias, scales of round-off        kinematics.cpp, constraints.cpp, active_set.cpp,
//                                                           candidates.cpp, step.cpp, event.cpp, impacts
//   proximity   pairs, candidates, their gaps               broad_phase.cpp, active_set.cpp, candidates.cpp,
//                                                           edge_candidates.cpp, contact_update.cpp,
//                                                           surface_boundaries.cpp, step.cpp, event.cpp, impacts,
//                                                           bounces.cpp
//   active      lasting contacts, their modes and forces    active_set.cpp, contact_forces.cpp, constraints.cpp,
//                                                           modes.cpp, gauss_seidel.cpp, contact_update.cpp,
//                                                           slip_step.cpp, step.cpp, event.cpp, impacts, painleve.cpp,
//                                                           surface_boundaries.cpp, edge_candidates.cpp
//   constraints linear system of the contacts, its factors  constraints.cpp, linear_solve.cpp, modes.cpp,
//                                                           gauss_seidel.cpp, contact_forces.cpp, active_set.cpp,
//                                                           projection.cpp, painleve.cpp
//   impacts     impacts of the present instant              impacts.cpp, impact_problem.cpp, edge_candidates.cpp
//   states      state vectors, their versions, rates        step.cpp, event.cpp, event_location.cpp, projection.cpp,
//                                                           impacts.cpp, active_set.cpp, contact_forces.cpp,
//                                                           slip_step.cpp
//   integration the method, error control                   step.cpp, slip_step.cpp, contact_forces.cpp, event.cpp
//   drag_bodies bodies under quadratic drag                 event.cpp
//   report      observer and outcome                        the functions of report.hpp, event.cpp; impacts,
//                                                           broad_phase.cpp and edge_candidates.cpp set the outcome
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
  // Simultaneous impacts form one complementarity problem; false: pairs are solved in turn.
  bool simultaneous = false;
};

// A candidate that touches at the instant of an impact.
template <class S> struct ImpactPoint {
  int candidate = 0, pair = 0;
  GapKinematics<S> kinematics;
  ImpactBody<S> surface, feature;
  S inverse_mass_n{}, inverse_mass_t{};  // [1/kg] inverse effective masses along and across the normal
  S before{}, target{};                  // [m/s] normal velocity before the impact; lower bound on it afterwards
  S least{}, normal_N_s{};               // [N s] lower bound of the normal impulse; its present value
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
