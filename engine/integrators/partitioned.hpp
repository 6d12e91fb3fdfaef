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

  bool continues(S t_s, const S* y) const;  // from the end of the last step, under the same law

  RigidModel<S>& model_;
  FreeTop top_;
  Kicker<S> kicker_;
  Compensation<S> compensation_;
  std::vector<Part> parts_;
  bool shares_kicks_;  // the last kick's forces are the first one's of the next step
  std::vector<S> last_end_;
  S last_end_s_{};
  std::int64_t last_epoch_ = -1;
};

// The stepper; a bare system of equations is refused.
template <class S>
StepperResult<S> make_kick_drift(const StepperRequest<S>& request, const std::string& composition,
                                 FreeTop top = FreeTop::splitting);

}  // namespace atwood
