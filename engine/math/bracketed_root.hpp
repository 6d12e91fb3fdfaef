// Roots of functions of one variable inside a bracket.
#pragma once

namespace atwood {

// The root lies in [low, high].
template <class S> struct BracketedRoot {
  S low{}, high{};
  int evaluations = 0;
  bool converged = false;  // narrowed to the requested width, or no number lies between low and high
};

// Bisection, for functions that may jump. `left_of_root(x)` is true below the root and false from it on; the caller
// guarantees that it lies in [low, high]. Converged when high - low <= relative * high; `relative` 0 asks for all
// digits. Not converged after `most` evaluations.
template <class S, class Predicate>
BracketedRoot<S> bisect(const Predicate& left_of_root, S low, S high, S relative, int most) {
  BracketedRoot<S> root{low, high};
  while (true) {
    const S middle = root.low + (root.high - root.low) / S(2);
    root.converged = !(root.high - root.low > relative * root.high) || !(middle > root.low && middle < root.high);
    if (root.converged || root.evaluations == most) return root;
    ++root.evaluations;
    (left_of_root(middle) ? root.low : root.high) = middle;
  }
}

// False position with the Illinois rule (M. Dowell and P. Jarratt, BIT 11 (1971) 168): the secant's root, the value at
// an end that stays twice running being halved. f(low) = f_low < 0 <= f_high = f(high), low >= 0; order 1.44 at a
// simple root of a smooth f. Converged when high - low <= relative * high, or f(high) = 0, and then low = high. Not
// converged after `most` evaluations, or where f is not a number.
template <class S, class Function>
BracketedRoot<S> false_position(const Function& f, S low, S f_low, S high, S f_high, S relative, int most) {
  BracketedRoot<S> root{low, high};
  for (int side = 0;;) {
    if (f_high == S(0)) root.low = root.high;
    root.converged = !(root.high - root.low > relative * root.high);
    if (root.converged || root.evaluations == most || !(f_high > S(0)) || !(f_low < S(0))) return root;
    S next = (root.low * f_high - root.high * f_low) / (f_high - f_low);
    const auto inside = [&] { return next > root.low && next < root.high; };
    if (!inside()) next = root.low + (root.high - root.low) / S(2);
    root.converged = !inside();
    if (root.converged) return root;
    ++root.evaluations;
    const S value = f(next);
    if (value < S(0)) {
      root.low = next;
      f_low = value;
      if (side < 0) f_high = f_high / S(2);
      side = -1;
    } else {
      root.high = next;
      f_high = value;
      if (side > 0) f_low = f_low / S(2);
      side = 1;
    }
  }
}

}  // namespace atwood
