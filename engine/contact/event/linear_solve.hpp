// The linear system of contact constraints.
#pragma once

#include "contact/event/constraints.hpp"

namespace atwood::event {

// Solves constraints.matrix unknown = constraints.right for constraints.row_count rows, and leaves the bodies'
// accelerations under the solution in constraints.acceleration.
//
// redundant: constraints may depend on each other; the solution nearest to the start in constraints.unknown is found,
// in the norm weighted by constraints.weight. Factors kept under the same `key` are tried first; key 0: neither reused
// nor kept. A block that has no factors gets the unknowns 0 and unsets constraints.solvable. Residual, with the scale
// |x_i| sqrt(A_ii):
//   |r_i| / sqrt(A_ii);
// converged: to 64 roundings; stagnated: each |r_i| is at most constraints.right_round_off[i]. Without redundancy the
// system is solved once and directly: the residual is not measured, and 0 stands in its place.
template <class S>
SolveReport solve_rows(const Bodies<S>& bodies, const ActiveSet<S>& active, ConstraintSystem<S>& constraints,
                       bool redundant, std::uint64_t key);

}  // namespace atwood::event
