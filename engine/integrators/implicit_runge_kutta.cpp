#include "integrators/implicit_runge_kutta.hpp"

#include <algorithm>

namespace atwood {

template <class S>
ImplicitRungeKutta<S>::ImplicitRungeKutta(System<S>& system, const CollocationTableau& tableau,
                                          const ImplicitOptions& options)
    : Stepper<S>(system), size_(system.size), stages_(tableau.stages), options_(options),
      a_(tableau.a.begin(), tableau.a.end()), b_(tableau.b.begin(), tableau.b.end()),
      c_(tableau.c.begin(), tableau.c.end()), compensation_(options.compensated, system.size),
      filter_(options.estimates ? system.size : 0), last_end_(system.size) {
  stiffly_accurate_ = std::equal(tableau.b.begin(), tableau.b.end(), tableau.a.end() - stages_);
  find_groups(tableau);
  find_extrapolation(tableau);
  const std::size_t all = static_cast<std::size_t>(size_) * stages_;
  for (std::vector<S>* room : {&k_, &z_, &group_k_, &group_z_, &known_, &stage_y_}) room->resize(all);
  stage_t_s_.resize(stages_);
  slope_.resize(size_);
  scratch_.resize(2 * size_);
  if (!options_.estimates) return;
  first_slope_.resize(size_);
  error_.resize(size_);
  Quad eigenvalue = Quad(3.6);  // of A^-1: x^3 - 9 x^2 + 36 x - 60 = 0
  for (int n = 0; n < 8; ++n)
    eigenvalue -= (((eigenvalue - 9) * eigenvalue + 36) * eigenvalue - 60) / ((3 * eigenvalue - 18) * eigenvalue + 36);
  gamma0_ = S(Quad(1) / eigenvalue);
}

// A group ends before stage i where no earlier stage depends on stage i or a later one.
template <class S> void ImplicitRungeKutta<S>::find_groups(const CollocationTableau& tableau) {
  const int s = stages_;
  const auto a = [&](int i, int j) { return tableau.a[i * s + j]; };
  for (int first = 0, end = 1; first < s; first = end, ++end) {
    const auto cut = [&] {
      for (int i = first; i < end; ++i)
        for (int j = end; j < s; ++j)
          if (a(i, j) != Quad(0)) return false;
      return true;
    };
    while (!cut()) ++end;
    std::vector<Quad> block;
    for (int i = first; i < end; ++i)
      for (int j = first; j < end; ++j) block.push_back(a(i, j));
    const bool is_explicit = block.size() == 1 && block[0] == Quad(0);
    groups_.push_back({first, is_explicit,
                       StageSolver<S>(is_explicit ? 0 : size_, is_explicit ? std::vector<Quad>{Quad(1)} : block)});
  }
}

// The polynomial through the slopes at c_j of the last step, integrated from 1 to 1 + c_i; the quadrature formula with
// nodes c_i is exact.
template <class S> void ImplicitRungeKutta<S>::find_extrapolation(const CollocationTableau& tableau) {
  if (groups_.size() > 1) return;
  const CollocationTableau points = gauss_collocation(stages_);
  for (int i = 0; i < stages_; ++i)
    for (int j = 0; j < stages_; ++j) {
      Quad total = Quad(0);
      for (int p = 0; p < stages_; ++p) {
        Quad value = points.b[p];
        for (int m = 0; m < stages_; ++m)
          if (m != j) value *= (Quad(1) + points.c[p] * tableau.c[i] - tableau.c[m]) / (tableau.c[j] - tableau.c[m]);
        total += value;
      }
      extrapolated_.push_back(S(total * tableau.c[i]));
    }
}

template <class S> void ImplicitRungeKutta<S>::rates_at(void* stepper, const S* z, S* k) {
  auto& self = *static_cast<ImplicitRungeKutta*>(stepper);
  const int n = self.group_->solver.stages();
  for (int i = 0; i < self.size_; ++i)
    for (int s = 0; s < n; ++s) self.stage_y_[i * n + s] = self.start_[i] + z[i * n + s];
  for (int s = 0; s < n; ++s) self.stage_t_s_[s] = self.start_s_ + self.c_[self.group_->first + s] * self.step_s_;
  self.system_.rates(n, self.stage_t_s_.data(), self.stage_y_.data(), k, self.scratch_.data());
}

// First guess in group_z_: the last step's polynomial, extrapolated; without one, the slope of the nearest earlier
// stage.
template <class S> void ImplicitRungeKutta<S>::guess(const Group& group, S t_s, const S* y, bool continued) {
  const int n = group.solver.stages(), s = stages_;
  if (continued && !extrapolated_.empty()) {
    for (int i = 0; i < size_; ++i)
      for (int g = 0; g < n; ++g) {
        S sum = S(0);
        for (int j = 0; j < s; ++j) sum += extrapolated_[g * s + j] * k_[i * s + j];
        group_z_[i * n + g] = step_s_ * sum;
      }
    return;
  }
  if (group.first > 0 || continued) {
    const int from = group.first > 0 ? group.first - 1 : s - 1;
    for (int i = 0; i < size_; ++i) slope_[i] = k_[i * s + from];
  } else {
    this->system_.rate(t_s, y, slope_.data());
  }
  for (int i = 0; i < size_; ++i)
    for (int g = 0; g < n; ++g) {
      S row_sum = S(0);
      for (int j = 0; j < n; ++j) row_sum += a_[(group.first + g) * s + group.first + j];
      group_z_[i * n + g] = known_[i * n + g] + step_s_ * row_sum * slope_[i];
    }
}

template <class S> bool ImplicitRungeKutta<S>::solve_group(Group& group, const S* y) {
  const int n = group.solver.stages(), s = stages_;
  group_ = &group;
  bool solved = true;
  if (group.is_explicit) {
    std::copy(known_.begin(), known_.begin() + size_, group_z_.begin());
    rates_at(this, group_z_.data(), group_k_.data());
  } else {
    group.solver.solve(&rates_at, this, step_s_, y, known_.data(), group_z_.data(), group_k_.data());
    solved = this->system_.solvers.add_unless_capped(IterativeSolver::implicit_stages, group.solver.report());
  }
  for (int i = 0; i < size_; ++i)
    for (int g = 0; g < n; ++g) {
      k_[i * s + group.first + g] = group_k_[i * n + g];
      z_[i * s + group.first + g] = group_z_[i * n + g];
    }
  return solved;
}

// The last stage of a method with c_s = 1 is the slope at the end.
template <class S> void ImplicitRungeKutta<S>::take_first_slope(S t_s, const S* y, bool continued) {
  if (!continued) return this->system_.rate(t_s, y, first_slope_.data());
  for (int i = 0; i < size_; ++i) first_slope_[i] = k_[i * stages_ + stages_ - 1];
}

template <class S> void ImplicitRungeKutta<S>::project(S* y_new) {
  if (compensation_.on()) project_compensated(this->system_, compensation_, y_new, slope_.data());
  else this->system_.project(y_new);
}

template <class S> bool ImplicitRungeKutta<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  const int s = stages_;
  const S nearly_s = S(8) * real::epsilon<S>() * real::max(real::abs(t_s), real::abs(last_end_s_));
  const bool continued = last_epoch_ == this->system_.epoch && real::abs(t_s - last_end_s_) <= nearly_s &&
                         real::abs(h_s - last_h_s_) <= S(1e-3) * real::abs(h_s) &&
                         std::equal(y, y + size_, last_end_.begin());
  start_ = y;
  start_s_ = t_s;
  step_s_ = h_s;
  last_epoch_ = -1;
  if (options_.estimates) take_first_slope(t_s, y, continued);
  for (Group& group : groups_) {
    const int n = group.solver.stages();
    for (int i = 0; i < size_; ++i)
      for (int g = 0; g < n; ++g) {
        S sum = S(0);
        for (int j = 0; j < group.first; ++j) sum += a_[(group.first + g) * s + j] * k_[i * s + j];
        known_[i * n + g] = h_s * sum;
      }
    if (!group.is_explicit) guess(group, t_s, y, continued);
    if (!solve_group(group, y)) return false;
  }
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) {
    S rise = S(0);
    for (int j = 0; j < s; ++j) rise += b_[j] * k_[i * s + j];
    y_new[i] = compensation_.add(i, y[i], stiffly_accurate_ ? z_[i * s + s - 1] : h_s * rise);
  }
  if (options_.projects) project(y_new);
  compensation_.end(y_new);
  std::copy(y_new, y_new + size_, last_end_.begin());
  last_end_s_ = t_s + h_s;
  last_h_s_ = h_s;
  last_epoch_ = this->system_.epoch;
  if (options_.estimates) estimate(h_s);
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

