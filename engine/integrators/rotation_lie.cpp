#include "integrators/rotation_lie.hpp"

#include <algorithm>

#include "integrators/kick_drift.hpp"
#include "math/so3.hpp"

namespace atwood {

template <class S>
LieRungeKutta<S>::LieRungeKutta(RigidModel<S>& model, LieMethod method, bool compensated)
    : Stepper<S>(model.system()), model_(model), method_(method), compensation_(compensated, model.state_size()),
      stage_(model.state_size()) {
  for (auto& k : k_) k.resize(model.state_size());
}

template <class S> Vec3<S> LieRungeKutta<S>::spin(int stage, int at) const { return load3(k_[stage].data() + at); }

// Stages at 0, h/2, h/2, h:
//   Munthe-Kaas       exp(h/2 k1)   exp(h/2 k2)   exp(h k3),
//                     q_new: exp(h (k1 + 2 k2 + 2 k3 + k4) / 6)
//   commutator-free   exp(h/2 k1)   exp(h/2 k2)   exp(h/2 k1) exp(h k3 - h/2 k1),
//                     q_new: exp(h (3 k1 + 2 k2 + 2 k3 - k4) / 12) exp(h (-k1 + 2 k2 + 2 k3 + 3 k4) / 12)
// k: body rates; for Munthe-Kaas rates of the rotation vector. The first rotation is the left factor (body axes).
template <class S> auto LieRungeKutta<S>::stage_rotations(int stage, S h_s, int at) const -> Rotations {
  const S half_s = h_s / S(2);
  if (stage < 3) return {half_s * spin(stage - 1, at), {}};
  if (method_ == LieMethod::munthe_kaas) return {h_s * spin(2, at), {}};
  return {half_s * spin(0, at), h_s * spin(2, at) - half_s * spin(0, at)};
}

template <class S> auto LieRungeKutta<S>::final_rotations(S h_s, int at) const -> Rotations {
  const Vec3<S> k1 = spin(0, at), k4 = spin(3, at), middle = S(2) * (spin(1, at) + spin(2, at));
  if (method_ == LieMethod::munthe_kaas) return {(h_s / S(6)) * (k1 + middle + k4), {}};
  return {(h_s / S(12)) * (S(3) * k1 + middle - k4), (h_s / S(12)) * (S(3) * k4 + middle - k1)};
}

template <class S> void LieRungeKutta<S>::rotate_stage(int stage, S h_s, const S* y) {
  for (const auto& [at, rate_at] : model_.attitudes()) {
    const Rotations rotations = stage_rotations(stage, h_s, at);
    Quat<S> q = load4(y + at) * so3_exp(rotations.first);
    if (method_ == LieMethod::commutator_free && stage == 3) q = q * so3_exp(rotations.second);
    store4(q, stage_.data() + at);
  }
}

// Replaces the quaternion's rate by the rotation vector's.
template <class S> void LieRungeKutta<S>::rotation_rates(int stage, S h_s) {
  for (const auto& [at, rate_at] : model_.attitudes()) {
    Vec3<S> w = load3(stage_.data() + rate_at);
    if (method_ == LieMethod::munthe_kaas && stage > 0)
      w = inverse_left_jacobian(-stage_rotations(stage, h_s, at).first, w);
    store3(w, k_[stage].data() + at);
  }
}

template <class S> bool LieRungeKutta<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  const int size = this->system_.size;
  const S c[4] = {S(0), S(0.5), S(0.5), S(1)};
  std::copy(y, y + size, stage_.begin());
  for (int stage = 0; stage < 4; ++stage) {
    if (stage > 0) {
      for (int i = 0; i < size; ++i) stage_[i] = y[i] + c[stage] * h_s * k_[stage - 1][i];
      rotate_stage(stage, h_s, y);
    }
    this->system_.rate(t_s + c[stage] * h_s, stage_.data(), k_[stage].data());
    rotation_rates(stage, h_s);
  }
  compensation_.begin(y);
  std::copy(y, y + size, y_new);
  for (const int j : model_.plain_components())
    y_new[j] = compensation_.add(j, y[j], h_s / S(6) * (k_[0][j] + S(2) * (k_[1][j] + k_[2][j]) + k_[3][j]));
  for (const auto& [at, rate_at] : model_.attitudes()) {
    const Rotations rotations = final_rotations(h_s, at);
    Quat<S> minus_one = so3_exp_minus_one(rotations.first);
    if (method_ == LieMethod::commutator_free) {
      const Quat<S> second = so3_exp_minus_one(rotations.second), both = minus_one * second;
      minus_one = {minus_one.w + second.w + both.w, minus_one.x + second.x + both.x, minus_one.y + second.y + both.y,
                   minus_one.z + second.z + both.z};
    }
    const Quat<S> dq = load4(y + at) * minus_one;
    for (int j = 0; j < 4; ++j) y_new[at + j] = compensation_.add(at + j, y[at + j], (&dq.w)[j]);
  }
  if (model_.constraints() == nullptr) renormalise(model_, y_new, compensation_);
  else if (compensation_.on()) project_compensated(this->system_, compensation_, y_new, k_[0].data());
  else this->system_.project(y_new);
  compensation_.end(y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template class LieRungeKutta<float>;
template class LieRungeKutta<double>;
template class LieRungeKutta<long double>;
template class LieRungeKutta<Quad>;

}  // namespace atwood
