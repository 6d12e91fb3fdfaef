#include "mujoco/mujoco_world.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include "mujoco/mechanism.hpp"
#include "mujoco/model.hpp"
#include "mujoco/pair_laws.hpp"
#include "protocol/printed_setting.hpp"
#include "rivals/vector.hpp"

static_assert(sizeof(mjtNum) == 8, "the adapter is for MuJoCo in double precision");

namespace atwood::mujoco {
namespace {

using rivals::operator+;
using rivals::operator*;
using rivals::Motion;
using rivals::Wrench;

// MuJoCo's default handlers write warnings to a file in the working directory, and end the process on an error.
std::int64_t warning_count = 0;
std::string first_warning;
void hear(const char* text) {
  if (++warning_count == 1) first_warning = text;
}
void fail(const char* text) { throw std::invalid_argument(std::string("MuJoCo gave up: ") + text); }

Real3 real3(const mjtNum* v) { return {v[0], v[1], v[2]}; }

// MuJoCo calls a function of the program at each evaluation of forces (mjcb_passive): here the world that steps adds
// the scene's forces and motors, so that RK4 has them at each of its stages.
class MujocoWorld;
MujocoWorld* acting = nullptr;
void act(const mjModel* model, mjData* data);

bool is_on(const std::vector<Interval>& on_s, double t_s) {
  return on_s.empty() ||
         std::any_of(on_s.begin(), on_s.end(), [&](const Interval& i) { return i.from_s <= t_s && t_s < i.to_s; });
}

class MujocoWorld : public rivals::World {
 public:
  MujocoWorld(const Scene& scene, const Settings& settings) : scene_(scene), settings_(settings) {
    mju_user_warning = hear;
    mju_user_error = fail;
    mjcb_passive = act;
    if (!scene.forces.empty()) wrenches_.resize(scene.bodies.size());
    for (const auto& body : scene.bodies) held_.push_back(!body.fixed && body.release_s > 0);
    placing_ = rivals::placing_joints(scene);
    build();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (floats(static_cast<int>(i))) set_motion(static_cast<int>(i), motion_of_scene(static_cast<int>(i)));
    }
    for (std::size_t j = 0; j < scene.joints.size(); ++j) {
      if (const int id = joint_ids_[j]; id >= 0)
        set_joint(scene.joints[j].kind, id, {scene.joints[j].coordinates, scene.joints[j].rates}, model_.get(),
                  data_.get());
    }
    set_constraints(scene, model_.get(), data_.get());
  }
  ~MujocoWorld() override { acting = nullptr; }
  MujocoWorld(const MujocoWorld&) = delete;
  MujocoWorld& operator=(const MujocoWorld&) = delete;

  void starts_at(double t_s) override { starts_s_ = t_s; }
  void step(double h_s, const std::vector<Wrench>&) override {
    if (h_s != h_s_) set_softness(settings_, h_s, model_.get());
    h_s_ = model_->opt.timestep = h_s;
    t_switch_s_ = data_->time + 0.5 * h_s;
    clock_start_s_ = data_->time;
    if (!scene_.forces.empty()) {  // the first, ahead of the step, which begins by scaling quaternions to length 1
      std::vector<Motion> motions;
      for (int i = 0; i < static_cast<int>(scene_.bodies.size()); ++i) motions.push_back(pose_of(i));
      add_wrenches(motions, *data_);
      has_first_ = true;
    }
    acting = this;
    mj_step(model_.get(), data_.get());
    viewed_ = false;
    for (const int bad : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC})
      lost_ = lost_ || data_->warning[bad].number > 0;
  }

  Motion motion(int i) const override {
    if (lost_) {
      const double nan = std::numeric_limits<double>::quiet_NaN();
      return {{nan, nan, nan}, {nan, nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}};
    }
    return placing_[static_cast<std::size_t>(i)] >= 0 ? placed_motion(i, *view()) : free_motion(i, *data_);
  }
  std::int64_t rate_calls() const override { return evaluations_; }
  void add_forces(mjData& data) {
    if (!scene_.joint_forces.empty()) run_motors(data);
    if (scene_.forces.empty()) return;
    if (&data == data_.get() && std::exchange(has_first_, false)) return;
    std::vector<Motion> motions;
    for (int i = 0; i < static_cast<int>(scene_.bodies.size()); ++i) {
      motions.push_back(!moves(i)   ? rivals::motion_at_start(scene_, i)
                        : floats(i) ? free_motion(i, data)
                                    : placed_motion(i, data));
    }
    add_wrenches(motions, data);
  }

