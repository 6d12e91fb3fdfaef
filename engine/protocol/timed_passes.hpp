// The timed pass of an engine: a warm-up, then as many timed runs as were asked for.
#pragma once

#include <chrono>
#include <cstdint>
#include <vector>

#include "protocol/sample.hpp"

namespace atwood {

// `pass(busy)` runs the scene once without observation, and sets `busy` to the time of what is measured. The first pass
// is not counted. The outcome is that of the last pass; the times are there if all passes ended ok.
template <class Pass> Outcome timed_passes(int repeats, const Pass& pass) {
  std::vector<std::int64_t> busy_ns;
  for (int k = 0;; ++k) {
    std::chrono::nanoseconds busy{};
    Outcome outcome = pass(busy);
    if (outcome.status != Status::ok) return outcome;
    if (k > 0) busy_ns.push_back(busy.count());
    if (k < repeats) continue;
    outcome.busy_ns = busy_ns;
    return outcome;
  }
}

// A pass that is measured as a whole.
template <class Run> auto whole_pass(const Run& run) {
  return [&run](std::chrono::nanoseconds& busy) {
    const auto start = std::chrono::steady_clock::now();
    Outcome outcome = run();
    busy = std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - start);
    return outcome;
  };
}

}  // namespace atwood
