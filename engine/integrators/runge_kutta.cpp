#include "integrators/runge_kutta.hpp"

#include <algorithm>

#include "math/scalar.hpp"

namespace atwood {

template <class S>
ExplicitRungeKutta<S>::ExplicitRungeKutta(System<S>& system, const Tableau& tableau)
    : Stepper<S>(system),
      stages_(tableau.stages),
      size_(system.size),
      first_same_as_last_(tableau.first_same_as_last),
      dense_(tableau.dense),
      b_(combine(tableau.b)),
      error_(combine(tableau.error_weight)),
      dense_weight_(combine(tableau.dense_weight)),
      rates_(static_cast<std::size_t>(tableau.stages) * system.size),
      stage_(system.size),
      last_end_(system.size) {
  for (int i = 0; i < stages_; ++i) {
    a_[i] = combine(tableau.a[i]);
    c_[i] = tableau.c[i].template as<S>();
    k_[i] = rates_.data() + static_cast<std::size_t>(i) * size_;
  }
}

template <class S> auto ExplicitRungeKutta<S>::combine(const TableauRow& row) -> Combination {
  Combination combination;
  for (int j = 0; j < max_stages; ++j)
    if (row[j].over != 0) combination.term[combination.terms++] = {j, row[j].template as<S>()};
  return combination;
}

// out = y + h (w1 k1 + w2 k2 + ...): the sum first, so that y is rounded once.
template <class S> void ExplicitRungeKutta<S>::add(const S* y, S h_s, const Combination& sum, S* out) const {
  for (int i = 0; i < size_; ++i) {
    S slope = S(0);
    for (int j = 0; j < sum.terms; ++j) slope += sum.term[j].weight * k_[sum.term[j].stage][i];
    out[i] = y[i] + h_s * slope;
  }
}

// The last rate of the step before is the first of this one, if this one starts where that one ended, under the same law.
template <class S> void ExplicitRungeKutta<S>::first_stage(S t_s, const S* y) {
  if (first_same_as_last_ && last_epoch_ == this->system_.epoch && last_end_s_ == t_s &&
      std::equal(y, y + size_, last_end_.begin())) {
    std::swap(k_[0], k_[stages_ - 1]);
    return;
  }
  this->system_.rate(t_s, y, k_[0]);
}

template <class S> bool ExplicitRungeKutta<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  first_stage(t_s, y);
  const int inner = first_same_as_last_ ? stages_ - 1 : stages_;
  for (int i = 1; i < inner; ++i) {
    add(y, h_s, a_[i], stage_.data());
    this->system_.rate(t_s + c_[i] * h_s, stage_.data(), k_[i]);
  }
  add(y, h_s, b_, y_new);
  this->system_.project(y_new);
  if (first_same_as_last_) {
    this->system_.rate(t_s + h_s, y_new, k_[stages_ - 1]);
    std::copy(y_new, y_new + size_, last_end_.begin());
    last_end_s_ = t_s + h_s;
    last_epoch_ = this->system_.epoch;
  }
  this->remember(t_s, h_s, y, y_new);
  return true;
}

template <class S> S ExplicitRungeKutta<S>::error_norm(S rtol, S atol) const {
  if (error_.terms == 0) return S(0);
  S sum = S(0);
  for (int i = 0; i < size_; ++i) {
    S estimate = S(0);
    for (int j = 0; j < error_.terms; ++j) estimate += error_.term[j].weight * k_[error_.term[j].stage][i];
    const S scale = atol + rtol * real::max(real::abs(this->y_[i]), real::abs(this->y_new_[i]));
    const S ratio = this->h_s_ * estimate / scale;
    sum += ratio * ratio;
  }
  return real::sqrt(sum / S(size_));
}

// y + th (dy + (1-th) (h k1 - dy + th (2 dy - h (k1 + k7) + (1-th) h sum d_i k_i)))       (HNW I, II.6; DOPRI5's CONTD5)
template <class S> void ExplicitRungeKutta<S>::dense(S theta, S* y_at) {
  if (!dense_) return Stepper<S>::dense(theta, y_at);
  const S rest = S(1) - theta, h = this->h_s_;
  const S *first = k_[0], *last = k_[stages_ - 1];
  for (int i = 0; i < size_; ++i) {
    S extra = S(0);
    for (int j = 0; j < dense_weight_.terms; ++j) extra += dense_weight_.term[j].weight * k_[dense_weight_.term[j].stage][i];
    const S rise = this->y_new_[i] - this->y_[i];
    const S bend = h * first[i] - rise;
    const S twist = rise - h * last[i] - bend;
    y_at[i] = this->y_[i] + theta * (rise + rest * (bend + theta * (twist + rest * (h * extra))));
  }
  this->system_.project(y_at);
}

template class ExplicitRungeKutta<float>;
template class ExplicitRungeKutta<double>;
template class ExplicitRungeKutta<long double>;
template class ExplicitRungeKutta<Quad>;

}  // namespace atwood
