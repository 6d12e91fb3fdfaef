#include "truth/truth.hpp"

#include "closed_form/closed_form.hpp"
#include "cvode/cvode.hpp"
#include "extended/extended.hpp"
#include "fluid_truth/semi_discrete.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

Truth solve_truth(const Scenario& scenario, std::int64_t samples) {
  switch (scenario.truth.kind) {
    case TruthKind::closed_form: return closed_form_truth(scenario, samples);
    case TruthKind::extended: return extended_truth(scenario, samples);
    case TruthKind::cvode: return cvode_truth(scenario, samples);
    case TruthKind::values: return values_truth(scenario, samples);
    case TruthKind::semi_discrete: return semi_discrete_truth(scenario, samples);
    case TruthKind::weakly_compressible:
    case TruthKind::literature:
    case TruthKind::none: break;
  }
  Truth made;
  made.source = "none";
  made.outcome =
      refused(scenario.truth.kind == TruthKind::none ? "no truth: the scenario names none"
                                                     : "this truth is a field: it has no samples of its own");
  return made;
}

}  // namespace atwood
