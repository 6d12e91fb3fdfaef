#include "ode/joints.hpp"

#include <cmath>
#include <numbers>

#include "rivals/vector.hpp"

namespace atwood::ode {
namespace {

using rivals::operator-;
using rivals::operator+;
using rivals::JointPlace;
using rivals::Motion;
using rivals::Reaction;

// A parameter of the joint's first free coordinate.
void set(dJointID made, JointKind kind, int parameter, double value) {
  if (kind == JointKind::hinge) {
    dJointSetHingeParam(made, parameter, value);
  } else {
    dJointSetSliderParam(made, parameter, value);
  }
}

dJointID create(dWorldID world, JointKind kind) {
  switch (kind) {
    case JointKind::fixed: return dJointCreateFixed(world, nullptr);
    case JointKind::hinge: return dJointCreateHinge(world, nullptr);
    case JointKind::slider: return dJointCreateSlider(world, nullptr);
    case JointKind::cylindrical: return dJointCreatePiston(world, nullptr);
    case JointKind::universal: return dJointCreateUniversal(world, nullptr);
    case JointKind::ball: return dJointCreateBall(world, nullptr);
  }
  return nullptr;
}

void place(dJointID made, JointKind kind, const JointPlace& at) {
  const Real3 &p = at.child_anchor_m, &axis = at.axes[0], &second = at.axes[1];
  switch (kind) {
    case JointKind::fixed: dJointSetFixed(made); break;
    case JointKind::hinge:
      dJointSetHingeAnchor(made, p[0], p[1], p[2]);
      dJointSetHingeAxis(made, axis[0], axis[1], axis[2]);
      break;
    case JointKind::slider: dJointSetSliderAxis(made, axis[0], axis[1], axis[2]); break;
    case JointKind::cylindrical:
      dJointSetPistonAnchor(made, p[0], p[1], p[2]);
      dJointSetPistonAxis(made, axis[0], axis[1], axis[2]);
      break;
    case JointKind::universal:  // ODE's first axis is fixed in its first body, the child
      dJointSetUniversalAnchor(made, p[0], p[1], p[2]);
      dJointSetUniversalAxis1(made, second[0], second[1], second[2]);
      dJointSetUniversalAxis2(made, axis[0], axis[1], axis[2]);
      break;
    case JointKind::ball: dJointSetBallAnchor(made, p[0], p[1], p[2]); break;
  }
}

}  // namespace

Joints::Joints(dWorldID world, const Scene& scene, const std::vector<dBodyID>& bodies, bool observe) : scene_(scene) {
  if (observe) {
    feedback_.resize(scene.joints.size());
    reactions_.resize(scene.joints.size());
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    const dJointID made = create(world, joint.kind);
    const dBodyID parent = joint.parent < 0 ? nullptr : bodies[static_cast<std::size_t>(joint.parent)];
    dJointAttach(made, bodies[static_cast<std::size_t>(joint.child)], parent);
    place(made, joint.kind,
          rivals::place_of(joint, rivals::motion_at_start(scene, joint.parent),
                           rivals::motion_at_start(scene, joint.child)));
    if (joint.limits) {
      set(made, joint.kind, dParamLoStop, joint.limits->lower - joint.coordinates[0]);
      set(made, joint.kind, dParamHiStop, joint.limits->upper - joint.coordinates[0]);
      set(made, joint.kind, dParamBounce, joint.limits->restitution);
    }
    if (joint.driven_rate) {
      set(made, joint.kind, dParamVel, *joint.driven_rate);
      set(made, joint.kind, dParamFMax, dInfinity);
    }
    if (observe) dJointSetFeedback(made, &feedback_[j]);
  }
}

bool Joints::connect(int a, int b) const {
  for (const Joint& joint : scene_.joints)
    if ((joint.parent == a && joint.child == b) || (joint.parent == b && joint.child == a)) return true;
  return false;
}

void Joints::before(const std::vector<Motion>& motions) {
  places_.clear();
  arms_m_.clear();
  for (const Joint& joint : scene_.joints) {
    const Motion child = rivals::motion_of(motions, joint.child);
    places_.push_back(rivals::place_of(joint, rivals::motion_of(motions, joint.parent), child));
    arms_m_.push_back(child.p_WB - places_.back().child_anchor_m);
  }
}

// ODE's torque is about the body's centre of mass.
void Joints::after() {
  for (std::size_t j = 0; j < feedback_.size(); ++j) {
    const dJointFeedback& found = feedback_[j];
    const Real3 force{found.f1[0], found.f1[1], found.f1[2]}, torque{found.t1[0], found.t1[1], found.t1[2]};
    const Reaction total{force, torque + rivals::cross(arms_m_[j], force)};
    reactions_[j] = rivals::constraint_part(scene_.joints[j], places_[j], total);
  }
}

std::optional<Fault> refused_mechanism(const Scene& scene, double cfm) {
  if (!scene.ropes.empty()) return Fault{"ODE has no ropes; found `" + scene.ropes[0].name + "`"};
  if (const int body = rivals::turning_point_mass(scene); body >= 0)
    return Fault{"ODE requires an inertia for every body that a joint rotates; `" +
                 scene.bodies[static_cast<std::size_t>(body)].name + "` has none"};
  if (const int body = rivals::jointed_point_mass(scene); body >= 0)
    return Fault{"ODE requires an inertia of a free body with joints; `" +
                 scene.bodies[static_cast<std::size_t>(body)].name + "` has none"};
  for (const Joint& joint : scene.joints) {
    if (joint.closes_loop && cfm == 0)
      return Fault{
          "ODE aborts the process where constraints depend on each other and cfm is 0, as they may in the loop of `" +
          joint.name + "`; expected cfm > 0"};
    if (!joint.limits) continue;
    const double lower = joint.limits->lower - joint.coordinates[0], upper = joint.limits->upper - joint.coordinates[0];
    if (joint.kind == JointKind::hinge && (lower <= -std::numbers::pi || upper >= std::numbers::pi))
      return Fault{"ODE has stops of hinges within half a turn of the start only; those of `" + joint.name +
                   "` are beyond"};
    if (joint.driven_rate)
      return Fault{"ODE's motors stop at stops; `" + joint.name + "` has a driven rate and limits"};
  }
  return {};
}

}  // namespace atwood::ode
