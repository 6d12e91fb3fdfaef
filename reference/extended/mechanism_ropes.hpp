// Where the constraint of a rope ends: its ends and what it covers of its pulleys.
#pragma once

#include <algorithm>
#include <vector>

#include "extended/mechanism_motion.hpp"

namespace atwood::extended {

struct RopeWatch {
  static constexpr double kEnd = 1e-7;         // of a rope's free length at the start: its end has reached the pulley
  static constexpr double kUncovered = 1e-12;  // rad: less is rounding
  const MechanismMotion& motion;
  int count;                        // of ropes
  std::vector<Wide> free_at_start;  // of each: its longer free end

  void begin(const Wide* y) {
    for (int k = 0; k < count; ++k) {
      const auto free_m = motion.rope_margins(y, k).free_m;
      free_at_start.push_back(std::max(free_m[0], free_m[1]));
    }
  }
  // No step leaps over the point to which an end is drawn: at most half of the way at the present speed.
  Wide limit(const Wide* y, Wide step) const {
    for (int k = 0; k < count; ++k) {
      const auto now = motion.rope_margins(y, k);
      for (int end = 0; end < 2; ++end)
        if (now.closing_m_per_s[end] * step > now.free_m[end] / 2)
          step = now.free_m[end] / (2 * now.closing_m_per_s[end]);
    }
    return step;
  }
  // Where the rope is tangent to the pulley at its very end, that end turns at a rate without bound.
  bool reaches_pulley(const Wide* y, int rope) const {
    const auto now = motion.rope_margins(y, rope).free_m;
    return std::min(now[0], now[1]) < Wide(kEnd) * free_at_start[rope];
  }
  Wide uncovered(const Wide* y, int rope) const {  // > 0: the rope has left a pulley
    const auto now = motion.rope_margins(y, rope).covered_rad;
    return -std::min(now[0], now[1]) - Wide(kUncovered);
  }
};

}  // namespace atwood::extended
