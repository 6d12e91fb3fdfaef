// IDA on mechanisms with loops and ropes: the stabilised index-2 form of Gear, Gupta and Leimkuhler (1985) in the
// coordinates of a spanning tree.
#pragma once

#include <chrono>

#include "ida/solver.hpp"
#include "protocol/sample.hpp"
#include "scene/scene.hpp"

namespace atwood::ida {

//   q' = N(q) (u + G^T mu)      M u' = tau + G^T lambda      0 = g(q)      0 = G u - bias
//
// with the independent rows of G that are chosen at the start and at switches. The absolute tolerance of lambda and mu
// is 1e8: the error test and Newton's convergence test shall not see them (with a tolerance of the size of the
// coordinates' Newton's iteration fails). Samples are the solver's q and u, without projection; reactions are computed
// from them. Stops of joints and what mechanism::unsupported() names are answered with Status::unsupported.
Outcome run_mechanism(const Scene& scene, double t_end_s, std::int64_t samples, const Options& options,
                      const Observer& observer, std::chrono::nanoseconds* busy = nullptr);

}  // namespace atwood::ida
