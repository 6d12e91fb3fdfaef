#include "dart/mechanism.hpp"

#include <algorithm>
#include <dart/constraint/BallJointConstraint.hpp>
#include <dart/constraint/ConstraintSolver.hpp>
#include <dart/constraint/WeldJointConstraint.hpp>
#include <dart/dynamics/BallJoint.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/PrismaticJoint.hpp>
#include <dart/dynamics/RevoluteJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/UniversalJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"

namespace atwood::dartsim {
namespace {

using rivals::cross;
using rivals::Motion;
using rivals::operator+;
using rivals::operator-;
using rivals::operator*;
namespace dynamics = dart::dynamics;

Eigen::Vector3d vector3(const Real3& v) { return {v[0], v[1], v[2]}; }
Real3 real3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
Eigen::Matrix3d rotation(const Real4& q) { return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(); }
Eigen::Isometry3d frame(const Real3& p, const Eigen::Matrix3d& r) {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = r;
  pose.translation() = vector3(p);
  return pose;
}

// With names of its own: DART prints a message for each name that occurs twice in a skeleton.
template <class JointType>
std::pair<JointType*, dynamics::BodyNode*> new_pair(int j, dynamics::Skeleton& skeleton, dynamics::BodyNode* parent) {
  typename JointType::Properties made;
  made.mName = "joint" + std::to_string(j);
  dynamics::BodyNode::AspectProperties node("body" + std::to_string(j));
  return skeleton.createJointAndBodyNodePair<JointType>(parent, made, dynamics::BodyNode::Properties(node));
}

dynamics::BodyNode* new_node(const Joint& joint, int j, dynamics::Skeleton& skeleton, dynamics::BodyNode* parent) {
  switch (joint.kind) {
    case JointKind::hinge: {
      const auto [made, node] = new_pair<dynamics::RevoluteJoint>(j, skeleton, parent);
      made->setAxis(vector3(joint.axis_body));
      return node;
    }
    case JointKind::slider: {
      const auto [made, node] = new_pair<dynamics::PrismaticJoint>(j, skeleton, parent);
      made->setAxis(vector3(joint.axis_body));
      return node;
    }
    case JointKind::universal: {
      const auto [made, node] = new_pair<dynamics::UniversalJoint>(j, skeleton, parent);
      made->setAxis1(vector3(joint.axes_body[0]));
      made->setAxis2(rotation(joint.frame_wxyz) * vector3(joint.axes_body[1]));
      return node;
    }
    case JointKind::ball: return new_pair<dynamics::BallJoint>(j, skeleton, parent).second;
    default: return new_pair<dynamics::WeldJoint>(j, skeleton, parent).second;
  }
}

void set_start(const Joint& joint, dynamics::Joint& made) {
  if (joint.kind == JointKind::ball) {
    made.setPositions(dynamics::BallJoint::convertToPositions(rotation(joint.coordinates)));
    made.setVelocities(vector3(joint.rates));
    return;
  }
  for (int k = 0; k < coordinate_count(joint.kind); ++k) {
    made.setPosition(static_cast<std::size_t>(k), joint.coordinates[k]);
    made.setVelocity(static_cast<std::size_t>(k), joint.rates[k]);
  }
}

void set_passive_forces(const Scene& scene, int j, dynamics::Joint& made) {
  const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
  for (int k = 0; k < rate_count(joint.kind); ++k) {
    const auto index = static_cast<std::size_t>(k);
    const rivals::PassiveForce passive = rivals::passive_force(scene, j, joint.kind == JointKind::ball ? 0 : k);
    made.setDampingCoefficient(index, passive.damping);
    if (joint.kind == JointKind::ball) continue;
    made.setSpringStiffness(index, passive.stiffness);
    made.setRestPosition(index, passive.rest);  // ahead of the limits: DART ignores a rest outside of them
  }
}

std::size_t index_of(int body) { return static_cast<std::size_t>(body); }

}  // namespace

std::string refused_mechanism(const Scene& scene) {
  if (!scene.ropes.empty()) return "DART has no ropes; found the rope `" + scene.ropes[0].name + "`";
  for (const Joint& joint : scene.joints) {
    const std::string named = "; found it on the joint `" + joint.name + "`";
    if (joint.kind == JointKind::cylindrical) return "DART has no cylindrical joint" + named;
    if (joint.limits && joint.limits->restitution != 0)
      return "DART's stops have no restitution: expected stop_restitution = 0 on the joint `" + joint.name + "`";
    if (!joint.closes_loop) continue;
    if (joint.kind == JointKind::slider || joint.kind == JointKind::universal)
      return "DART's constraints close loops only by fixed, hinge and ball joints" + named;
    if (joint.limits || joint.driven_rate) return "DART has no limits or drives of a joint that closes a loop" + named;
  }
  for (const JointForce& force : scene.joint_forces) {
    const int j = std::visit([](const auto& f) { return f.joint; }, force);
    const Joint& joint = scene.joints[static_cast<std::size_t>(j)];
    if (joint.closes_loop) return "DART has no forces of a joint that closes a loop; found one on `" + joint.name + "`";
  }
  if (const int body = rivals::turning_point_mass(scene); body >= 0)
    return "DART requires an inertia of the point mass `" + scene.bodies[index_of(body)].name +
           "`, which turns with its parent";
  return "";
}

dynamics::BodyNode* add_placed_body(const Scene& scene, int j, dynamics::Skeleton& skeleton,
                                    dynamics::BodyNode* parent) {
  const Joint& joint = scene.joints[index_of(j)];
  dynamics::BodyNode* node = new_node(joint, j, skeleton, parent);
  dynamics::Joint* made = node->getParentJoint();
  const bool universal = joint.kind == JointKind::universal;
  const Eigen::Matrix3d turned = rotation(joint.frame_wxyz);
  Eigen::Isometry3d in_parent = frame(joint.anchors_body_m[0], universal ? Eigen::Matrix3d::Identity() : turned);
  if (!parent && joint.parent >= 0) {
    const Body& fixed = scene.bodies[index_of(joint.parent)];
    in_parent = frame(fixed.position_m, rotation(fixed.orientation_wxyz)) * in_parent;
  }
  made->setTransformFromParentBodyNode(in_parent);
  made->setTransformFromChildBodyNode(
      frame(joint.anchors_body_m[1], universal ? Eigen::Matrix3d(turned.transpose()) : Eigen::Matrix3d::Identity()));
  if (joint.kind == JointKind::fixed) return node;
  set_passive_forces(scene, j, *made);
  if (joint.limits) {
    made->setPositionLowerLimit(0, joint.limits->lower);
    made->setPositionUpperLimit(0, joint.limits->upper);
    made->setLimitEnforcement(true);
  }
  set_start(joint, *made);
  if (joint.driven_rate) made->setActuatorType(dynamics::Joint::VELOCITY);
  return node;
}

void add_closing_joints(const Scene& scene, const std::vector<dynamics::BodyNode*>& nodes,
                        dart::simulation::World& world) {
  auto* solver = world.getConstraintSolver();
  for (const Joint& joint : scene.joints) {
    if (!joint.closes_loop) continue;
    const bool grounded = joint.parent < 0 || scene.bodies[index_of(joint.parent)].fixed;
    dynamics::BodyNode* child = nodes[index_of(joint.child)];
    dynamics::BodyNode* parent = grounded ? nullptr : nodes[index_of(joint.parent)];
    if (joint.kind == JointKind::fixed) {
      using dart::constraint::WeldJointConstraint;
      solver->addConstraint(parent ? std::make_shared<WeldJointConstraint>(parent, child)
                                   : std::make_shared<WeldJointConstraint>(child));
      continue;
    }
    const double lever = std::max(rivals::length(joint.anchors_body_m[0]), rivals::length(joint.anchors_body_m[1]));
    const Real3 half = (lever > 0 ? lever : 1.0) * joint.axis_body;
    for (const double side : {1.0, -1.0}) {
      if (joint.kind == JointKind::ball && side < 0) continue;
      const Real3 in_child =
          joint.kind == JointKind::ball ? joint.anchors_body_m[1] : joint.anchors_body_m[1] + side * half;
      const Eigen::Vector3d at = child->getWorldTransform() * vector3(in_child);
      using dart::constraint::BallJointConstraint;
      solver->addConstraint(parent ? std::make_shared<BallJointConstraint>(parent, child, at)
                                   : std::make_shared<BallJointConstraint>(child, at));
    }
  }
}

void command(const Scene& scene, const std::vector<dynamics::BodyNode*>& nodes, double t_s, double t_switch_s) {
  const std::vector<Real3> efforts = rivals::motor_efforts(scene, t_s, t_switch_s);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    const Joint& joint = scene.joints[j];
    if (joint.closes_loop) continue;
    dynamics::Joint* made = nodes[index_of(joint.child)]->getParentJoint();
    if (joint.driven_rate) {
      made->setCommand(0, *joint.driven_rate);
      continue;
    }
    for (int k = 0; k < rate_count(joint.kind); ++k) made->setForce(static_cast<std::size_t>(k), efforts[j][k]);
  }
}

