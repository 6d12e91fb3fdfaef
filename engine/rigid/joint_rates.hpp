// The rates of a scene's mechanisms, of one state and of several at once, by the least that the scene asks for: trees in
// planes, trees, loops in planes (joints/planar_rates.hpp, tree_rates.hpp, planar_loops.hpp); whatever else there is,
// bodies that feel forces on a tree among it, by the model's own rates (rigid/mechanism.cpp).
#pragma once

#include <memory>
#include <optional>

#include "joints/planar_rates.hpp"
#include "joints/tree_rates.hpp"
#include "rigid/model.hpp"

namespace atwood {

// What the rates read and write of a model, which they are a part of.
template <class S> struct MechanismParts {
  System<S>& system;
  Tree<S>& tree;
  Constraints<S>* constraints;  // null: none
  bool projects;                // the constraints are projected after each step
  const JointForces<S>& joint_forces;
  const std::vector<const ForceTerm<S>*>& active;  // the forces that act now
  const bool& holds;                               // some body is held now
  const bool& lanes;                               // every active force has a law over lanes
  const VectorWidth& width;
  const Vec3<S>& gravity;
  const std::vector<Slot<S>>& slots;
  const std::vector<int>& on_joints;
  std::vector<Load<S>>& loads;
  std::vector<S>& placed;  // by body, as RigidModel has it
  LaneArray<S>&resting_lanes, &load_lanes;
  int state_size = 0;
};

template <class S> class JointRates {
 public:
  explicit JointRates(const MechanismParts<S>& parts);

  // Makes the system's functions those of joint rates; `system` has the model's. Both live until forget().
  static void take(const MechanismParts<S>& parts);
  static void forget(const System<S>& system);

 private:
  static void rate_of(void* context, S t_s, const S* y, S* dydt);
  static void rates_of(void* context, int count, const S* t_s, const S* y, S* dydt);
  static void project_of(void* context, S* y);
  static void projection_of(void* context, const S* y, S* change);

  void rate(S t_s, const S* y, S* dydt);
  void rates(int count, const S* t_s, const S* y, S* dydt);
  void rate_of_model(S t_s, const S* y, S* dydt) { model_.rate_of(model_.context, t_s, y, dydt); }
  bool by_joints_alone() const;
  bool by_loops() const;
  bool rate_of_loops(const OneState<S>& y);
  void apply(S t_s, const S* y);
  void apply_in_lanes(const StateLanes<S>& y);
  void rates_in_lanes(const StateLanes<S>& y);
  void loops_in_lanes(const StateLanes<S>& y);

  MechanismParts<S> parts_;
  System<S> model_;                       // the functions of the model
  std::optional<TreeRates<S>> tree_;      // has a value where nothing ties the tree's links further
  std::optional<PlanarRates<S>> planar_;  // and where the whole tree moves in planes
  std::vector<S> applied_;                // generalised forces
  RegisterVector<Pack<S>> applied_lanes_;
  LaneArray<S> part_;   // of eight states: the states, their times, their rates
  std::vector<S> one_;  // a state and its rate
};

}  // namespace atwood
