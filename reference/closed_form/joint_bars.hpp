// Samples of joints and ropes with their bars, from the evaluations in quad and in long double.
#pragma once

#include <string>
#include <vector>

#include "closed_form/solution.hpp"
#include "closed_form/spread.hpp"

namespace atwood::closed_form {

class JointBars {
 public:
  JointBars(const Scene& scene, double safety);

  // Adds the joints and ropes of instant k. A component of a reaction that one of the evaluations does not determine is
  // NaN. Answers the name of a joint or rope whose motion amplifies round-off too much for a bar; empty: there is none.
  std::string add(std::size_t k, const Motion<Wide>& wide, const std::vector<Motion<Narrow>>& narrow, Sample& value,
                  Sample& bar);

 private:
  struct Spreads {
    Spread q, u, force, torque, applied;
  };
  const Scene& scene_;
  double safety_;
  bool has_loops_;
  // The largest so far of all bodies. The start of a loop is projected, and coordinates of its joints follow from
  // poses: their errors are those of numbers of this size (of an angle: 1), however small a coordinate is.
  Wide place_ = 0, speed_ = 0, rate_ = 0;
  std::vector<Spreads> joints_;
  std::vector<std::pair<Spread, Spread>> ropes_;  // tension, angles

  void widen_scales(Spreads& of, JointKind kind) const;
  void add_joint(std::size_t k, std::size_t j, const Motion<Wide>& wide, const std::vector<Motion<Narrow>>& narrow,
                 JointSample& value, JointSample& bar);
};

// A sample within the half-width of the instant of an impact at a joint's stop may have the rate before or after it:
// the bars of rates and velocities include the jump, and reactions are not reported.
void add_stop_jump(const Scene& scene, const ContactEvent<Wide>& at, Sample& value, Sample& bar);

}  // namespace atwood::closed_form
