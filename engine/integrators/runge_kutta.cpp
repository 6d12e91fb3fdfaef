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
    if (row[j].over != 0) {
      combination.stage[combination.terms] = j;
      combination.weight[combination.terms++] = row[j].template as<S>();
    }
  return combination;
}

template <class S> S ExplicitRungeKutta<S>::sum(const Combination& combination, int i) const {
  S total = S(0);
  for (int j = 0; j < combination.terms; ++j) total += combination.weight[j] * k_[combination.stage[j]][i];
  return total;
}

// The sum first, so that y is rounded once. The number of terms is known to the compiler: the loop over components
// then runs in vector lanes.
template <class S>
template <int terms>
void ExplicitRungeKutta<S>::add_terms(const S* y, S h_s, const Combination& combination, S* out) const {
  const S* k[terms];
  S weight[terms];
  for (int j = 0; j < terms; ++j) {
    k[j] = k_[combination.stage[j]];
    weight[j] = combination.weight[j];
  }
  const int size = size_;
#pragma GCC ivdep
  for (int i = 0; i < size; ++i) {
    S slope = weight[0] * k[0][i];
    for (int j = 1; j < terms; ++j) slope += weight[j] * k[j][i];
    out[i] = y[i] + h_s * slope;
  }
}

template <class S> void ExplicitRungeKutta<S>::add(const S* y, S h_s, const Combination& c, S* out) const {
  switch (c.terms) {
    case 1: return add_terms<1>(y, h_s, c, out);
    case 2: return add_terms<2>(y, h_s, c, out);
    case 3: return add_terms<3>(y, h_s, c, out);
    case 4: return add_terms<4>(y, h_s, c, out);
    case 5: return add_terms<5>(y, h_s, c, out);
    case 6: return add_terms<6>(y, h_s, c, out);
    default: return add_terms<7>(y, h_s, c, out);
  }
}

// The last rate of the step before is the first of this one, if this one starts where that one ended, under the same
// law.
template <class S> void ExplicitRungeKutta<S>::first_stage(S t_s, const S* y) {
  const S same_instant_s = S(8) * real::epsilon<S>() * real::max(real::abs(t_s), real::abs(last_end_s_));
  if (first_same_as_last_ && last_epoch_ == this->system_.epoch && real::abs(last_end_s_ - t_s) <= same_instant_s &&
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
  S squares = S(0);
  for (int i = 0; i < size_; ++i) {
    const S scale = atol + rtol * real::max(real::abs(this->y_[i]), real::abs(this->y_new_[i]));
    const S ratio = this->h_s_ * sum(error_, i) / scale;
    squares += ratio * ratio;
  }
  return real::sqrt(squares / S(size_));
}

// y + th (dy + (1-th) (h k1 - dy + th (2 dy - h (k1 + k7) + (1-th) h sum d_i k_i)))       (HNW I, II.6; DOPRI5's
// CONTD5)
template <class S> void ExplicitRungeKutta<S>::dense(S theta, S* y_at) {
  if (!dense_) return Stepper<S>::dense(theta, y_at);
  const S rest = S(1) - theta, h = this->h_s_;
  const S *first = k_[0], *last = k_[stages_ - 1];
  for (int i = 0; i < size_; ++i) {
    const S rise = this->y_new_[i] - this->y_[i];
    const S bend = h * first[i] - rise;
    const S twist = rise - h * last[i] - bend;
    y_at[i] = this->y_[i] + theta * (rise + rest * (bend + theta * (twist + rest * (h * sum(dense_weight_, i)))));
  }
  this->system_.project(y_at);
}

template class ExplicitRungeKutta<float>;
template class ExplicitRungeKutta<double>;
template class ExplicitRungeKutta<long double>;
template class ExplicitRungeKutta<Quad>;

}  // namespace atwood
