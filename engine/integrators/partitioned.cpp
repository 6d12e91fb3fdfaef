#include "integrators/partitioned.hpp"

#include <algorithm>

namespace atwood {

template <class S>
KickDrift<S>::KickDrift(RigidModel<S>& model, const Composition& composition, FreeTop top, bool compensated)
    : Stepper<S>(model.system()), model_(model), top_(top), kicker_(model),
      compensation_(compensated, model.state_size()), last_end_(model.state_size()) {
  Quad elapsed = 0;
  for (const Substep& substep : composition.substeps()) {
    parts_.push_back({substep.kick, S(substep.direct), S(substep.adjoint), S(elapsed)});
    if (!substep.kick) elapsed += substep.direct + substep.adjoint;
  }
  shares_kicks_ = parts_.front().kick && parts_.back().kick && !model.velocity_dependent();
}

template <class S> bool KickDrift<S>::continues(S t_s, const S* y) const {
  const S same_instant_s = S(8) * real::epsilon<S>() * real::max(real::abs(t_s), real::abs(last_end_s_));
  return last_epoch_ == this->system_.epoch && real::abs(last_end_s_ - t_s) <= same_instant_s &&
         std::equal(last_end_.begin(), last_end_.end(), y);
}

template <class S> bool KickDrift<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  std::copy(y, y + this->system_.size, y_new);
  compensation_.begin(y);
  bool known = shares_kicks_ && continues(t_s, y), solved = true;
  for (const Part& part : parts_) {
    const S direct_s = part.direct * h_s, adjoint_s = part.adjoint * h_s;
    if (!part.kick) solved = drift(model_, top_, direct_s, adjoint_s, y_new, compensation_) && solved;
    else if (known) kicker_.kick_again(direct_s + adjoint_s, y_new, compensation_);
    else solved = kicker_.kick(t_s + part.elapsed * h_s, direct_s, adjoint_s, y_new, compensation_) && solved;
    known = false;
  }
  renormalise(model_, y_new, compensation_);
  compensation_.end(y_new);
  if (shares_kicks_) {
    std::copy(y_new, y_new + this->system_.size, last_end_.begin());
    last_end_s_ = t_s + h_s;
    last_epoch_ = this->system_.epoch;
  }
  this->set_last_step(t_s, h_s, y, y_new);
  return solved;
}

template <class S>
StepperResult<S> make_kick_drift(const StepperRequest<S>& request, const std::string& composition, FreeTop top) {
  if (without_bodies(request)) return cannot_step_bare(request.scheme, "needs positions and velocities");
  if (has_mechanisms(request))
    return cannot_step_mechanisms(request.scheme,
                                  "its kicks need a mass matrix that does not depend on the coordinates");
  return StepperPointer<S>(
      std::make_unique<KickDrift<S>>(*request.model, *find_composition(composition), top, request.flag("compensated")));
}

#define ATWOOD_INSTANTIATE(S)  \
  template class KickDrift<S>; \
  template StepperResult<S> make_kick_drift<S>(const StepperRequest<S>&, const std::string&, FreeTop);
ATWOOD_INSTANTIATE(float)
ATWOOD_INSTANTIATE(double)
ATWOOD_INSTANTIATE(long double)
ATWOOD_INSTANTIATE(Quad)
#undef ATWOOD_INSTANTIATE

}  // namespace atwood
