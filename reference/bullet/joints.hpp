// Joints of a scene as constraints of Bullet between rigid bodies, in maximal coordinates: btFixedConstraint,
// btHingeConstraint, btSliderConstraint (slider, and cylindrical with its angle free), btPoint2PointConstraint (ball),
// and for universal joints btGeneric6DofSpring2Constraint with the Euler angle between the two axes locked, where its
// angles are regular. Bullet's body A is the parent and B the child.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <memory>
#include <string>
#include <vector>

#include "rivals/joints.hpp"

namespace atwood::bullet {

// Where a joint is fixed to a rigid body of Bullet, whose axes and origin may differ from the scene's body.
struct Mount {
  btRigidBody* body = nullptr;
  Real3 p_OB{};  // the scene's body in Bullet's
  Real4 q_OB{1, 0, 0, 0};
};

class Joints {
 public:
  // `mounts`: one for each of the scene's joints, of parent and child. Joints leave the world with this object.
  // Feedback is recorded if `observe`.
  Joints(btDynamicsWorld& world, const Scene& scene, const std::vector<std::array<Mount, 2>>& mounts, double erp,
         bool observe);
  ~Joints();
  Joints(const Joints&) = delete;
  Joints& operator=(const Joints&) = delete;

  // Ahead of a step and after it: places where the joints are, then reads what Bullet found to act on them there.
  void before(const std::vector<rivals::Motion>& motions);
  void after();
  // Of the last step; not reported before the first.
  const std::vector<rivals::Reaction>& reactions() const { return reactions_; }

 private:
  btDynamicsWorld& world_;
  const Scene& scene_;
  std::vector<std::unique_ptr<btTypedConstraint>> made_;
  std::vector<btJointFeedback> feedback_;
  std::vector<rivals::JointPlace> places_;
  std::vector<Real3> arms_m_;  // from each joint's point on the child to the child's centre of mass
  std::vector<rivals::Reaction> reactions_;
};

// Why Bullet's rigid bodies cannot hold the scene's joints and ropes; empty when they can.
std::string refused_mechanism(const Scene& scene);

}  // namespace atwood::bullet
