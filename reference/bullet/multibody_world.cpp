#include "bullet/multibody_world.hpp"

#include <BulletDynamics/Featherstone/btMultiBody.h>
#include <BulletDynamics/Featherstone/btMultiBodyConstraintSolver.h>
#include <BulletDynamics/Featherstone/btMultiBodyDynamicsWorld.h>
#include <BulletDynamics/Featherstone/btMultiBodyFixedConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointFeedback.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointLimitConstraint.h>
#include <BulletDynamics/Featherstone/btMultiBodyJointMotor.h>
#include <BulletDynamics/Featherstone/btMultiBodyLinkCollider.h>
#include <BulletDynamics/Featherstone/btMultiBodyPoint2Point.h>
#include <btBulletDynamicsCommon.h>

#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "bullet/bullet_world.hpp"
#include "bullet/multibody_tree.hpp"
#include "bullet/narrow.hpp"
#include "protocol/printed_setting.hpp"
#include "rivals/vector.hpp"

namespace atwood::bullet {
namespace {

using rivals::operator*;
using rivals::operator+;
using rivals::JointState;
using rivals::Motion;
using rivals::Reaction;
using rivals::Wrench;

constexpr double kUnbounded = 1e18;  // of an impulse

bool constrained(const Joint& joint) { return joint.closes_loop || joint.limits || joint.driven_rate; }
bool has_constraints(const Scene& scene) {
  for (const Joint& joint : scene.joints)
    if (constrained(joint)) return true;
  return false;
}

class MultibodyWorld : public rivals::World {
 public:
  MultibodyWorld(const Scene& scene, const Settings& settings, bool observe)
      : scene_(scene), settings_(settings), dispatcher_(&configuration_),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_), trees_(scene),
        reports_(observe && !scene.joints.empty() && !has_constraints(scene)) {
    world_.setGravity(narrow(scene.gravity_m_per_s2));
    set_solver(world_.getSolverInfo(), settings);
    for (const auto& tree : trees_.bodies()) add(*tree);
    if (reports_) listen();
    if (has_constraints(scene)) constrain();
  }
  ~MultibodyWorld() override {
    for (const auto& constraint : constraints_) world_.removeMultiBodyConstraint(constraint.get());
    for (const auto& collider : colliders_) world_.removeCollisionObject(collider.get());
    for (const auto& tree : trees_.bodies()) world_.removeMultiBody(tree.get());
  }
  MultibodyWorld(const MultibodyWorld&) = delete;
  MultibodyWorld& operator=(const MultibodyWorld&) = delete;

  void step(double h_s, const std::vector<Wrench>& wrenches) override {
    apply(wrenches);
    world_.stepSimulation(narrow(h_s), 0);
    trees_.moved();
  }
  Motion motion(int body) const override { return trees_.motion(body); }
  std::optional<JointState> joint(int j) const override {
    if (scene_.joints[static_cast<std::size_t>(j)].closes_loop) return std::nullopt;
    return trees_.joint(j);
  }
  void release(int) override {}
  std::vector<Touch> touches() const override { return {}; }

  // The articulated-body algorithm once more, at the present state and for a step of no length, which changes nothing.
  std::vector<Reaction> reactions(double, const std::vector<Wrench>& wrenches) override {
    if (!reports_) return {};
    world_.applyGravity();
    apply(wrenches);
    for (const auto& tree : trees_.bodies())
      tree->computeAccelerationsArticulatedBodyAlgorithmMultiDof(0, numbers_, vectors_, matrices_, false, false, true);
    world_.clearMultiBodyForces();
    std::vector<Reaction> all;
    for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
      const Joint& joint = scene_.joints[j];
      const Motion child = motion(joint.child);
      const btSpatialForceVector& found = feedback_[j].m_reactionForces;
      const Reaction total{trees_.link_to_world(joint.child, widen(found.m_topVec)),
                           trees_.link_to_world(joint.child, widen(found.m_bottomVec))};
      const Motion parent = joint.parent < 0 || scene_.bodies[static_cast<std::size_t>(joint.parent)].fixed
                                ? rivals::motion_at_start(scene_, joint.parent)
                                : motion(joint.parent);
      all.push_back(rivals::constraint_part(joint, rivals::place_of(joint, parent, child), total));
    }
    return all;
  }

 private:
  void add(btMultiBody& tree) {
    tree.setLinearDamping(narrow(rivals::number(settings_, "linear_damping")));
    tree.setAngularDamping(narrow(rivals::number(settings_, "angular_damping")));
    tree.setMaxCoordinateVelocity(narrow(rivals::number(settings_, "max_coordinate_velocity")));
    tree.setMaxAppliedImpulse(narrow(rivals::number(settings_, "max_applied_impulse")));
    tree.setUseGyroTerm(rivals::flag(settings_, "multibody_gyroscopic"));
    tree.useRK4Integration(rivals::word(settings_, "multibody_integrator") == kRungeKutta);
    tree.setHasSelfCollision(false);
    world_.addMultiBody(&tree, 0, 0);
  }

