// The rates of a scene's mechanisms, of one state and of several at once, by the least that the scene asks for: trees
// in planes, trees, loops in planes (joints/planar_rates.hpp, tree_rates.hpp, planar_loops.hpp); whatever else there
// is, bodies that feel forces on a tree among it, by the model's own rates (rigid/mechanism.cpp).
#pragma once

#include <optional>

#include "joints/planar_rates.hpp"
#include "joints/tree_rates.hpp"
#include "rigid/model.hpp"

namespace atwood {

template <class S> class JointRates {
 public:
  // `model` has its layout, tree, constraints and forces, and outlives this.
  explicit JointRates(RigidModel<S>& model);

  void rate(S t_s, const S* y, S* dydt);
  // Component i of state k at y[i * count + k]; each state's rate has the bits that rate() gives.
  void rates(int count, const S* t_s, const S* y, S* dydt);

 private:
  bool by_joints_alone() const;
  bool by_loops() const;
  bool rate_of_loops(const OneState<S>& y);
  void apply_in_lanes(const StateLanes<S>& y);
  void rates_in_lanes(const StateLanes<S>& y);
  void loops_in_lanes(const StateLanes<S>& y);

  RigidModel<S>& model_;
  std::optional<TreeRates<S>> tree_;      // has a value where nothing ties the tree's links further
  std::optional<PlanarRates<S>> planar_;  // and where the whole tree moves in planes
  LaneArray<S> applied_lanes_;            // generalised forces
  LaneArray<S> part_;                     // of eight states: the states, their times, their rates
  std::vector<S> one_;                    // a state and its rate
};

}  // namespace atwood
