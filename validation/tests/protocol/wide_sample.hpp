// A sample whose values need more than doubles, for tests of the wire format.
#pragma once

#include <limits>

#include "protocol/wire.hpp"

namespace atwood {

inline const Wide third = static_cast<Wide>(1) / 3;

inline Sample wide_sample() {
  Sample sample;
  sample.t_s = 0.1;
  sample.bodies.resize(2);
  sample.bodies[0].p_m = {0.1, third, static_cast<Wide>(0.1L)};
  sample.bodies[0].v_m_per_s = {std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(),
                                -0.0};
  sample.bodies[1].q_wxyz = {0.5, 0.5, -0.5, 0.5};
  sample.bodies[1].w_rad_per_s = {1e-320, 1e300, 3};
  return sample;
}

}  // namespace atwood
