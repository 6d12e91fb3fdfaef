#include "integrators/runge_kutta.hpp"

#include <algorithm>

#include "math/scalar.hpp"
#include "math/vector_width.hpp"

namespace atwood {

template <class S>
ExplicitRungeKutta<S>::ExplicitRungeKutta(System<S>& system, const Tableau& tableau, bool compensated)
    : Stepper<S>(system), stages_(tableau.stages), dense_stages_(tableau.dense_stages), end_stage_(tableau.end_stage()),
      size_(system.size), first_same_as_last_(tableau.first_same_as_last), retakes_(tableau.embedded_order > 0),
      dense_(tableau.dense_order > 0), rates_(static_cast<std::size_t>(stages_ + dense_stages_) * system.size),
      stage_(system.size), start_(system.size), last_end_(system.size), change_(compensated ? system.size : 0),
      compensation_(compensated, system.size) {
  const Coefficients read = read_coefficients(tableau);
  for (int i = 0; i < stages_ + dense_stages_; ++i) {
    a_[i] = combine(read.a[i]);
    c_[i] = static_cast<S>(read.c[i]);
    k_[i] = rates_.data() + static_cast<std::size_t>(i) * size_;
    if (i < stages_) weights_.a.push_back(row_of(a_[i]));
  }
  b_ = combine(read.b);
  error_ = combine(read.error);
  companion_ = combine(read.companion_error);
  estimate_order_ = read.estimate_order;
  dense_rows_ = static_cast<int>(read.dense.size());
  for (int n = 0; n < dense_rows_; ++n) dense_row_[n] = combine(read.dense[n]);
  weights_.b = row_of(b_);
  weights_.first_same_as_last = first_same_as_last_;
}

template <class S> auto ExplicitRungeKutta<S>::combine(const TableauRow& row) -> Combination {
  Combination combination;
  for (int j = 0; j < static_cast<int>(row.size()); ++j)
    if (row[j] != Quad(0)) {
      combination.stage[combination.terms] = j;
      combination.weight[combination.terms++] = static_cast<S>(row[j]);
    }
  return combination;
}

template <class S> auto ExplicitRungeKutta<S>::row_of(const Combination& c) -> typename ExplicitWeights<S>::Row {
  return {{c.stage, c.stage + c.terms}, {c.weight, c.weight + c.terms}};
}

template <class S> S ExplicitRungeKutta<S>::sum(const Combination& combination, int i) const {
  if (combination.terms == 0) return S(0);
  S total = combination.weight[0] * k_[combination.stage[0]][i];  // not 0 + ...: zeros get the sign of add_terms()
  for (int j = 1; j < combination.terms; ++j) total += combination.weight[j] * k_[combination.stage[j]][i];
  return total;
}

namespace {

// For shorter states the call of a function compiled for wider vectors is slower than the loop it replaces.
constexpr int kShortestWideState = 40;

constexpr int kMinShared = 20000;  // numbers: below, starting a team costs more than it saves

// The sum first, so that y is rounded once. The number of terms is known to the compiler: the loop over components
// then runs in vector lanes.
template <class S, int terms>
ATWOOD_INLINE void add_sum(const S* y, S h_s, const S* const* rates, const int* stage, const S* weights, Share own,
                           S* out) {
  const S* k[terms];
  S weight[terms];
  for (int j = 0; j < terms; ++j) {
    k[j] = rates[stage[j]];
    weight[j] = weights[j];
  }
  ATWOOD_INDEPENDENT
  for (int i = own.first; i < own.last; ++i) {
    S slope = weight[0] * k[0][i];
    for (int j = 1; j < terms; ++j) slope += weight[j] * k[j][i];
    out[i] = y[i] + h_s * slope;
  }
}

}  // namespace

template <class S>
template <int terms>
void ExplicitRungeKutta<S>::add_terms(const S* y, S h_s, const Combination& c, S* out) const {
  const auto add_share = [&](Share own) {
    const auto kernel = [&]() __attribute__((always_inline)) {
      add_sum<S, terms>(y, h_s, k_, c.stage, c.weight, own, out);
    };
    if constexpr (has_vector_lanes<S>)
      if (size_ >= kShortestWideState) return at_width(width_, kernel);
    kernel();
  };
  if (team_ == nullptr || size_ < kMinShared) return add_share({0, size_});
  const int parts = 4 * team_->size();
  team_->run(parts, [&](int part) { add_share(share(size_, part, parts)); });
}

template <class S> void ExplicitRungeKutta<S>::add(const S* y, S h_s, const Combination& c, S* out) const {
  switch (c.terms) {
    case 1: return add_terms<1>(y, h_s, c, out);
    case 2: return add_terms<2>(y, h_s, c, out);
    case 3: return add_terms<3>(y, h_s, c, out);
    case 4: return add_terms<4>(y, h_s, c, out);
    case 5: return add_terms<5>(y, h_s, c, out);
    case 6: return add_terms<6>(y, h_s, c, out);
    case 7: return add_terms<7>(y, h_s, c, out);
    case 8: return add_terms<8>(y, h_s, c, out);
    case 9: return add_terms<9>(y, h_s, c, out);
    case 10: return add_terms<10>(y, h_s, c, out);
    default:
      for (int i = 0; i < size_; ++i) out[i] = y[i] + h_s * sum(c, i);
  }
}

// The rounding errors of adding h sum b_i k_i and the projection's change are added to the next step's increment.
template <class S> void ExplicitRungeKutta<S>::add_compensated(const S* y, S h_s, S* y_new) {
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = compensation_.add(i, y[i], h_s * sum(b_, i));
  project_compensated(this->system_, compensation_, y_new, change_.data());
  compensation_.end(y_new);
}

// The first rate is reused if a step is repeated from the same state with another h, or (first same as last) if this
// step starts where the last one ended, under the same force law.
template <class S> void ExplicitRungeKutta<S>::first_stage(S t_s, const S* y) {
  const std::int64_t epoch = this->system_.epoch;
  if (retakes_ && start_epoch_ == epoch && start_s_ == t_s && std::equal(y, y + size_, start_.begin())) return;
  const S same_instant_s = S(8) * real::epsilon<S>() * real::max(real::abs(t_s), real::abs(last_end_s_));
  if (first_same_as_last_ && last_epoch_ == epoch && real::abs(last_end_s_ - t_s) <= same_instant_s &&
      std::equal(y, y + size_, last_end_.begin())) {
    std::swap(k_[0], k_[stages_ - 1]);
    if (retakes_) start_.swap(last_end_);
  } else {
    this->system_.rate(t_s, y, k_[0]);
    if (retakes_) std::copy(y, y + size_, start_.begin());
  }
  start_s_ = t_s;
  start_epoch_ = epoch;
}

template <class S> bool ExplicitRungeKutta<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  first_stage(t_s, y);
  const int inner = first_same_as_last_ ? stages_ - 1 : stages_;
  for (int i = 1; i < inner; ++i) {
    add(y, h_s, a_[i], stage_.data());
    this->system_.rate(t_s + c_[i] * h_s, stage_.data(), k_[i]);
  }
  if (compensation_.on()) {
    add_compensated(y, h_s, y_new);
  } else {
    add(y, h_s, b_, y_new);
    this->system_.project(y_new);
  }
  if (first_same_as_last_) {
    this->system_.rate(t_s + h_s, y_new, k_[stages_ - 1]);
    std::copy(y_new, y_new + size_, last_end_.begin());
    last_end_s_ = t_s + h_s;
    last_epoch_ = this->system_.epoch;
  }
  this->set_last_step(t_s, h_s, y, y_new);
  dense_known_ = false;
  return true;
}

