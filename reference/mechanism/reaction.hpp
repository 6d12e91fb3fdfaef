// What both formulations report of joints and ropes, from motions and from the loads of constraints.
#pragma once

#include "mechanism/maximal.hpp"

namespace atwood::mechanism {

// Adds the loads of springs, dampers and torques along a joint's rates.
template <class S>
void add_applied(const Model<S>& model, int joint, const std::vector<Motion<S>>& now, const StepChoice& choice,
                 const S& t_s, std::vector<Wrench<S>>& loads);
// Coordinates, rates and applied forces of all joints; room for ropes.
template <class S>
void fill_joints(const Model<S>& model, const std::vector<Motion<S>>& now, const StepChoice& choice, const S& t_s,
                 Sample& sample);
// From the load on the child (about its centre of mass): force, and torque about its anchor.
template <class S>
void set_reaction(const Model<S>& model, int joint, const std::vector<Motion<S>>& now, const Wrench<S>& on_child,
                  JointSample& sample);
template <class S>
void fill_pulleys(const Model<S>& model, int rope, const std::vector<Motion<S>>& now, const Memory& memory,
                  RopeSample& sample);
// Sets the bits of the components of reactions that multipliers `null` of `rows` change.
template <class S>
void mark_open_components(const Model<S>& model, const std::vector<Motion<S>>& now, const std::vector<Row<S>>& rows,
                          const std::vector<S>& null, std::vector<JointSample>& joints);

}  // namespace atwood::mechanism
