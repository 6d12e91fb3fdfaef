// The semi-axes of Monaghan's drop, for the solution and its tests.
#pragma once

#include "fluid_truth/number.hpp"

namespace atwood::fluid_truth {

template <class S> struct Drop {
  S a{}, b{}, A{};  // [m], [m], [1/s]
  S error{};        // relative, of the integration
};

template <class S> Drop<S> drop_at(const Drop<S>& start, S t);

}  // namespace atwood::fluid_truth
