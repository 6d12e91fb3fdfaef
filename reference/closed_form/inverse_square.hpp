// Motion under r'' = -mu r / r^3 from any initial state; mu < 0 repels.
#pragma once

#include <string>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

template <class S> struct InverseSquare {
  S mu{};
  Vec<S> r0{}, v0{};
  std::string refusal() const;  // empty: covered; otherwise the centre is or may be reached
  CenterMotion<S> at(S t) const;
};

extern template struct InverseSquare<Narrow>;
extern template struct InverseSquare<Wide>;

}  // namespace atwood::closed_form
