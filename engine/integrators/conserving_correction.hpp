// Runge-Kutta's classical step with a correction that keeps the energy.
#pragma once

#include "integrators/compensation.hpp"
#include "integrators/stepper.hpp"
#include "rigid/model.hpp"

namespace atwood {

// h sum_i b_i k_i of the classical Runge-Kutta method: the increment before the correction.
template <class S> class ClassicalIncrement {
 public:
  explicit ClassicalIncrement(System<S>& system);
  void evaluate(S t_s, S h_s, const S* y, S* d);
  const S* first_slope() const { return first_.data(); }

 private:
  System<S>& system_;
  std::vector<S> first_, k_, stage_;
};

// Whether a step continues the run whose invariants are stored: false after the caller changed the state, or the force
// law changed.
template <class S> class RunInvariants {
 public:
  explicit RunInvariants(RigidModel<S>& model) : model_(model), start_(model.state_size()), end_(model.state_size()) {}
  bool continues(const S* y);  // false: take the invariants from y
  void end(const S* y_new);

 private:
  RigidModel<S>& model_;
  std::vector<S> start_, end_;
  std::int64_t epoch_ = -1;
};

// Classical RK4, then the nearest state with the run's invariants (Hairer, Lubich, Wanner, Geometric Numerical
// Integration, 2nd ed., algorithm IV.4.2), near in m |dv|^2 + m |dp|^2 / tau^2 with tau = |v| / |a| of the step's
// start. Invariants: of points and centres of mass the energy, and where every force is central the angular momentum;
// of each torque-free body its rotational energy and its angular momentum. An invariant whose gradient depends on those
// before it to within 1 % (angular momentum on a circular orbit) is not imposed. Linear momentum needs no projection:
// RK4 conserves it.
template <class S> class ProjectedRungeKutta final : public Stepper<S> {
 public:
  ProjectedRungeKutta(RigidModel<S>& model, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  struct Spin {
    S twice_energy;
    Vec3<S> momentum_W;
  };
  static constexpr int kMaxInvariants = 4;  // energy, three components of angular momentum
  void take_invariants(const S* y);
  void find_metric(const S* y);
  void find_directions(const S* y, int constraints);
  void residuals(const S* y, S* g, S* scale) const;
  SolveReport satisfy(S* y, int constraints);
  bool project_orbits(S* y);
  void project_spin(const Spin& wanted, int body, S* at);
  void report_spin(const Spin& wanted, const Vec3<S>& momentum, const Vec3<S>& w, int rounds);
  void add(S* y, int i, S change) { y[i] = compensation_.add(i, y[i], change); }

  RigidModel<S>& model_;
  int size_;
  ClassicalIncrement<S> classical_;
  RunInvariants<S> run_invariants_;
  Compensation<S> compensation_;
  S energy_{};
  Vec3<S> momentum_;
  std::vector<Spin> spin_;
  std::vector<Vec3<S>> force_W_;
  std::vector<S> d_, trial_, inverse_metric_, direction_[kMaxInvariants];  // directions: orthonormal in the metric
  S triangle_[kMaxInvariants][kMaxInvariants]{};                           // gradient_c = sum_b triangle_cb direction_b
  bool kept_[kMaxInvariants]{};
};

// Relaxation (Ketcheson, SIAM J. Numer. Anal. 57 (2019) 2850; Ranocha, Sayyari, Dalcin, Parsani, Ketcheson, SIAM J.
// Sci. Comput. 42 (2020) A612): y + gamma d, which has the run's energy, is an approximation of order 4 at t + gamma h,
// gamma = 1 + O(h^3). The rest of the step, (1 - gamma) h = O(h^4), is another relaxed step, which ends O(h^16) from
// t + h. Reported states therefore belong to the requested times; a step takes four to eight evaluations.
template <class S> class RelaxationRungeKutta final : public Stepper<S> {
 public:
  RelaxationRungeKutta(RigidModel<S>& model, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  bool find_gamma(const S* y, S& gamma);
  S energy_error(const S* y, S gamma);

  RigidModel<S>& model_;
  int size_;
  ClassicalIncrement<S> classical_;
  RunInvariants<S> run_invariants_;
  Compensation<S> compensation_;
  S energy_{}, energy_round_off_{};
  std::vector<S> d_, trial_;
};

}  // namespace atwood
