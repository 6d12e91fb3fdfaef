// Methods that move positions and velocities in turns.
#pragma once

#include "integrators/kick_drift.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

// v += h a(t, x, v); x += h v with the new v. One function a file, so that each scheme reads on its own.
template <class S> class SymplecticEuler final : public Stepper<S> {
 public:
  explicit SymplecticEuler(RigidModel<S>& model) : Stepper<S>(model.system()), model_(model), kicker_(model) {}
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  RigidModel<S>& model_;
  Kicker<S> kicker_;
};

// Kick h/2, drift h, kick h/2.
template <class S> class VelocityVerlet final : public Stepper<S> {
 public:
  explicit VelocityVerlet(RigidModel<S>& model) : Stepper<S>(model.system()), model_(model), kicker_(model) {}
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  RigidModel<S>& model_;
  Kicker<S> kicker_;
};

// Drift h/2, kick h, drift h/2.
template <class S> class Leapfrog final : public Stepper<S> {
 public:
  explicit Leapfrog(RigidModel<S>& model) : Stepper<S>(model.system()), model_(model), kicker_(model) {}
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  RigidModel<S>& model_;
  Kicker<S> kicker_;
};

}  // namespace atwood