  void listen() {
    feedback_.resize(scene_.joints.size());
    for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
      const MultibodyLink at = trees_.link_of(scene_.joints[j].child);
      at.tree->getLink(at.link).m_jointFeedback = &feedback_[j];
    }
  }

  void apply(const std::vector<Wrench>& wrenches) {
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      const MultibodyLink at = trees_.link_of(static_cast<int>(i));
      if (!at.tree) continue;
      const btVector3 force = narrow(wrenches[i].force_N), torque = narrow(wrenches[i].torque_N_m);
      if (at.link < 0) {
        at.tree->addBaseForce(force);
        if (rotates(scene_.bodies[i])) at.tree->addBaseTorque(torque);
      } else {
        at.tree->addLinkForce(at.link, force);
        at.tree->addLinkTorque(at.link, torque);
      }
    }
  }

  void constrain() {
    for (const auto& tree : trees_.bodies()) {
      for (int k = -1; k < tree->getNumLinks(); ++k) {
        colliders_.push_back(std::make_unique<btMultiBodyLinkCollider>(tree.get(), k));
        btMultiBodyLinkCollider& collider = *colliders_.back();
        collider.setCollisionShape(&speck_);
        collider.setActivationState(DISABLE_DEACTIVATION);
        if (k < 0) {
          tree->setBaseCollider(&collider);
        } else {
          tree->getLink(k).m_collider = &collider;
        }
        world_.addCollisionObject(&collider, 0, 0);
      }
    }
    for (std::size_t j = 0; j < scene_.joints.size(); ++j) {
      const Joint& joint = scene_.joints[j];
      const MultibodyLink at = trees_.link_of(joint.child);
      if (joint.closes_loop) {
        close(joint);
      } else if (joint.limits) {
        keep(std::make_unique<btMultiBodyJointLimitConstraint>(at.tree, at.link, narrow(joint.limits->lower),
                                                               narrow(joint.limits->upper)));
      } else if (joint.driven_rate) {
        keep(std::make_unique<btMultiBodyJointMotor>(at.tree, at.link, narrow(*joint.driven_rate), narrow(kUnbounded)));
      }
    }
  }

  // A point of a scene's body, or of the world, in the axes of its link.
  btVector3 in_link(int body, const Real3& point_B) const {
    if (!trees_.link_of(body).tree) {
      const Motion pose = rivals::motion_at_start(scene_, body);
      return narrow(pose.p_WB + rivals::to_world(pose.q_WB, point_B));
    }
    return narrow(rivals::to_world(trees_.turn_to_link(body), point_B));
  }

  void close_at(const Joint& joint, const Real3& of_parent_B, const Real3& of_child_B) {
    const MultibodyLink child = trees_.link_of(joint.child), parent = trees_.link_of(joint.parent);
    const btVector3 a = in_link(joint.child, of_child_B), b = in_link(joint.parent, of_parent_B);
    if (parent.tree) {
      keep(std::make_unique<btMultiBodyPoint2Point>(child.tree, child.link, parent.tree, parent.link, a, b));
    } else {
      keep(std::make_unique<btMultiBodyPoint2Point>(child.tree, child.link, &btTypedConstraint::getFixedBody(), a, b));
    }
  }

  void close(const Joint& joint) {
    const auto& [of_parent, of_child] = joint.anchors_body_m;
    if (joint.kind == JointKind::ball) return close_at(joint, of_parent, of_child);
    if (joint.kind == JointKind::hinge) {  // two points of the axis, the child's radius of gyration to both sides
      const Body& body = scene_.bodies[static_cast<std::size_t>(joint.child)];
      const Real33& inertia = body.inertia_kg_m2;
      const double reach_m = std::sqrt((inertia[0] + inertia[4] + inertia[8]) / (2 * body.mass_kg));
      for (const double side : {-1.0, 1.0}) {
        const Real3 along = (side * reach_m) * joint.axis_body;
        close_at(joint, of_parent + rivals::to_world(joint.frame_wxyz, along), of_child + along);
      }
      return;
    }
    // A fixed joint: the frames of both sides coincide.
    const MultibodyLink child = trees_.link_of(joint.child), parent = trees_.link_of(joint.parent);
    const auto basis = [](const Real4& q) { return btMatrix3x3(narrow(q).normalized()); };
    const Real4 in_parent = rivals::product(trees_.turn_to_link(joint.parent), joint.frame_wxyz);
    const btMatrix3x3 a = basis(trees_.turn_to_link(joint.child));
    if (parent.tree) {
      keep(std::make_unique<btMultiBodyFixedConstraint>(child.tree, child.link, parent.tree, parent.link,
                                                        in_link(joint.child, of_child),
                                                        in_link(joint.parent, of_parent), a, basis(in_parent)));
    } else {
      // Bullet takes the transpose of a frame that belongs to a rigid body.
      const Motion pose = rivals::motion_at_start(scene_, joint.parent);
      keep(std::make_unique<btMultiBodyFixedConstraint>(
          child.tree, child.link, &btTypedConstraint::getFixedBody(), in_link(joint.child, of_child),
          in_link(joint.parent, of_parent), a, basis(rivals::product(pose.q_WB, joint.frame_wxyz)).transpose()));
    }
  }

  void keep(std::unique_ptr<btMultiBodyConstraint> constraint) {
    constraint->setMaxAppliedImpulse(narrow(rivals::number(settings_, "max_applied_impulse")));
    constraint->finalizeMultiDof();
    world_.addMultiBodyConstraint(constraint.get());
    constraints_.push_back(std::move(constraint));
  }

  const Scene& scene_;
  const Settings& settings_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btMultiBodyConstraintSolver solver_;
  btMultiBodyDynamicsWorld world_;
  MultibodyTrees trees_;
  bool reports_ = false;
  std::vector<btMultiBodyJointFeedback> feedback_;
  btSphereShape speck_{narrow(1e-3)};
  std::vector<std::unique_ptr<btMultiBodyLinkCollider>> colliders_;
  std::vector<std::unique_ptr<btMultiBodyConstraint>> constraints_;
  btAlignedObjectArray<btScalar> numbers_;
  btAlignedObjectArray<btVector3> vectors_;
  btAlignedObjectArray<btMatrix3x3> matrices_;
};

}  // namespace

