// The phase a of a Hertz contact at a time after its start: the root of time_of(a) = t, by Newton's method with
// dt/da = 4 d_m / (5 v) sin(a)^(-1/5).
#pragma once

#include "closed_form/number.hpp"

namespace atwood::closed_form {

inline Narrow fifth_root(Narrow x) { return std::pow(x, Narrow(1) / 5); }
inline Wide fifth_root(Wide x) { return powq(x, Wide(1) / 5); }

template <class S> struct HertzPhase {
  S a{};
  bool converged = false;  // the last change was within the round-off of time_of
};

// t: from 0 to the time of the largest overlap, at which a = pi / 2.
template <class S, class TimeOf> HertzPhase<S> hertz_phase(S t, S v, S max_overlap, const TimeOf& time_of) {
  constexpr int max_tries = 40, quadrature_round_off = 64;  // in units of the round-off of a
  // To first order d = v t, so a = (v t / d_m)^(5/4).
  const S first = v * t / max_overlap;
  HertzPhase<S> phase;
  S& a = phase.a;
  a = first < 1 ? first * sqrt(sqrt(first)) : pi<S>() / 2;
  for (int k = 0; k < max_tries; ++k) {
    if (a <= 0) return {a, t <= 0};
    const S change = (t - time_of(a)) * 5 * v / (4 * max_overlap) * fifth_root(sin(a));
    a = a + change;
    if (a > pi<S>() / 2) a = pi<S>() / 2;
    phase.converged = magnitude(change) <= quadrature_round_off * unit_round_off<S>() * a;
    if (magnitude(change) <= 4 * unit_round_off<S>() * a) break;
  }
  return phase;
}

}  // namespace atwood::closed_form
