#include "bullet/bullet_world.hpp"

#include <BulletCollision/CollisionDispatch/btCollisionObjectWrapper.h>
#include <BulletCollision/CollisionDispatch/btInternalEdgeUtility.h>
#include <btBulletDynamicsCommon.h>

#include <stdexcept>
#include <vector>

#include "bullet/joints.hpp"
#include "bullet/multibody_world.hpp"
#include "bullet/narrow.hpp"
#include "bullet/shapes.hpp"
#include "protocol/printed_setting.hpp"
#include "rivals/vector.hpp"

#ifdef BT_USE_DOUBLE_PRECISION
static_assert(sizeof(btScalar) == 8, "the double build of Bullet must see btScalar as double");
#else
static_assert(sizeof(btScalar) == 4, "the float build of Bullet must see btScalar as float");
#endif

namespace atwood::bullet {
namespace {

using rivals::operator*;
using rivals::operator+;
using rivals::Motion;
using rivals::Wrench;

// Bullet asks for a pair's coefficients through plain function pointers; the scene hangs on each collision object.
const PairLaw& law_of(const btCollisionObject* a, const btCollisionObject* b) {
  return pair_law(*static_cast<const Scene*>(a->getUserPointer()), a->getUserIndex(), b->getUserIndex());
}
btScalar restitution_of(const btCollisionObject* a, const btCollisionObject* b) {
  return narrow(law_of(a, b).restitution);
}
btScalar friction_of(const btCollisionObject* a, const btCollisionObject* b) { return narrow(law_of(a, b).friction); }

btScalar rolling_friction_of(const btCollisionObject* a, const btCollisionObject* b) {
  return narrow(law_of(a, b).rolling_friction_m);
}

// Called for meshes that ask for it: turns a contact's normal at an inner edge to the face's.
bool smooth_inner_edge(btManifoldPoint& point, const btCollisionObjectWrapper* a, int part_a, int triangle_a,
                       const btCollisionObjectWrapper* b, int part_b, int triangle_b) {
  if (b->getCollisionShape()->getShapeType() == TRIANGLE_SHAPE_PROXYTYPE) {
    btAdjustInternalEdgeContacts(point, b, a, part_b, triangle_b);
  } else {
    btAdjustInternalEdgeContacts(point, a, b, part_a, triangle_a);
  }
  return true;
}

int gyroscopic_flag(const Settings& settings) {
  const auto word = rivals::word(settings, "gyroscopic");
  if (word == "implicit-body") return BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY;
  if (word == "implicit-world") return BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD;
  return word == "explicit" ? BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT : 0;
}

class BulletWorld : public rivals::World {
 public:
  BulletWorld(const Scene& scene, const Settings& settings, bool observe)
      : scene_(scene), settings_(settings), observe_(observe && !scene.joints.empty()), dispatcher_(&configuration_),
        shapes_(rivals::number(settings, "collision_margin_m"), rivals::flag(settings, "smooth_inner_edges")),
        world_(&dispatcher_, &broadphase_, &solver_, &configuration_) {
    gContactBreakingThreshold = narrow(rivals::number(settings, "contact_breaking_threshold_m"));
    gCalculateCombinedRestitutionCallback = restitution_of;
    gCalculateCombinedFrictionCallback = friction_of;
    gCalculateCombinedRollingFrictionCallback = rolling_friction_of;
    gContactAddedCallback = smooth_inner_edge;
    world_.setGravity(narrow(scene.gravity_m_per_s2));
    set_solver(world_.getSolverInfo(), settings);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(static_cast<int>(i));
    std::vector<std::array<Mount, 2>> mounts;
    for (const Joint& joint : scene.joints) mounts.push_back({mount(joint.parent), mount(joint.child)});
    joints_ = std::make_unique<Joints>(world_, scene, mounts, rivals::number(settings, "erp"), observe_);
  }
  ~BulletWorld() override {
    joints_.reset();
    for (auto& body : bodies_)
      if (body) world_.removeRigidBody(body.get());
  }
  BulletWorld(const BulletWorld&) = delete;
  BulletWorld& operator=(const BulletWorld&) = delete;

  void step(double h_s, const std::vector<Wrench>& wrenches) override {
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      if (!bodies_[i] || bodies_[i]->isStaticObject()) continue;
      bodies_[i]->applyCentralForce(narrow(wrenches[i].force_N));
      bodies_[i]->applyTorque(narrow(wrenches[i].torque_N_m));
    }
    if (observe_) joints_->before(motions());
    world_.stepSimulation(narrow(h_s), 0);
    if (observe_) joints_->after();
  }

  std::vector<rivals::Reaction> reactions(double, const std::vector<Wrench>&) override { return joints_->reactions(); }

