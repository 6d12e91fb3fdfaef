#include "simbody/simbody_world.hpp"

#include <Simbody.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include "protocol/printed_setting.hpp"
#include "rivals/vector.hpp"
#include "simbody/mechanism.hpp"

static_assert(sizeof(SimTK::Real) == 8, "the adapter is for Simbody in double precision");

namespace atwood::simbody {
namespace {

using rivals::Motion;
using rivals::Wrench;

std::string first_complaint;

// The law of the pairs that can touch, null where none can; the fault of the engine where it is not the same for all of
// them, or not one that Simbody has.
Result<const PairLaw*> one_law(const Scene& scene) {
  const auto refused = [](const std::string& reason) { return Fault{reason}; };
  const PairLaw* one = nullptr;
  bool joined = false;
  for (std::size_t b = 0; b < scene.bodies.size(); ++b) {
    for (std::size_t a = 0; a < b; ++a) {
      const Body &first = scene.bodies[a], &second = scene.bodies[b];
      if (!rivals::has_shape(first) || !rivals::has_shape(second) || (first.fixed && second.fixed)) continue;
      if (rivals::joined(scene, static_cast<int>(a), static_cast<int>(b))) {
        joined = true;
        continue;
      }
      for (const Body* body : {&second, &first}) {
        if (!std::holds_alternative<Sphere>(body->shape) && !std::holds_alternative<Plane>(body->shape))
          return refused("Simbody's Hertz contact is one of spheres and half-spaces, not of `" + body->name + "`, a " +
                         rivals::shape_name(body->shape));
      }
      const PairLaw& law = pair_law(scene, static_cast<int>(a), static_cast<int>(b));
      if (law.contact_law == ContactLaw::rigid)
        return refused(
            "Simbody has no contact with the pair's restitution and friction that a program can use: its rigid "
            "contacts are experimental and trace every step on standard output; its compliant ones have a stiffness "
            "and a dissipation (scenes with contact_law = \"hertz\")");
      if (law.contact_law == ContactLaw::linear)
        return refused("Simbody's compliant contacts have Hertz's law; found contact_law = \"linear\"");
      if (law.friction != 0 || law.rolling_friction_m != 0)
        return refused("Simbody's compliant contacts creep under friction: expected friction = 0");
      if (one && (one->modulus_Pa != law.modulus_Pa || one->damping_s_per_m != law.damping_s_per_m))
        return refused(
            "Simbody mixes the stiffness of materials by a rule of its own: pairs of different modulus or damping are "
            "not realised");
      one = &law;
    }
  }
  if (one && joined) return refused("Simbody's adapter does not keep bodies with a common joint from touching");
  return one;
}

SimTK::Vec3 vec3(const Real3& v) { return SimTK::Vec3(v[0], v[1], v[2]); }
Real3 real3(const SimTK::Vec3& v) { return {v[0], v[1], v[2]}; }

Motion motion_of(const SimTK::MobilizedBody& body, const SimTK::State& state) {
  Motion m;
  const SimTK::Transform& pose = body.getBodyTransform(state);
  const SimTK::Quaternion q = pose.R().convertRotationToQuaternion();
  m.p_WB = real3(pose.p());
  m.q_WB = {q[0], q[1], q[2], q[3]};
  const SimTK::SpatialVec& v = body.getBodyVelocity(state);
  m.v_WB = real3(v[1]);
  m.w_WB_B = real3(~pose.R() * v[0]);
  return m;
}

std::vector<Motion> motions_at(const Scene& scene, const Mobilized& bodies, const SimTK::State& state) {
  std::vector<Motion> motions;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& b = scene.bodies[i];
    motions.push_back(b.fixed ? Motion{b.position_m, b.orientation_wxyz, {}, {}} : motion_of(bodies[i], state));
  }
  return motions;
}

std::vector<Wrench> wrenches_at(const Scene& scene, const Mobilized& bodies, double switches_at_s,
                                const SimTK::State& state) {
  std::vector<Wrench> wrenches(scene.bodies.size());
  rivals::applied_wrenches(scene, state.getTime(), switches_at_s, motions_at(scene, bodies, state), wrenches);
  return wrenches;
}

bool has_motors(const Scene& scene) {
  return std::any_of(scene.joint_forces.begin(), scene.joint_forces.end(),
                     [](const JointForce& force) { return std::holds_alternative<JointTorque>(force); });
}

// The scene's forces and motors at the state of the integrator; switched forces are on or off as at `switches_at_s`.
class SceneForces : public SimTK::Force::Custom::Implementation {
 public:
  SceneForces(const Scene& scene, const std::vector<SimTK::MobilizedBody>& bodies, const double& switches_at_s)
      : scene_(scene), bodies_(bodies), switches_at_s_(switches_at_s) {}

