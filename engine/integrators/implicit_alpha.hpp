// Generalised alpha.
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/implicit_stages.hpp"
#include "integrators/stepper.hpp"
#include "rigid/model.hpp"

namespace atwood {

// Generalised alpha (Chung, Hulbert, J. Appl. Mech. 60 (1993) 371) for positions and velocities, and its first-order
// form (Jansen, Whiting, Hulbert, Comput. Methods Appl. Mech. Eng. 190 (2000) 305) for attitudes and body rates. Both
// meet the law at t + af h, at the state y + af (y_new - y), af = 1 / (1 + rho):
//
//   a_n + am (a_new - a_n) = f(t + af h, y + af (y_new - y))
//   v_new = v + h (a_n + g (a_new - a_n)),   x_new = x + h v + h^2 (a_n / 2 + b (a_new - a_n))
//   g = 1/2 + am - af,  b = (1 + am - af)^2 / 4,  am = (2 - rho) / (1 + rho)
//       (Chung, Hulbert, eq. 17, 20, 25; their alphas are 1 - am and 1 - af)
//   y_new = y + h (r_n + g (r_new - r_n)),  am = (3 - rho) / (2 + 2 rho),  r the rates
//       (Jansen et al., eq. 19 and 24)
//
// rho is the spectral radius at infinite stiffness. The rates a_n, r_n are variables of the method, kept from step to
// step.
template <class S> class GeneralisedAlpha final : public Stepper<S> {
 public:
  // `model`: of the system, which says what is a position; null: the first-order form for every entry.
  GeneralisedAlpha(System<S>& system, const RigidModel<S>* model, S rho, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  struct Weights {
    S am, g, b;
  };
  static void rates_at(void* stepper, const S* z, S* k);
  void restore_rates(S t_s, S h_s, const S* y);

  int size_;
  S af_;
  Weights second_, first_;
  std::vector<int> velocity_of_;  // of each entry of the state: the index of its velocity if it is a position, else -1
  std::vector<bool> is_velocity_;
  StageSolver<S> solver_;
  std::vector<S> z_, k_, known_, at_, slope_, rate_, rate_new_, start_, end_;
  Compensation<S> compensation_;
  S start_s_{}, end_s_{};
  std::int64_t epoch_ = -1;
  // of the present step
  const S* y_start_ = nullptr;
  S t_start_s_{}, step_s_{};
};

}  // namespace atwood
