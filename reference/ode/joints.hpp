// Joints of a scene as joints of ODE. Each is attached to the child first, so that ODE's coordinates and feedback are
// the child's. Kinds: dJointFixed, Hinge, Slider, Piston (cylindrical), Universal, Ball. ODE takes the joint's zero
// from the poses at which its axes are set, the scene's start: stops are set relative to the start's coordinate.
#pragma once

#include <ode/ode.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "protocol/fault.hpp"
#include "rivals/joints.hpp"

namespace atwood::ode {

class Joints {
 public:
  // `bodies`: one for each of the scene's, null where it is fixed; at the scene's start. They belong to `world`, as the
  // joints do. Feedback is recorded if `observe`.
  Joints(dWorldID world, const Scene& scene, const std::vector<dBodyID>& bodies, bool observe);

  // Whether some joint connects these two bodies.
  bool connect(int a, int b) const;

  // Ahead of a step and after it: places where the joints are, then reads what ODE found to act on them there.
  void before(const std::vector<rivals::Motion>& motions);
  void after();
  // Of the last step; not reported before the first.
  const std::vector<rivals::Reaction>& reactions() const { return reactions_; }

 private:
  const Scene& scene_;
  std::vector<dJointFeedback> feedback_;
  std::vector<rivals::JointPlace> places_;
  std::vector<Real3> arms_m_;  // from each joint's point on the child to the child's centre of mass
  std::vector<rivals::Reaction> reactions_;
};

// Why ODE cannot hold the scene's joints and ropes, with this softness of its constraints (cfm); none when it can.
std::optional<Fault> refused_mechanism(const Scene& scene, double cfm);

}  // namespace atwood::ode
