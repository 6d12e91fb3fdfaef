// Every method of kicks and drifts, from its list of substeps.
#pragma once

#include "integrators/compositions.hpp"
#include "integrators/families.hpp"
#include "integrators/kick_drift.hpp"
#include "integrators/stepper.hpp"

namespace atwood {

template <class S> class KickDrift final : public Stepper<S> {
 public:
  KickDrift(RigidModel<S>& model, const Composition& composition, FreeTop top, bool compensated);
  bool step(S t_s, S h_s, const S* y, S* y_new) override;

 private:
  // elapsed: the drifts before it, in steps
  struct Part {
    bool kick;
    S direct, adjoint, elapsed;
  };

  bool continues(S t_s, const S* y) const;  // the step starts at the end of the last one, under the same force law

  RigidModel<S>& model_;
  FreeTop top_;
  Kicker<S> kicker_;
  Compensation<S> compensation_;
  std::vector<Part> parts_;
  bool shares_kicks_;  // the first kick uses the forces of the last kick of the step before
  std::vector<S> last_end_;
  S last_end_s_{};
  std::int64_t last_epoch_ = -1;
};

// The stepper; a bare system of equations is refused.
template <class S>
StepperResult<S> make_kick_drift(const StepperRequest<S>& request, const std::string& composition,
                                 FreeTop top = FreeTop::splitting);

}  // namespace atwood
