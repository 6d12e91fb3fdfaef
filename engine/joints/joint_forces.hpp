// Springs, dampers and motors that act along the coordinates of a tree's joints; those of joints that close loops are
// in closing_force.hpp.
#pragma once

#include <vector>

#include "scene/scene.hpp"

namespace atwood {

template <class S> class Tree;

template <class S> class JointForces {
 public:
  explicit JointForces(const Scene& scene);

  bool empty() const { return springs_.empty() && torques_.empty(); }
  // Times at which a motor is switched, unsorted.
  const std::vector<double>& switch_times_s() const { return switch_times_s_; }
  // Motors that are on at the time middle_s act; the others do not.
  void select(double middle_s);
  // Adds the forces along the rates of `tree` (its generalised vector) in the state (t, y).
  void add(const Tree<S>& tree, S t_s, const S* y, S* applied) const;
  // J of the springs; joints whose motion is prescribed are where y has them.
  S potential_energy(const Tree<S>& tree, const S* y) const;

 private:
  struct SpringForce {
    int joint, coordinate;
    S stiffness, rest, damping;
  };
  struct TorqueForce {
    int joint, coordinate;
    S torque, frequency, phase;
    std::vector<Interval> on_s;
    bool on = true;
  };
  std::vector<SpringForce> springs_;
  std::vector<TorqueForce> torques_;
  std::vector<double> switch_times_s_;
};

}  // namespace atwood