  void calcForce(const SimTK::State& state, SimTK::Vector_<SimTK::SpatialVec>& body_forces,
                 SimTK::Vector_<SimTK::Vec3>&, SimTK::Vector& mobility_forces) const override {
    run_motors(state, mobility_forces);
    if (scene_.forces.empty()) return;
    const std::vector<Wrench> wrenches = wrenches_at(scene_, bodies_, switches_at_s_, state);
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      if (scene_.bodies[i].fixed) continue;
      const SimTK::Vec3 torque = rotates(scene_.bodies[i]) ? vec3(wrenches[i].torque_N_m) : SimTK::Vec3(0);
      bodies_[i].applyBodyForce(state, SimTK::SpatialVec(torque, vec3(wrenches[i].force_N)), body_forces);
    }
  }
  SimTK::Real calcPotentialEnergy(const SimTK::State&) const override { return 0; }
  bool dependsOnlyOnPositions() const override { return false; }

 private:
  void run_motors(const SimTK::State& state, SimTK::Vector& mobility_forces) const {
    if (scene_.joints.empty()) return;
    const std::vector<Real3> efforts = rivals::motor_efforts(scene_, state.getTime(), switches_at_s_);
    for (std::size_t j = 0; j < efforts.size(); ++j) {
      const auto& child = bodies_[static_cast<std::size_t>(scene_.joints[j].child)];
      for (int k = 0; k < 3; ++k) {
        if (efforts[j][k] != 0) child.applyOneMobilityForce(state, k, efforts[j][k], mobility_forces);
      }
    }
  }

  const Scene& scene_;
  const std::vector<SimTK::MobilizedBody>& bodies_;
  const double& switches_at_s_;
};

std::unique_ptr<SimTK::Integrator> integrator_of(const std::string& name, const SimTK::System& system) {
  if (name == "RungeKuttaMerson") return std::make_unique<SimTK::RungeKuttaMersonIntegrator>(system);
  if (name == "RungeKuttaFeldberg") return std::make_unique<SimTK::RungeKuttaFeldbergIntegrator>(system);
  if (name == "RungeKutta3") return std::make_unique<SimTK::RungeKutta3Integrator>(system);
  if (name == "CPodes") return std::make_unique<SimTK::CPodesIntegrator>(system, SimTK::CPodes::Adams);
  if (name == "Verlet") return std::make_unique<SimTK::VerletIntegrator>(system);
  return std::make_unique<SimTK::SemiExplicitEuler2Integrator>(system);
}

