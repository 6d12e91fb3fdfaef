// A vector's length and direction where squares would leave the scalar's range.
#pragma once

#include <limits>

#include "math/vec3.hpp"

namespace atwood {

// |v|, and `unit` = v / |v|. A zero vector has no direction: `unit` is left as it was, and 0 returned.
template <class S> inline S length_and_direction(const Vec3<S>& v, Vec3<S>& unit) {
  const S square = dot(v, v);
  constexpr S least = std::numeric_limits<S>::min() / (real::epsilon<S>() * real::epsilon<S>());
  if (square >= least && square <= std::numeric_limits<S>::max()) {
    const S length = real::sqrt(square);
    unit = (S(1) / length) * v;
    return length;
  }
  const S largest = largest_component(v);
  if (!(largest > S(0))) return S(0);
  const Vec3<S> scaled{v.x / largest, v.y / largest, v.z / largest};
  const S length = norm(scaled);
  unit = (S(1) / length) * scaled;
  return length * largest;
}

}  // namespace atwood
