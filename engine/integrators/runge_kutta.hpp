// The stepper of all explicit Runge-Kutta methods, from their tableaux.
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/stepper.hpp"
#include "integrators/tableaux.hpp"
#include "math/vector_width.hpp"
#include "parallel/team.hpp"

namespace atwood {

template <class S> class ExplicitRungeKutta final : public Stepper<S> {
 public:
  ExplicitRungeKutta(System<S>& system, const Tableau& tableau, bool compensated = false);

  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  void share_sums(Team* team) { team_ = team; }  // over the stages of long states; the same bits. Null: one thread
  S error_norm(S rtol, S atol) const override;
  int estimate_order() const override { return estimate_order_; }
  void dense(S theta, S* y_at) override;
  bool dense_is_accurate() const override { return dense_; }
  const ExplicitWeights<S>* weights() const override { return compensation_.on() ? nullptr : &weights_; }

 private:
  // A row with the zeros of the tableau left out.
  struct Combination {
    int stage[kMaxStages];
    S weight[kMaxStages];
    int terms = 0;
  };

  static Combination combine(const TableauRow& row);
  static typename ExplicitWeights<S>::Row row_of(const Combination& combination);
  S sum(const Combination& combination, int i) const;                         // of weight * k, component i
  void add(const S* y, S h_s, const Combination& combination, S* out) const;  // out = y + h sum
  template <int terms> void add_terms(const S* y, S h_s, const Combination& combination, S* out) const;
  void add_compensated(const S* y, S h_s, S* y_new);
  void first_stage(S t_s, const S* y);
  void dense_stages();
  S scaled(const Combination& combination, int i, S rtol, S atol) const;

  int stages_, dense_stages_, end_stage_, size_, estimate_order_, dense_rows_;
  bool first_same_as_last_, retakes_, dense_, dense_known_ = false;
  ExplicitWeights<S> weights_;
  Combination a_[kMaxStages], b_, error_, companion_, dense_row_[kMaxDenseRows];
  S c_[kMaxStages];
  std::vector<S> rates_, stage_, start_, last_end_, change_;
  S* k_[kMaxStages];
  S start_s_{}, last_end_s_{};
  std::int64_t start_epoch_ = -1, last_epoch_ = -1;
  Compensation<S> compensation_;
  VectorWidth width_ = widest_vectors();
  Team* team_ = nullptr;
};

}  // namespace atwood
