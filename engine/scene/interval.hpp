// A span of time.
#pragma once

namespace atwood {

// half-open [from, to)
struct Interval {
  double from_s = 0;
  double to_s = 0;
};

}  // namespace atwood