class SimbodyWorld : public rivals::World {
 public:
  SimbodyWorld(const Scene& scene, const Settings& settings)
      : scene_(scene), settings_(settings), matter_(system_), forces_(system_),
        gravity_(forces_, matter_, vec3(scene.gravity_m_per_s2)) {
    chooses_ = rivals::word(settings, "steps") == "chosen";
    if (const auto law = one_law(scene)) law_ = *law;
    if (law_) {
      tracker_ = std::make_unique<SimTK::ContactTrackerSubsystem>(system_);
      contacts_ = std::make_unique<SimTK::CompliantContactSubsystem>(system_, *tracker_);
    }
    placing_ = rivals::placing_joints(scene);
    bodies_.resize(scene.bodies.size());
    for (const int i : rivals::parents_first(scene)) add(i);
    closings_ = add_closings(scene, bodies_);
    add_springs(scene, forces_, bodies_);
    if (!scene.forces.empty() || has_motors(scene))
      SimTK::Force::Custom(forces_, new SceneForces(scene_, bodies_, switches_at_s_));
    SimTK::State state = system_.realizeTopology();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (!scene.bodies[i].fixed && placing_[i] < 0) set_motion(static_cast<int>(i), state);
    }
    for (const Joint& joint : scene.joints) {
      if (!joint.closes_loop) set_joint(joint, bodies_[static_cast<std::size_t>(joint.child)], state);
    }
    start(state);
  }

  void step(double h_s, const std::vector<Wrench>&) override {
    if (h_s != h_s_) {
      since_s_ = now_s();
      count_ = 0;
      h_s_ = h_s;
      started_ = false;
    }
    switches_at_s_ = now_s() + 0.5 * h_s;
    ++count_;
    try {
      if (!started_) start(integrator_->getState());
      while (!lost_ && integrator_->getTime() < now_s()) integrator_->stepTo(now_s());
    } catch (const std::exception& error) {
      lost_ = true;
      if (first_complaint.empty()) first_complaint = error.what();
    }
  }

  Motion motion(int i) const override {
    if (lost_) {
      const double nan = std::numeric_limits<double>::quiet_NaN();
      return {{nan, nan, nan}, {nan, nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}};
    }
    const SimTK::State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Velocity);
    Motion m = motion_of(bodies_[i], state);
    if (!rotates(scene_.bodies[i]) && placing_[i] < 0) m.q_WB = scene_.bodies[i].orientation_wxyz;
    return m;
  }

  void release(int i) override {
    SimTK::State state = integrator_->getState();
    bodies_[i].unlock(state);
    system_.realizeModel(state);
    bodies_[i].setUToFitVelocity(state, velocity_of(scene_.bodies[i]));
    start(state);
    started_ = h_s_ > 0;
  }

  std::vector<Touch> touches() const override { return {}; }
  std::optional<rivals::JointState> joint(int j) const override {
    const Joint& joint = scene_.joints[static_cast<std::size_t>(j)];
    if (lost_ || joint.closes_loop) return std::nullopt;
    return joint_of(joint, bodies_[static_cast<std::size_t>(joint.child)], integrator_->getState());
  }
  bool joint_forces_inside() const override { return true; }
  std::vector<rivals::Reaction> reactions(double t_s, const std::vector<Wrench>&) override {
    if (lost_ || law_) return {};  // contacts hide their forces
    switches_at_s_ = t_s + 0.5 * h_s_;
    const SimTK::State& state = integrator_->getState();
    system_.realize(state, SimTK::Stage::Acceleration);
    return reactions_of(
        scene_, bodies_, closings_, motions_at(scene_, bodies_, state),
        scene_.forces.empty() ? std::vector<Wrench>() : wrenches_at(scene_, bodies_, switches_at_s_, state), state);
  }
  std::vector<RopeSample> ropes() override {
    if (lost_ || scene_.ropes.empty()) return {};
    system_.realize(integrator_->getState(), SimTK::Stage::Acceleration);
    return ropes_of(closings_, integrator_->getState());
  }
  std::string broken() override {
    const std::vector<RopeSample> now = ropes();
    for (std::size_t r = 0; r < now.size(); ++r) {
      if (now[r].tension_N < 0) return "the rope `" + scene_.ropes[r].name + "` would be slack";
    }
    return "";
  }
  std::int64_t rate_calls() const override { return evaluations_before_ + (integrator_ ? realizations() : 0); }

 private:
  void add(int i) {
    const Body& body = scene_.bodies[i];
    if (body.fixed) {
      if (law_ && rivals::has_shape(body))
        add_surface(body, SimTK::Transform(vec3(body.position_m)), matter_.updGround().updBody());
      bodies_[i] = matter_.updGround();
      return;
    }
    const Real33& m = body.inertia_kg_m2;
    const bool turns = rotates(body), placed = placing_[i] >= 0;
    const SimTK::Inertia inertia = turns    ? SimTK::Inertia(m[0], m[4], m[8], m[1], m[2], m[5])
                                   : placed ? SimTK::Inertia(0)
                                            : SimTK::Inertia(1, 1, 1);
    SimTK::Body::Rigid rigid(SimTK::MassProperties(body.mass_kg, SimTK::Vec3(0), inertia));
    if (law_ && rivals::has_shape(body)) add_surface(body, SimTK::Transform(), rigid);
    if (placed) {
      const int parent = scene_.joints[placing_[i]].parent;
      bodies_[i] = add_placed_body(scene_, placing_[i], rigid, parent < 0 ? matter_.updGround() : bodies_[parent]);
    } else if (turns) {
      bodies_[i] = SimTK::MobilizedBody::Free(matter_.updGround(), SimTK::Transform(), rigid, SimTK::Transform());
    } else {
      bodies_[i] =
          SimTK::MobilizedBody::Translation(matter_.updGround(), SimTK::Transform(), rigid, SimTK::Transform());
    }
  }

  // A half-space of Simbody is x > 0 in its own frame.
  void add_surface(const Body& body, const SimTK::Transform& at, SimTK::Body& to) {
    const SimTK::ContactMaterial material(std::pow(2.0, 1.5) * law_->modulus_Pa, law_->damping_s_per_m / 1.5, 0, 0);
    if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
      to.addContactSurface(at, SimTK::ContactSurface(SimTK::ContactGeometry::Sphere(sphere->radius_m), material));
      return;
    }
    const Plane& plane = std::get<Plane>(body.shape);
    const SimTK::UnitVec3 inward(-vec3(plane.normal));
    to.addContactSurface(SimTK::Transform(SimTK::Rotation(inward, SimTK::XAxis), -plane.offset_m * SimTK::Vec3(inward)),
                         SimTK::ContactSurface(SimTK::ContactGeometry::HalfSpace(), material));
  }

  static SimTK::SpatialVec velocity_of(const Body& b) {
    const Real3 w = rivals::to_world(b.orientation_wxyz, b.angular_velocity_body_rad_per_s);
    return SimTK::SpatialVec(rotates(b) ? vec3(w) : SimTK::Vec3(0), vec3(b.velocity_m_per_s));
  }

  void set_motion(int i, SimTK::State& state) {
    const Body& b = scene_.bodies[i];
    const Real4& q = b.orientation_wxyz;
    const SimTK::Rotation turn =
        rotates(b) ? SimTK::Rotation(SimTK::Quaternion(SimTK::Vec4(q[0], q[1], q[2], q[3]))) : SimTK::Rotation();
    bodies_[i].setQToFitTransform(state, SimTK::Transform(turn, vec3(b.position_m)));
    if (b.release_s > 0) {
      bodies_[i].lock(state);
    } else {
      bodies_[i].setUToFitVelocity(state, velocity_of(b));
    }
  }

  // The step size of an integrator is constant: another step size, or the release of a body, needs a new integrator.
  void start(const SimTK::State& state) {
    if (integrator_) evaluations_before_ += realizations();
    SimTK::State from = state;
    integrator_ = integrator_of(std::get<std::string>(settings_.at("integrator")), system_);
    integrator_->setAccuracy(rivals::number(settings_, "accuracy"));
    integrator_->setConstraintTolerance(rivals::number(settings_, "constraint_tolerance"));
    integrator_->setProjectEveryStep(rivals::flag(settings_, "project_every_step"));
    if (!chooses_ && h_s_ > 0) integrator_->setFixedStepSize(h_s_);
    if (chooses_ && h_s_ > 0) integrator_->setInitialStepSize(h_s_);
    // Free flight has no error, so that chosen steps grow until one passes over a contact.
    if (law_ && chooses_ && h_s_ > 0) integrator_->setMaximumStepSize(h_s_);
    bool switched = false;
    for (const auto& force : scene_.forces) {
      const auto* thruster = std::get_if<Thruster>(&force);
      const auto* push = std::get_if<PointForce>(&force);
      switched = switched || (thruster && !thruster->on_s.empty()) || (push && !push->on_s.empty());
    }
    for (const auto& force : scene_.joint_forces) {
      const auto* motor = std::get_if<JointTorque>(&force);
      switched = switched || (motor && !motor->on_s.empty());
    }
    integrator_->setAllowInterpolation(chooses_ &&
                                       !switched);  // no step goes past the end of one that may end a thrust
    integrator_->initialize(from);
    started_ = true;
  }
  std::int64_t realizations() const { return integrator_->getNumRealizations(); }
  double now_s() const { return since_s_ + static_cast<double>(count_) * h_s_; }

  const Scene& scene_;
  const Settings& settings_;
  SimTK::MultibodySystem system_;
  SimTK::SimbodyMatterSubsystem matter_;
  SimTK::GeneralForceSubsystem forces_;
  SimTK::Force::UniformGravity gravity_;
  const PairLaw* law_ = nullptr;
  std::unique_ptr<SimTK::ContactTrackerSubsystem> tracker_;
  std::unique_ptr<SimTK::CompliantContactSubsystem> contacts_;
  Mobilized bodies_;
  std::vector<int> placing_;  // joint by body
  Closings closings_;
  double switches_at_s_ = 0;
  std::unique_ptr<SimTK::Integrator> integrator_;
  bool chooses_ = false, started_ = false, lost_ = false;
  double h_s_ = 0, since_s_ = 0;
  std::int64_t count_ = 0, evaluations_before_ = 0;
};

}  // namespace

