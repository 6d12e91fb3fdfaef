#include "protocol/solver_report.hpp"

namespace atwood {

const std::array<SolverInfo, kIterativeSolvers>& solver_infos() {
  static const std::array<SolverInfo, kIterativeSolvers> infos{{
      {"implicit-stages",
       "the equations of an implicit step, by fixed-point sweeps or Newton's method; converged: further changes would "
       "sum to less than a thousandth of an ulp; of kick-drift steps, the change is at most two ulp; of Radau 15, what "
       "remains is a tenth of the run's tolerance or an eighth of an ulp; stagnated: the "
       "change no longer halves and is below 4096 ulp",
       "largest change of a component that would follow, where the iteration converges, else that of the last "
       "iteration, over the component or a thousandth of the largest"},
      {"invariant-projection",
       "the invariants that a projected step returns to, by Newton's method; converged: half an ulp; stagnated: the "
       "misfit no longer halves and is below 64 ulp; capped with four invariants: the step keeps the energy alone. Of "
       "mechanisms: the positions, nearest in the metric of the mass, at which loops are closed and ropes have their "
       "lengths; converged: 16 roundings of the lengths in a constraint, of 1 for an angle (0 iterations: met already); "
       "stagnated: the misfit no longer halves and is below 4096 roundings, or, of planar loops, a last step opened gaps "
       "beyond the tolerance and was taken back. Of symmetric projection: the multipliers by which a step is moved before "
       "and after it, by simplified Newton iterations of whole steps, to the same roundings of positions and speeds",
       "misfit of an invariant, or of a constraint, over the size of its terms"},
      {"energy-relaxation",
       "the length of a relaxed step that keeps the energy; converged: half an ulp of the energy; stagnated: the "
       "misfit no longer halves and is below 64 of these",
       "misfit of the energy over the size of its terms"},
      {"contact-sweeps",
       "contact impulses of a substep, by projected Gauss-Seidel with a fixed number of sweeps, which is the method: "
       "capped unless the last sweep changed velocities by at most 1e-10 of the scale; measured in the last substep of "
       "each step",
       "largest change of a body's velocity, or of its angular velocity times its bounding radius, in the last sweep "
       "over the larger of the largest such velocity and what gravity gives in the substep"},
      {"contact-newton",
       "contact impulses of an island, by Newton's method on the contact law; converged: 1000 roundings of the largest "
       "impulse, 10000 where the starting impulses already satisfy it",
       "largest violation of the contact law, as an impulse, over the largest impulse, there or needed to stop a "
       "point"},
      {"impact-queue",
       "impacts of a substep, one after another in the order of their times; capped: the limit was reached, eight impacts "
       "a contact on average, where one of restitution e counts as 2 (1 - e), at most 1: the approaches that were left are "
       "stopped without restitution; or eight impacts a stop of a joint; or an impact sent a body so far within the step "
       "that it may have met others than its candidate pairs",
       "fastest approach that was left over the fastest that was resolved"},
      {"impact-time",
       "the instant of an impact of shapes that turn, by Newton's method on the gap; converged: 16 roundings of the "
       "smaller body; not counted where the instant lies outside the substep, whose velocity solver then stops them",
       "gap over the bounding radius of the smaller body"},
      {"slip-path",
       "the slip during one impact with friction, whose direction turns, by an adaptive method along the normal impulse, "
       "and the couple against rolling; counted where one of them did not converge",
       "not measured"},
      {"simultaneous-impacts",
       "impulses of all points of an instant, by projected Gauss-Seidel, then by Newton's method; converged: the last "
       "sweep changed them by at most four roundings; stagnated: Newton's method left at most 64",
       "largest change of an impulse in the last sweep over the largest impulse"},
      {"contact-forces",
       "forces of all lasting contacts where the modes of contact are searched for, by projected Gauss-Seidel; converged: "
       "the last sweep changed them by at most two roundings",
       "largest change of a force in the last sweep over the largest normal force"},
      {"redundant-contacts",
       "forces of redundant lasting contacts, and the least changes of position and velocity that close "
       "their drift, by the proximal point method; converged: 64 roundings; stagnated: what is left of a drift is "
       "round-off of the gaps or velocities that it was computed from",
       "what is left of the accelerations (or gaps, velocities) asked for, over those that the forces give, in the "
       "Delassus matrix's norm"},
      {"contact-projection",
       "the least displacement that closes the gaps of lasting contacts after a step, by at most two iterations of "
       "Newton's method; converged: the round-off of a gap",
       "largest gap over the largest coordinate or size"},
      {"event-location",
       "the instant within a trial step at which a gap closes, a contact changes its mode, a joint reaches or leaves its "
       "stop, or a relative wind vanishes, by Newton's method within a bracket, by false position or by bisection; "
       "converged: an ulp of the step, or a gap of round-off",
       "what is left of the bracket, or the last change, as a share of the step"},
      {"expanding-polytope",
       "the direction of least overlap of two convex shapes; converged: known to 64 roundings of their extent, or "
       "every axis of two polyhedra tried; capped: found by Newton's method from many directions, not certified",
       "overlap along the direction found less the certified least, over the shapes' extent"},
      {"conservative-advancement",
       "the time of impact of two bodies; converged: a gap of the stated round-off, or a step below that of the time; "
       "capped: that round-off was doubled because the bodies stayed near without touching",
       "gap at the touch over the bodies' size"},
  }};
  return infos;
}

std::map<std::string, SolveTally> named_tallies(const SolverTallies& tallies) {
  std::map<std::string, SolveTally> named;
  for (std::size_t i = 0; i < kIterativeSolvers; ++i)
    if (tallies.of[i].solves() > 0) named[solver_infos()[i].name] = tallies.of[i];
  return named;
}

}  // namespace atwood
