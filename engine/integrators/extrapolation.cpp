#include "integrators/extrapolation.hpp"

#include "math/scalar.hpp"

namespace atwood {

template <class S>
Extrapolation<S>::Extrapolation(System<S>& system, int columns, bool compensated)
    : Stepper<S>(system), columns_(columns), size_(system.size), compensation_(compensated, system.size),
      rate_start_(size_), rate_(size_), before_(size_), state_(size_), difference_(size_) {
  for (int j = 0; j < columns_; ++j) row_[j].resize(size_);
}

// increment = d_n; `before_` holds d_(i-1); the two arrays are exchanged at each substep.
template <class S> void Extrapolation<S>::midpoints(S t_s, S h_s, const S* y, int substeps, S* increment) {
  const S H = h_s / S(substeps);
  for (int i = 0; i < size_; ++i) {
    before_[i] = S(0);
    increment[i] = H * rate_start_[i];
  }
  for (int n = 1; n < substeps; ++n) {
    for (int i = 0; i < size_; ++i) state_[i] = y[i] + increment[i];
    this->system_.rate(t_s + S(n) * H, state_.data(), rate_.data());
    for (int i = 0; i < size_; ++i) {
      const S next = before_[i] + (H + H) * rate_[i];
      before_[i] = increment[i];
      increment[i] = next;
    }
  }
}

template <class S> bool Extrapolation<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  this->system_.rate(t_s, y, rate_start_.data());
  for (int j = 0; j < columns_; ++j) {
    midpoints(t_s, h_s, y, 2 * (j + 1), row_[j].data());
    for (int m = j - 1; m >= 0; --m) {
      const S ratio = S(j + 1) / S(m + 1), divisor = ratio * ratio - S(1);
      for (int i = 0; i < size_; ++i) {
        const S change = (row_[m + 1][i] - row_[m][i]) / divisor;
        row_[m][i] = row_[m + 1][i] + change;
        if (m == 0) difference_[i] = change;
      }
    }
  }
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y[i], row_[0][i]);
  this->system_.project(y_new);
  compensation_.end(y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template <class S> S Extrapolation<S>::error_norm(S rtol, S atol) const {
  S squares = S(0);
  for (int i = 0; i < size_; ++i) {
    const S ratio = difference_[i] / (atol + rtol * real::max(real::abs(this->y_[i]), real::abs(this->y_new_[i])));
    squares += ratio * ratio;
  }
  return real::sqrt(squares / S(size_));
}

template class Extrapolation<float>;
template class Extrapolation<double>;
template class Extrapolation<long double>;
template class Extrapolation<Quad>;

}  // namespace atwood
