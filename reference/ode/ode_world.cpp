#include "ode/ode_world.hpp"

#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <stdexcept>
#include <vector>

#include "ode/joints.hpp"
#include "ode/shapes.hpp"
#include "protocol/printed_setting.hpp"
#include "rivals/vector.hpp"

static_assert(sizeof(dReal) == 8, "the adapter is for ODE in double precision");

namespace atwood::ode {
namespace {

using rivals::operator*;
using rivals::operator-;
using rivals::operator+;
using rivals::Motion;
using rivals::Wrench;

constexpr int kMaxContacts = 64;  // per pair; upper limit of the setting max_contacts

// ODE prints thousands of messages of its solver per run. They are counted instead, and reported in the run's outcome.
std::int64_t message_count = 0;
std::string first_message;
void hear(int, const char* format, va_list arguments) {
  if (++message_count > 1) return;
  char text[256];
  std::vsnprintf(text, sizeof text, format, arguments);
  first_message = text;
}

// ODE ends the process where an assertion of its own fails, as on a quaternion that is not finite any more. Its
// handlers must not return; the step is abandoned instead.
struct Abandoned {};
void give_up(int number, const char* format, va_list arguments) {
  hear(number, format, arguments);
  throw Abandoned{};
}

// dInitODE2 is process-wide; worlds come and go under it.
void start_library() {
  static const bool started = [] {
    dSetMessageHandler(hear);
    dSetErrorHandler(give_up);
    dSetDebugHandler(give_up);
    if (!dInitODE2(0)) throw std::runtime_error("ODE did not start");
    dAllocateODEDataForThread(dAllocateMaskAll);
    return true;
  }();
  (void)started;
}

Real3 real3(const dReal* v) { return {v[0], v[1], v[2]}; }

dMass mass_of(const Body& body) {
  dMass mass;
  dMassSetZero(&mass);
  if (rotates(body)) {
    const Real33& inertia = body.inertia_kg_m2;
    dMassSetParameters(&mass, body.mass_kg, 0, 0, 0, inertia[0], inertia[4], inertia[8], inertia[1], inertia[2],
                       inertia[5]);
  } else {
    dMassSetSphereTotal(&mass, body.mass_kg, 1);  // irrelevant: no torque is applied to a point mass
  }
  return mass;
}

class OdeWorld : public rivals::World {
 public:
  OdeWorld(const Scene& scene, const Settings& settings, bool observe) : scene_(scene), observe_(observe) {
    start_library();
    quick_ = rivals::word(settings, "step") == "dWorldQuickStep";
    along_slip_ = rivals::word(settings, "friction_direction") == "slip";
    bounce_velocity_m_per_s_ = rivals::number(settings, "bounce_velocity_m_per_s");
    most_contacts_ = static_cast<int>(rivals::count(settings, "max_contacts"));
    world_ = dWorldCreate();
    space_ = dHashSpaceCreate(nullptr);
    contacts_ = dJointGroupCreate(0);
    const Real3& g = scene.gravity_m_per_s2;
    dWorldSetGravity(world_, g[0], g[1], g[2]);
    dWorldSetERP(world_, rivals::number(settings, "erp"));
    dWorldSetCFM(world_, rivals::number(settings, "cfm"));
    dWorldSetQuickStepNumIterations(world_, static_cast<int>(rivals::count(settings, "iterations")));
    dWorldSetQuickStepW(world_, rivals::number(settings, "sor"));
    dWorldSetContactMaxCorrectingVel(world_, rivals::number(settings, "contact_max_correcting_velocity_m_per_s"));
    dWorldSetContactSurfaceLayer(world_, rivals::number(settings, "contact_surface_layer_m"));
    dWorldSetAutoDisableFlag(world_, rivals::flag(settings, "auto_disable"));
    dWorldSetLinearDamping(world_, rivals::number(settings, "linear_damping"));
    dWorldSetAngularDamping(world_, rivals::number(settings, "angular_damping"));
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add(static_cast<int>(i), settings);
    joints_ = std::make_unique<Joints>(world_, scene, bodies_, observe);
  }
  ~OdeWorld() override {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);
    dWorldDestroy(world_);
  }
  OdeWorld(const OdeWorld&) = delete;
  OdeWorld& operator=(const OdeWorld&) = delete;

  void step(double h_s, const std::vector<Wrench>& wrenches) override {
    if (lost_) return;
    try {
      step_or_throw(h_s, wrenches);
    } catch (const Abandoned&) {
      lost_ = true;
      met_.clear();
    }
  }

