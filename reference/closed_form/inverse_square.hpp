// Motion under r'' = -mu r / r^3 from any initial state; mu < 0 repels.
#pragma once

#include <string>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

// Is (b - a) x (vb - va) zero? Decided in exact arithmetic: without angular momentum the centre is reached, and with
// however little it is passed.
bool is_radial(const Real3& a, const Real3& b, const Real3& va, const Real3& vb);

template <class S> struct InverseSquare {
  S mu{};
  Vec<S> r0{}, v0{};
  bool radial = false;          // r0 and v0 are parallel: is_radial of the numbers that they were rounded from
  std::string refusal() const;  // empty: covered
  // [s] from the start until an attracting centre is reached; infinite: it never is. r = 0 is a singularity of the
  // equation, after which there is no motion.
  S collision_s() const;
  CenterMotion<S> at(S t) const;  // 0 <= t < collision_s()
};

extern template struct InverseSquare<Narrow>;
extern template struct InverseSquare<Wide>;

}  // namespace atwood::closed_form
