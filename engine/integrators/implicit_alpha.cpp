#include "integrators/implicit_alpha.hpp"

#include <algorithm>

namespace atwood {

template <class S>
GeneralisedAlpha<S>::GeneralisedAlpha(System<S>& system, const RigidModel<S>* model, S rho, bool compensated)
    : Stepper<S>(system), size_(system.size), af_(S(1) / (S(1) + rho)), velocity_of_(size_, -1),
      is_velocity_(size_, false), solver_(size_, {Quad(1)}), compensation_(compensated, size_) {
  const auto weights = [&](S am, bool second) {
    const S g = S(0.5) + am - af_, b = (S(1) + am - af_) * (S(1) + am - af_) / S(4);
    return Weights{am, g, second ? b : S(0)};
  };
  second_ = weights((S(2) - rho) / (S(1) + rho), true);
  first_ = weights((S(3) - rho) / (S(2) + S(2) * rho), false);
  for (std::vector<S>* room : {&z_, &k_, &known_, &at_, &slope_, &rate_, &rate_new_, &start_, &end_})
    room->resize(size_);
  if (model == nullptr || model->bare_problem()) return;
  for (int body = 0; body < model->body_count(); ++body)
    for (int i = 0; i < 3 && model->offset(body) >= 0; ++i) {
      velocity_of_[model->offset(body) + kAtPosition + i] = model->offset(body) + kAtVelocity + i;
      is_velocity_[model->offset(body) + kAtVelocity + i] = true;
    }
  if (model->tree() == nullptr) return;
  const int coordinates = model->tree()->scalar_count(), first = model->tree()->scalars_at();
  for (int i = first; i < first + coordinates; ++i) {
    velocity_of_[i] = i + coordinates;
    is_velocity_[i + coordinates] = true;
  }
}

// The solver's unknown is z = af (y_new - y); its equation z = h k(z). With f the law at y + z:
//   rate entries and velocities:  k = af (r_n + g (f - r_n) / am)
//   positions:                    k = af (v + h (a_n / 2 + b (f_v - a_n) / am))
template <class S> void GeneralisedAlpha<S>::rates_at(void* stepper, const S* z, S* k) {
  auto& self = *static_cast<GeneralisedAlpha*>(stepper);
  for (int i = 0; i < self.size_; ++i) self.at_[i] = self.y_start_[i] + z[i];
  self.system_.rate(self.t_start_s_ + self.af_ * self.step_s_, self.at_.data(), self.slope_.data());
  for (int i = 0; i < self.size_; ++i) {
    const int v = self.velocity_of_[i];
    if (v >= 0) {
      const Weights& w = self.second_;
      const S jump = (self.slope_[v] - self.rate_[v]) / w.am;
      k[i] = self.af_ * (self.y_start_[v] + self.step_s_ * (S(0.5) * self.rate_[v] + w.b * jump));
    } else {
      const Weights& w = self.is_velocity_[i] ? self.second_ : self.first_;
      k[i] = self.af_ * (self.rate_[i] + w.g * (self.slope_[i] - self.rate_[i]) / w.am);
    }
  }
}

// Sets rate_ to the rates of the state that the step starts from. A repeated step starts from the same rates as before.
template <class S> void GeneralisedAlpha<S>::restore_rates(S t_s, S h_s, const S* y) {
  const S nearly_s = S(8) * real::epsilon<S>() * (real::abs(t_s) + real::abs(h_s));
  const bool same_law = epoch_ == this->system_.epoch;
  if (same_law && real::abs(t_s - end_s_) <= nearly_s && std::equal(y, y + size_, end_.begin())) {
    std::swap(rate_, rate_new_);
  } else if (!same_law || real::abs(t_s - start_s_) > nearly_s || !std::equal(y, y + size_, start_.begin())) {
    this->system_.rate(t_s, y, rate_.data());
  }
  epoch_ = this->system_.epoch;
  start_s_ = t_s;
  std::copy(y, y + size_, start_.begin());
}

template <class S> bool GeneralisedAlpha<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  restore_rates(t_s, h_s, y);
  y_start_ = y;
  t_start_s_ = t_s;
  step_s_ = h_s;
  for (int i = 0; i < size_; ++i) z_[i] = af_ * h_s * rate_[i];
  solver_.solve(&rates_at, this, h_s, y, known_.data(), z_.data(), k_.data());
  if (!this->system_.solvers.add_unless_capped(IterativeSolver::implicit_stages, solver_.report())) {
    epoch_ = -1;
    return false;
  }
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) {
    const Weights& w = is_velocity_[i] ? second_ : first_;
    const S rise = h_s * k_[i] / af_;
    y_new[i] = compensation_.add(i, y[i], rise);
    rate_new_[i] = rate_[i] + (rise / h_s - rate_[i]) / w.g;
  }
  for (int i = 0; i < size_; ++i)
    if (velocity_of_[i] >= 0) rate_new_[i] = y_new[velocity_of_[i]];  // only a first guess
  if (compensation_.on()) project_compensated(this->system_, compensation_, y_new, slope_.data());
  else this->system_.project(y_new);
  compensation_.end(y_new);
  std::copy(y_new, y_new + size_, end_.begin());
  end_s_ = t_s + h_s;
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template class GeneralisedAlpha<float>;
template class GeneralisedAlpha<double>;
template class GeneralisedAlpha<long double>;
template class GeneralisedAlpha<Quad>;

}  // namespace atwood