template <class S> S ExplicitRungeKutta<S>::scaled(const Combination& combination, int i, S rtol, S atol) const {
  const S scale = atol + rtol * real::max(real::abs(this->y_[i]), real::abs(this->y_new_[i]));
  return this->h_s_ * sum(combination, i) / scale;
}

// With a companion (DOP853): e5^2 / sqrt(e5^2 + e3^2 / 100), e the root mean squares of the two estimates.
template <class S> S ExplicitRungeKutta<S>::error_norm(S rtol, S atol) const {
  if (error_.terms == 0) return S(0);
  S squares = S(0), companion_squares = S(0);
  for (int i = 0; i < size_; ++i) {
    const S ratio = scaled(error_, i, rtol, atol);
    squares += ratio * ratio;
    if (companion_.terms == 0) continue;
    const S companion = scaled(companion_, i, rtol, atol);
    companion_squares += companion * companion;
  }
  if (companion_.terms == 0 || squares == S(0)) return real::sqrt(squares / S(size_));
  return squares / real::sqrt(S(size_) * (squares + S(0.01) * companion_squares));
}

template <class S> void ExplicitRungeKutta<S>::dense_stages() {
  for (int i = stages_; i < stages_ + dense_stages_; ++i) {
    add(this->y_, this->h_s_, a_[i], stage_.data());
    this->system_.rate(this->t_s_ + c_[i] * this->h_s_, stage_.data(), k_[i]);
  }
  dense_known_ = true;
}

// The nested form given at Tableau::dense, evaluated from the last row outwards.
template <class S> void ExplicitRungeKutta<S>::dense(S theta, S* y_at) {
  if (!dense_) return Stepper<S>::dense(theta, y_at);
  if (!dense_known_) dense_stages();
  const S one_minus_theta = S(1) - theta, h = this->h_s_;
  const S *first = k_[0], *last = k_[end_stage_];
  for (int i = 0; i < size_; ++i) {
    const S rise = this->y_new_[i] - this->y_[i];
    const S bend = h * first[i] - rise;
    const S third_difference = rise - h * last[i] - bend;
    S inner = S(0);
    for (int n = dense_rows_ - 1; n >= 0; --n)
      inner = h * sum(dense_row_[n], i) + (n % 2 == 0 ? theta : one_minus_theta) * inner;
    y_at[i] =
        this->y_[i] + theta * (rise + one_minus_theta * (bend + theta * (third_difference + one_minus_theta * inner)));
  }
  this->system_.project(y_at);
}

template class ExplicitRungeKutta<float>;
template class ExplicitRungeKutta<double>;
template class ExplicitRungeKutta<long double>;
template class ExplicitRungeKutta<Quad>;

}  // namespace atwood
