#include "integrators/stepper.hpp"

#include "math/scalar.hpp"

namespace atwood {

template <class S>
Stepper<S>::Stepper(System<S>& system) : system_(system), rate_start_(system.size), rate_end_(system.size) {}

template <class S> void Stepper<S>::set_last_step(S t_s, S h_s, const S* y, const S* y_new) {
  t_s_ = t_s;
  h_s_ = h_s;
  y_ = y;
  y_new_ = y_new;
  ends_known_ = false;
}

template <class S> S Stepper<S>::error_norm(S, S) const { return S(0); }
template <class S> auto Stepper<S>::advise(S, S) -> Advice { return {true, h_s_}; }
template <class S> void Stepper<S>::set_tolerance(S, S) {}

// y(theta) = (1-th) y0 + th y1 + th (th-1) ((1-2th)(y1-y0) + (th-1) h f0 + th h f1)      (HNW I, eq. II.6.7)
template <class S> void Stepper<S>::dense(S theta, S* y_at) {
  if (!ends_known_) {
    system_.rate(t_s_, y_, rate_start_.data());
    system_.rate(t_s_ + h_s_, y_new_, rate_end_.data());
    ends_known_ = true;
  }
  const S back = theta - S(1);
  for (int i = 0; i < system_.size; ++i) {
    const S rise = y_new_[i] - y_[i];
    const S bend = (S(1) - S(2) * theta) * rise + h_s_ * (back * rate_start_[i] + theta * rate_end_[i]);
    y_at[i] = y_[i] + theta * rise + theta * back * bend;
  }
  system_.project(y_at);
}

template class Stepper<float>;
template class Stepper<double>;
template class Stepper<long double>;
template class Stepper<Quad>;

}  // namespace atwood
