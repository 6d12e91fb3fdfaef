// Switching functions over one step: where each may fall to zero. Signs at the ends of a step do not tell: a function
// may fall below zero and rise again in between. Its course is a polynomial through its values on the step's dense
// output, and the minima of that are found from its derivative (L. F. Shampine, I. Gladwell and R. W. Brankin, Reliable
// solution of special event location problems for ODEs, ACM Trans. Math. Softw. 17 (1991) 11).
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "extended/problem.hpp"

namespace atwood::extended {

// A minimum inside the step. Places are parts of the step, in (0, 1).
struct Minimum {
  double x = 0, value = 0;
  double left = 0, right = 1;  // the nearest maxima, or the ends of the step
  double rise = 0;             // the lower one of the values there, less the minimum
};

// A switching function over a step, approximately.
struct Course {
  double error = 0;  // an estimate, on the large side, of the polynomial's difference from the function
  double largest = 0, least = 0;
  double last_maximum = 0;                 // place from which on the function falls until the end; 1: it rises there
  double first_slope = 0, last_slope = 0;  // at the ends, a step
  std::vector<Minimum> minima;             // in order

  bool is_positive() const { return least > error; }
  // Whether the minimum is one of the function too: the rise on both sides is beyond the error.
  bool shows(const Minimum& at) const { return at.rise > 4 * error; }
  // Whether the polynomial has the function's own slopes at the ends: a dip beside an end, between two nodes, has
  // others. round_off: of the function's values.
  bool has_slopes(double first, double last, double round_off) const;
};

template <class S> class StepCourse {
 public:
  using Value = std::function<S(S t, const S* y)>;

  explicit StepCourse(DenseStep<S> step) : step_(std::move(step)) {}
  const DenseStep<S>& step() const { return step_; }
  // The state at x in [0, 1]: Hermite's polynomial of degree 5 through both ends and the middle.
  std::vector<S> state(S x) const;
  Course of(const Value& value) const;

 private:
  std::vector<S> cubic_state(S x) const;  // through the ends alone
  const std::vector<std::vector<S>>& nodes() const;

  DenseStep<S> step_;
  mutable std::vector<std::vector<S>> nodes_, coarse_;  // the states where values are taken, made once
};

// Where a switching function first falls below zero in a step.
template <class S> struct Fall {
  std::optional<S> tau;     // from the start of the step
  bool undecided = false;   // the dense output does not tell; a shorter step can
  std::optional<S> grazes;  // here its minimum is zero within its round-off
  bool located = true;      // false: the iteration at tau ended before its tolerance
};
// exact(tau): the value on the motion integrated to tau; empty where that failed, which makes the answer not `located`.
template <class S>
Fall<S> first_fall(const StepCourse<S>& step, const typename StepCourse<S>::Value& value,
                   const std::function<std::optional<S>(S tau)>& exact);

extern template class StepCourse<double>;
extern template class StepCourse<Wide>;
extern template Fall<double> first_fall(const StepCourse<double>&, const StepCourse<double>::Value&,
                                        const std::function<std::optional<double>(double)>&);
extern template Fall<Wide> first_fall(const StepCourse<Wide>&, const StepCourse<Wide>::Value&,
                                      const std::function<std::optional<Wide>(Wide)>&);

}  // namespace atwood::extended
