#include "integrators/conserving_gradient.hpp"

#include <algorithm>

#include "integrators/collocation_nodes.hpp"

namespace atwood {
namespace {

constexpr int kNodes = 9;  // an odd number: the middle one is the midpoint. Exact up to degree 17

}  // namespace

template <class S>
DiscreteGradient<S>::DiscreteGradient(RigidModel<S>& model, Force force, bool compensated)
    : Stepper<S>(model.system()), model_(model), size_(model.state_size()), force_(force), solver_(size_, {Quad(1)}),
      z_(size_), k_(size_), known_(size_), end_y_(size_), force_W_(model.body_count()),
      compensation_(compensated, size_) {
  const CollocationTableau points = gauss_collocation(kNodes);
  node_.assign(points.c.begin(), points.c.end());
  weight_.assign(points.b.begin(), points.b.end());
  node_t_s_.resize(kNodes);
  node_y_.resize(static_cast<std::size_t>(kNodes) * size_);
  node_rate_.resize(node_y_.size());
  scratch_.resize(2 * size_);
}

// The mean of v' over the segment; p' = v is linear along it, and q' and w' are taken at the middle node.
template <class S> void DiscreteGradient<S>::average_over_segment(const S* z, S* k) {
  for (int i = 0; i < size_; ++i)
    for (int n = 0; n < kNodes; ++n) node_y_[i * kNodes + n] = y_[i] + node_[n] * z[i];
  std::fill(node_t_s_.begin(), node_t_s_.end(), t_s_now_ + h_now_s_ / S(2));
  this->system_.rates(kNodes, node_t_s_.data(), node_y_.data(), node_rate_.data(), scratch_.data());
  for (int i = 0; i < size_; ++i) k[i] = node_rate_[i * kNodes + kNodes / 2];
  for (const int body : model_.moving())
    for (int i = model_.offset(body) + kAtVelocity; i < model_.offset(body) + kAtVelocity + 3; ++i) {
      S mean = S(0);
      for (int n = 0; n < kNodes; ++n) mean += weight_[n] * node_rate_[i * kNodes + n];
      k[i] = mean;
    }
}

template <class S> void DiscreteGradient<S>::difference_potential(const S* z, S* k) {
  const S half = S(0.5);
  for (int i = 0; i < size_; ++i) end_y_[i] = y_[i] + z[i];
  std::fill(force_W_.begin(), force_W_.end(), Vec3<S>{});
  ++this->system_.evaluations;
  model_.conservative().add_discrete_forces(model_.motion(t_s_now_, y_), model_.motion(t_s_now_, end_y_.data()),
                                            force_W_.data());
  std::fill(k, k + size_, S(0));
  for (const int body : model_.moving()) {
    const int at = model_.offset(body);
    const MassProperties<S>& mass = model_.mass(body);
    store3(load3(y_ + at + kAtVelocity) + half * load3(z + at + kAtVelocity), k + at + kAtPosition);
    store3(mass.inverse_mass_per_kg * force_W_[body], k + at + kAtVelocity);
    if (!model_.rotates(body)) continue;
    const Vec3<S> w = load3(y_ + at + kAtBodyRate) + half * load3(z + at + kAtBodyRate);
    Quat<S> q = load4(y_ + at + kAtAttitude);
    const Quat<S> turn = load4(z + at + kAtAttitude);
    q = {q.w + half * turn.w, q.x + half * turn.x, q.y + half * turn.y, q.z + half * turn.z};
    store4(quaternion_rate(q, w), k + at + kAtAttitude);
    store3(mass.times_inverse_inertia(cross(mass.times_inertia(w), w)), k + at + kAtBodyRate);
  }
}

template <class S> void DiscreteGradient<S>::rates_at(void* stepper, const S* z, S* k) {
  auto& self = *static_cast<DiscreteGradient*>(stepper);
  if (self.force_ == Force::mean_over_segment) self.average_over_segment(z, k);
  else self.difference_potential(z, k);
}

template <class S> bool DiscreteGradient<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  y_ = y;
  t_s_now_ = t_s;
  h_now_s_ = h_s;
  this->system_.rate(t_s, y, k_.data());
  for (int i = 0; i < size_; ++i) z_[i] = h_s * k_[i];
  solver_.solve(&rates_at, this, h_s, y, known_.data(), z_.data(), k_.data());
  if (!this->system_.solvers.add_unless_capped(IterativeSolver::implicit_stages, solver_.report())) return false;
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y[i], z_[i]);
  compensation_.end(y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template class DiscreteGradient<float>;
template class DiscreteGradient<double>;
template class DiscreteGradient<long double>;
template class DiscreteGradient<Quad>;

}  // namespace atwood
