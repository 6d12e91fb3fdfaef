#include "dart/dart_world.hpp"

#include <algorithm>
#include <cmath>
#include <dart/collision/CollisionFilter.hpp>
#include <dart/collision/CollisionObject.hpp>
#include <dart/collision/dart/DARTCollisionDetector.hpp>
#include <dart/collision/ode/OdeCollisionDetector.hpp>
#include <dart/config.hpp>
#include <dart/constraint/BoxedLcpConstraintSolver.hpp>
#include <dart/constraint/ContactConstraint.hpp>
#include <dart/constraint/DantzigBoxedLcpSolver.hpp>
#include <dart/constraint/PgsBoxedLcpSolver.hpp>
#include <dart/dynamics/BodyNode.hpp>
#include <dart/dynamics/FreeJoint.hpp>
#include <dart/dynamics/Skeleton.hpp>
#include <dart/dynamics/TranslationalJoint.hpp>
#include <dart/dynamics/WeldJoint.hpp>
#include <dart/simulation/World.hpp>
#include <iostream>
#include <limits>
#include <unordered_map>

#include "dart/mechanism.hpp"
#include "dart/shapes.hpp"
#include "dart/surfaces.hpp"
#include "rivals/vector.hpp"

namespace atwood::dartsim {
namespace {

using rivals::operator*;
using rivals::operator-;
using rivals::operator+;
using rivals::Motion;
using rivals::Wrench;
namespace dynamics = dart::dynamics;
namespace collision = dart::collision;
namespace constraint = dart::constraint;

Eigen::Vector3d vector3(const Real3& v) { return {v[0], v[1], v[2]}; }
Real3 real3(const Eigen::Vector3d& v) { return {v[0], v[1], v[2]}; }
Eigen::Isometry3d pose(const Real3& p, const Real4& q) {
  Eigen::Isometry3d transform = Eigen::Isometry3d::Identity();
  transform.linear() = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix();
  transform.translation() = vector3(p);
  return transform;
}

// DART writes thousands of warnings per run to std::cerr, and messages to std::cout, which carries the worker's
// protocol. Inside the scope of this object they are counted instead, and the first is kept.
std::int64_t line_count = 0;
std::string first_line;
class MessageCounter : public std::streambuf {
 public:
  MessageCounter() : errors_(std::cerr.rdbuf(this)), remarks_(std::cout.rdbuf(this)) {}
  ~MessageCounter() override {
    std::cerr.rdbuf(errors_);
    std::cout.rdbuf(remarks_);
  }

 protected:
  int overflow(int c) override {
    if (c == '\n') ++line_count;
    if (c != '\n' && line_count == 0) first_line += static_cast<char>(c);
    return c;
  }

 private:
  std::streambuf *errors_, *remarks_;
};

// The body of a shape, and the material of the other body that the shape is for (-1: all).
struct Owner {
  int body = 0, partner = -1;
};
using Owners = std::unordered_map<const dynamics::ShapeFrame*, Owner>;

class ScenePairFilter : public collision::CollisionFilter {
 public:
  ScenePairFilter(const Scene& scene, const std::vector<dynamics::SkeletonPtr>& skeletons, const Owners& owners)
      : scene_(scene), skeletons_(skeletons), owners_(owners) {}
  bool ignoresCollision(const collision::CollisionObject* first,
                        const collision::CollisionObject* second) const override {
    const Owner a = owners_.at(first->getShapeFrame()), b = owners_.at(second->getShapeFrame());
    if (a.body == b.body || rivals::joined(scene_, a.body, b.body)) return true;
    if (a.partner >= 0 && a.partner != scene_.bodies[b.body].material) return true;
    if (b.partner >= 0 && b.partner != scene_.bodies[a.body].material) return true;
    return !skeletons_[a.body]->isMobile() && !skeletons_[b.body]->isMobile();
  }

 private:
  const Scene& scene_;
  const std::vector<dynamics::SkeletonPtr>& skeletons_;
  const Owners& owners_;
};

const dynamics::ShapeNode* shape_node(const collision::CollisionObject* object) {
  return object->getShapeFrame()->asShapeNode();
}

// Aligns the friction pyramids with the slip before the contact constraints are built.
class SlipDetector : public collision::OdeCollisionDetector {
 public:
  bool collide(collision::CollisionGroup* group, const collision::CollisionOption& option,
               collision::CollisionResult* result) override {
    const bool collides = OdeCollisionDetector::collide(group, option, result);
    if (result) align(*result);
    return collides;
  }
  using OdeCollisionDetector::collide;

