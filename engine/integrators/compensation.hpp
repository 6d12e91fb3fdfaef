// Compensated summation over the steps of a run: the rounding error of one step's increment is added to the next one.
#pragma once

#include <algorithm>
#include <vector>

#include "math/system.hpp"

namespace atwood {

// Kahan, Comm. ACM 8 (1965) 40; Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), VIII.5. The sum is
// Knuth's two-sum, which is exact whichever of y and the increment is larger.
//
//   compensation.begin(y); for each i: y_new[i] = compensation.add(i, y[i], increment_i); compensation.end(y_new);
//
// add() may be called several times a component in a step (the substeps of a composition). If the caller changes the
// state between steps, the remainder is cleared; a step repeated from the same y starts from the same remainder.
template <class S> class Compensation {
 public:
  Compensation(bool on, int size)
      : on_(on), remainder_(on ? size : 0), remainder_start_(remainder_.size()), start_(remainder_.size()),
        end_(remainder_.size()) {}

  bool on() const { return on_; }

  void begin(const S* y) {
    if (!on_) return;
    if (std::equal(end_.begin(), end_.end(), y)) remainder_start_ = remainder_;
    else if (!std::equal(start_.begin(), start_.end(), y))
      std::fill(remainder_start_.begin(), remainder_start_.end(), S(0));
    std::copy(y, y + start_.size(), start_.begin());
    remainder_ = remainder_start_;
  }

  S add(int i, S y, S increment) {
    if (!on_) return y + increment;
    const S wanted = increment + remainder_[i];
    const S sum = y + wanted;
    const S part = sum - y;
    remainder_[i] = (y - (sum - part)) + (wanted - part);
    return sum;
  }

  void end(const S* y_new) {
    if (on_) std::copy(y_new, y_new + end_.size(), end_.begin());
  }

 private:
  bool on_;
  std::vector<S> remainder_, remainder_start_, start_, end_;
};

// Projects a compensated state between add() and end(). Replacing y by its projection would round every component again
// and lose the remainder; the change by the projection is added like any increment instead. A unit quaternion's change
// lies along q itself, and q' = 1/2 q (0, w) is linear in q, so an error of its norm does not change the attitude's
// direction.
template <class S> void project_compensated(const System<S>& system, Compensation<S>& compensation, S* y, S* change) {
  if (system.projection_of == nullptr) return system.project(y);
  system.projection_of(system.context, y, change);
  for (int i = 0; i < system.size; ++i)
    if (change[i] != S(0)) y[i] = compensation.add(i, y[i], change[i]);
}

}  // namespace atwood