std::string version() {
  int major = 0, minor = 0, patch = 0;
  SimTK_version_simbody(&major, &minor, &patch);
  return std::to_string(major) + "." + std::to_string(minor) + (patch > 0 ? "." + std::to_string(patch) : "");
}

std::vector<Setting> settings() {
  return {
      printed("scalar", std::string("double"), "Type of the engine's numbers."),
      printed("step", std::string("Integrator::stepTo")),
      printed("pair_law", std::string("hertz between spheres and planes: CompliantContactSubsystem, dissipation 2/3 of "
                                      "the damping; others are refused")),
      printed("forces", std::string("all but uniform gravity: by the adapter as a Force::Custom, at every rate call")),
      printed("attitude", std::string("a quaternion")),
      printed("joints", std::string("a mobilizer for each placing joint; closing joints are constraints")),
      printed("joint_forces", std::string("springs, dampers and motors: at every rate call")),
      printed("sleeping", std::string("none: Simbody has none")),
      printed("linear_damping", 0.0),
      printed("angular_damping", 0.0),
      printed("steps", std::string("fixed"), "Of the plan's length, or chosen by the accuracy."),
      printed("longest_step", std::string("chosen steps where bodies can touch: the plan's; else none is set")),
      rivals::substeps_setting(),
      {"integrator",
       std::string("RungeKuttaMerson"),
       {one_of({"RungeKuttaMerson", "RungeKuttaFeldberg", "RungeKutta3", "Verlet", "SemiExplicitEuler2", "CPodes"}),
        "Which of Simbody's integrators steps; CPodes (Adams) only in chosen steps."}},
      {"accuracy", 1e-3, {strictly_between(0, 1), "Simbody's accuracy: relative error of a step."}},
      {"constraint_tolerance", 1e-10, {strictly_between(0, 1), "Error of constraints at which a step projects."}},
      {"project_every_step", false, {{}, "Every step ends with a projection onto the constraints."}}};
}