  // A held body has no joints: at its release the model is compiled again, and the state of all other bodies is kept.
  void release(int i) override {
    std::vector<Motion> motions(scene_.bodies.size());
    for (std::size_t k = 0; k < motions.size(); ++k) {
      if (floats(static_cast<int>(k))) motions[k] = motion(static_cast<int>(k));
    }
    std::vector<rivals::JointState> joints(scene_.joints.size());
    for (std::size_t j = 0; j < joints.size(); ++j)
      joints[j] = joint(static_cast<int>(j)).value_or(rivals::JointState{});
    const Model before = std::move(model_);
    const double t_s = data_->time;
    motions[static_cast<std::size_t>(i)] = motion_of_scene(i);
    held_[static_cast<std::size_t>(i)] = false;
    build();
    data_->time = t_s;
    for (std::size_t k = 0; k < motions.size(); ++k) {
      if (floats(static_cast<int>(k))) set_motion(static_cast<int>(k), motions[k]);
    }
    for (std::size_t j = 0; j < joints.size(); ++j) {
      if (joint_ids_[j] >= 0) set_joint(scene_.joints[j].kind, joint_ids_[j], joints[j], model_.get(), data_.get());
    }
    set_constraints(scene_, model_.get(), data_.get());
    mju_copy(model_->tendon_length0, before->tendon_length0, model_->ntendon);
    if (h_s_ > 0) set_softness(settings_, h_s_, model_.get());
  }

  // A contact's frame has its axes in rows; the first is the normal, from geom1 to geom2, and the force is on geom2.
  std::vector<Touch> touches() const override {
    std::vector<Touch> all;
    for (int c = 0; c < data_->ncon; ++c) {
      const mjContact& contact = data_->contact[c];
      if (contact.efc_address < 0) continue;
      mjtNum force[6];
      mj_contactForce(model_.get(), data_.get(), c, force);
      if (!(force[0] > 0)) continue;
      const int first = owner_of(contact.geom1), second = owner_of(contact.geom2);
      const double to_b = first < second ? 1.0 : -1.0;
      const Real3 friction = force[1] * real3(contact.frame + 3) + force[2] * real3(contact.frame + 6);
      all.push_back({std::min(first, second), std::max(first, second), real3(contact.pos), to_b * real3(contact.frame),
                     contact.dist, force[0] * h_s_, (to_b * h_s_) * friction});
    }
    return all;
  }

  std::optional<rivals::JointState> joint(int j) const override {
    const auto id = joint_ids_[static_cast<std::size_t>(j)];
    if (id < 0) return std::nullopt;
    return joint_of(scene_.joints[static_cast<std::size_t>(j)].kind, id, model_.get(), data_.get());
  }
  bool joint_forces_inside() const override { return true; }

