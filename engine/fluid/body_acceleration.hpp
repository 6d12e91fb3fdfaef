// The named body acceleration of a fluid (Fluid::source): the one under which a manufactured field solves the fluid's
// equations (docs/fluids.md, "The source"). Derived from the field's formulas by automatic differentiation.
//
// Source: Roache, J. Fluids Eng. 124 (2002) 4; Griewank and Walther, Evaluating Derivatives (2008), ch. 3.
#pragma once

#include "fluid/law.hpp"
#include "scene/fluid.hpp"

namespace atwood::fluid {

template <class S> class BodyAcceleration {
 public:
  BodyAcceleration() = default;  // none
  explicit BodyAcceleration(const Fluid& fluid);

  bool acts() const { return dimensions_ > 0; }
  // Adds s(t, x) [m/s^2]; x and `to` have as many numbers as the field has dimensions, x unwrapped or not.
  void add(S t_s, const S* x, S* to) const;

 private:
  template <int d> void add_in(S t_s, const S* x, S* to) const;

  int dimensions_ = 0;
  S wave_number_{}, speed_{}, angular_frequency_{}, density_amplitude_{};
  FluidLaw<S> law_;
};

}  // namespace atwood::fluid
