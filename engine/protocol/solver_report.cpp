#include "protocol/solver_report.hpp"

namespace atwood {

const std::array<SolverInfo, kIterativeSolvers>& solver_infos() {
  static const std::array<SolverInfo, kIterativeSolvers> infos{{
      {"implicit-stages",
       "the equations of an implicit step, by fixed-point sweeps or Newton's method; converged: further changes would "
       "sum to less than a thousandth of an ulp; of kick-drift steps, the change is at most two ulp; of Radau 15, what "
       "remains is a tenth of the run's tolerance or an eighth of an ulp; stagnated: the "
       "change no longer halves and is below 4096 ulp",
       "estimated remaining change of a component (of an iteration that does not converge, its last change), over the "
       "component or a thousandth of the largest component, whichever is larger"},
      {"invariant-projection",
       "three projections, by Newton's method. Onto the invariants of a projected step; converged: half an ulp; "
       "stagnated: the misfit no longer halves and is below 64 ulp; capped with four invariants: the step keeps the "
       "energy only. Onto the constraints of a mechanism, the positions nearest in the metric of its mass matrix at "
       "which loops are closed and ropes have their lengths; converged: 16 roundings of the lengths in a constraint, of 1 "
       "for an angle (0 iterations: met already); stagnated: the misfit no longer halves and is below 4096 roundings, or, "
       "of planar loops, a last step opened gaps beyond the tolerance and was taken back. Symmetric projection, its "
       "multipliers before and after a step by simplified Newton iterations of whole steps; converged: the same "
       "roundings of positions and speeds",
       "misfit of an invariant, or of a constraint, over the size of its terms"},
      {"energy-relaxation",
       "the length of a relaxed step that keeps the energy; converged: half an ulp of the energy; stagnated: the "
       "misfit no longer halves and is below 64 of these",
       "misfit of the energy over the size of its terms"},
      {"contact-sweeps",
       "contact impulses of a substep, by projected Gauss-Seidel: `iterations` sweeps, with joints at least 30, and at "
       "rest up to `rest_sweeps`; converged: the last sweep changed velocities by at most 1e-10 of the scale. Bodies in "
       "motion are not swept to convergence, so most of their solves end capped. Measured in every substep at rest, else "
       "in the last substep of each step. With joints, contacts and joints are solved in turn. Where 20 turns of the direct solver did not satisfy both, they "
       "count as one more solve, of 20 iterations; with sweeps, which include the joints, there are two turns at most, and "
       "what the second leaves is not measured",
       "largest change of a body's velocity, or of its angular velocity times its bounding radius, in the last "
       "sweep (or alternation), over the largest such velocity or what gravity gives in the substep, whichever is "
       "larger"},
      {"contact-newton",
       "contact impulses of an island, by Newton's method on the contact law; converged: 1000 roundings of the largest "
       "impulse, 10000 where the starting impulses already satisfy it",
       "largest violation of the contact law, as an impulse, over the largest impulse or the largest that would stop one "
       "point, whichever is larger"},
      {"impact-queue",
       "impacts of a substep, one after another in the order of their times. Capped where (a) approaches were left "
       "after eight impacts a contact on average (one of restitution e counts as 2 (1 - e), at most 1), (b) joints "
       "approached stops after eight impacts a stop on average, or (c) an impact made a body so fast that it may have met "
       "bodies outside its candidate pairs. Approaches left by (a) are stopped without restitution",
       "fastest approach that was left over the fastest that was resolved"},
      {"impact-time",
       "the instant of an impact of shapes that turn, by Newton's method on the gap; converged: 16 roundings of the "
       "smaller body; capped also where an iterate fell before the impacts that are resolved already: the impact then "
       "takes place at the last of these. Not counted where the instant lies after the substep, whose velocity solver then "
       "stops this approach, or where the shapes overlap at the last resolved impact already",
       "gap over the bounding radius of the smaller body"},
      {"slip-path",
       "the slip during one impact with friction, whose direction turns, by an adaptive method along the normal impulse, "
       "and the couple against rolling, by alternating with friction; counted where one of them did not converge",
       "error of the last step over the impulse; of the direction at an onset of slip, the width of its bracket over that "
       "of the first bracket; against rolling, the last change of the couple over the couple; infinity where the slip's "
       "path has no end"},
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
       "misfit of the prescribed accelerations (or gaps, velocities) over those that the forces produce, in the norm of "
       "the Delassus matrix"},
      {"contact-projection",
       "the least displacement that closes the gaps of lasting contacts after a step, by at most two iterations of "
       "Newton's method; converged: the round-off of a gap",
       "largest gap over the largest coordinate or size"},
      {"event-location",
       "the instant within a trial step at which a gap closes, a contact changes its mode, a joint reaches or leaves its "
       "stop, or a relative wind vanishes, by Newton's method within a bracket, by false position or by bisection; "
       "converged: an ulp of the step, or a gap of round-off",
       "what is left of the bracket, or the last change, as a share of the step"},
      {"closest-points",
       "the closest points of two convex shapes, by the algorithm of Gilbert, Johnson and Keerthi; counted, of shapes in "
       "contact, where 200 iterations left it capped",
       "upper bound of the distance minus its lower bound, over the shapes' extent"},
      {"expanding-polytope",
       "the direction of least overlap of two convex shapes, `iterations` being points of the polytope; converged: known to 64 roundings of their extent, or "
       "every axis of two polyhedra tried; capped: found by Newton's method from many directions, not certified",
       "overlap along the direction found minus the certified lower bound of the overlap, over the shapes' extent"},
      {"conservative-advancement",
       "the time of impact of two bodies; converged: a gap of the stated round-off, or a step below that of the time; "
       "capped: the tolerance of a touch was doubled, because steps at small gaps did not end, or a search for the "
       "closest points or the least overlap at the touch was capped",
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
