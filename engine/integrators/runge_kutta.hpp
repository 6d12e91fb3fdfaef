// Every explicit Runge-Kutta method, from its tableau.
#pragma once

#include "integrators/stepper.hpp"
#include "integrators/tableaux.hpp"

namespace atwood {

template <class S> class ExplicitRungeKutta final : public Stepper<S> {
 public:
  ExplicitRungeKutta(System<S>& system, const Tableau& tableau);

  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  S error_norm(S rtol, S atol) const override;
  void dense(S theta, S* y_at) override;
  bool dense_is_accurate() const override { return dense_; }

 private:
  struct Combination { int stage[max_stages]; S weight[max_stages]; int terms = 0; };  // zeros of the tableau left out

  static Combination combine(const TableauRow& row);
  S sum(const Combination& combination, int i) const;                                  // of weight * k, component i
  void add(const S* y, S h_s, const Combination& combination, S* out) const;           // out = y + h sum
  template <int terms> void add_terms(const S* y, S h_s, const Combination& combination, S* out) const;
  void first_stage(S t_s, const S* y);

  int stages_, size_;
  bool first_same_as_last_, dense_;
  Combination a_[max_stages], b_, error_, dense_weight_;
  S c_[max_stages];
  std::vector<S> rates_, stage_, last_end_;
  S* k_[max_stages];
  S last_end_s_{};
  std::int64_t last_epoch_ = -1;
};

}  // namespace atwood