  Motion motion(int i) const override {
    if (lost_) {
      const double nan = std::numeric_limits<double>::quiet_NaN();
      return {{nan, nan, nan}, {nan, nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}};
    }
    const dBodyID body = bodies_[i];
    Motion m;
    m.p_WB = real3(dBodyGetPosition(body));
    const dReal* q = dBodyGetQuaternion(body);
    m.q_WB = {q[0], q[1], q[2], q[3]};
    m.v_WB = real3(dBodyGetLinearVel(body));
    m.w_WB_B = rivals::to_body(m.q_WB, real3(dBodyGetAngularVel(body)));
    return m;
  }

  void release(int i) override {
    dBodySetDynamic(bodies_[i]);
    set_velocity(i);
  }

  std::vector<rivals::Reaction> reactions(double, const std::vector<Wrench>&) override { return joints_->reactions(); }

  // dJointFeedback's f1 is the force on the joint's first body, into which the contact's normal points.
  std::vector<Touch> touches() const override {
    std::vector<Touch> all;
    for (std::size_t k = 0; k < met_.size(); ++k) {
      const Met& met = met_[k];
      const double to_b = met.first < met.second ? -1.0 : 1.0;
      const Real3 force = to_b * real3(feedback_[k].f1), normal = to_b * met.normal;
      const double along = rivals::dot(force, normal);
      if (!(along > 0)) continue;
      all.push_back({std::min(met.first, met.second), std::max(met.first, met.second), met.x_m, normal, -met.depth_m,
                     along * h_s_, h_s_ * (force - along * normal)});
    }
    return all;
  }

 private:
  void step_or_throw(double h_s, const std::vector<Wrench>& wrenches) {
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      if (!bodies_[i] || dBodyIsKinematic(bodies_[i])) continue;
      const Real3 &f = wrenches[i].force_N, &t = wrenches[i].torque_N_m;
      dBodyAddForce(bodies_[i], f[0], f[1], f[2]);
      if (rotates(scene_.bodies[i])) dBodyAddTorque(bodies_[i], t[0], t[1], t[2]);
    }
    met_.clear();
    h_s_ = h_s;
    dSpaceCollide(space_, this, &OdeWorld::near);
    feedback_.resize(met_.size());  // all contacts are known: addresses stay until the next step
    if (observe_) {
      for (std::size_t k = 0; k < met_.size(); ++k) dJointSetFeedback(met_[k].joint, &feedback_[k]);
    }
    const bool reactions = observe_ && !scene_.joints.empty();
    if (reactions) joints_->before(motions());
    if (quick_) {
      dWorldQuickStep(world_, h_s);
    } else {
      dWorldStep(world_, h_s);
    }
    if (reactions) joints_->after();
    dJointGroupEmpty(contacts_);
  }

  struct Met {
    int first = 0, second = 0;  // the normal points into `first`
    Real3 x_m{}, normal{};
    double depth_m = 0;
    dJointID joint = nullptr;
  };

  std::vector<Motion> motions() const {
    std::vector<Motion> all;
    for (int i = 0; i < static_cast<int>(bodies_.size()); ++i)
      all.push_back(bodies_[i] ? motion(i) : rivals::motion_at_start(scene_, i));
    return all;
  }

