// Forces of lasting contacts as part of the rates.
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// Redirects System::rate_of and the projections of the model to this run, which must outlive them. Once a run.
template <class S> void install_contact_forces(EventRun<S>& run);
// Solves for the forces of the active contacts at y and adds their accelerations to the rates dydt. Sets
// constraints.solvable = false if a matrix is singular. Changes the contacts' forces, kinematics and Delassus range,
// and active.force_near_bound.
template <class S>
void add_contact_forces(Bodies<S>& bodies, const Proximity<S>& proximity, ActiveSet<S>& active,
                        ConstraintSystem<S>& constraints, const S* y, std::uint64_t version, S* dydt);
// The rates at states.y with contact forces, into states.dydt. Not counted as an evaluation of the method's.
template <class S> void evaluate_rates(EventRun<S>& run, S t_s);
// Copies each contact's forces to its warm-start values.
template <class S> void store_warm_start(ActiveSet<S>& active);
// Relative acceleration of the bodies at a contact point, its normal part g'', and the relative angular acceleration;
// with all forces in dydt, from bodies.poses.
template <class S>
Vec3<S> relative_acceleration(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                              const S* dydt);
template <class S>
S normal_acceleration(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact, const S* dydt);
template <class S>
Vec3<S> relative_angular_acceleration(const Bodies<S>& bodies, const Proximity<S>& proximity, const Contact<S>& contact,
                                      const S* dydt);

}  // namespace atwood::event
