#include "bullet/joints.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bullet/narrow.hpp"
#include "rivals/vector.hpp"

namespace atwood::bullet {
namespace {

using rivals::operator*;
using rivals::operator-;
using rivals::operator+;
using rivals::Motion;
using rivals::Reaction;

constexpr double kUnbounded = 1e18;  // of a motor's impulse; an infinity times zero would not be a number

// A right-handed orthonormal triad whose first vector is the axis.
struct Triad {
  Real3 along{}, second{}, third{};
};
Triad triad_of(const Real3& axis) {
  int least = 0;
  for (int k = 1; k < 3; ++k)
    if (std::abs(axis[k]) < std::abs(axis[least])) least = k;
  Real3 other{};
  other[least] = 1;
  Real3 second = rivals::cross(axis, other);
  second = (1 / rivals::length(second)) * second;
  return {axis, second, rivals::cross(axis, second)};
}
Triad turned(const Real4& q, const Triad& t) {
  return {rivals::to_world(q, t.along), rivals::to_world(q, t.second), rivals::to_world(q, t.third)};
}

enum class Along { x, z };
// The frame in Bullet's body at a point of the scene's body, its x or z along the triad's axis.
btTransform frame(const Mount& mount, const Real3& point_B, const Triad& triad_B, Along along) {
  const Triad t = turned(mount.q_OB, triad_B);
  const Real3 &x = along == Along::x ? t.along : t.second, &y = along == Along::x ? t.second : t.third,
              &z = along == Along::x ? t.third : t.along;
  return btTransform(btMatrix3x3(narrow(x[0]), narrow(y[0]), narrow(z[0]), narrow(x[1]), narrow(y[1]), narrow(z[1]),
                                 narrow(x[2]), narrow(y[2]), narrow(z[2])),
                     narrow(mount.p_OB + rivals::to_world(mount.q_OB, point_B)));
}

using Made = std::unique_ptr<btTypedConstraint>;

Made hinge(const Joint& joint, const Mount& a, const Mount& b, const btTransform& in_a, const btTransform& in_b) {
  // Its last argument turns the sign of the angle: positive angles turn the child about the axis.
  auto made = std::make_unique<btHingeConstraint>(*a.body, *b.body, in_a, in_b, true);
  // Bullet multiplies both the stop's restitution, the last argument, and its correction by the bias factor before it.
  if (joint.limits)
    made->setLimit(narrow(joint.limits->lower), narrow(joint.limits->upper), narrow(0.9), 1,
                   narrow(joint.limits->restitution));
  if (joint.driven_rate) made->enableAngularMotor(true, narrow(*joint.driven_rate), narrow(kUnbounded));
  return made;
}

Made slider(const Joint& joint, const Mount& a, const Mount& b, const btTransform& in_a, const btTransform& in_b) {
  auto made = std::make_unique<btSliderConstraint>(*a.body, *b.body, in_a, in_b, true);
  if (joint.kind == JointKind::cylindrical) {  // a lower bound above the upper one: free
    made->setLowerAngLimit(1);
    made->setUpperAngLimit(-1);
  }
  if (joint.limits) {
    made->setLowerLinLimit(narrow(joint.limits->lower));
    made->setUpperLinLimit(narrow(joint.limits->upper));
  }
  if (joint.driven_rate) {
    made->setPoweredLinMotor(true);
    made->setTargetLinMotorVelocity(narrow(*joint.driven_rate));
    made->setMaxLinMotorForce(narrow(kUnbounded));
  }
  return made;
}

// Rotation order X, Y, Z: Bullet's first axis is the x of the child's frame and the last the z of the parent's.
Made universal(const Joint& joint, const Mount& a, const Mount& b, double erp) {
  const btTransform in_a = frame(a, joint.anchors_body_m[0], triad_of(joint.axes_body[0]), Along::z);
  const btTransform in_b = frame(b, joint.anchors_body_m[1], triad_of(joint.axes_body[1]), Along::x);
  auto made = std::make_unique<btGeneric6DofSpring2Constraint>(*a.body, *b.body, in_a, in_b, RO_XYZ);
  made->setLimit(3, 1, -1);
  made->setLimit(4, 0, 0);
  made->setLimit(5, 1, -1);
  for (int k = 0; k < 6; ++k) made->setParam(BT_CONSTRAINT_STOP_ERP, narrow(erp), k);
  return made;
}

Made constraint_of(const Joint& joint, const Mount& a, const Mount& b, double erp) {
  const auto [at_a, at_b] = joint.anchors_body_m;
  const bool has_axis = joint.kind != JointKind::ball && joint.kind != JointKind::fixed;
  const Triad in_child = triad_of(has_axis ? joint.axis_body : Real3{1, 0, 0});
  const Triad in_parent = turned(joint.frame_wxyz, in_child);
  switch (joint.kind) {
    case JointKind::fixed: {
      auto made = std::make_unique<btFixedConstraint>(*a.body, *b.body, frame(a, at_a, in_parent, Along::x),
                                                      frame(b, at_b, in_child, Along::x));
      for (int k = 0; k < 6; ++k) made->setParam(BT_CONSTRAINT_STOP_ERP, narrow(erp), k);
      return made;
    }
    case JointKind::hinge:
      return hinge(joint, a, b, frame(a, at_a, in_parent, Along::z), frame(b, at_b, in_child, Along::z));
    case JointKind::slider:
    case JointKind::cylindrical:
      return slider(joint, a, b, frame(a, at_a, in_parent, Along::x), frame(b, at_b, in_child, Along::x));
    case JointKind::universal: return universal(joint, a, b, erp);
    case JointKind::ball:
      return std::make_unique<btPoint2PointConstraint>(*a.body, *b.body,
                                                       frame(a, at_a, in_parent, Along::x).getOrigin(),
                                                       frame(b, at_b, in_child, Along::x).getOrigin());
  }
  return nullptr;
}

}  // namespace

Joints::Joints(btDynamicsWorld& world, const Scene& scene, const std::vector<std::array<Mount, 2>>& mounts, double erp,
               bool observe)
    : world_(world), scene_(scene) {
  if (observe) {
    feedback_.resize(scene.joints.size());
    reactions_.resize(scene.joints.size());
  }
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    made_.push_back(constraint_of(scene.joints[j], mounts[j][0], mounts[j][1], erp));
    if (observe) made_[j]->setJointFeedback(&feedback_[j]);
    world.addConstraint(made_[j].get(), true);
  }
}

