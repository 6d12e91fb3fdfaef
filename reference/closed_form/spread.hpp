// The difference between quad and long double of one kind of value over a run, and the bar that follows from it.
#pragma once

#include <limits>

#include "closed_form/number.hpp"

namespace atwood::closed_form {

inline const Wide round_off = unit_round_off<Wide>();
inline const Wide ratio = unit_round_off<Wide>() / unit_round_off<Narrow>();
inline const Wide kMeasureLimit = 0x1p-20;

// The largest sizes so far of a motion's values, of all bodies: whatever is a sum of such numbers has their round-off,
// however small it is itself.
struct MotionScales {
  Wide place_m = 0, speed_m_per_s = 0, rate_rad_per_s = 0;
  void include(const std::vector<BodySample>& bodies) {
    for (const BodySample& body : bodies) {
      place_m = larger(place_m, norm(body.p_m));
      speed_m_per_s = larger(speed_m_per_s, norm(body.v_m_per_s));
      rate_rad_per_s = larger(rate_rad_per_s, norm(body.w_rad_per_s));
    }
  }
};

struct Spread {  // one kind of value of one body, over the run so far
  Wide difference = 0, scale = 0;
  template <class A, class B> void include(const A& wide, const B& narrow) {
    for (std::size_t i = 0; i < wide.size(); ++i) {
      difference = larger(difference, magnitude(wide[i] - Wide(narrow[i])));
      if (!is_finite(wide[i]) || !is_finite(narrow[i])) difference = std::numeric_limits<double>::infinity();
      scale = larger(scale, magnitude(wide[i]));
    }
  }
  Wide bar(double safety) const { return safety * (ratio * difference + round_off * scale); }
  // The same of values that are sums of numbers up to `size`.
  Wide bar(double safety, Wide size) const { return safety * (ratio * difference + round_off * larger(scale, size)); }
  // The difference is proportional to the round-off only while it is small compared with the extent of the motion
  // (`way`, plus round-off of numbers of the scene's size). A larger difference is not a measure of quad's round-off
  // error.
  bool is_measure(Wide way) const { return difference <= kMeasureLimit * way || !is_finite(difference); }
};

}  // namespace atwood::closed_form
