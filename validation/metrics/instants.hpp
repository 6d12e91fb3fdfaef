// The instants at which errors over a run, drift and growth are judged. At the scene's own samples alone they depend on
// how the samples meet the motion: at whole periods of an oscillation symplectic Euler's error is of order h^2, and
// beside them a bounded error of energy looks like a drift.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "protocol/truth.hpp"
#include "scene/scene.hpp"
#include "validation/row.hpp"

namespace atwood {

// Samples of a run: a multiple of the scene's own that divides every step count of its ladder, so that all rungs
// share their instants. At most 256 (128 of mechanisms whose truth is integrated) or four times the own ones, and
// 16384 states of bodies. Of what these limits leave, the number with the most different primes, and of those the
// largest: few periods fall on all of its instants. The own samples: the ladder admits no more, or nothing is judged
// at them (fluids, recorded frames, neither a truth that can be had at any instant nor energy).
std::int64_t shared_samples(const Scenario& scenario);
// Of a rung, which takes part in ladders that have this divisor: those of shared_samples that it has too.
std::int64_t shared_samples(const Scenario& scenario, std::int64_t divisor);

// Whether a run with so many samples of its own may have been asked for `shared`.
bool may_share(std::int64_t samples, std::int64_t shared);

// Which of the instants t_end k / shared, k = 1..shared, are judged. All of them, or, of 2 n and more, n = 64 or as
// many as there are own samples: one in each of n equal parts of the run, placed by multiples of the golden ratio, so
// that no period falls on all of them or on many (Weyl's sequence, of low discrepancy).
std::vector<std::int64_t> judged_instants(std::int64_t samples, std::int64_t shared);

// A run that was asked for `shared` samples: its own samples, and between them the judged instants, without contacts
// and ropes. One that did not end well keeps its own samples.
Recording with_instants(Recording run, std::int64_t samples, std::int64_t shared);

// A truth of more samples than these at every n-th of its own, which `fewer` keeps; itself where it has no more: a
// truth of a million samples is not copied.
const Truth& at_samples(const Truth& truth, std::size_t samples, std::optional<Truth>& fewer);

// The run's samples and its judged instants in one list, and the truth at the same times.
struct Observed {
  std::shared_ptr<const Recording> kept_run;  // null: `run` and `truth` are the caller's
  std::shared_ptr<const Truth> kept_truth;
  const Recording& run;
  const Truth& truth;  // no values: there is none at the judged instants
  std::vector<bool> judged;
};
// `truth`: at the run's own samples, or at all that it shares. Both outlive what is made.
Observed observed(const Truth& truth, const Recording& run);
// What is made of these values alone.
Observed observed_of(Recording run, Truth truth, std::vector<bool> judged);

}  // namespace atwood