 private:
  void align(const collision::CollisionResult& result) {
    for (auto& [node, speed] : fastest_) {
      node->getDynamicsAspect()->setFirstFrictionDirection(Eigen::Vector3d::Zero());
      speed = 0;
    }
    for (const auto& contact : result.getContacts()) {
      const auto velocity = [&](const dynamics::ShapeNode* node) -> Eigen::Vector3d {
        const auto body = node->getBodyNodePtr();
        return body->getLinearVelocity(body->getWorldTransform().inverse() * contact.point);
      };
      const dynamics::ShapeNode* nodes[] = {shape_node(contact.collisionObject1), shape_node(contact.collisionObject2)};
      const Eigen::Vector3d u = velocity(nodes[0]) - velocity(nodes[1]);
      const Eigen::Vector3d slip = u - u.dot(contact.normal) * contact.normal;
      const double speed = slip.norm();
      if (!(speed > 1e-9)) continue;
      for (const auto* node : nodes) {
        double& fastest = fastest_[const_cast<dynamics::ShapeNode*>(node)];
        if (!(speed > fastest)) continue;
        fastest = speed;
        auto* aspect = const_cast<dynamics::ShapeNode*>(node)->getDynamicsAspect();
        aspect->setFirstFrictionDirectionFrame(dynamics::Frame::World());
        aspect->setFirstFrictionDirection(slip / speed);
      }
    }
  }
  std::unordered_map<dynamics::ShapeNode*, double> fastest_;
};

std::shared_ptr<collision::CollisionDetector> detector_of(const Settings& settings) {
  const auto& name = std::get<std::string>(settings.at("collision_detector"));
  if (name == "dart") return collision::DARTCollisionDetector::create();
  if (std::get<std::string>(settings.at("friction_direction")) == "slip") return std::make_shared<SlipDetector>();
  return collision::OdeCollisionDetector::create();
}

constraint::BoxedLcpSolverPtr lcp_solver(const Settings& settings, const std::string& setting) {
  const auto& name = std::get<std::string>(settings.at(setting));
  if (name == "none") return nullptr;
  if (name == "dantzig") return std::make_shared<constraint::DantzigBoxedLcpSolver>();
  auto pgs = std::make_shared<constraint::PgsBoxedLcpSolver>();
  pgs->setOption({static_cast<int>(rivals::count(settings, "pgs_iterations")),
                  rivals::number(settings, "pgs_tolerance"), rivals::number(settings, "pgs_relative_tolerance"), 1e-9,
                  false});
  return pgs;
}

class DartWorld : public rivals::World {
 public:
  DartWorld(const Scene& scene, const Settings& settings)
      : scene_(scene), laws_(rivals::laws_in_play(scene)), world_(dart::simulation::World::create()) {
    const MessageCounter counter;
    world_->setGravity(vector3(scene.gravity_m_per_s2));
    using constraint::ContactConstraint;
    ContactConstraint::setErrorAllowance(rivals::number(settings, "error_allowance_m"));
    ContactConstraint::setErrorReductionParameter(rivals::number(settings, "erp"));
    ContactConstraint::setMaxErrorReductionVelocity(rivals::number(settings, "max_erv_m_per_s"));
    ContactConstraint::setConstraintForceMixing(rivals::number(settings, "cfm"));
    world_->setConstraintSolver(std::make_unique<constraint::BoxedLcpConstraintSolver>(
        lcp_solver(settings, "lcp_solver"), lcp_solver(settings, "secondary_lcp_solver")));
    auto* solver = world_->getConstraintSolver();
    if (std::get<std::string>(settings.at("collision_detector")) != "fcl")
      solver->setCollisionDetector(detector_of(settings));
    solver->getCollisionOption().collisionFilter = std::make_shared<ScenePairFilter>(scene_, skeletons_, owners_);
    const auto room = static_cast<std::size_t>(rivals::count(settings, "contacts_per_body")) * scene.bodies.size();
    solver->getCollisionOption().maxNumContacts = std::max<std::size_t>(1000, room);
    placing_ = rivals::placing_joints(scene);
    nodes_.resize(scene.bodies.size());
    skeletons_.resize(scene.bodies.size());
    for (const int i : rivals::parents_first(scene)) add(i);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (nodes_[i]->getParentBodyNode() == nullptr) world_->addSkeleton(skeletons_[i]);
    }
    add_closing_joints(scene, nodes_, *world_);
  }

