#pragma once

#include "integrators/implicit_solver.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

// y_new = y + h f(t + h, y_new), solved to round-off; then unit quaternions.
template <class S> class ImplicitEuler final : public Stepper<S> {
 public:
  explicit ImplicitEuler(System<S>& system);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  ImplicitSolver<S> solver_;
  std::vector<S> rate_;
};

}  // namespace atwood
