// Integration of a mechanism's whole motion by one formulation: from sample to sample, projected after each step,
// restarted at switches and at the stops of joints.
#pragma once

#include "extended/mechanism_motion.hpp"
#include "extended/problem.hpp"

namespace atwood::extended {

struct MechanismPath {
  SampleSeries samples;       // at t_end k / samples
  std::vector<Event> events;  // impacts at stops, and joints that come to rest at one
  std::string failure;        // empty: the whole motion was integrated
  bool valid_until_failure = false;
  Wide end_s = 0;     // time that was reached, or of the failure
  Wide residual = 0;  // largest of the constraints after projection, m or rad: of those that follow from the others
  std::int64_t steps = 0, evaluations = 0;
};

struct MechanismRun {
  const Scene& scene;
  double t_end_s;
  std::int64_t samples;
  double tolerance;
  // A joint's bounces at a stop are summed as a series when they would end within this span: it is then at rest, and
  // the motions of the others are wrong by about the span times the neglected speed.
  double rest_span_s;
  Grid grid = Grid::samples;
};

// Never throws.
MechanismPath integrate_mechanism(MechanismMotion& motion, const Sample& start, const MechanismRun& run);

}  // namespace atwood::extended
