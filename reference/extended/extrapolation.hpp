// Gragg's explicit midpoint rule, extrapolated (Gragg 1965; Bulirsch and Stoer 1966; Hairer, Norsett and Wanner,
// Solving Ordinary Differential Equations I, section II.9).
#pragma once

#include "extended/problem.hpp"

namespace atwood::extended {

// Over a step H the midpoint rule with n = 2, 4, 6, ... substeps has an error with even powers of H/n only; each
// column of the tableau removes one: column k has order 2 k, at most 24. A step is accepted at the first column whose
// difference from the previous one is at most `tolerance` of the scale.
//
// With n = 2, 6, 10, ... substeps the middle of the step is a point of the rule with an odd number, and the errors of
// these points have even powers of H/n as well: extrapolated, they give dense(), of order k or k + 1 after column k.
template <class S> class Extrapolation : public Stepper<S> {
 public:
  Extrapolation(int size, std::vector<int> group, Rate<S> rate, S tolerance);
  S step(S t, S* y, S limit) override;
  DenseStep<S> dense() override;
  void raise_scale(const S* sizes) override { scale_.include(sizes); }

 private:
  void midpoint(S t, const S* y, S H, int substeps, std::vector<S>& result);
  int columns(S t, const S* y, S H, S& error);  // fills row_; returns the accepted column, or 0: none

  int size_;
  Rate<S> rate_;
  S tolerance_;
  S proposal_ = 0;
  Scale<S> scale_;
  std::vector<S> slope_, before_, now_, after_, dydt_;
  std::vector<std::vector<S>> row_;
  std::vector<std::vector<S>> middle_;  // with 2, 6, 10, ... substeps
  DenseStep<S> last_;                   // without its middle
  int last_column_ = 0;
};

extern template class Extrapolation<double>;
extern template class Extrapolation<long double>;
extern template class Extrapolation<Wide>;

}  // namespace atwood::extended
