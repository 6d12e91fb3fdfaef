// Symmetric projection of a symmetric method onto the constraints of a mechanism.
//
//   y~ = y + A(y) mu,   y~_new = Phi(t, h, y~),   y_new = y~_new + A(y_new) mu,   y_new on the constraints
//
// (Hairer, BIT 40 (2000) 726; Hairer, Lubich, Wanner, Geometric Numerical Integration, 2nd ed., V.4.1): the same mu
// before and after the step, so that the projected method is symmetric where Phi is. A = M^-1 G^T, of coordinates and
// of rates each; mu by simplified Newton iterations, 2 A^T A in place of the derivative, which contract by O(h) each. A
// step therefore takes several of Phi.
#pragma once

#include <memory>

#include "integrators/stepper.hpp"
#include "joints/constraints.hpp"
#include "rigid/model.hpp"

namespace atwood {

template <class S> class SymmetricProjection final : public Stepper<S> {
 public:
  // `inner` is symmetric and does not project; `model` has constraints.
  SymmetricProjection(RigidModel<S>& model, std::unique_ptr<Stepper<S>> inner);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  bool find_multipliers(S t_s, S h_s, const S* y, S* y_new);

  RigidModel<S>& model_;
  std::unique_ptr<Stepper<S>> inner_;
  typename Constraints<S>::Multipliers mu_;
  std::vector<S> start_, near_;
};

}  // namespace atwood
