#include "integrators/multistep.hpp"

#include <algorithm>

#include "math/lanes.hpp"

namespace atwood {

template <class S>
Multistep<S>::Multistep(System<S>& system, const MultistepTable& table, std::unique_ptr<Stepper<S>> starter,
                        bool compensated)
    : Stepper<S>(system), size_(system.size), increment_(table.increment.begin(), table.increment.end()),
      rate_(table.rate.begin(), table.rate.end()),
      guess_increment_(table.guess_increment.begin(), table.guess_increment.end()),
      guess_rate_(table.guess_rate.begin(), table.guess_rate.end()), implicit_(S(table.implicit)),
      starter_(std::move(starter)),
      solver_(table.implicit == Quad(0) ? 0 : size_, {table.implicit == Quad(0) ? Quad(1) : table.implicit}),
      compensation_(compensated, size_) {
  const std::vector<S> blocks((size_ + kLaneCount - 1) / kLaneCount * kLaneCount);
  increments_.assign(increment_.size(), blocks);
  rates_.assign(rate_.size(), blocks);
  for (std::vector<S>* room : {&z_, &known_}) *room = blocks;
  for (std::vector<S>* room : {&k_, &at_, &before_projection_, &start_, &end_}) room->resize(size_);
}

template <class S> auto Multistep<S>::classify_start(S t_s, S h_s, const S* y) const -> StepStart {
  if (epoch_ != this->system_.epoch) return StepStart::elsewhere;
  const S nearly_s = S(8) * real::epsilon<S>() * (real::abs(t_s) + real::abs(h_s));
  if (real::abs(t_s - start_s_) <= nearly_s && std::equal(y, y + size_, start_.begin())) return StepStart::start;
  if (real::abs(h_s - h_s_) > nearly_s || real::abs(t_s - (start_s_ + h_s_)) > nearly_s) return StepStart::elsewhere;
  return std::equal(y, y + size_, end_.begin()) ? StepStart::end : StepStart::elsewhere;
}

template <class Row> void push(std::vector<Row>& history, const Row& newest, int& known) {
  if (history.empty()) return;
  for (std::size_t j = history.size(); --j > 0;) history[j].swap(history[j - 1]);
  std::copy(newest.begin(), newest.end(), history.front().begin());
  known = std::min(known + 1, static_cast<int>(history.size()));
}

// Appends the step that ended at (t_s, y) to the history.
template <class S> void Multistep<S>::shift(S t_s, const S* y) {
  push(increments_, z_, known_increments_);
  if (!rates_.empty() && !k_is_end_rate_) this->system_.rate(t_s, y, k_.data());
  push(rates_, k_, known_rates_);
}

template <class S> void Multistep<S>::restart(S t_s, const S* y) {
  known_increments_ = known_rates_ = 0;
  if (rates_.empty()) return;
  this->system_.rate(t_s, y, k_.data());
  push(rates_, k_, known_rates_);
}

template <class S> bool Multistep<S>::start_by_one_step(S t_s, S h_s, const S* y, S* y_new) {
  if (!starter_->step(t_s, h_s, y, y_new)) return false;
  for (int i = 0; i < size_; ++i) z_[i] = y_new[i] - y[i];
  k_is_end_rate_ = false;
  return true;
}

template <class S> void Multistep<S>::rates_at(void* stepper, const S* z, S* k) {
  auto& self = *static_cast<Multistep*>(stepper);
  for (int i = 0; i < self.size_; ++i) self.at_[i] = self.y_start_[i] + z[i];
  self.system_.rate(self.end_s_, self.at_.data(), k);
}

// out = sum_j weights_j rows_j of eight components, each in the order of j.
template <class S>
void sum_block(const std::vector<S>& weights, const std::vector<std::vector<S>>& rows, int from, S (&out)[kLaneCount]) {
  for (S& sum : out) sum = S(0);
  for (std::size_t j = 0; j < weights.size(); ++j) {
    const S weight = weights[j];
    const S* row = rows[j].data() + from;
    for (int k = 0; k < kLaneCount; ++k) out[k] += weight * row[k];
  }
}

template <class S>
void Multistep<S>::combine(const std::vector<S>& of_increments, const std::vector<S>& of_rates, S h_s,
                           std::vector<S>& out) const {
  S rises[kLaneCount], slopes[kLaneCount];
  for (int from = 0; from < size_; from += kLaneCount) {
    sum_block(of_increments, increments_, from, rises);
    sum_block(of_rates, rates_, from, slopes);
    for (int k = 0; k < kLaneCount; ++k) out[from + k] = rises[k] + h_s * slopes[k];
  }
}

template <class S> bool Multistep<S>::multistep(S t_s, S h_s, const S* y, S* y_new) {
  k_is_end_rate_ = implicit_ != S(0);
  if (k_is_end_rate_) {
    combine(increment_, rate_, h_s, known_);
    combine(guess_increment_, guess_rate_, h_s, z_);
    y_start_ = y;
    end_s_ = t_s + h_s;
    solver_.solve(&rates_at, this, h_s, y, known_.data(), z_.data(), k_.data());
    if (!this->system_.solvers.add_unless_capped(IterativeSolver::implicit_stages, solver_.report())) return false;
  } else {
    combine(increment_, rate_, h_s, z_);
  }
  compensation_.begin(y);
  for (int i = 0; i < size_; ++i) y_new[i] = before_projection_[i] = compensation_.add(i, y[i], z_[i]);
  if (compensation_.on()) project_compensated(this->system_, compensation_, y_new, at_.data());
  else this->system_.project(y_new);
  compensation_.end(y_new);
  for (int i = 0; i < size_; ++i) z_[i] += y_new[i] - before_projection_[i];
  return true;
}

template <class S> bool Multistep<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  const StepStart place = classify_start(t_s, h_s, y);
  if (place == StepStart::start && h_s != h_s_) {
    this->set_last_step(t_s, h_s, y, y_new);
    return starter_->step(t_s, h_s, y, y_new);
  }
  if (place == StepStart::end) shift(t_s, y);
  if (place == StepStart::elsewhere) restart(t_s, y);
  epoch_ = -1;
  const bool enough =
      known_increments_ == static_cast<int>(increments_.size()) && known_rates_ == static_cast<int>(rates_.size());
  if (!(enough ? multistep(t_s, h_s, y, y_new) : start_by_one_step(t_s, h_s, y, y_new))) return false;
  if (place == StepStart::end) start_.swap(end_);  // the last step ended at y
  else std::copy(y, y + size_, start_.begin());
  std::copy(y_new, y_new + size_, end_.begin());
  start_s_ = t_s;
  h_s_ = h_s;
  epoch_ = this->system_.epoch;
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template class Multistep<float>;
template class Multistep<double>;
template class Multistep<long double>;
template class Multistep<Quad>;

}  // namespace atwood
