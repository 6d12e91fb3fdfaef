#include "integrators/extrapolation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include "math/elementary.hpp"

#include "math/scalar.hpp"

namespace atwood {

namespace {

int substeps_of(int column) { return 2 * column; }

// Evaluations of a step that ends with this column, A_j.
int evaluations_of(int column) {
  int count = 1;
  for (int j = 1; j <= column; ++j) count += substeps_of(j) - 1;
  return count;
}

// Whether an error in this column is too large for convergence in `last`: err_j <= prod (n_i / n_1)^2, i = j + 1 ..
// last.
bool hopeless(double error, int column, int last) {
  double most = 1;
  for (int i = column + 1; i <= last; ++i) most *= substeps_of(i) / substeps_of(1);
  return !(error <= most * most);
}

}  // namespace

template <class S>
Extrapolation<S>::Extrapolation(System<S>& system, const ExtrapolationOptions& options)
    : Stepper<S>(system), options_(options), size_(system.size), compensation_(options.compensated, system.size),
      rate_start_(size_), rate_(size_), before_(size_), state_(size_), difference_(size_) {
  for (int j = 0; j < (options.choose_order ? kMaxColumns : options.columns); ++j) row_[j].resize(size_);
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

template <class S> void Extrapolation<S>::add_column(S t_s, S h_s, const S* y, int column) {
  midpoints(t_s, h_s, y, substeps_of(column), row_[column - 1].data());
  for (int m = column - 2; m >= 0; --m) {
    const S ratio = S(column) / S(m + 1), divisor = ratio * ratio - S(1);
    for (int i = 0; i < size_; ++i) {
      const S change = (row_[m + 1][i] - row_[m][i]) / divisor;
      row_[m][i] = row_[m + 1][i] + change;
      if (m == 0) difference_[i] = change;
    }
  }
}

// The columns up to the first of k - 1, k and k + 1 whose error is within the tolerance, k being the expected one;
// fewer where that cannot come.
template <class S> void Extrapolation<S>::columns_to_tolerance(S t_s, S h_s, const S* y) {
  converged_ = false;
  for (reached_ = 1;; ++reached_) {
    add_column(t_s, h_s, y, reached_);
    if (reached_ == 1) continue;
    for (int i = 0; i < size_; ++i) state_[i] = y[i] + row_[0][i];
    error_[reached_] = norm(y, state_.data(), rtol_, atol_);
    if (reached_ < expected_ - 1) continue;
    converged_ = error_[reached_] <= 1;
    if (converged_ || reached_ > expected_ || hopeless(error_[reached_], reached_, expected_ + 1)) return;
  }
}

template <class S> bool Extrapolation<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  this->system_.rate(t_s, y, rate_start_.data());
  if (options_.choose_order && rtol_ > S(0)) columns_to_tolerance(t_s, h_s, y);
  else
    for (int column = 1; column <= options_.columns; ++column) add_column(t_s, h_s, y, column);
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y[i], row_[0][i]);
  this->system_.project(y_new);
  compensation_.end(y_new);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template <class S> double Extrapolation<S>::norm(const S* y, const S* y_new, S rtol, S atol) const {
  S squares = S(0);
  for (int i = 0; i < size_; ++i) {
    const S ratio = difference_[i] / (atol + rtol * real::max(real::abs(y[i]), real::abs(y_new[i])));
    squares += ratio * ratio;
  }
  return static_cast<double>(real::sqrt(squares / S(size_)));
}

template <class S> S Extrapolation<S>::error_norm(S rtol, S atol) const {
  return S(norm(this->y_, this->y_new_, rtol, atol));
}

template <class S> void Extrapolation<S>::set_tolerance(S rtol, S atol) {
  rtol_ = rtol;
  atol_ = atol;
  rejected_before_ = false;
  const double digits = -std::log10(static_cast<double>(rtol));
  expected_ = std::clamp(static_cast<int>(0.6 * digits + 1.5), 2, kMaxColumns - 1);
}

// The step that this column allows, over the last one.
template <class S> double Extrapolation<S>::factor(int column) const {
  const auto& [safety, beta, least, most] = options_.limits;
  const double error = error_[column];
  if (!(error < std::numeric_limits<double>::infinity())) return least;
  return error > 0 ? std::clamp(safety * real::step_power(error, -1.0 / (2 * column - 1)), least, most) : most;
}

template <class S> double Extrapolation<S>::work(int column) const { return evaluations_of(column) / factor(column); }

template <class S> auto Extrapolation<S>::advise(S, S) -> typename Stepper<S>::Advice {
  constexpr double down = 0.8, up = 0.9;  // a change of the order must save this much
  const S h_s = this->h_s_;
  const int last = reached_, most = kMaxColumns - 1;
  if (!converged_) {
    rejected_before_ = true;
    expected_ = std::min(expected_, last);
    if (expected_ > 2 && work(expected_ - 1) < down * work(expected_)) --expected_;
    return {false, h_s * S(real::min(factor(expected_), up))};
  }
  int best = last;
  if (last > expected_) {
    best = last - 1;
    if (last > 3 && work(last - 2) < down * work(last - 1)) best = last - 2;
    if (work(last) < up * work(best)) best = last;
  } else if (last > 2) {
    if (work(last - 1) < down * work(last)) best = last - 1;
    else if (work(last) < up * work(last - 1)) best = last + 1;
  } else {
    best = 3;
  }
  best = std::min(best, most);
  if (rejected_before_) {
    rejected_before_ = false;
    expected_ = std::min(best, last);
    return {true, h_s * S(real::min(factor(expected_), 1.0))};
  }
  expected_ = best;
  if (best <= last) return {true, h_s * S(factor(best))};
  return {true, h_s * S(factor(last) * evaluations_of(best) / evaluations_of(last))};
}

template class Extrapolation<float>;
template class Extrapolation<double>;
template class Extrapolation<long double>;
template class Extrapolation<Quad>;

}  // namespace atwood
