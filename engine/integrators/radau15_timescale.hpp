// The timescale by which the criterion PRS23 chooses steps.
#pragma once

#include "integrators/radau15.hpp"

namespace atwood {

// Pham, Rein, Spiegel (2024), in units of the step, with the acceleration a, jerk j and snap s at its end of the
// `count` components together:
//   tau^2 = 2 |a|^2 / (|j|^2 + |a| |s|)
// `rate`: at the nodes, of all components. 0: they have no acceleration, or it does not change.
template <class S>
S radau_timescale(const RadauTable<S>& table, const int* components, int count, const LaneArray<S>& rate) {
  S squares[3] = {};  // of the acceleration, the jerk and the snap
  for (int c = 0; c < count; ++c) {
    const S* nodes = rate[components[c]].lane;
    S sum[3] = {};
    for (int k = 0; k < kRadauNodes; ++k) {
      S coefficient = S(0);
      for (int j = 0; j < kRadauNodes; ++j) coefficient += nodes[j] * table.power[j][k];
      sum[0] += coefficient;
      sum[1] += S(k) * coefficient;
      sum[2] += S(k * (k - 1)) * coefficient;
    }
    for (int d = 0; d < 3; ++d) squares[d] += sum[d] * sum[d];
  }
  const S change = squares[1] + real::sqrt(squares[0] * squares[2]);
  return squares[0] > S(0) && change > S(0) ? real::sqrt(S(2) * squares[0] / change) : S(0);
}

}  // namespace atwood
