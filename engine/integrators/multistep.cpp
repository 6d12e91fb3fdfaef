#include "integrators/multistep.hpp"

#include <algorithm>

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
      compensation_(compensated, size_), increments_(increment_.size(), std::vector<S>(size_)),
      rates_(rate_.size(), std::vector<S>(size_)) {
  for (std::vector<S>* room : {&z_, &k_, &known_, &at_, &before_projection_, &start_, &end_}) room->resize(size_);
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
  std::rotate(history.begin(), history.end() - 1, history.end());
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

template <class S> bool Multistep<S>::multistep(S t_s, S h_s, const S* y, S* y_new) {
  const auto combine = [&](const std::vector<S>& of_increments, const std::vector<S>& of_rates, S* out) {
    for (int i = 0; i < size_; ++i) {
      S rises = S(0), slopes = S(0);
      for (std::size_t j = 0; j < of_increments.size(); ++j) rises += of_increments[j] * increments_[j][i];
      for (std::size_t j = 0; j < of_rates.size(); ++j) slopes += of_rates[j] * rates_[j][i];
      out[i] = rises + h_s * slopes;
    }
  };
  combine(increment_, rate_, known_.data());
  k_is_end_rate_ = implicit_ != S(0);
  if (k_is_end_rate_) {
    combine(guess_increment_, guess_rate_, z_.data());
    y_start_ = y;
    end_s_ = t_s + h_s;
    solver_.solve(&rates_at, this, h_s, y, known_.data(), z_.data(), k_.data());
    if (!this->system_.solvers.note(IterativeSolver::implicit_stages, solver_.report())) return false;
  } else {
    std::copy(known_.begin(), known_.end(), z_.begin());
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
  std::copy(y, y + size_, start_.begin());
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
