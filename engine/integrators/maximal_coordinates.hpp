// Mechanisms in maximal coordinates: every body free, every joint a constraint. Contrast methods.
//
// RATTLE over h (Andersen, J. Comput. Phys. 52 (1983) 24; Jay, SIAM J. Numer. Anal. 33 (1996) 368; Hairer, Lubich,
// Wanner, Geometric Numerical Integration, 2nd ed., VII.1.4), with forces that depend on positions alone:
//   v += h/2 M^-1 f(q_n) + M^-1 G(q_n)^T lambda          so that g(q_(n+1)) = 0
//   q_n -> q_(n+1), the free motion over h                (a rotating body's is exact, rigid/free_top.hpp)
//   v += h/2 M^-1 f(q_(n+1)) + M^-1 G(q_(n+1))^T mu       so that G(q_(n+1)) v = 0
// It is symmetric and symplectic on the constraints, of order 2; symmetric compositions of it are of order 4 and 6.
// lambda is found by Newton's method with the matrix G(q_n) M^-1 G(q_n)^T h.
//
// Stabilisation after Baumgarte as game engines use it (Baumgarte, Comput. Methods Appl. Mech. Eng. 1 (1972) 1;
// Catto, Iterative Dynamics with Temporal Coherence, GDC 2005), semi-implicit, of order 1:
//   v* = v + h M^-1 f,   v_(n+1) = v* + M^-1 G^T lambda with G v_(n+1) = -(erp / h) g(q_n),   q_(n+1) = q_n + h v_(n+1)
#pragma once

#include <string>
#include <vector>

#include "integrators/stepper.hpp"
#include "joints/constraints.hpp"
#include "protocol/fault.hpp"
#include "rigid/model.hpp"

namespace atwood {

// The same scene with all its bodies free: joints that placed bodies close loops. The engine's fault, with the name of
// the scheme: limits, prescribed motion, pulleys with inertia and forces along joints have no such form.
Result<Scene> in_maximal_coordinates(const Scene& scene, const std::string& scheme);

// The constraints of a model in maximal coordinates at one state.
template <class S> class MaximalConstraints {
 public:
  explicit MaximalConstraints(RigidModel<S>& model) : model_(model) {}

  // Takes the rows and their factors at y, which later calls refer to.
  void factor_at(const S* y);
  // Changes the velocities in `v` (a state) by M^-1 G^T x with x of least effect so that their rates change by `b`, one
  // a row.
  void change_rates(const std::vector<S>& b, S* v);
  // G v of the velocities in a state, by the rows of factor_at().
  void rates(const S* v, std::vector<S>& out) const;
  // The values of the constraints at y; returns the largest, in roundings of the lengths in it. The rows of factor_at()
  // stay.
  S values_at(const S* y, std::vector<S>& out);
  int count() const { return static_cast<int>(ties_.size()); }

 private:
  struct Tie {
    int body[2];
    Vec3<S> force[2], torque_B[2];  // of the row on its bodies; the torque in their axes
    S scale;
  };
  RigidModel<S>& model_;
  std::vector<Tie> ties_;
  std::vector<BodyRow<S>> rows_;
  std::vector<int> local_;
  LeastNorm<S> qr_;
  std::vector<S> z_, x_, b_;
};

template <class S> class Rattle final : public Stepper<S> {
 public:
  // `fractions` of a step, taken one after another.
  Rattle(RigidModel<S>& model, std::vector<S> fractions);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  bool rattle(S t_s, S h_s, S* y);
  void kick(S t_s, S h_s, S* y);

  RigidModel<S>& model_;
  std::vector<S> fractions_, acceleration_, kicked_, b_, values_;
  MaximalConstraints<S> constraints_;
};

template <class S> class BaumgarteEuler final : public Stepper<S> {
 public:
  BaumgarteEuler(RigidModel<S>& model, S erp);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  RigidModel<S>& model_;
  S erp_;
  std::vector<S> acceleration_, b_, values_;
  MaximalConstraints<S> constraints_;
};

}  // namespace atwood
