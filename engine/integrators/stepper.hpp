// One step of any method: from (t, y) over h, with dense output of the step just taken.
//
//   auto made = make_stepper("rk4", model);  // integrators/catalogue.hpp; allocates here, not in steps
//   if (!made) return made.fault();          // names the method and what it needs
//   auto stepper = std::move(*made);
//   stepper->step(t, h, y, y_new);          // y is not changed, so a step can be repeated
//   stepper->step(t, theta * h, y, y_mid);  // ... with another h: the method's own order inside a step
//   stepper->dense(theta, y_mid);           // cheaper: the interpolant of the last call of step()
//
// A caller may change the state between steps (a contact's impulse): the stepper compares (t, y) with the end of its
// last step and evaluates the rate again if they differ. A change of the force law is detected by System::epoch, which
// RigidModel::select_interval increments.
#pragma once

#include <vector>

#include "integrators/explicit_weights.hpp"
#include "math/system.hpp"

namespace atwood {

template <class S> class Stepper {
 public:
  explicit Stepper(System<S>& system);
  virtual ~Stepper() = default;
  Stepper(const Stepper&) = delete;
  Stepper& operator=(const Stepper&) = delete;

  // Steps from (t_s, y) to y_new (system.size scalars each, no overlap); h_s may be of either sign. False: the solver
  // of the implicit equations did not converge; y_new is then undefined. Does not allocate.
  virtual bool step(S t_s, S h_s, const S* y, S* y_new) = 0;

  // Root mean square of the last step's error estimate, each component over atol + rtol max(|y|, |y_new|)
  // (Hairer, Norsett, Wanner I, eq. II.4.11). Methods without an estimate return 0.
  virtual S error_norm(S rtol, S atol) const;
  // k where the estimate is of local order k + 1: the controller scales the step by error_norm^(-1/(k+1)).
  virtual int estimate_order() const { return 4; }

  // Not null: a step consists only of the sums with these weights, without compensation and without dependence on time;
  // the caller may then compute many steps in one loop (integrators/free_flight.hpp).
  virtual const ExplicitWeights<S>* weights() const { return nullptr; }

  // ---- methods that choose their own steps (Taylor, Radau 15): the caller then uses advise() after each step in place
  // of error_norm() and its own controller.
  struct Advice {
    bool accepted;
    S next_s;
  };
  virtual bool chooses_steps() const { return false; }
  // Whether a tolerance below the scalar's round-off has a meaning: the error estimate does not stop at round-off.
  virtual bool takes_any_tolerance() const { return chooses_steps(); }
  virtual Advice advise(S rtol, S atol);
  // Called once before the first step of an adaptive run; the caller proposes the first step.
  virtual void set_tolerance(S rtol, S atol);

  // The state at t + theta h of the last step, theta in [0, 1]; y and y_new of that step must be unchanged.
  // Here: cubic Hermite on the states and the rates at both ends (local error O(h^4)); the rates are evaluated on
  // first use. Methods with an interpolant of their own override it.
  virtual void dense(S theta, S* y_at);

  // Whether dense() is as accurate as the method. If not, samples inside a step are computed by a shorter step().
  virtual bool dense_is_accurate() const { return false; }

 protected:
  void set_last_step(S t_s, S h_s, const S* y, const S* y_new);  // called by step(): the data of dense output

  System<S>& system_;
  S t_s_{}, h_s_{};
  const S* y_ = nullptr;
  const S* y_new_ = nullptr;

 private:
  bool ends_known_ = false;
  std::vector<S> rate_start_, rate_end_;
};

}  // namespace atwood
