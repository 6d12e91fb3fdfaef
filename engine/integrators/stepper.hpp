// One step of any method: from (t, y) over h, with dense output of the step just taken.
//
//   auto stepper = make_stepper<double>("rk4", model, why);  // integrators/catalogue.hpp; allocates here, not in steps
//   stepper->step(t, h, y, y_new);          // y is left as it was, so a step can be taken again
//   stepper->step(t, theta * h, y, y_mid);  // ... with another h: the method's own order inside a step
//   stepper->dense(theta, y_mid);           // cheaper: the interpolant of the last call of step()
//
// A caller that edits a state between steps (a contact's impulse) just passes the edited state: the method notices
// that (t, y) is not where its last step ended and evaluates the rate anew. A change of the force law itself is seen
// through System::epoch, which RigidModel::select_interval raises.
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

  // Steps from (t_s, y) to y_new (system.size scalars each, no overlap); h_s may be of either sign. False: the method's
  // implicit equations have no solution that it could find; y_new is then meaningless. Never allocates.
  virtual bool step(S t_s, S h_s, const S* y, S* y_new) = 0;

  // Root mean square of the last step's error estimate, each component over atol + rtol max(|y|, |y_new|)
  // (Hairer, Norsett, Wanner I, eq. II.4.11). Methods without an estimate answer 0.
  virtual S error_norm(S rtol, S atol) const;
  // k where the estimate is of local order k + 1: the controller's step grows as error_norm^(-1/(k+1)).
  virtual int estimate_order() const { return 4; }

  // Not null: an uncompensated step is no more than these weights say, whatever the time; the runner may then fuse
  // many.
  virtual const ExplicitWeights<S>* weights() const { return nullptr; }

  // ---- methods that choose their own steps (extrapolation, Taylor, Radau 15): the runner then asks advise() after
  // each step instead of error_norm(), with no controller of its own.
  struct Advice {
    bool accepted;
    S next_s;
  };
  virtual bool chooses_steps() const { return false; }
  virtual Advice advise(S rtol, S atol);
  // Called once before the first step of an adaptive run; the first guess of a step is the runner's.
  virtual void set_tolerance(S rtol, S atol);

  // The state at t + theta h of the last step, theta in [0, 1]; y and y_new of that step must still stand unchanged.
  // Here: cubic Hermite on the states and the rates at both ends (local error O(h^4)); the rates are evaluated on
  // first use. Methods with an interpolant of their own override it.
  virtual void dense(S theta, S* y_at);

  // Does dense() keep the method's accuracy? Otherwise samples inside a step are better taken by a shorter step().
  virtual bool dense_is_accurate() const { return false; }

 protected:
  void remember(S t_s, S h_s, const S* y, const S* y_new);  // called by step(): what dense output starts from

  System<S>& system_;
  S t_s_{}, h_s_{};
  const S* y_ = nullptr;
  const S* y_new_ = nullptr;

 private:
  bool ends_known_ = false;
  std::vector<S> rate_start_, rate_end_;
};

}  // namespace atwood
