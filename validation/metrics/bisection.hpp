// Roots of functions of one variable. Private to this room, which shares no numerics with the engine that it judges
// (engine/math/bracketed_root.hpp).
#pragma once

namespace atwood::metrics {

template <class S> struct Bracket {
  S low, high;            // f(low) > 0 >= f(high)
  bool converged = true;  // false: f was NaN at a point, and the bracket ends there
};

// Bisection (Hamming, Numerical Methods for Scientists and Engineers, 1973, section 4.4) between low and high, where
// the caller knows that f is above 0 at low and not at high; f may jump. `halvings` reduce the bracket to
// (high - low) / 2^halvings, or fewer until no number lies between its ends.
template <class S, class Function> Bracket<S> bisect(const Function& f, S low, S high, int halvings) {
  for (int k = 0; k < halvings; ++k) {
    const S middle = (low + high) / 2;
    if (!(middle > low && middle < high)) break;
    const auto value = f(middle);
    if (value != value) return {low, high, false};
    (value > 0 ? low : high) = middle;
  }
  return {low, high};
}

}  // namespace atwood::metrics