// Hairer, Wanner II, eq. IV.8.19 f., for Radau IIA of three stages and an explicit fourth one of weight g0 at c = 0:
//   y^ - y_new = g0 h f(t, y) + g0 / 3 ((-13 - 7 sqrt 6) z_1 + (-13 + 7 sqrt 6) z_2 - z_3),
//   err = (I - h g0 J)^-1 (y^ - y_new)
// with 1 / g0 the real eigenvalue of A^-1. The filter (I - h g0 J)^-1 is needed, and its Jacobian exists,
// only where the stages were solved by Newton's method.
template <class S> void ImplicitRungeKutta<S>::estimate(S h_s) {
  const S g0 = gamma0_, root6 = real::sqrt(S(6));
  const S e1 = (S(-13) - S(7) * root6) / S(3), e2 = (S(-13) + S(7) * root6) / S(3), e3 = S(-1) / S(3);
  for (int i = 0; i < size_; ++i)
    error_[i] = g0 * (h_s * first_slope_[i] + e1 * z_[3 * i] + e2 * z_[3 * i + 1] + e3 * z_[3 * i + 2]);
  const StageSolver<S>& solver = groups_[0].solver;
  if (!solver.took_newton()) return;
  for (int i = 0; i < size_; ++i)
    for (int c = 0; c < size_; ++c) filter_.at(i, c) = (i == c ? S(1) : S(0)) - h_s * g0 * solver.jacobian(0, i, c);
  filter_.factor();
  filter_.solve(error_.data());
}

template <class S> S ImplicitRungeKutta<S>::error_norm(S rtol, S atol) const {
  if (!options_.estimates) return S(0);
  S squares = S(0);
  for (int i = 0; i < size_; ++i) {
    const S ratio = error_[i] / (atol + rtol * real::max(real::abs(this->y_[i]), real::abs(this->y_new_[i])));
    squares += ratio * ratio;
  }
  return real::sqrt(squares / S(size_));
}

template class ImplicitRungeKutta<float>;
template class ImplicitRungeKutta<double>;
template class ImplicitRungeKutta<long double>;
template class ImplicitRungeKutta<Quad>;

}  // namespace atwood
