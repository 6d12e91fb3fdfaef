#include "mujoco/mujoco_world.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

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

class MujocoWorld : public rivals::World {
 public:
  MujocoWorld(const Scene& scene, const Settings& settings) : scene_(scene), settings_(settings) {
    mju_user_warning = hear;
    mju_user_error = fail;
    for (const auto& body : scene.bodies) held_.push_back(!body.fixed && body.release_s > 0);
    build();
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (moves(static_cast<int>(i))) set_motion(static_cast<int>(i), motion_of_scene(static_cast<int>(i)));
    }
  }

  void step(double h_s, const std::vector<Wrench>& wrenches) override {
    for (std::size_t i = 0; i < wrenches.size(); ++i) {
      mjtNum* applied = data_->xfrc_applied + 6 * (i + 1);
      for (int k = 0; k < 3; ++k) {
        applied[k] = wrenches[i].force_N[k];
        applied[3 + k] = wrenches[i].torque_N_m[k];
      }
    }
    h_s_ = model_->opt.timestep = h_s;
    mj_step(model_.get(), data_.get());
    for (const int bad : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC})
      lost_ = lost_ || data_->warning[bad].number > 0;
  }

  Motion motion(int i) const override {
    if (lost_) {
      const double nan = std::numeric_limits<double>::quiet_NaN();
      return {{nan, nan, nan}, {nan, nan, nan, nan}, {nan, nan, nan}, {nan, nan, nan}};
    }
    const mjtNum *q = data_->qpos + position_at(i), *v = data_->qvel + velocity_at(i);
    const Body& body = scene_.bodies[i];
    if (!rotates(body)) return {body.position_m + real3(q), body.orientation_wxyz, real3(v), {}};
    return {real3(q), {q[3], q[4], q[5], q[6]}, real3(v), real3(v + 3)};
  }

  // A held body has no joints: at its release the model is compiled again, and the state of all other bodies is kept.
  void release(int i) override {
    std::vector<Motion> motions(scene_.bodies.size());
    for (std::size_t k = 0; k < motions.size(); ++k) {
      if (moves(static_cast<int>(k))) motions[k] = motion(static_cast<int>(k));
    }
    motions[static_cast<std::size_t>(i)] = motion_of_scene(i);
    held_[static_cast<std::size_t>(i)] = false;
    build();
    for (std::size_t k = 0; k < motions.size(); ++k) {
      if (moves(static_cast<int>(k))) set_motion(static_cast<int>(k), motions[k]);
    }
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
      const int first = model_->geom_bodyid[contact.geom1] - 1, second = model_->geom_bodyid[contact.geom2] - 1;
      const double to_b = first < second ? 1.0 : -1.0;
      const Real3 friction = force[1] * real3(contact.frame + 3) + force[2] * real3(contact.frame + 6);
      all.push_back({std::min(first, second), std::max(first, second), real3(contact.pos), to_b * real3(contact.frame),
                     contact.dist, force[0] * h_s_, (to_b * h_s_) * friction});
    }
    return all;
  }

 private:
  void build() {
    model_ = compile(xml_of(scene_, settings_, held_));
    data_.reset(mj_makeData(model_.get()));
    if (!data_) throw std::invalid_argument("MuJoCo could not allocate its buffers");
  }
  bool moves(int i) const { return !scene_.bodies[i].fixed && !held_[static_cast<std::size_t>(i)]; }
  int position_at(int i) const { return model_->jnt_qposadr[model_->body_jntadr[i + 1]]; }
  int velocity_at(int i) const { return model_->body_dofadr[i + 1]; }

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
  Model model_;
  Data data_;
  double h_s_ = 0;
  bool lost_ = false;
};

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
      printed("forces", std::string("all but uniform gravity: evaluated by the adapter once a step, at its beginning")),
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
      {"contacts_per_body", std::int64_t{8}, {between(1, 10000), "Contact points for which there is room."}}};
}

Settings tuned_changes() {
  return {{"integrator", std::string("RK4")},
          {"cone", std::string("elliptic")},
          {"impratio", 100.0},  // a stiffer friction creeps less
          {"tolerance", 1e-10},
          {"solref_time_constant_s", 0.01},  // MuJoCo itself raises it to two steps (refsafe)
          {"solimp_least", 0.99},            // a stiffer contact: less overlap at rest
          {"solimp_most", 0.999}};
}

std::string refusal(const Scene& scene, const Settings& settings) {
  if (!rivals::shapes_matter(scene)) return "";
  for (const auto& law : rivals::laws_in_play(scene)) {
    if (law.restitution != 0) return "MuJoCo has no restitution: expected restitution = 0";
  }
  bool compound = false;
  for (const auto& body : scene.bodies) {
    if (const auto reason = refused_shape(body); !reason.empty()) return reason;
    compound = compound || std::holds_alternative<Compound>(body.shape);
  }
  if (!precedences(scene)) {
    if (const auto pairs = listed_pairs(scene); pairs > kMostListedPairs) {
      return "MuJoCo would need an explicit list of the friction of " + std::to_string(pairs) + " pairs";
    }
    if (compound)
      return "MuJoCo's adapter does not list pairs of parts of a compound, and these materials have no order of priorities";
  }
  if (room_for_contacts(scene, settings) == 0) {
    return "MuJoCo 2.2 keeps the rows of all contacts squared in one buffer of 2 GiB: too small for two contacts each "
           "of " +
           std::to_string(scene.bodies.size()) + " bodies";
  }
  return "";
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
