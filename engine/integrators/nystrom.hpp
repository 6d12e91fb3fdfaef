// Runge-Kutta-Nystrom methods: points under forces of time and position.
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/nystrom_tables.hpp"
#include "integrators/stepper.hpp"
#include "rigid/model.hpp"

namespace atwood {

// What both classes share: accelerations in the layout of the state (in the velocity entries of moving bodies). The one
// at the end of a step is kept for the start of the next.
template <class S> class NystromAccelerations {
 public:
  NystromAccelerations(RigidModel<S>& model, int stages);
  S* operator[](int stage) { return k_[stage]; }
  const S* operator[](int stage) const { return k_[stage]; }
  void evaluate(int stage, S t_s, const S* y) { model_.accelerations(t_s, y, k_[stage]); }
  // Stage 0 at (t, y): reused if the step is repeated, or starts where the last one ended under the same law.
  void start(S t_s, const S* y);
  void end(int stage, S t_s, const S* y_new);  // stage holds the acceleration at (t, y_new)

 private:
  RigidModel<S>& model_;
  std::vector<S> values_, start_, end_;
  std::vector<S*> k_;
  int end_stage_ = -1;
  S start_s_{}, end_s_{};
  std::int64_t epoch_ = -1;
  bool start_known_ = false;
};

template <class S> class Nystrom final : public Stepper<S> {
 public:
  Nystrom(RigidModel<S>& model, const NystromTableau& tableau, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  S error_norm(S rtol, S atol) const override;
  int estimate_order() const override { return estimate_order_; }

 private:
  struct Combination {
    int stage[kMaxNystromStages];
    S weight[kMaxNystromStages];
    int terms = 0;
  };
  static Combination combine(const TableauRow& row);
  S sum(const Combination& combination, int velocity_entry) const;

  RigidModel<S>& model_;
  int stages_, estimate_order_;
  bool first_same_as_last_;
  Combination a_[kMaxNystromStages], b_, b_velocity_, error_, error_velocity_;
  S c_[kMaxNystromStages];
  NystromAccelerations<S> k_;
  std::vector<S> stage_;
  Compensation<S> compensation_;
};

template <class S> class SymplecticNystrom final : public Stepper<S> {
 public:
  SymplecticNystrom(RigidModel<S>& model, const SymplecticNystromTable& table, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  RigidModel<S>& model_;
  std::vector<S> kicks_, drifts_;
  NystromAccelerations<S> k_;
  Compensation<S> compensation_;
};

}  // namespace atwood
