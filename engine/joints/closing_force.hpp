// Springs, dampers and motors along the coordinates of joints that close loops. Such a joint has no coordinate in the
// state: it follows from the poses of the joint's two bodies, its angles up to whole turns, which are counted from step
// to step. The force along a rate is a wrench on the child and its opposite on the parent, which do the same power,
//   hinge, angle of a cylindrical joint     torque along the axis b of the child
//   slider, offset of a cylindrical joint   force along b through the parent's anchor
//   universal                               torque along the vector dual to the rate's axis in the plane of both axes
//   ball                                    torque in the child's axes
// and so a load on two bodies, as any other force is.
#pragma once

#include <array>

#include "forces/force.hpp"
#include "joints/constraint.hpp"

namespace atwood {

// A force that the scene declares along a joint that closes a loop.
template <class S> class ClosingForce final : public ForceTerm<S> {
 public:
  // Coordinates, angles with all their turns, and rates of the joint at t_s.
  struct JointState {
    S t_s{};
    std::array<S, 4> q{};
    std::array<S, 3> u{};
  };

  // `force` acts along a joint of `scene` that closes a loop.
  ClosingForce(const JointForce& force, const Scene& scene);

  int joint() const { return joint_; }  // index into Scene::joints
  // The joint at the end of a step. Of the values of an angle at t_s that one counts which is nearest to where the mean
  // of its rates leads from there. Before the first call: the scene's start.
  void remember(const JointState& at) { last_ = at; }
  // Along each rate while it acts [N m or N].
  std::array<S, 3> along_rates(const JointState& at) const;
  S potential_energy(const Motion<S>& motion) const;  // J of a spring; the angle next to the remembered one

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override;
  bool has_lanes() const override { return true; }
  void add_lane_loads(const LaneMotion<S>& motion, S* loads) const override;
  bool velocity_dependent() const override { return damping_ != S(0); }

 private:
  Wrench<S> on_child(const std::array<S, 3>& along, const Quat<S>& q_parent, const Quat<S>& q_child) const;
  JointState state_at(S t_s, const TiedBody<S>& parent, const TiedBody<S>& child) const;
  template <class M, class L> void add(const M& motion, const L& loads, int lane) const;

  Joint of_;
  int joint_ = 0, coordinate_ = 0;
  S stiffness_{}, rest_{}, damping_{};
  S torque_{}, frequency_{}, phase_{};
  JointState last_;
};

// Of a term among a model's forces; null: it is not a force along a closing joint.
template <class S> ClosingForce<S>* closing_force(ForceTerm<S>* term) { return dynamic_cast<ClosingForce<S>*>(term); }
template <class S> const ClosingForce<S>* closing_force(const ForceTerm<S>* term) {
  return dynamic_cast<const ClosingForce<S>*>(term);
}

}  // namespace atwood