rivals::JointState joint_of(const Scene& scene, int j, const dynamics::BodyNode& child) {
  const Joint& joint = scene.joints[index_of(j)];
  const dynamics::Joint* made = child.getParentJoint();
  rivals::JointState state;
  if (joint.kind == JointKind::ball) {
    const Eigen::Matrix3d r = dynamics::BallJoint::convertToRotation(made->getPositions());
    state.q = rivals::quaternion_of({r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)});
    state.u = real3(made->getVelocities());
    return state;
  }
  for (int k = 0; k < coordinate_count(joint.kind); ++k) {
    state.q[k] = made->getPosition(static_cast<std::size_t>(k));
    state.u[k] = made->getVelocity(static_cast<std::size_t>(k));
  }
  return state;
}

std::vector<rivals::Reaction> reactions_of(const Scene& scene, const std::vector<dynamics::BodyNode*>& nodes,
                                           const std::vector<Motion>& motions,
                                           const std::vector<rivals::Wrench>& wrenches) {
  std::vector<rivals::Wrench> missing(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (body.fixed) continue;
    const Real3 &w = motions[i].w_WB_B,
                alpha = rivals::to_body(motions[i].q_WB, real3(nodes[i]->getAngularAcceleration()));
    const Real33& inertia = body.inertia_kg_m2;
    const Real3 rate = rivals::times(inertia, alpha) + cross(w, rivals::times(inertia, w));
    missing[i].force_N = body.mass_kg * (real3(nodes[i]->getLinearAcceleration()) - scene.gravity_m_per_s2);
    missing[i].torque_N_m = rivals::to_world(motions[i].q_WB, rate);
    if (wrenches.empty()) continue;
    missing[i].force_N = missing[i].force_N - wrenches[i].force_N;
    missing[i].torque_N_m = missing[i].torque_N_m - wrenches[i].torque_N_m;
  }
  return rivals::subtree_reactions(scene, motions, std::move(missing),
                                   std::vector<rivals::Reaction>(scene.joints.size()));
}

bool reactions_hidden(const Scene& scene, const std::vector<dynamics::BodyNode*>& nodes) {
  if (rivals::shapes_matter(scene)) return true;
  return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const Joint& joint) {
    if (joint.closes_loop) return true;
    if (!joint.limits) return false;
    const double q = nodes[index_of(joint.child)]->getParentJoint()->getPosition(0);
    return q <= joint.limits->lower || q >= joint.limits->upper;
  });
}

}  // namespace atwood::dartsim