  void step(double h_s, const std::vector<Wrench>& wrenches) override {
    if (lost_) return;
    put(wrenches);
    if (lost_) return;
    if (h_s != h_s_) world_->setTimeStep(h_s);
    h_s_ = h_s;
    if (!scene_.joints.empty()) command(scene_, nodes_, t_s_, t_s_ + 0.5 * h_s);
    t_s_ += h_s;
    const MessageCounter counter;
    world_->step();
    // The next step squares speeds, and DART's assertions would end the process on NaN.
    constexpr double max_speed = 1e60;
    for (const auto* node : nodes_) lost_ = lost_ || !(node->getSpatialVelocity().cwiseAbs().maxCoeff() < max_speed);
  }

  Motion motion(int i) const override {
    if (lost_) {
      const double nan = std::numeric_limits<double>::quiet_NaN();
      return {{nan, nan, nan}, {nan, nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}};
    }
    const dynamics::BodyNode* node = nodes_[i];
    const Eigen::Isometry3d& at = node->getWorldTransform();
    const Eigen::Matrix3d& r = at.linear();
    Motion m;
    m.p_WB = real3(at.translation());
    m.v_WB = real3(node->getLinearVelocity());
    m.q_WB = scene_.bodies[i].orientation_wxyz;
    if (!rotates(scene_.bodies[i])) return m;
    m.q_WB = rivals::quaternion_of({r(0, 0), r(0, 1), r(0, 2), r(1, 0), r(1, 1), r(1, 2), r(2, 0), r(2, 1), r(2, 2)});
    m.w_WB_B = real3(node->getSpatialVelocity().head<3>());
    return m;
  }

  std::optional<rivals::JointState> joint(int j) const override {
    if (lost_ || scene_.joints[static_cast<std::size_t>(j)].closes_loop) return std::nullopt;
    return joint_of(scene_, j, *nodes_[static_cast<std::size_t>(scene_.joints[static_cast<std::size_t>(j)].child)]);
  }
  bool joint_forces_inside() const override { return true; }
  // Forward dynamics changes accelerations alone, and the next step computes them again.
  std::vector<rivals::Reaction> reactions(double t_s, const std::vector<Wrench>& wrenches) override {
    if (lost_ || reactions_hidden(scene_, nodes_)) return {};
    put(wrenches);
    command(scene_, nodes_, t_s, t_s + 0.5 * h_s_);
    std::vector<Motion> motions;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      const int body = static_cast<int>(i);
      motions.push_back(skeletons_[i]->isMobile() ? motion(body) : rivals::motion_at_start(scene_, body));
      if (skeletons_[i]->isMobile() && nodes_[i]->getParentBodyNode() == nullptr)
        skeletons_[i]->computeForwardDynamics();
    }
    return reactions_of(scene_, nodes_, motions, wrenches);
  }

  void release(int i) override {
    skeletons_[i]->setMobile(true);
    set_velocity(i);
  }

  std::vector<Touch> touches() const override {
    std::vector<Touch> all;
    for (const auto& contact : world_->getLastCollisionResult().getContacts()) {
      const int first = owner_of(contact.collisionObject1), second = owner_of(contact.collisionObject2);
      const double to_b = first < second ? -1.0 : 1.0;
      const Real3 force = to_b * real3(contact.force), normal = to_b * real3(contact.normal);
      const double along = rivals::dot(force, normal);
      if (!(along > 0)) continue;
      all.push_back({std::min(first, second), std::max(first, second), real3(contact.point), normal,
                     -contact.penetrationDepth, along * h_s_, h_s_ * (force - along * normal)});
    }
    return all;
  }

 private:
  int owner_of(const collision::CollisionObject* object) const { return owners_.at(object->getShapeFrame()).body; }

  void put(const std::vector<Wrench>& wrenches) {
    for (std::size_t i = 0; i < wrenches.size() && !lost_; ++i) {
      if (scene_.bodies[i].fixed) continue;
      const Eigen::Vector3d force = vector3(wrenches[i].force_N), torque = vector3(wrenches[i].torque_N_m);
      lost_ = lost_ || !force.allFinite() || !torque.allFinite();
      if (lost_) return;
      nodes_[i]->setExtForce(force, Eigen::Vector3d::Zero(), false, true);
      if (rotates(scene_.bodies[i])) nodes_[i]->addExtTorque(torque, false);
    }
  }