Joints::~Joints() {
  for (const auto& made : made_) world_.removeConstraint(made.get());
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

namespace {

bool at_stop(const btTypedConstraint& made) {
  if (auto* hinge = dynamic_cast<const btHingeConstraint*>(&made))
    return const_cast<btHingeConstraint*>(hinge)->getSolveLimit() != 0;
  if (auto* slider = dynamic_cast<const btSliderConstraint*>(&made))
    return const_cast<btSliderConstraint*>(slider)->getSolveLinLimit();
  return false;
}

}  // namespace

// Bullet's torque is about the body's centre of mass. What a stop exerts is not among the feedback of the joints that
// carry it: while one acts there are no reactions.
void Joints::after() {
  if (std::any_of(made_.begin(), made_.end(), [](const auto& made) { return at_stop(*made); })) {
    reactions_.assign(feedback_.size(), Reaction{});
    return;
  }
  for (std::size_t j = 0; j < feedback_.size(); ++j) {
    const Real3 force = widen(feedback_[j].m_appliedForceBodyB), torque = widen(feedback_[j].m_appliedTorqueBodyB);
    const Reaction total{force, torque + rivals::cross(arms_m_[j], force)};
    reactions_[j] = rivals::constraint_part(scene_.joints[j], places_[j], total);
  }
}

std::string refused_mechanism(const Scene& scene) {
  if (!scene.ropes.empty()) return "Bullet has no ropes; found `" + scene.ropes[0].name + "`";
  if (const int body = rivals::turning_point_mass(scene); body >= 0)
    return "Bullet does not turn a body without an inertia as its joints would; `" +
           scene.bodies[static_cast<std::size_t>(body)].name + "` has none";
  for (const Joint& joint : scene.joints) {
    if (!joint.limits) continue;
    if (joint.kind == JointKind::hinge && joint.limits->upper - joint.limits->lower >= 2 * std::numbers::pi)
      return "Bullet requires the limits of a hinge to be less than one turn apart; those of `" + joint.name +
             "` are not";
    if (joint.kind == JointKind::slider && joint.limits->restitution > 0)
      return "Bullet's sliders do not bounce off their stops, whatever their settings; `" + joint.name +
             "` has a restitution";
    if (joint.driven_rate) return "Bullet's motors stop at stops; `" + joint.name + "` has a driven rate and limits";
  }
  return "";
}

}  // namespace atwood::bullet