  std::vector<rivals::Reaction> reactions(double t_s, const std::vector<Wrench>&) override {
    if (lost_) return {};
    t_switch_s_ = t_s + 0.5 * h_s_;
    starts_s_ = t_s;
    clock_start_s_ = data_->time;
    const mjData* seen = view_of_forces();
    std::vector<Motion> motions;
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) motions.push_back(pose_of(static_cast<int>(i)));
    return reactions_of(scene_, ids_, motions, wrenches_, model_.get(), seen);
  }
  std::vector<RopeSample> ropes() override {
    if (scene_.ropes.empty() || lost_) return {};
    return ropes_of(scene_, view_of_forces());
  }
  std::string broken() override {
    const std::vector<RopeSample> now = ropes();
    for (std::size_t r = 0; r < now.size(); ++r) {
      if (now[r].tension_N < 0) return "the rope `" + scene_.ropes[r].name + "` would be slack";
    }
    return "";
  }

 private:
  void build() {
    model_ = compile(xml_of(scene_, settings_, held_));
    data_.reset(mj_makeData(model_.get()));
    if (!data_) throw std::invalid_argument("MuJoCo could not allocate its buffers");
    view_.reset();
    viewed_ = false;
    ids_.clear();
    std::vector<int> of_body(static_cast<std::size_t>(model_->nbody), -1);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {
      ids_.push_back(mj_name2id(model_.get(), mjOBJ_BODY, ("b" + std::to_string(i)).c_str()));
      of_body[static_cast<std::size_t>(ids_.back())] = static_cast<int>(i);
    }
    owners_.clear();
    for (int geom = 0; geom < model_->ngeom; ++geom)
      owners_.push_back(of_body[static_cast<std::size_t>(model_->geom_bodyid[geom])]);
    for (std::size_t i = 0; i < scene_.bodies.size(); ++i) {  // those of planes are the world's
      const int geom = mj_name2id(model_.get(), mjOBJ_GEOM, ("g" + std::to_string(i)).c_str());
      if (geom >= 0) owners_[static_cast<std::size_t>(geom)] = static_cast<int>(i);
    }
    joint_ids_ = joint_ids(scene_, model_.get());
  }
  bool moves(int i) const { return !scene_.bodies[i].fixed && !held_[static_cast<std::size_t>(i)]; }
  bool floats(int i) const { return moves(i) && placing_[static_cast<std::size_t>(i)] < 0; }
  int owner_of(int geom) const { return owners_[static_cast<std::size_t>(geom)]; }
  int position_at(int i) const { return model_->jnt_qposadr[model_->body_jntadr[ids_[static_cast<std::size_t>(i)]]]; }
  int velocity_at(int i) const { return model_->body_dofadr[ids_[static_cast<std::size_t>(i)]]; }
  void put(const std::vector<Wrench>& wrenches, mjData& data) const {
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      mjtNum* applied = data.xfrc_applied + 6 * ids_[i];
      for (int k = 0; k < 3; ++k) {
        applied[k] = wrenches[i].force_N[k];
        applied[3 + k] = wrenches[i].torque_N_m[k];
      }
    }
  }

  // After mj_step all of mjData but the state is that of the step's beginning. What samples need is computed in a
  // second mjData, so that observing a run does not change it.
  mjData* view() const {
    if (!view_) view_.reset(mj_makeData(model_.get()));
    if (viewed_) return view_.get();
    view_->time = data_->time;
    mju_copy(view_->qpos, data_->qpos, model_->nq);
    mju_copy(view_->qvel, data_->qvel, model_->nv);
    mju_copy(view_->qacc_warmstart, data_->qacc_warmstart, model_->nv);
    mj_kinematics(model_.get(), view_.get());
    mj_comPos(model_.get(), view_.get());
    mj_comVel(model_.get(), view_.get());
    viewed_ = true;
    return view_.get();
  }
  mjData* view_of_forces() const {
    mjData* seen = view();
    acting = const_cast<MujocoWorld*>(this);
    mj_forward(model_.get(), seen);
    mj_rnePostConstraint(model_.get(), seen);
    return seen;
  }
  void add_wrenches(const std::vector<Motion>& motions, mjData& data) {
    const double t_s = starts_s_ + (data.time - clock_start_s_);
    rivals::applied_wrenches(scene_, t_s, starts_s_ + 0.5 * h_s_, motions, wrenches_);
    put(wrenches_, data);
    if (&data == data_.get()) ++evaluations_;  // and not of what is observed
  }
  Motion free_motion(int i, const mjData& data) const {
    const mjtNum *q = data.qpos + position_at(i), *v = data.qvel + velocity_at(i);
    const Body& body = scene_.bodies[static_cast<std::size_t>(i)];
    if (!rotates(body)) return {body.position_m + real3(q), body.orientation_wxyz, real3(v), {}};
    return {real3(q), {q[3], q[4], q[5], q[6]}, real3(v), real3(v + 3)};
  }
  // Of a body of a joint, where `data` has the poses and velocities of its state.
  Motion placed_motion(int i, const mjData& data) const {
    const int id = ids_[static_cast<std::size_t>(i)];
    const mjtNum* q = data.xquat + 4 * id;
    mjtNum velocity[6];
    mj_objectVelocity(model_.get(), &data, mjOBJ_XBODY, id, velocity, 0);
    const Real4 attitude{q[0], q[1], q[2], q[3]};
    return {real3(data.xpos + 3 * id), attitude, real3(velocity + 3), rivals::to_body(attitude, real3(velocity))};
  }
  void run_motors(mjData& data) const {
    mju_zero(data.qfrc_applied, model_->nv);
    for (const JointForce& force : scene_.joint_forces) {
      const auto* motor = std::get_if<JointTorque>(&force);
      if (!motor || !is_on(motor->on_s, t_switch_s_)) continue;
      const int id = joint_ids_[static_cast<std::size_t>(motor->joint)];
      data.qfrc_applied[model_->jnt_dofadr[id] + motor->coordinate] +=
          motor->torque * std::cos(motor->angular_frequency_rad_per_s * data.time + motor->phase_rad);
    }
  }
  Motion pose_of(int i) const { return moves(i) ? motion(i) : rivals::motion_at_start(scene_, i); }

  Motion motion_of_scene(int i) const {
    const Body& b = scene_.bodies[i];
    return {b.position_m, b.orientation_wxyz, b.velocity_m_per_s, b.angular_velocity_body_rad_per_s};
  }
  void set_motion(int i, const Motion& m) {
    mjtNum *q = data_->qpos + position_at(i), *v = data_->qvel + velocity_at(i);
    const bool turns = rotates(scene_.bodies[i]);
    for (int k = 0; k < 3; ++k) {
      q[k] = turns ? m.p_WB[k] : m.p_WB[k] - scene_.bodies[i].position_m[k];
      v[k] = m.v_WB[k];
    }
    for (int k = 0; turns && k < 4; ++k) q[3 + k] = m.q_WB[k];
    for (int k = 0; turns && k < 3; ++k) v[3 + k] = m.w_WB_B[k];
  }

  const Scene& scene_;
  const Settings& settings_;
  std::vector<bool> held_;
  std::vector<int> placing_;          // joint by body
  std::vector<int> ids_, joint_ids_;  // MuJoCo's numbers of bodies and joints
  std::vector<int> owners_;           // body by MuJoCo's number of a geom
  Model model_;
  Data data_;
  mutable Data view_;
  mutable bool viewed_ = false;
  double h_s_ = 0, t_switch_s_ = 0;
  double starts_s_ = 0, clock_start_s_ = 0;  // of the step, by the scene's time and by MuJoCo's
  std::vector<Wrench> wrenches_;             // of the scene's forces at the last evaluation; empty: it has none
  std::int64_t evaluations_ = 0;
  bool has_first_ = false;  // the data has the forces of the step's first evaluation
  bool lost_ = false;
};