  Motion motion(int i) const override {
    const btRigidBody& body = *bodies_[i];
    const btTransform& pose = body.getWorldTransform();
    const Real4 q_WP = rivals::quaternion_of(widen(pose.getBasis()));
    const Real3 w_WB = widen(body.getAngularVelocity());
    Motion m;
    m.p_WB = widen(pose.getOrigin());
    m.v_WB = widen(body.getLinearVelocity());
    const Real3 w_WB_P = rivals::transposed_times(widen(pose.getBasis()), w_WB);
    m.q_WB = turned_[i] ? rivals::product(q_WP, rivals::conjugate(q_BP_[i])) : q_WP;
    m.w_WB_B = turned_[i] ? rivals::to_world(q_BP_[i], w_WB_P) : w_WB_P;
    return m;
  }

  void release(int i) override {
    btRigidBody& body = *bodies_[i];
    world_.removeRigidBody(&body);
    set_mass(i);
    body.setCollisionFlags(body.getCollisionFlags() & ~btCollisionObject::CF_STATIC_OBJECT);
    set_velocity(i);
    insert(i);
  }

  // m_normalWorldOnB points from the manifold's second body to its first; friction's impulses act on the first, along
  // the lateral directions. Friction is held to a load of the iteration before, so a point may carry friction and no
  // load.
  std::vector<Touch> touches() const override {
    std::vector<Touch> all;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold* manifold =
          const_cast<btCollisionDispatcher&>(dispatcher_).getManifoldByIndexInternal(m);
      const int first = manifold->getBody0()->getUserIndex(), second = manifold->getBody1()->getUserIndex();
      const double to_b = first < second ? -1.0 : 1.0;
      for (int k = 0; k < manifold->getNumContacts(); ++k) {
        const btManifoldPoint& point = manifold->getContactPoint(k);
        if (point.getDistance() > manifold->getContactProcessingThreshold())
          continue;  // holds an earlier step's impulses
        const Real3 lateral = double(point.m_appliedImpulseLateral1) * widen(point.m_lateralFrictionDir1) +
                              double(point.m_appliedImpulseLateral2) * widen(point.m_lateralFrictionDir2);
        if (point.getAppliedImpulse() == 0 && rivals::length(lateral) == 0) continue;
        all.push_back({std::min(first, second), std::max(first, second), widen(point.getPositionWorldOnB()),
                       to_b * widen(point.m_normalWorldOnB), point.getDistance(), point.getAppliedImpulse(),
                       to_b * lateral});
      }
    }
    return all;
  }

 private:
  void add(int i) {
    const Body& body = scene_.bodies[i];
    bodies_.emplace_back();
    q_BP_.push_back({1, 0, 0, 0});
    turned_.push_back(false);
    if (rotates(body)) {
      q_BP_[i] = rivals::principal_axes(body.inertia_kg_m2).q_BP;
      turned_[i] = q_BP_[i] != Real4{1, 0, 0, 0};
    }
    btCollisionShape* shape = shapes_.make(body.shape, rivals::conjugate(q_BP_[i]));
    if (!shape && !body.fixed) shape = shapes_.speck();
    if (!shape) return;  // a fixed body without a shape takes no part
    const bool held = body.release_s > 0;
    btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shape);
    const bool plane = std::holds_alternative<Plane>(body.shape);
    if (!plane) {
      info.m_startWorldTransform =
          btTransform(narrow(rivals::product(body.orientation_wxyz, q_BP_[i])).normalized(), narrow(body.position_m));
    }
    bodies_[i] = std::make_unique<btRigidBody>(info);
    btRigidBody& made = *bodies_[i];
    made.setUserPointer(const_cast<Scene*>(&scene_));
    made.setUserIndex(i);
    if (std::holds_alternative<Mesh>(body.shape) && rivals::flag(settings_, "smooth_inner_edges")) {
      made.setCollisionFlags(made.getCollisionFlags() | btCollisionObject::CF_CUSTOM_MATERIAL_CALLBACK);
    }
    made.setContactProcessingThreshold(narrow(rivals::number(settings_, "contact_processing_threshold_m")));
    made.setDamping(narrow(rivals::number(settings_, "linear_damping")),
                    narrow(rivals::number(settings_, "angular_damping")));
    if (!rivals::flag(settings_, "sleeping")) made.setActivationState(DISABLE_DEACTIVATION);
    const int gyroscopic = BT_ENABLE_GYROSCOPIC_FORCE_EXPLICIT | BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_WORLD |
                           BT_ENABLE_GYROSCOPIC_FORCE_IMPLICIT_BODY;
    made.setFlags((made.getFlags() & ~gyroscopic) | gyroscopic_flag(settings_));
    if (!body.fixed && !held) {
      set_mass(i);
      set_velocity(i);
    }
    insert(i);
  }

  // Fixed bodies without a shape, planes and the world are not bodies of Bullet: joints hold on to its fixed one.
  Mount mount(int i) const {
    if (i >= 0 && bodies_[i] && !std::holds_alternative<Plane>(scene_.bodies[i].shape))
      return {bodies_[i].get(), {}, rivals::conjugate(q_BP_[i])};
    const Motion pose = rivals::motion_at_start(scene_, i);
    return {&btTypedConstraint::getFixedBody(), pose.p_WB, pose.q_WB};
  }

  std::vector<Motion> motions() const {
    std::vector<Motion> all;
    for (int i = 0; i < static_cast<int>(bodies_.size()); ++i)
      all.push_back(scene_.bodies[i].fixed ? rivals::motion_at_start(scene_, i) : motion(i));
    return all;
  }

  // A body without a shape collides with nothing: filters keep it out, the small sphere is never asked.
  void insert(int i) {
    btRigidBody& body = *bodies_[i];
    if (rivals::has_shape(scene_.bodies[i])) {
      world_.addRigidBody(&body);
    } else {
      world_.addRigidBody(&body, 0, 0);
    }
    if (!body.isStaticObject()) body.setGravity(world_.getGravity());
  }

  void set_mass(int i) {
    const Body& body = scene_.bodies[i];
    const Real3 moments = rotates(body) ? rivals::principal_axes(body.inertia_kg_m2).moments_kg_m2 : Real3{};
    bodies_[i]->setMassProps(narrow(body.mass_kg), narrow(moments));
    bodies_[i]->updateInertiaTensor();
  }

  void set_velocity(int i) {
    const Body& body = scene_.bodies[i];
    bodies_[i]->setLinearVelocity(narrow(body.velocity_m_per_s));
    if (rotates(body)) {
      bodies_[i]->setAngularVelocity(
          narrow(rivals::to_world(body.orientation_wxyz, body.angular_velocity_body_rad_per_s)));
    }
  }

  const Scene& scene_;
  const Settings& settings_;
  bool observe_ = false;  // reactions
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_;
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  Shapes shapes_;
  btDiscreteDynamicsWorld world_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<Real4> q_BP_;  // principal frame in body frame
  std::vector<bool> turned_;
  std::unique_ptr<Joints> joints_;
};

}  // namespace

