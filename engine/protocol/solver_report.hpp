// How an iteration ended, and the same summed over the solves of a run.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>

namespace atwood {

// How a solve ended. A solver names its own tolerance where it sets this.
//   converged    the residual fell to the tolerance
//   stagnated    the residual stopped falling within a few roundings of its own computation, above the tolerance; or a
//                last step below the tolerance was taken back, because it raised the residual
//   capped       neither: the iteration limit was reached, or the iteration diverged or broke down
enum class SolveEnd : unsigned char { converged, stagnated, capped };

// One solve. `residual` is scaled; solver_infos() name the scale. An iteration that diverges may leave infinity or NaN.
struct SolveReport {
  std::int64_t iterations = 0;
  double residual = 0;
  SolveEnd ended = SolveEnd::converged;
};

// All solves of one solver in a run.
struct SolveTally {
  std::int64_t converged = 0, stagnated = 0, capped = 0, iterations_max = 0;
  double residual_max = 0;  // NaN once a residual was NaN

  void add(const SolveReport& report) {
    if (report.ended == SolveEnd::converged) ++converged;
    else if (report.ended == SolveEnd::stagnated) ++stagnated;
    else ++capped;
    if (report.iterations > iterations_max) iterations_max = report.iterations;
    if (!(report.residual <= residual_max)) residual_max = report.residual;
  }
  void add(const SolveTally& other) {
    converged += other.converged;
    stagnated += other.stagnated;
    capped += other.capped;
    if (other.iterations_max > iterations_max) iterations_max = other.iterations_max;
    if (!(other.residual_max <= residual_max)) residual_max = other.residual_max;
  }
  std::int64_t solves() const { return converged + stagnated + capped; }
};
inline bool operator==(const SolveTally& a, const SolveTally& b) {  // not defaulted: Boost's odeint needs C++17
  return a.converged == b.converged && a.stagnated == b.stagnated && a.capped == b.capped &&
         a.iterations_max == b.iterations_max && a.residual_max == b.residual_max;
}

// The iterative solvers of Atwood's own engine, in the order of solver_infos().
enum class IterativeSolver : unsigned char {
  implicit_stages,
  invariant_projection,
  energy_relaxation,
  contact_sweeps,
  contact_newton,
  impact_queue,
  impact_time,
  slip_path,
  simultaneous_impacts,
  contact_forces,
  redundant_contacts,
  contact_projection,
  event_location,
  closest_points,
  expanding_polytope,
  conservative_advancement
};
inline constexpr std::size_t kIterativeSolvers = 16;

// What is printed of a solver: its name in rows and in the worker protocol, what it solves and to which tolerance, and
// what its residual is relative to.
struct SolverInfo {
  const char *name, *solves, *residual;
};
const std::array<SolverInfo, kIterativeSolvers>& solver_infos();

// The solves of one run, kept beside the system of equations.
//
// A step that may be refused and taken again shorter reports by add_unless_capped(): a capped solve is held back then,
// because its result is thrown away, and counted by keep_capped() if the run ends because of it.
struct SolverTallies {
  std::array<SolveTally, kIterativeSolvers> of{};
  SolveReport refused{};  // iterations 0: none
  IterativeSolver refused_of = IterativeSolver::implicit_stages;

  void add(IterativeSolver solver, const SolveReport& report) { of[static_cast<std::size_t>(solver)].add(report); }
  // False: capped.
  bool add_unless_capped(IterativeSolver solver, const SolveReport& report) {
    if (report.ended == SolveEnd::capped) {
      refused = report;
      refused_of = solver;
      return false;
    }
    add(solver, report);
    return true;
  }
  void keep_capped() {
    if (refused.iterations > 0) add(refused_of, refused);
    refused.iterations = 0;
  }
};

// By name, those that solved anything.
std::map<std::string, SolveTally> named_tallies(const SolverTallies& tallies);

}  // namespace atwood