void act(const mjModel*, mjData* data) {
  if (acting) acting->add_forces(*data);
}

std::string refused_shape(const Body& body) {
  if (std::holds_alternative<Rectangle>(body.shape))
    return "MuJoCo has no rectangle shape (a box of zero thickness); found one on `" + body.name + "`";
  if (std::holds_alternative<Mesh>(body.shape))
    return "MuJoCo replaces a mesh by its convex hull; found the mesh `" + body.name + "`";
  return "";
}

}  // namespace

// mj_defaultOption and the compiler's defaults for geoms. Friction with condim 3; 1 where the pair has none.
std::vector<Setting> settings() {
  return {
      printed("scalar", std::string("double"), "Type of the engine's numbers."),
      printed("step", std::string("mj_step")),
      printed("pair_law", std::string("the scene's: by geom priorities, or pair by pair where these can't say it")),
      printed("restitution", std::string("none: MuJoCo has no coefficient; scenes that ask for one are refused")),
      printed("spinning_friction", std::string("MuJoCo's least, 1e-5, where rolling friction is asked for; else none")),
      printed("forces",
              std::string("all but uniform gravity: by the adapter at each evaluation of forces (mjcb_passive): "
                          "RK4's four stages, else once a step at its beginning")),
      printed("sleeping", std::string("none: MuJoCo 2.2 has none")),
      printed("linear_damping", 0.0),
      printed("angular_damping", 0.0),
      rivals::substeps_setting(),
      {"integrator", std::string("Euler"), {one_of({"Euler", "RK4", "implicit"}), "Integrator of a step."}},
      {"solver", std::string("Newton"), {one_of({"PGS", "CG", "Newton"}), "Solver of the convex contact problem."}},
      {"iterations", std::int64_t{100}, {between(1, 100000), "Most iterations of the solver."}},
      {"tolerance", 1e-8, {between(0, 1), "Improvement, scaled by MuJoCo, at which the solver ends."}},
      {"noslip_iterations", std::int64_t{0}, {between(0, 100000), "Iterations of the no-slip solver after it."}},
      {"noslip_tolerance", 1e-6, {between(0, 1), "Improvement at which the no-slip solver ends."}},
      {"cone", std::string("pyramidal"), {one_of({"pyramidal", "elliptic"}), "Model of the friction cone."}},
      {"impratio", 1.0, {{0, 1e6, true, false}, "Stiffness of friction over that of normal forces."}},
      {"jacobian", std::string("auto"), {one_of({"dense", "sparse", "auto"}), "Storage of the contact Jacobian."}},
      {"warm_start", true, {{}, "The solver starts from the last step's accelerations."}},
      {"refsafe", true, {{}, "The contact's time constant is at least two steps."}},
      {"multiccd", false, {{}, "Several contact points of a convex pair."}},
      {"mpr_iterations", std::int64_t{50}, {between(1, 100000), "Most iterations of convex collision."}},
      {"mpr_tolerance", 1e-6, {between(0, 1), "Tolerance of convex collision."}},
      {"solref_time_constant_s", 0.02, {{0, 1000, true, false}, "Time constant of a contact (solref).", "s"}},
      {"solref_damping_ratio", 1.0, {{0, 1000, true, false}, "Damping over critical damping of a contact (solref)."}},
      {"solimp_least", 0.9, {between(0, 1), "Impedance at no overlap (solimp)."}},
      {"solimp_most", 0.95, {between(0, 1), "Impedance at overlaps beyond the width (solimp)."}},
      {"solimp_width_m", 0.001, {between(0, 1000), "Overlap over which the impedance rises (solimp).", "m"}},
      {"solimp_midpoint", 0.5, {between(0, 1), "Where it rises steepest, over the width (solimp)."}},
      {"solimp_power", 2.0, {between(1, 1000), "Power of its rise (solimp)."}},
      {"margin_m", 0.0, {between(0, 1000), "Gap up to which a contact is detected.", "m"}},
      {"gap_m", 0.0, {between(0, 1000), "Part of the margin in which a contact has no force.", "m"}},
      printed("joints",
              std::string("the tree of bodies; closing joints are equality constraints, softened by joint_sol*")),
      printed("joint_forces",
              std::string("springs and dampers are MuJoCo's (Euler: implicit in the damping), motors run "
                          "in mjcb_passive")),
      {"mechanism_tolerance", 1e-8, {between(0, 1), "The solver's tolerance in scenes with joints or ropes."}},
      {"joint_solref_time_constant_s",
       0.02,
       {{0, 1000, true, false}, "Time constant of closing joints, ropes and stops (solref).", "s"}},
      {"joint_solref_time_constant_steps", 0.0, {between(0, 1000), "The same as a number of steps; 0: as in seconds."}},
      {"joint_solref_damping_ratio", 1.0, {{0, 1000, true, false}, "Their damping over critical damping (solref)."}},
      {"joint_solimp_least", 0.9, {between(0, 1), "Their impedance without violation (solimp)."}},
      {"joint_solimp_most", 0.95, {between(0, 1), "Their impedance at violations beyond solimp_width_m (solimp)."}},
      {"contacts_per_body", std::int64_t{8}, {between(1, 10000), "Contact points for which there is room."}}};
}