  void add_to_tree(int i) {
    const Joint& joint = scene_.joints[static_cast<std::size_t>(placing_[i])];
    const bool grounded = joint.parent < 0 || scene_.bodies[joint.parent].fixed;
    skeletons_[i] = grounded ? dynamics::Skeleton::create(std::to_string(i)) : skeletons_[joint.parent];
    nodes_[i] = add_placed_body(scene_, placing_[i], *skeletons_[i], grounded ? nullptr : nodes_[joint.parent]);
    set_inertia(i);
    add_shapes(i);
  }

  void add(int i) {
    if (placing_[i] >= 0) return add_to_tree(i);
    const Body& body = scene_.bodies[i];
    const auto skeleton = dynamics::Skeleton::create(std::to_string(i));
    const bool in_world_axes = std::holds_alternative<Plane>(body.shape);
    const Eigen::Isometry3d at =
        in_world_axes ? Eigen::Isometry3d::Identity() : pose(body.position_m, body.orientation_wxyz);
    if (body.fixed) {
      const auto [joint, node] = skeleton->createJointAndBodyNodePair<dynamics::WeldJoint>();
      joint->setTransformFromParentBodyNode(at);
      nodes_[i] = node;
    } else if (rotates(body)) {
      const auto [joint, node] = skeleton->createJointAndBodyNodePair<dynamics::FreeJoint>();
      joint->setTransform(at);
      nodes_[i] = node;
    } else {
      const auto [joint, node] = skeleton->createJointAndBodyNodePair<dynamics::TranslationalJoint>();
      joint->setTransformFromChildBodyNode(pose({}, body.orientation_wxyz).inverse());
      joint->setPositions(vector3(body.position_m));
      nodes_[i] = node;
    }
    skeletons_[i] = skeleton;
    if (!body.fixed) set_inertia(i);
    add_shapes(i);
    skeleton->setMobile(!body.fixed && !(body.release_s > 0));
    if (skeleton->isMobile()) set_velocity(i);
  }

  void set_inertia(int i) {
    const Body& body = scene_.bodies[i];
    const Real33& m = body.inertia_kg_m2;
    Eigen::Matrix3d moment = Eigen::Matrix3d::Identity();  // for a point mass, which does not rotate
    if (rotates(body)) moment << m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8];
    nodes_[i]->setInertia(dynamics::Inertia(body.mass_kg, Eigen::Vector3d::Zero(), moment));
  }

  void add_shapes(int i) {
    const Body& body = scene_.bodies[i];
    if (!rivals::shapes_matter(scene_)) return;
    const std::vector<PlacedShape> shapes = shapes_of(body);
    for (const Surface& surface : surfaces_of(body.material, laws_)) {
      for (const PlacedShape& placed : shapes) {
        auto* node = nodes_[i]->createShapeNodeWith<dynamics::CollisionAspect, dynamics::DynamicsAspect>(placed.shape);
        node->setRelativeTransform(pose(placed.p_B, placed.q_B));
        node->getDynamicsAspect()->setFrictionCoeff(surface.friction);
        node->getDynamicsAspect()->setRestitutionCoeff(surface.restitution);
        owners_[node] = {i, surface.partner};
      }
    }
  }

  void set_velocity(int i) {
    const Body& body = scene_.bodies[i];
    auto* joint = nodes_[i]->getParentJoint();
    const Eigen::Vector3d v = vector3(body.velocity_m_per_s);
    if (!rotates(body)) {
      joint->setVelocities(v);
      return;
    }
    Eigen::VectorXd twist(6);
    twist << vector3(body.angular_velocity_body_rad_per_s), nodes_[i]->getWorldTransform().linear().transpose() * v;
    joint->setVelocities(twist);
  }

  const Scene& scene_;
  std::vector<PairLaw> laws_;
  std::vector<dynamics::SkeletonPtr> skeletons_;
  std::vector<dynamics::BodyNode*> nodes_;
  Owners owners_;
  dart::simulation::WorldPtr world_;  // destroyed first: it refers to the others
  std::vector<int> placing_;          // joint by body
  double h_s_ = 0, t_s_ = 0;
  bool lost_ = false;
};

}  // namespace

std::string version() { return DART_VERSION; }

std::string diagnostics_since_last_call() {
  std::string text;
  if (line_count > 0) text = "DART printed " + std::to_string(line_count) + " lines, first: " + first_line;
  line_count = 0;
  first_line.clear();
  return text;
}

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool) {
  return std::make_unique<DartWorld>(scene, settings);
}

}  // namespace atwood::dartsim
