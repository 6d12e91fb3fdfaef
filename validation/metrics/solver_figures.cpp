// How the iterative solvers of a run ended: five figures per solver, with its name in `body`, and two of the whole run.
#include "validation/metrics/measurements.hpp"

namespace atwood::metrics {
namespace {

// The scale of a solver's residual; a solver that is not described here refers to its engine's documentation.
std::string scale_of(const std::string& solver) {
  for (const SolverInfo& info : solver_infos())
    if (solver == info.name) return info.residual;
  return "scaled by the engine; see its documentation";
}

}  // namespace

void append_solver_figures(const Recording& run, std::vector<Row>& rows) {
  double capped = 0;
  const std::string* worst = nullptr;
  for (const auto& [solver, tally] : run.outcome.solvers) {
    const auto append = [&, &name = solver](const char* metric, double value, const std::string& reason = "") {
      rows.push_back(row(metric, value, 0, reason));
      rows.back().body = name;
    };
    append("solver-iterations-max", static_cast<double>(tally.iterations_max));
    append("solver-residual-max", tally.residual_max, scale_of(solver));
    append("solver-converged", static_cast<double>(tally.converged));
    append("solver-stagnated", static_cast<double>(tally.stagnated));
    append("solver-capped", static_cast<double>(tally.capped));
    capped += static_cast<double>(tally.capped);
    const auto residual = [&](const std::string* name) { return run.outcome.solvers.at(*name).residual_max; };
    if (worst == nullptr || !(tally.residual_max <= residual(worst))) worst = &solver;
  }
  if (worst == nullptr) return;
  rows.push_back(row("solver-capped", capped, 0, capped > 0 ? "" : "every solve reached its tolerance or round-off"));
  rows.push_back(row("solver-residual-max", run.outcome.solvers.at(*worst).residual_max, 0,
                     "the largest is that of " + *worst + ": " + scale_of(*worst)));
}

}  // namespace atwood::metrics