void set_solver(btContactSolverInfo& info, const Settings& settings) {
  using namespace rivals;
  const auto value = [&](const char* name) { return narrow(number(settings, name)); };
  info.m_numIterations = static_cast<int>(count(settings, "iterations"));
  info.m_erp = info.m_erp2 = value("erp");
  info.m_globalCfm = value("cfm");
  info.m_frictionERP = value("friction_erp");
  info.m_frictionCFM = value("friction_cfm");
  info.m_splitImpulse = flag(settings, "split_impulse");
  info.m_splitImpulsePenetrationThreshold = value("split_impulse_penetration_threshold_m");
  info.m_splitImpulseTurnErp = value("split_impulse_turn_erp");
  info.m_linearSlop = value("linear_slop_m");
  info.m_sor = value("sor");
  info.m_maxErrorReduction = value("max_error_reduction");
  info.m_warmstartingFactor = value("warm_starting_factor");
  info.m_restitutionVelocityThreshold = value("restitution_velocity_threshold_m_per_s");
  info.m_leastSquaresResidualThreshold = value("least_squares_residual_threshold");
  const auto bit = [&](const char* name, int mask) { return flag(settings, name) ? mask : 0; };
  info.m_solverMode =
      bit("simd", SOLVER_SIMD) | bit("warm_starting", SOLVER_USE_WARMSTARTING) |
      bit("randomized_order", SOLVER_RANDMIZE_ORDER) |
      (count(settings, "friction_directions") == 2 ? SOLVER_USE_2_FRICTION_DIRECTIONS : 0) |
      (flag(settings, "friction_along_slip") ? 0 : SOLVER_DISABLE_VELOCITY_DEPENDENT_FRICTION_DIRECTION);
}

