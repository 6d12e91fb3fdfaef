#include "truth/truth.hpp"

#ifdef ATWOOD_HAS_closed_form
#include "closed_form/closed_form.hpp"
#endif
#ifdef ATWOOD_HAS_cvode
#include "cvode/cvode.hpp"
#endif
#include "extended/extended.hpp"

namespace atwood {

Truth solve_truth(const Scenario& scenario, std::int64_t samples) {
  switch (scenario.truth.kind) {
#ifdef ATWOOD_HAS_closed_form
    case TruthKind::closed_form: return closed_form_truth(scenario, samples);
#else
    case TruthKind::closed_form: break;
#endif
    case TruthKind::extended: return extended_truth(scenario, samples);
#ifdef ATWOOD_HAS_cvode
    case TruthKind::cvode: return cvode_truth(scenario, samples);
#else
    case TruthKind::cvode: break;
#endif
    case TruthKind::values: return values_truth(scenario, samples);
    case TruthKind::none: break;
  }
  Truth made;
  made.source = "none";
  made.outcome.status = Status::unsupported;
  made.outcome.reason = "no truth: the scenario names none";
  return made;
}

}  // namespace atwood
