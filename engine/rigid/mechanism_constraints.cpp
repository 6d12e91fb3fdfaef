// Loops and ropes of a scene's mechanisms: their start, what they report, and when they end a run.
#include <algorithm>
#include <cmath>

#include "joints/closing_force.hpp"
#include "joints/constraints.hpp"
#include "rigid/model.hpp"
#include "scene/mechanism.hpp"

namespace atwood {
namespace {

// The exact start, in quad, as the state has it: bodies without a placing joint, then the joints of the tree.
template <class S> void take_start(const MechanismStart& start, const RigidModel<S>& model, S* y) {
  for (int i = 0; i < model.body_count(); ++i) {
    const BodyMotion& m = start.bodies[i];
    const auto narrow = [](const quad::Vector& v) { return Vec3<S>{S(v[0]), S(v[1]), S(v[2])}; };
    const auto& q = m.q_wxyz;
    model.set_body(i, {narrow(m.p_m), narrow(m.v_m_per_s), {S(q[0]), S(q[1]), S(q[2]), S(q[3])}, narrow(m.w_rad_per_s)},
                   y);
  }
  for (const Link<S>& link : model.tree()->links()) {
    if (link.joint < 0) continue;
    const JointMotion& motion = start.joints[link.joint];
    for (int k = 0; k < coordinate_count(link.kind); ++k) y[link.at_q + k] = S(motion.q[k]);
    for (int k = 0; k < link.rates; ++k) y[link.at_u + k] = S(motion.u[k]);
  }
}

}  // namespace

template <class S> void RigidModel<S>::build_constraints(const Scene& scene) {
  auto constraints = std::make_unique<Constraints<S>>(scene, *tree_);
  unsupported_ = constraints->refusal();
  if (!unsupported_.empty() || constraints->empty()) return;
  std::vector<S> y(static_cast<std::size_t>(state_size_));
  initial_state(y.data());
  try {
    take_start(mechanism_start(scene), *this, y.data());
  } catch (const MechanismError& error) {
    unsupported_ = error.what();
    return;
  }
  constraints->start(y.data());
  unsupported_ = constraints->refusal();
  if (!unsupported_.empty()) return;
  projected_.resize(y.size());
  for (const Joint& joint : scene.joints) closing_joints_.push_back(joint.closes_loop ? joint : Joint{});
  for (const Rope& rope : scene.ropes) rope_names_.push_back(rope.name);
  closing_motions_.resize(scene.joints.size());
  rope_angle_.assign(scene.ropes.size(), S(0));
  for (const JointForce& force : scene.joint_forces) {
    if (!scene.joints[std::visit([](const auto& f) { return f.joint; }, force)].closes_loop) continue;
    terms_.push_back(std::make_unique<ClosingForce<S>>(force, scene));
    forces_depend_on_velocities_ = forces_depend_on_velocities_ || terms_.back()->velocity_dependent();
    for (const Interval& on : terms_.back()->on_s)
      for (const double t : {on.from_s, on.to_s})
        if (t > 0 && std::isfinite(t)) switch_times_s_.push_back(t);
  }
  active_.reserve(terms_.size());
  constraints_ = std::move(constraints);
  start_ = std::move(y);
}

// The coordinates and rates of a closing joint at the present kinematics, those of t_s. Each angle is the one nearest
// to where the mean of its rates leads from the last time to t_s; at t = 0 the one nearest to the scene's.
template <class S> void RigidModel<S>::follow_closing(std::size_t joint, S t_s) {
  const Joint& of = closing_joints_[joint];
  ClosingMotion& motion = closing_motions_[joint];
  if (!(t_s > S(0))) {
    motion = {};
    for (int k = 0; k < 4; ++k) motion.q[k] = S(of.coordinates[k]);
  }
  const ClosingMotion before = motion;
  motion.t_s = t_s;
  constraints_->closing_coordinates(of, motion.q.data(), motion.u.data());
  if (of.kind != JointKind::ball && t_s > S(0)) {
    for (int k = 0; k < rate_count(of.kind); ++k)
      motion.q[k] = before.q[k] + (t_s - before.t_s) * (before.u[k] + motion.u[k]) / S(2);
    constraints_->closing_coordinates(of, motion.q.data(), motion.u.data());
  }
  for (const auto& term : terms_)
    if (auto* force = closing_force(term.get()); force != nullptr && force->joint() == static_cast<int>(joint))
      force->remember({t_s, motion.q, motion.u});
}

template <class S> void RigidModel<S>::follow_turns(S t_s, const S* y) {
  if (constraints_ == nullptr) return;
  tree_->kinematics(t_s, y);
  for (std::size_t j = 0; j < closing_joints_.size(); ++j)
    if (closing_joints_[j].closes_loop) follow_closing(j, t_s);
  for (std::size_t i = 0; i < rope_angle_.size(); ++i) {
    const RopePath<S> path = constraints_->rope_path_of(static_cast<int>(i));
    if (path.fault == nullptr) rope_travel(constraints_->rope(static_cast<int>(i)), path, rope_angle_[i]);
  }
}

// The tree's kinematics, accelerations and the multipliers are those at (t, y).
template <class S> void RigidModel<S>::write_constraints(S t_s, const S*, Sample& sample) {
  constraints_->find_open_components();
  for (std::size_t j = 0; j < closing_joints_.size(); ++j) {
    JointSample& out = sample.joints[j];
    const int at = static_cast<int>(j);
    out.not_unique = constraints_->not_unique(at);
    const Joint& joint = closing_joints_[j];
    if (!joint.closes_loop) continue;
    follow_closing(j, t_s);
    const ClosingMotion& motion = closing_motions_[j];
    for (int k = 0; k < coordinate_count(joint.kind); ++k) out.q[k] = motion.q[k];
    for (int k = 0; k < rate_count(joint.kind); ++k) out.u[k] = motion.u[k];
    out.applied = {};
    for (const ForceTerm<S>* term : active_) {
      const ClosingForce<S>* force = closing_force(term);
      if (force == nullptr || force->joint() != at) continue;
      const std::array<S, 3> along = force->along_rates({t_s, motion.q, motion.u});
      for (int k = 0; k < rate_count(joint.kind); ++k) out.applied[k] += along[k];
    }
    const auto [force, moment] = constraints_->closing_wrench(at);
    out.force_N = {force.x, force.y, force.z};
    out.torque_N_m = {moment.x, moment.y, moment.z};
  }
  sample.ropes.resize(rope_angle_.size());
  for (std::size_t i = 0; i < rope_angle_.size(); ++i) {
    const int at = static_cast<int>(i);
    const RopeConstraint<S>& rope = constraints_->rope(at);
    const RopePath<S> path = constraints_->rope_path_of(at);
    RopeSample& out = sample.ropes[i];
    out.tension_N = constraints_->tension(at);
    out.pulley_angle_rad.clear();
    if (!(t_s > S(0))) rope_angle_[i] = S(0);
    const S run = path.fault == nullptr ? rope_travel(rope, path, rope_angle_[i]) : S(0);
    for (const auto& pulley : rope.pulleys)
      out.pulley_angle_rad.push_back(pulley.angle + (pulley.radius > S(0) ? run / pulley.radius : S(0)));
  }
}

template <class S> std::string RigidModel<S>::constraint_fault(S t_s, const S* y) {
  if (constraints_ == nullptr) return "";
  if (!constraints_->fault().empty()) return constraints_->fault();
  if (rope_names_.empty()) return "";
  accelerate_mechanisms(t_s, y);
  ++system_.evaluations;
  if (!constraints_->fault().empty()) return constraints_->fault();
  for (std::size_t i = 0; i < rope_names_.size(); ++i)
    if (constraints_->tension(static_cast<int>(i)) < S(0)) return "rope `" + rope_names_[i] + "` is slack";
  return "";
}

#define ATWOOD_CONSTRAINTS(S)                                           \
  template void RigidModel<S>::build_constraints(const Scene&);         \
  template void RigidModel<S>::write_constraints(S, const S*, Sample&); \
  template std::string RigidModel<S>::constraint_fault(S, const S*);    \
  template void RigidModel<S>::follow_turns(S, const S*);
ATWOOD_CONSTRAINTS(float)
ATWOOD_CONSTRAINTS(double)
ATWOOD_CONSTRAINTS(long double)
ATWOOD_CONSTRAINTS(Quad)
#undef ATWOOD_CONSTRAINTS

}  // namespace atwood
