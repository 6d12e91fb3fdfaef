#include "integrators/symmetric_projection.hpp"

#include <algorithm>

namespace atwood {
namespace {

constexpr int kMaxIterations = 60;

}  // namespace

template <class S>
SymmetricProjection<S>::SymmetricProjection(RigidModel<S>& model, std::unique_ptr<Stepper<S>> inner)
    : Stepper<S>(model.system()), model_(model), inner_(std::move(inner)), mu_(model.constraints()->no_multipliers()),
      start_(model.state_size()), near_(model.state_size()) {}

// Rows may be chosen anew by the ordinary projection, which also gives the place of the first A(y_new).
template <class S> bool SymmetricProjection<S>::step(S t_s, S h_s, const S* y, S* y_new) {
  Constraints<S>& constraints = *model_.constraints();
  if (!inner_->step(t_s, h_s, y, y_new)) return false;
  std::copy(y_new, y_new + start_.size(), near_.begin());
  if (!constraints.project(near_.data())) return true;  // the run ends by the constraints' fault
  std::fill(mu_.position.begin(), mu_.position.end(), S(0));
  std::fill(mu_.rate.begin(), mu_.rate.end(), S(0));
  constraints.add_half_correction(y_new, mu_, S(1));
  if (!find_multipliers(t_s, h_s, y, y_new)) return false;
  this->set_last_step(t_s, h_s, y, y_new);
  return true;
}

template <class S> bool SymmetricProjection<S>::find_multipliers(S t_s, S h_s, const S* y, S* y_new) {
  Constraints<S>& constraints = *model_.constraints();
  SolveReport report;
  S best = S(0);
  for (int n = 1;; ++n) {
    std::copy(y, y + start_.size(), start_.begin());
    constraints.displace(y, mu_, start_.data());
    const S speed = constraints.speed_scale();  // a run may begin or end at rest
    if (!inner_->step(t_s, h_s, start_.data(), y_new)) return false;
    constraints.displace(near_.data(), mu_, y_new);
    std::copy(y_new, y_new + start_.size(), near_.begin());
    const S misfit = constraints.add_half_correction(y_new, mu_, speed);
    report.iterations = n;
    report.residual = static_cast<double>(misfit * S(16) * real::epsilon<S>());
    if (misfit <= S(1)) report.ended = SolveEnd::converged;
    else if (n > 1 && misfit > best / S(2) && misfit <= S(256)) report.ended = SolveEnd::stagnated;
    else if (n == kMaxIterations || !(misfit < S(1e30f))) report.ended = SolveEnd::capped;
    else {
      best = n == 1 ? misfit : real::min(best, misfit);
      continue;
    }
    return this->system_.solvers.add_unless_capped(IterativeSolver::invariant_projection, report);
  }
}

template class SymmetricProjection<float>;
template class SymmetricProjection<double>;
template class SymmetricProjection<long double>;
template class SymmetricProjection<Quad>;

}  // namespace atwood
