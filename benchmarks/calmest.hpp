// Measures again while the machine is busy.
#pragma once

#include <utility>

#include "benchmarks/figures.hpp"

namespace atwood {

inline constexpr int kMaxAgain = 2;  // a measurement on a busy machine is repeated at most this many times

template <class Figures> struct Measured {
  Figures figures;
  MachineState machine;  // meanwhile
};

// Calls `measure`, which returns a Measured, until the machine was not busy meanwhile, at most 1 + kMaxAgain times.
// The calmest measurement, whatever its figures are; its `machine.again` says how many followed the first.
template <class Measure> auto calmest(const Measure& measure) {
  auto best = measure();
  for (int again = 1; busy(best.machine) && again <= kMaxAgain; ++again) {
    auto next = measure();
    if (unrest(next.machine) < unrest(best.machine)) best = std::move(next);
    best.machine.again = again;
  }
  return best;
}

}  // namespace atwood