  void add(int i, const Settings& settings) {
    const Body& body = scene_.bodies[i];
    bodies_.push_back(nullptr);
    const dBodyID made = body.fixed ? nullptr : dBodyCreate(world_);
    bodies_[i] = made;
    if (made) set_up(i, settings);
    for (const dGeomID geom : shapes_.make(space_, body, made)) {
      dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::intptr_t>(i)));
      // Two fixed geoms do not collide.
      dGeomSetCategoryBits(geom, body.fixed ? 1ul : 2ul);
      dGeomSetCollideBits(geom, body.fixed ? 2ul : 3ul);
    }
  }

  void set_up(int i, const Settings& settings) {
    const Body& body = scene_.bodies[i];
    const dBodyID made = bodies_[i];
    const Real3& p = body.position_m;
    const dQuaternion q{body.orientation_wxyz[0], body.orientation_wxyz[1], body.orientation_wxyz[2],
                        body.orientation_wxyz[3]};
    const dMass mass = mass_of(body);
    dBodySetMass(made, &mass);
    dBodySetPosition(made, p[0], p[1], p[2]);
    dBodySetQuaternion(made, q);
    dBodySetGyroscopicMode(made, rivals::flag(settings, "gyroscopic"));
    dBodySetFiniteRotationMode(made, rivals::flag(settings, "finite_rotation"));
    if (body.release_s > 0) {
      dBodySetKinematic(made);
    } else {
      set_velocity(i);
    }
  }

  void set_velocity(int i) {
    const Body& body = scene_.bodies[i];
    const Real3& v = body.velocity_m_per_s;
    dBodySetLinearVel(bodies_[i], v[0], v[1], v[2]);
    if (!rotates(body)) return;
    const Real3 w = rivals::to_world(body.orientation_wxyz, body.angular_velocity_body_rad_per_s);
    dBodySetAngularVel(bodies_[i], w[0], w[1], w[2]);
  }

  static void near(void* self, dGeomID a, dGeomID b) { static_cast<OdeWorld*>(self)->meet(a, b); }

  void meet(dGeomID a, dGeomID b) {
    const int first = static_cast<int>(reinterpret_cast<std::intptr_t>(dGeomGetData(a)));
    const int second = static_cast<int>(reinterpret_cast<std::intptr_t>(dGeomGetData(b)));
    if (first == second) return;  // parts of one body
    if (!scene_.joints.empty() && joints_->connect(first, second)) return;
    const auto still = [&](int i) { return !bodies_[i] || dBodyIsKinematic(bodies_[i]); };
    if (still(first) && still(second)) return;
    dContactGeom found[kMaxContacts];
    const int n = dCollide(a, b, most_contacts_, found, sizeof(dContactGeom));
    if (n == 0) return;
    const PairLaw& law = pair_law(scene_, first, second);
    for (int k = 0; k < n; ++k) {
      // Where a hull touches without overlap, ODE (libccd) gives a point without a normal: no direction to push.
      if (real3(found[k].normal) == Real3{}) continue;
      dContact contact{};
      contact.geom = found[k];
      contact.surface.mode = dContactBounce | dContactApprox1;
      contact.surface.mu = law.friction;
      contact.surface.bounce = law.restitution;
      contact.surface.bounce_vel = bounce_velocity_m_per_s_;
      if (law.rolling_friction_m != 0) {
        contact.surface.mode |= dContactRolling;
        contact.surface.rho = contact.surface.rho2 = law.rolling_friction_m;
      }
      if (along_slip_) align(contact, first, second);
      const dJointID joint = dJointCreateContact(world_, contacts_, &contact);
      dJointAttach(joint, bodies_[first], bodies_[second]);
      met_.push_back({first, second, real3(found[k].pos), real3(found[k].normal), found[k].depth, joint});
    }
  }

  // The friction pyramid's first axis along the slip: exact Coulomb friction while the slip keeps its direction.
  void align(dContact& contact, int first, int second) const {
    const Real3 x = real3(contact.geom.pos), n = real3(contact.geom.normal);
    const auto velocity = [&](int i) -> Real3 {
      if (!bodies_[i]) return {};
      dVector3 v;
      dBodyGetPointVel(bodies_[i], x[0], x[1], x[2], v);
      return real3(v);
    };
    const Real3 u = velocity(first) - velocity(second);
    const Real3 slip = u - rivals::dot(u, n) * n;
    const double speed = rivals::length(slip);
    if (!(speed > 1e-9)) return;
    contact.surface.mode |= dContactFDir1;
    for (int k = 0; k < 3; ++k) contact.fdir1[k] = slip[k] / speed;
  }

  const Scene& scene_;
  bool observe_ = false, quick_ = false, along_slip_ = false;
  bool lost_ = false;  // ODE gave up in the middle of a step
  double bounce_velocity_m_per_s_ = 0, h_s_ = 0;
  int most_contacts_ = 1;
  dWorldID world_ = nullptr;
  dSpaceID space_ = nullptr;
  dJointGroupID contacts_ = nullptr;
  Shapes shapes_;
  std::vector<dBodyID> bodies_;
  std::unique_ptr<Joints> joints_;
  std::vector<Met> met_;
  std::vector<dJointFeedback> feedback_;
};

}  // namespace