Settings stiff() {
  return {{"integrator", std::string("RK4")},
          {"cone", std::string("elliptic")},
          {"impratio", 100.0},  // a stiffer friction creeps less
          {"tolerance", 1e-10},
          {"solref_time_constant_s", 0.01},  // MuJoCo itself raises it to two steps (refsafe)
          {"solimp_least", 0.99},            // a stiffer contact: less overlap at rest
          {"solimp_most", 0.999},
          {"mechanism_tolerance", 0.0},
          {"joint_solref_time_constant_steps", 2.0},  // the least that MuJoCo holds stable
          {"joint_solimp_least", 0.9999},
          {"joint_solimp_most", 0.9999}};
}

std::optional<Fault> refusal(const Scene& scene, const Settings& settings) {
  if (const auto reason = refused_mechanism(scene); !reason.empty()) return Fault{reason};
  if (!rivals::shapes_matter(scene)) return {};
  for (const auto& law : rivals::laws_in_play(scene)) {
    if (law.restitution != 0) return Fault{"MuJoCo has no restitution: expected restitution = 0"};
  }
  bool compound = false;
  for (const auto& body : scene.bodies) {
    if (const auto reason = refused_shape(body); !reason.empty()) return Fault{reason};
    compound = compound || std::holds_alternative<Compound>(body.shape);
  }
  if (!precedences(scene)) {
    if (const auto pairs = listed_pairs(scene); pairs > kMaxListedPairs) {
      return Fault{"MuJoCo would need an explicit list of the friction of " + std::to_string(pairs) + " pairs"};
    }
    if (compound)
      return Fault{
          "MuJoCo's adapter does not list pairs of parts of a compound, and these materials have no order of priorities"};
  }
  if (room_for_contacts(scene, settings) == 0) {
    return Fault{
        "MuJoCo 2.2 stores a square matrix over all contact rows in a buffer of 2 GiB, which is too small for two "
        "contacts each of " +
        std::to_string(scene.bodies.size()) + " bodies"};
  }
  return {};
}

std::string diagnostics_since_last_call() {
  std::string text;
  if (warning_count > 0) text = "MuJoCo warned " + std::to_string(warning_count) + " times, first: " + first_warning;
  warning_count = 0;
  return text;
}

std::unique_ptr<rivals::World> make_world(const Scene& scene, const Settings& settings, bool) {
  return std::make_unique<MujocoWorld>(scene, settings);
}

}  // namespace atwood::mujoco