std::optional<Fault> contradiction(const Settings& settings) {
  if (rivals::word(settings, "integrator") == "CPodes" && rivals::word(settings, "steps") != "chosen")
    return Fault{"setting `integrator`: CPodes has no steps of fixed size; expected the method simbody/cpodes"};
  return {};
}

// CPodes throws where a quaternion's norm is a constraint, and its projection onto loops was seen to give wrong
// motions with status ok (the seven-body mechanism of Andrews).
std::string refused_by_cpodes(const Scene& scene) {
  const std::vector<int> placing = rivals::placing_joints(scene);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (placing[i] < 0 && !body.fixed && rotates(body))
      return "Simbody's CPodes fails on quaternions; found the floating body `" + body.name + "`";
  }
  for (const Joint& joint : scene.joints) {
    if (joint.closes_loop)
      return "Simbody's CPodes is wrong on loops; found the joint `" + joint.name + "`, which closes one";
    if (joint.kind == JointKind::ball)
      return "Simbody's CPodes fails on quaternions; found the ball joint `" + joint.name + "`";
  }
  return scene.ropes.empty() ? ""
                             : "Simbody's CPodes is wrong on constraints; found the rope `" + scene.ropes[0].name + "`";
}

std::optional<Fault> refusal(const Scene& scene, const Settings& settings) {
  if (rivals::word(settings, "integrator") == "CPodes") {
    if (const auto reason = refused_by_cpodes(scene); !reason.empty()) return Fault{reason};
  }
  if (const auto reason = refused_mechanism(scene); !reason.empty()) return Fault{reason};
  if (const auto law = one_law(scene); !law) return law.fault();
  return {};
}

std::string diagnostics_since_last_call() {
  std::string text;
  if (!first_complaint.empty()) text = "Simbody gave up: " + first_complaint;
  first_complaint.clear();
  return text;
}

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool) {
  return std::make_unique<SimbodyWorld>(scene, settings);
}

}  // namespace atwood::simbody
