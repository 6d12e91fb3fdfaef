// The rates of a scene with mechanisms: every moving body is a link of its tree.
#include "joints/constraints.hpp"
#include "rigid/joint_rates.hpp"

#include <algorithm>
#include <limits>

namespace atwood {
template <class S> void RigidModel<S>::build_joints(const Scene& scene) {
  if (!unsupported_.empty()) return;
  std::vector<int> offsets;
  for (const Slot<S>& slot : slots_) offsets.push_back(slot.offset);
  auto tree = std::make_unique<Tree<S>>(scene, offsets, state_size_);
  unsupported_ = tree->refusal();
  if (!unsupported_.empty()) return;
  tree_ = std::move(tree);
  state_size_ = tree_->state_end();
  applied_.resize(tree_->rate_count());
  du_.resize(tree_->rate_count());
  joint_forces_ = std::make_unique<JointForces<S>>(scene);
  switch_times_s_.insert(switch_times_s_.end(), joint_forces_->switch_times_s().begin(),
                         joint_forces_->switch_times_s().end());
  velocity_dependent_ = true;
  magnetic_only_ = false;
  system_.rate_of = &RigidModel::mechanism_rate_of;
  system_.rates_of = &RigidModel::mechanism_rates_of;
  conservative_.refuse("its mechanisms move in coordinates in which the mass is not constant");
  series_forces_.refusal = "joints";
  build_constraints(scene);
  std::sort(switch_times_s_.begin(), switch_times_s_.end());
  switch_times_s_.erase(std::unique(switch_times_s_.begin(), switch_times_s_.end()), switch_times_s_.end());
  joint_rates_ = std::make_unique<JointRates<S>>(*this);
}

template <class S> void RigidModel<S>::place_bodies(S t_s, const S* y, DrivenJoints driven) const {
  if (tree_ == nullptr) return;
  tree_->kinematics(t_s, y, driven);
  for (const int i : on_joints_) tree_->write_body(tree_->link_of(i), placed_.data() + i * kBodyScalars);
}

template <class S> Motion<S> RigidModel<S>::motion(S t_s, const S* y) const {
  place_bodies(t_s, y);
  return {t_s, y, slots_.data()};
}

template <class S> void RigidModel<S>::apply_joint_forces(S t_s, const S* y) {
  if (joint_forces_->empty()) return;  // applied_ is 0
  std::fill(applied_.begin(), applied_.end(), S(0));
  joint_forces_->add(*tree_, t_s, y, applied_.data());
}

// Leaves loads_, applied_, du_ and the tree's kinematics and accelerations at (t, y).
template <class S> void RigidModel<S>::accelerate_mechanisms(S t_s, const S* y) {
  if (active_.empty()) tree_->kinematics(t_s, y);
  else place_bodies(t_s, y);  // for the forces
  add_loads(t_s, y);
  apply_joint_forces(t_s, y);
  tree_->accelerations(loads_.data(), applied_.data(), du_.data());
  if (constraints_ != nullptr) constraints_->constrain(du_.data());
}

template <class S> void RigidModel<S>::mechanism_rate_of(void* context, S t_s, const S* y, S* dydt) {
  static_cast<RigidModel*>(context)->joint_rates_->rate(t_s, y, dydt);
}

template <class S> void RigidModel<S>::mechanism_rates_of(void* context, int count, const S* t_s, const S* y, S* dydt) {
  static_cast<RigidModel*>(context)->joint_rates_->rates(count, t_s, y, dydt);
}

template <class S> void RigidModel<S>::rate_of_links(S t_s, const S* y, S* dydt) {
  if (holds_) std::fill(dydt, dydt + state_size_, S(0));  // held bodies do not move
  accelerate_mechanisms(t_s, y);
  for (const Link<S>& link : tree_->links()) {
    const S* du = du_.data() + link.first_rate;
    if (link.joint < 0) {
      if (slots_[link.body].resting != nullptr) continue;
      const S* at = y + link.at_q;
      S* rate = dydt + link.at_q;
      for (int k = 0; k < 3; ++k) rate[kAtPosition + k] = at[kAtVelocity + k];
      for (int k = 0; k < 3; ++k) rate[kAtVelocity + k] = du[k];
      if (!link.rotates) continue;
      store4(quaternion_rate(load4(at + kAtAttitude), load3(at + kAtBodyRate)), rate + kAtAttitude);
      for (int k = 0; k < 3; ++k) rate[kAtBodyRate + k] = du[3 + k];
      continue;
    }
    const S* u = y + link.at_u;
    if (link.kind == JointKind::ball) store4(quaternion_rate(load4(y + link.at_q), load3(u)), dydt + link.at_q);
    else
      for (int k = 0; k < link.rates; ++k) dydt[link.at_q + k] = link.driven ? link.driven_rate : u[k];
    for (int k = 0; k < link.rates; ++k) dydt[link.at_u + k] = du[k];
  }
}

template <class S> void RigidModel<S>::write_joints(S t_s, const S* y, Sample& sample) {
  accelerate_mechanisms(t_s, y);
  for (const int i : on_joints_) tree_->write_body(tree_->link_of(i), placed_.data() + i * kBodyScalars);
  if (constraints_ != nullptr) tree_->accelerate_bodies(du_.data());
  tree_->reactions(loads_.data(), constraints_ == nullptr ? nullptr : constraints_->wrenches());
  sample.joints.resize(tree_->joint_count());
  for (int j = 0; j < tree_->joint_count(); ++j) {
    const int i = tree_->link_of_joint(j);
    if (i < 0) continue;
    const Link<S>& link = tree_->links()[i];
    JointSample& out = sample.joints[j];
    for (int k = 0; k < coordinate_count(link.kind); ++k) out.q[k] = y[link.at_q + k];
    for (int k = 0; k < link.rates; ++k) out.u[k] = y[link.at_u + k];
    if (link.driven) {
      out.q[0] = link.driven_start + t_s * link.driven_rate;
      out.u[0] = link.driven_rate;
    }
    for (int k = 0; k < link.rates; ++k) out.applied[k] = applied_[link.first_rate + k];
    out.stop = {};
    if (constraints_ != nullptr) out.stop[0] = constraints_->locked_force(j);
    const auto [force, moment] = tree_->constraint_wrench(i, applied_.data());
    out.force_N = {force.x, force.y, force.z};
    out.torque_N_m = {moment.x, moment.y, moment.z};
  }
  if (constraints_ != nullptr) write_constraints(t_s, y, sample);
}

#define ATWOOD_MECHANISM(S)                                                            \
  template void RigidModel<S>::build_joints(const Scene&);                             \
  template void RigidModel<S>::place_bodies(S, const S*, DrivenJoints) const;          \
  template Motion<S> RigidModel<S>::motion(S, const S*) const;                         \
  template void RigidModel<S>::apply_joint_forces(S, const S*);                        \
  template void RigidModel<S>::accelerate_mechanisms(S, const S*);                     \
  template void RigidModel<S>::mechanism_rate_of(void*, S, const S*, S*);              \
  template void RigidModel<S>::mechanism_rates_of(void*, int, const S*, const S*, S*); \
  template void RigidModel<S>::rate_of_links(S, const S*, S*);                         \
  template void RigidModel<S>::write_joints(S, const S*, Sample&);
ATWOOD_MECHANISM(float)
ATWOOD_MECHANISM(double)
ATWOOD_MECHANISM(long double)
ATWOOD_MECHANISM(Quad)
#undef ATWOOD_MECHANISM

}  // namespace atwood
