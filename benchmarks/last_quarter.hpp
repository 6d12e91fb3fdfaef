// The error over the last quarter of a run, beside that at its end: an error that oscillates may pass through zero
// there.
#pragma once

#include <map>

#include "benchmarks/goals.hpp"
#include "validation/study/study.hpp"

namespace atwood {

class LastQuarter {
 public:
  // `goal` and the rest must outlive this.
  LastQuarter(const Goal& goal, const std::vector<Worker>& workers, const StudyOptions& study)
      : goal_(goal), workers_(workers), study_(study) {}
  // The largest figure of the goal's metric at samples from 3/4 of the run to its end, from a run of the cell with
  // samples. Infinity: the run diverged, or a state or the figure at one of these samples is not finite. NaN: the
  // metric is not an error at the end, the error spans variants of the scene, equal steps cannot be split into 8 to 64
  // samples, the truth failed, the run ended otherwise (time limit, crash, refusal), or runs take minutes.
  double error(const Cell& cell);

 private:
  const Goal& goal_;
  const std::vector<Worker>& workers_;
  const StudyOptions& study_;
  std::map<std::int64_t, Truth> truths_;  // by samples
};

}  // namespace atwood
