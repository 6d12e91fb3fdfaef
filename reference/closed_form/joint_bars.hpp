// Samples of joints and ropes with their bars, from the evaluations in quad and in long double.
#pragma once

#include <string>
#include <vector>

#include "closed_form/solution.hpp"
#include "closed_form/spread.hpp"
#include "protocol/sample_series.hpp"

namespace atwood::closed_form {

class JointBars {
 public:
  // loops: the start is projected, and coordinates of joints follow from poses: their errors are those of numbers of
  // the size of the motion (of an angle: 1), however small a coordinate is.
  JointBars(const Scene& scene, double safety, bool loops);

  // Adds the joints and ropes of instant k. A component of a reaction that one of the evaluations does not determine is
  // NaN. Answers the name of a joint or rope whose motion amplifies round-off too much for a bar; empty: there is none.
  std::string add(std::size_t k, const Motion<Wide>& wide, const std::vector<Motion<Narrow>>& narrow,
                  const MotionScales& scales, Sample& value, Sample& bar);

 private:
  struct Spreads {
    Spread q, u, force, torque, applied, stop;
  };
  const Scene& scene_;
  double safety_;
  bool loops_;
  std::vector<Spreads> joints_;
  std::vector<std::pair<Spread, Spread>> ropes_;  // tension, angles

  void add_joint(std::size_t k, std::size_t j, const Motion<Wide>& wide, const std::vector<Motion<Narrow>>& narrow,
                 const MotionScales& scales, JointSample& value, JointSample& bar);
};

// A sample within the half-width of the instant of an impact at a joint's stop may have the rate before or after it:
// the bars of rates and velocities include the jump, and reactions are not reported.
void add_stop_jump(const Scene& scene, const ContactEvent<Wide>& at, const SampleReference& value,
                   const SampleReference& bar);

}  // namespace atwood::closed_form
