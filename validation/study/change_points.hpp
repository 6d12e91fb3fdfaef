// Where the level of a figure changes over runs.
//
// The values are cut into segments of constant level so that
//
//   sum over segments of sum (x_i - mean of the segment)^2 + penalty * (segments - 1)
//
// is least: penalised least squares, minimised exactly by optimal partitioning (Jackson et al., IEEE Signal Processing
// Letters 12 (2005) 105), the minimum that PELT (Killick, Fearnhead, Eckley, J. Am. Stat. Assoc. 107 (2012) 1590) finds
// with less work. A segment has two runs or more, so that one outlier is not a level. The penalty is 4 s^2 ln n; s is
// the spread of a run, of which the median of the absolute differences between neighbours tells (their median is
// 0.6745 sqrt(2) s for normal values; a change of level moves one difference only).
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace atwood {

inline constexpr std::size_t kMinRuns = 8;  // of fewer the spread is not known well enough

struct ChangePoints {
  bool enough = false;              // kMinRuns values or more, all of them finite
  std::vector<std::size_t> starts;  // the index of the first value of each new level, ascending
  bool logarithmic = false;         // levels are of ln |x|: all values are positive
  double spread = 0, penalty = 0;   // in those units, or relative to the largest |x|
};
ChangePoints find_change_points(std::span<const double> values);

}  // namespace atwood
