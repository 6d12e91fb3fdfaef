// Linear multistep methods: Adams-Bashforth, Adams-Moulton and BDF.
#pragma once

#include <memory>

#include "integrators/compensation.hpp"
#include "integrators/implicit_stages.hpp"
#include "integrators/multistep_tables.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

// Adams and BDF methods with equal steps. While the history is too short, steps are taken by `starter`, a one-step
// method of higher order. The history is cleared when the caller changes the state or h, or the force law changes
// (System::epoch). A step repeated from the same state over another h is taken by the starter and does not change the
// history.
template <class S> class Multistep final : public Stepper<S> {
 public:
  Multistep(System<S>& system, const MultistepTable& table, std::unique_ptr<Stepper<S>> starter, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  enum class StepStart { end, start, elsewhere };  // where a step starts, relative to the last full step
  StepStart classify_start(S t_s, S h_s, const S* y) const;
  void shift(S t_s, const S* y);
  void restart(S t_s, const S* y);
  bool start_by_one_step(S t_s, S h_s, const S* y, S* y_new);
  // out = sum_j of_increments_j increments_[j] + h sum_j of_rates_j rates_[j]
  void combine(const std::vector<S>& of_increments, const std::vector<S>& of_rates, S h_s, std::vector<S>& out) const;
  bool multistep(S t_s, S h_s, const S* y, S* y_new);
  static void rates_at(void* stepper, const S* z, S* k);

  int size_;
  std::vector<S> increment_, rate_, guess_increment_, guess_rate_;
  S implicit_;
  std::unique_ptr<Stepper<S>> starter_;
  StageSolver<S> solver_;
  Compensation<S> compensation_;
  // history, newest first, in blocks of eight components; rates_[0] is the rate at the start of the step
  std::vector<std::vector<S>> increments_, rates_;
  int known_increments_ = 0, known_rates_ = 0;
  std::vector<S> z_, k_, known_, at_, before_projection_;
  bool k_is_end_rate_ = false;
  // the last full step
  std::vector<S> start_, end_;
  S start_s_{}, h_s_{};
  std::int64_t epoch_ = -1;
  // of the present equations
  const S* y_start_ = nullptr;
  S end_s_{};
};

}  // namespace atwood