std::vector<Setting> multibody_settings() {
  return {printed("formulation", std::string(kMaximal), "Rigid bodies under constraints, or btMultiBody."),
          printed("multibody_integrator", std::string("none"), "Of btMultiBody."),
          {"max_coordinate_velocity",
           1e18,
           {between(0, 1e18), "Largest rate of a multibody's coordinates [1/s or m/s]; Bullet's own is 100."}},
          {"max_applied_impulse",
           1e18,
           {between(0, 1e18), "Largest impulse of a constraint of multibodies [N s or N m s]; Bullet's own is 1000."}},
          {"multibody_gyroscopic", true, {{}, "The gyroscopic term acts on multibodies."}}};
}

bool in_reduced_coordinates(const Settings& settings) { return rivals::word(settings, "formulation") == kReduced; }

std::optional<Fault> refused_by_multibodies(const Scene& scene, const Settings& settings) {
  const auto name = [&](int body) { return "`" + scene.bodies[static_cast<std::size_t>(body)].name + "`"; };
  if (!scene.ropes.empty()) return Fault{"Bullet has no ropes; found `" + scene.ropes[0].name + "`"};
  if (rivals::shapes_matter(scene))
    return Fault{"the adapter's multibodies of Bullet have no contacts; bodies have shapes"};
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (!scene.bodies[i].fixed && scene.bodies[i].release_s > 0)
      return Fault{"the adapter's multibodies of Bullet are not held; " + name(static_cast<int>(i)) +
                   " is until its release"};
  if (const int body = rivals::turning_point_mass(scene); body >= 0)
    return Fault{"Bullet requires an inertia for every body that a joint rotates; " + name(body) + " has none"};
  if (const int body = rivals::jointed_point_mass(scene); body >= 0)
    return Fault{"Bullet requires an inertia of a free body with joints; " + name(body) + " has none"};
  const bool runge_kutta = rivals::word(settings, "multibody_integrator") == kRungeKutta;
  for (const Joint& joint : scene.joints) {
    const std::string which = "; found the joint `" + joint.name + "`";
    if (runge_kutta && constrained(joint))
      return Fault{
          "Bullet's Runge-Kutta step sets positions before constraints change velocities, so that closing joints, limits "
          "and driven rates have no effect on it" +
          which};
    if (joint.closes_loop && joint.kind != JointKind::ball && joint.kind != JointKind::hinge &&
        joint.kind != JointKind::fixed)
      return Fault{"Bullet's multibodies close loops by balls, hinges and fixed joints" + which};
    if (joint.limits && joint.limits->restitution > 0)
      return Fault{"stops of Bullet's multibodies have no restitution" + which};
    if (joint.limits && joint.driven_rate)
      return Fault{"Bullet's motors stop at stops; `" + joint.name + "` has a driven rate and limits"};
  }
  return {};
}

std::unique_ptr<rivals::World> make_multibody_world(const Scene& scene, const Settings& settings, bool observe) {
  return std::make_unique<MultibodyWorld>(scene, settings, observe);
}

}  // namespace atwood::bullet