// What btContactSolverInfo and btRigidBodyConstructionInfo hold when nothing is set, but for sleeping, which fairness
// turns off (damping is 0 in Bullet anyway).
std::vector<Setting> settings() {
  const std::string own = sizeof(btScalar) == 8 ? "double" : "float";
  std::vector<Setting> all{
      printed("scalar", own, "Type of the engine's numbers."),
      printed("step", std::string("stepSimulation(h, 0)")),
      printed("solver", std::string("sequential-impulse")),
      printed("pair_law", std::string("the scene's, by combined-coefficient callbacks")),
      printed("forces", std::string("all but uniform gravity: evaluated by the adapter once a step, at its beginning")),
      printed("joint_forces",
              std::string("springs, dampers and motors: evaluated by the adapter once a step, explicitly: "
                          "a damper is unstable beyond c h = 2 I")),
      printed("continuous_collision", false),
      printed("rectangle", std::string("a box without thickness")),
      printed("rolling_friction", std::string("Bullet's: torque impulse up to coefficient x load impulse, by two axes; "
                                              "the load counts up to 1 N s a step")),
      printed("joints", std::string("btFixedConstraint, Hinge, Slider (also cylindrical), Point2Point (ball), "
                                    "Generic6DofSpring2 (universal); jointed bodies do not collide with each other")),
      printed("driven_joints", std::string("the joint's motor with an unbounded force")),
      printed("stops", std::string("the joint's, with bias factor 1 and the stop's restitution as relaxation: found at "
                                   "the start of the step after they were passed")),
      printed("reactions", std::string("the joint's feedback: those of the step that ends at the sample")),
      rivals::substeps_setting(),
      {"iterations", std::int64_t{10}, {between(1, 100000), "Sweeps of the sequential impulses in a step."}},
      {"erp", 0.2, {between(0, 1), "Share of an overlap, or of a joint's gap, that a step takes away."}},
      {"cfm", 0.0, {between(0, 1000), "Softness of contacts and joints (constraint force mixing)."}},
      {"friction_erp", 0.2, {between(0, 1), "Share of a friction anchor's error that a step takes away."}},
      {"friction_cfm", 0.0, {between(0, 1000), "Softness of friction."}},
      {"sor", 1.0, {{0, 2, true, false}, "Over-relaxation of the sweeps."}},
      {"max_error_reduction", 20.0, {between(0, 1e6), "m_maxErrorReduction of btContactSolverInfo."}},
      {"split_impulse", true, {{}, "Overlap is removed only in positions."}},
      {"split_impulse_penetration_threshold_m",
       -0.04,
       {between(-1000, 1000), "Gap below which overlap is removed in positions; above it, by velocity.", "m"}},
      {"split_impulse_turn_erp", 0.1, {between(0, 1), "Share of the split impulse that turns bodies."}},
      {"linear_slop_m", 0.0, {between(0, 1000), "Overlap that is left alone.", "m"}},
      {"restitution_velocity_threshold_m_per_s",
       0.2,
       {between(0, 1e6), "Approaches slower than this do not bounce.", "m/s"}},
      {"least_squares_residual_threshold", 0.0, {between(0, 1e6), "Residual at which the sweeps end; 0: never."}},
      {"contact_processing_threshold_m",
       1e18,
       {between(0, 1e18), "Gap up to which a contact enters the solver; 0: none before it touches.", "m"}},
      {"contact_breaking_threshold_m", 0.02, {between(0, 1000), "Drift up to which a contact point is kept.", "m"}},
      {"collision_margin_m",
       0.04,
       {between(0, 1000), "Margin of boxes and cylinders, inside: at most a tenth of the smallest half extent.", "m"}},
      printed("hull_margin_m", 0.0, "Bullet would add a margin of hulls outside of their points."),
      {"smooth_inner_edges", false, {{}, "Normals at the inner edges of a mesh are those of its faces."}},
      {"gyroscopic",
       std::string("implicit-body"),
       {one_of({"implicit-body", "implicit-world", "explicit", "off"}), "How the gyroscopic term is stepped."}},
      {"linear_damping", 0.0, {between(0, 1), "Share of the velocity lost in a second."}},
      {"angular_damping", 0.0, {between(0, 1), "Share of the angular velocity lost in a second."}},
      {"sleeping", false, {{}, "Slow bodies are deactivated."}},
      {"warm_starting", true, {{}, "The sweeps start from the last step's impulses."}},
      {"warm_starting_factor", 0.85, {between(0, 1), "Share of the last step's impulses that they start from."}},
      {"friction_directions", std::int64_t{1}, {between(1, 2), "Axes of the friction pyramid."}},
      {"friction_along_slip", true, {{}, "The first of them is along the slip."}},
      {"randomized_order", false, {{}, "The order of the contacts changes from sweep to sweep."}},
      {"simd", true, {{}, "The solver uses vector instructions."}}};
  for (const Setting& setting : multibody_settings()) all.push_back(setting);
  return all;
}

std::optional<Fault> refusal(const Scene& scene, const Settings& settings) {
  if (in_reduced_coordinates(settings)) return refused_by_multibodies(scene, settings);
  if (const auto reason = refused_mechanism(scene); !reason.empty()) return Fault{reason};
  if (!rivals::shapes_matter(scene)) return {};
  for (const auto& body : scene.bodies) {
    if (const auto reason = refused_shape(body); !reason.empty()) return Fault{reason};
  }
  return {};
}

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe) {
  if (in_reduced_coordinates(settings)) return make_multibody_world(scene, settings, observe);
  return std::make_unique<BulletWorld>(scene, settings, observe);
}

}  // namespace atwood::bullet
