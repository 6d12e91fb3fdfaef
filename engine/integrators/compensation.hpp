// Compensated summation over the steps of a run: what rounding cut off one step's increment joins the next one's.
#pragma once

#include <algorithm>
#include <vector>

#include "math/system.hpp"

namespace atwood {

// Kahan, Comm. ACM 8 (1965) 40; Hairer, Lubich, Wanner, Geometric Numerical Integration (2nd ed.), VIII.5. The sum is
// Knuth's two-sum, which is exact whichever of y and the increment is larger.
//
//   rest.begin(y); for each i: y_new[i] = rest.add(i, y[i], increment_i); rest.end(y_new);
//
// add() may be called several times a component in a step (the substeps of a composition). A caller that edits the
// state between steps starts afresh; a step taken again from the same y starts from the same rest.
template <class S> class Compensation {
 public:
  Compensation(bool on, int size)
      : on_(on), rest_(on ? size : 0), rest_start_(rest_.size()), start_(rest_.size()), end_(rest_.size()) {}

  bool on() const { return on_; }

  void begin(const S* y) {
    if (!on_) return;
    if (std::equal(end_.begin(), end_.end(), y)) rest_start_ = rest_;
    else if (!std::equal(start_.begin(), start_.end(), y)) std::fill(rest_start_.begin(), rest_start_.end(), S(0));
    std::copy(y, y + start_.size(), start_.begin());
    rest_ = rest_start_;
  }

  S add(int i, S y, S increment) {
    if (!on_) return y + increment;
    const S wanted = increment + rest_[i];
    const S sum = y + wanted;
    const S part = sum - y;
    rest_[i] = (y - (sum - part)) + (wanted - part);
    return sum;
  }

  void end(const S* y_new) {
    if (on_) std::copy(y_new, y_new + end_.size(), end_.begin());
  }

 private:
  bool on_;
  std::vector<S> rest_, rest_start_, start_, end_;
};

// Projects a compensated state between add() and end(). To overwrite y by its projection would round every component
// anew and throw the rest away; the projection's change is added like any increment instead. A unit quaternion's change
// lies along q itself, and q' = 1/2 q (0, w) is linear in q, so an error in its size turns nothing.
template <class S> void project_compensated(const System<S>& system, Compensation<S>& rest, S* y, S* change) {
  if (system.projection_of == nullptr) return system.project(y);
  system.projection_of(system.context, y, change);
  for (int i = 0; i < system.size; ++i)
    if (change[i] != S(0)) y[i] = rest.add(i, y[i], change[i]);
}

}  // namespace atwood