// The defaults of dWorldCreate, without auto-disable and damping (ODE's defaults), and with friction as a coefficient
// (mu would be a force). ODE has no default for a contact's bounce_vel, which is set to 0.
std::vector<Setting> settings() {
  return {
      printed("scalar", std::string("double"), "Type of the engine's numbers."),
      printed("pair_law", std::string("the scene's, in every contact's surface")),
      printed("friction_model", std::string("pyramid, mu times the normal force (dContactApprox1)")),
      printed("forces", std::string("all but uniform gravity: evaluated by the adapter once a step, at its beginning")),
      printed("joint_forces",
              std::string("springs, dampers and motors: evaluated by the adapter once a step, explicitly: "
                          "a damper is unstable beyond c h = 2 I")),
      printed("space", std::string("dHashSpace")),
      printed("rectangle", std::string("a box of the least thickness")),
      printed("rolling_friction", std::string("torque up to coefficient x load (dContactRolling), by two axes")),
      printed("joints",
              std::string("dJointFixed, Hinge, Slider, Piston (cylindrical), Universal, Ball; jointed bodies do "
                          "not collide with each other")),
      printed("driven_joints", std::string("the joint's motor with an unbounded force")),
      printed("stops",
              std::string("the joint's, with its bounce: found at the start of the step after they were passed")),
      printed("reactions", std::string("the joint's feedback: those of the step that ends at the sample")),
      rivals::substeps_setting(),
      {"step",
       std::string("dWorldStep"),
       {one_of({"dWorldStep", "dWorldQuickStep"}), "Direct solver of the contact problem, or sweeps."}},
      {"iterations", std::int64_t{20}, {between(1, 100000), "Sweeps of dWorldQuickStep in a step."}},
      {"sor", 1.3, {{0, 2, true, false}, "Over-relaxation of dWorldQuickStep's sweeps."}},
      {"erp", 0.2, {between(0, 1), "Share of an overlap, or of a joint's gap, that a step takes away."}},
      {"cfm", 1e-10, {between(0, 1000), "Softness of contacts and joints (constraint force mixing)."}},
      {"contact_max_correcting_velocity_m_per_s",
       dInfinity,
       {at_least(0), "Largest velocity that removes overlap.", "m/s"}},
      {"contact_surface_layer_m", 0.0, {between(0, 1000), "Overlap that is left alone.", "m"}},
      {"bounce_velocity_m_per_s", 0.0, {between(0, 1e6), "Approaches slower than this do not bounce.", "m/s"}},
      {"friction_direction",
       std::string("engine"),
       {one_of({"engine", "slip"}), "First axis of the friction pyramid: the engine's choice, or along the slip."}},
      {"max_contacts", std::int64_t{8}, {between(1, kMaxContacts), "Most contact points of a pair."}},
      {"gyroscopic", true, {{}, "The gyroscopic term acts."}},
      {"finite_rotation", false, {{}, "Attitudes move by rotations of finite angle."}},
      {"auto_disable", false, {{}, "Slow bodies are disabled."}},
      {"linear_damping", 0.0, {between(0, 1), "Share of the velocity lost in a step."}},
      {"angular_damping", 0.0, {between(0, 1), "Share of the angular velocity lost in a step."}}};
}

std::optional<Fault> refusal(const Scene& scene, const Settings& settings) {
  if (auto fault = refused_mechanism(scene, rivals::number(settings, "cfm"))) return fault;
  if (!dCheckConfiguration("ODE_double_precision")) return Fault{"the installed ODE is not the double precision build"};
  const auto shaped = std::count_if(scene.bodies.begin(), scene.bodies.end(), rivals::has_shape);
  int cylinders = 0, capsules = 0;
  for (const auto& body : scene.bodies) {
    if (shaped > 1) {
      if (const auto reason = refused_shape(body); !reason.empty()) return Fault{reason};
    }
    if (!body.fixed && rotates(body)) {
      const dMass mass = mass_of(body);
      if (!dMassCheck(&mass))
        return Fault{"ODE requires a positive definite inertia; that of `" + body.name + "` is not"};
    }
    if (!body.fixed && !rotates(body) && rivals::has_shape(body) && shaped > 1) {
      return Fault{"ODE would rotate `" + body.name + "`, which has a shape and no inertia"};
    }
    cylinders += std::holds_alternative<Cylinder>(body.shape);
    capsules += std::holds_alternative<Capsule>(body.shape);
  }
  if (cylinders > 1 || (cylinders > 0 && capsules > 0)) {
    if (!dCheckConfiguration("ODE_EXT_libccd"))
      return Fault{"this build of ODE has no collision of a cylinder with a cylinder or capsule"};
  }
  return {};
}

std::string diagnostics_since_last_call() {
  std::string text;
  if (message_count > 0) text = "ODE printed " + std::to_string(message_count) + " messages, first: " + first_message;
  message_count = 0;
  return text;
}

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool observe) {
  return std::make_unique<OdeWorld>(scene, settings, observe);
}

}  // namespace atwood::ode
