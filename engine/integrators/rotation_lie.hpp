// Runge-Kutta methods on SO(3): the attitude advances by exponentials of rotation vectors, all other variables as in
// RK4.
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/stepper.hpp"
#include "rigid/model.hpp"

namespace atwood {

enum class LieMethod {
  // RK4 for the rotation vector s of q = q_0 exp(s), s' = J_r(s)^-1 w (Munthe-Kaas, Appl. Numer. Math. 29 (1999) 115).
  munthe_kaas,
  // Four stages, two exponentials in the last, no commutators (Celledoni, Marthinsen, Owren, Future Gener. Comput.
  // Syst. 19 (2003) 341, eq. 6).
  commutator_free,
};

template <class S> class LieRungeKutta final : public Stepper<S> {
 public:
  LieRungeKutta(RigidModel<S>& model, LieMethod method, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  // The attitude's motion over a step: two rotation vectors in body axes, one after the other. The second may be zero.
  struct Rotations {
    Vec3<S> first, second;
  };

  Rotations stage_rotations(int stage, S h_s, int at) const;
  Rotations final_rotations(S h_s, int at) const;
  void rotate_stage(int stage, S h_s, const S* y);
  void rotation_rates(int stage, S h_s);
  Vec3<S> spin(int stage, int at) const;  // the rotation vector's rate at a stage

  RigidModel<S>& model_;
  LieMethod method_;
  Compensation<S> compensation_;
  std::vector<S> k_[4], stage_;
};

}  // namespace atwood
